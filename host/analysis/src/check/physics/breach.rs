//! A breach of physics and its likely cause, and what the checks compute with.

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_data::{Sample, Trial};

/// What most likely happened to the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// Lengths in another unit (mm).
    LengthUnit,
    /// Torques in another unit (N mm).
    TorqueUnit,
    /// A mass in another unit (g), or forces.
    MassUnit,
    /// Time stamps in another unit (ms, us).
    TimeUnit,
    /// Angles in degrees.
    AngleUnit,
    /// Grip in another unit, or of both fingers together.
    GripUnit,
    /// Finger 1 and finger 2 exchanged.
    FingersSwapped,
    /// Wrenches as exerted by the object instead of on it.
    SignsTurned,
    /// x, y, z, w in place of w, x, y, z.
    QuaternionOrder,
    /// A pose in other axes than the format's.
    Frame,
    /// A column that is needed and not there.
    MissingColumn,
    /// The grip that is held is nowhere stated.
    MissingGrip,
    /// Poses and forces by different clocks.
    ClockOffset,
    /// Forces and weight do not sum to zero in most trials.
    Balance,
}

/// A breach of physics in one trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Breach {
    /// Likely cause.
    pub cause: Cause,
    /// Columns or keys to look at.
    pub columns: String,
    /// What is measured, why that cannot be, the likely cause, what to do.
    pub text: String,
}

/// Values of `of` where it has one.
pub(super) fn values(trial: &Trial, of: impl Fn(&Sample) -> Option<f64>) -> Vec<f64> {
    trial.samples.iter().filter_map(of).filter(|value| value.is_finite()).collect()
}

pub(super) fn norm(values: [f64; 3]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Number with three digits.
pub(super) fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = (2 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.2e}")
    }
}
