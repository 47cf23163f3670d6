//! A trial as planned.

use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

use crate::physics::motion::{Knock, Motion, Schedule};

/// What kind of pusher.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum PusherKind {
    /// A plane against the end at -X.
    Plate,
    /// A line along pusher Y under the face at -Z, m.
    Edge(f64),
    /// A plane under a cylinder.
    Platform,
    /// A vertical rod, radius in m.
    Rod(f64),
}

/// Disturbance of the force sensors in one trial.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Pickup {
    /// Sine on all force channels, N.
    pub sine_n: f64,
    /// Hz.
    pub hz: f64,
    /// Low-passed noise on all force channels, standard deviation, N.
    pub broad_n: f64,
}

/// One trial of a plan.
#[derive(Clone, Debug, Serialize)]
pub struct TrialSpec {
    /// Identifier.
    pub id: String,
    /// Index of the object.
    pub object: usize,
    /// As in trials.csv.
    pub primitive: String,
    /// N.
    pub grip_n: f64,
    /// m/s.
    pub speed_m_s: Option<f64>,
    /// rad/s.
    pub speed_rad_s: Option<f64>,
    /// rad.
    pub slope_rad: Option<f64>,
    /// m.
    pub offset_m: Option<f64>,
    /// Repetition.
    pub run: usize,
    /// Place in the order of the data set, 0 to 1.
    pub progress: f64,
    /// Object's origin at the start, m.
    pub start: Vector3<f64>,
    /// As commanded.
    pub gripper: Motion,
    /// Is the object between fingers?
    pub grasped: bool,
    /// Force that acts, N.
    pub grip: Schedule,
    /// What grip_cmd_n says; `None` for the same.
    pub grip_told: Option<Schedule>,
    /// Factor on each finger's friction.
    pub wetness: [Schedule; 2],
    /// Pusher and its motion; does it move?
    pub pusher: Option<(PusherKind, Motion)>,
    /// Does a table lie under it?
    pub table: bool,
    /// Mass poured in, kg.
    pub added_kg: Schedule,
    /// Knocks.
    pub knocks: Vec<Knock>,
    /// On the sensors.
    pub pickup: Pickup,
    /// s.
    pub duration_s: f64,
    /// For the key.
    pub note: serde_json::Map<String, serde_json::Value>,
}

/// +X of the pusher upwards, +Y stays.
pub fn upwards() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -FRAC_PI_2)
}
