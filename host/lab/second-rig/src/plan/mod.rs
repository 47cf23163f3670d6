//! Which trials are run: benches for the diagnosis, grasps for the warnings.

pub mod bench;
pub mod grasps;

use nalgebra::{UnitQuaternion, Vector3};

use crate::physics::motion::{Motion, Schedule};
use crate::trial::{Pickup, TrialSpec};

/// A trial in which nothing happens; plans fill in the rest.
fn blank(primitive: &str, object: usize, start: Vector3<f64>) -> TrialSpec {
    TrialSpec {
        id: String::new(),
        object,
        primitive: primitive.into(),
        grip_n: 0.0,
        speed_m_s: None,
        speed_rad_s: None,
        slope_rad: None,
        offset_m: None,
        run: 0,
        progress: 0.0,
        start,
        gripper: Motion::fixed(start, UnitQuaternion::identity()),
        grasped: true,
        grip: Schedule::constant(0.0),
        grip_told: None,
        wetness: [Schedule::constant(1.0), Schedule::constant(1.0)],
        pusher: None,
        table: false,
        added_kg: Schedule(Vec::new()),
        knocks: Vec::new(),
        pickup: Pickup::default(),
        duration_s: 1.0,
        note: serde_json::Map::new(),
    }
}
