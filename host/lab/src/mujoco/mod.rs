//! MuJoCo beside the own model: a recorded trial as MJCF, run in the real engine.
//!
//! The engine is the PyPI wheel `mujoco`, in a Python environment of its own
//! (`make mujoco-setup`); [`engine`] hands it trials and reads back what its sensors would
//! show, [`mjcf`] writes the scene. Without the wheel only the export works.
//!
//! Contacts are the arrays of rigid points that the paper's decomposition and the own model
//! use: six small spheres on a ring of 2a/3 for a disc of radius a, a thin capsule for the
//! edge, MuJoCo's own corners for box and cylinder on a plane. Gripper and fingers are moved
//! as recorded by setting position and velocity in every step, which no contact force can
//! change; the jaw's two halves are coupled, each pressed with the grip.

pub mod engine;
pub mod mjcf;

use clap::ValueEnum;
use serde::Serialize;

/// How the engine is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Setting {
    /// MuJoCo's defaults: 2 ms, pyramidal cone, contacts with a time constant of 20 ms
    Default,
    /// Elliptic cone, impratio 100, contacts with a time constant of 5 ms (stiffer ones chatter), 1 ms steps
    Tuned,
}

impl Setting {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Default, Self::Tuned];

    /// Name of the model in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "mujoco-default",
            Self::Tuned => "mujoco-tuned",
        }
    }

    /// Step, s.
    pub fn step_s(self) -> f64 {
        match self {
            Self::Default => 0.002,
            Self::Tuned => 0.001,
        }
    }
}
