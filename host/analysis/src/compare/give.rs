//! What no rigid model can be better at: pads and plates of real stiffness give way, and how
//! a body at rest shares its weight among them hangs on how much. The sizes are those of the
//! diagnosis ([`crate::fit::noise`]), so that both call the same thing an error.

use crate::channels::{NAMES, Quantity, quantity};
use crate::fit::noise::{FLOOR_OF_PATH, FLOOR_POSITION_M, FLOOR_ROTATION_RAD, shared_weight};
use crate::run::simulate::Prepared;

/// Grip and push.
const NOT_SHARED: [&str; 5] = ["finger1_fx_n", "finger1_fy_n", "finger2_fx_n", "finger2_fy_n", "pusher_fx_n"];

/// How far pose and forces of one trial may be from those of a rigid model.
pub struct Give {
    position_m: f64,
    /// Zero where the object rests on one thing only.
    weight_n: f64,
    weight_nm: f64,
}

/// For one trial.
pub fn give(prepared: &Prepared) -> Give {
    let scene = &prepared.scene;
    let both = scene.fingers.is_some() && scene.pusher.is_some();
    let weight = |quantity| if both { shared_weight(scene, quantity) } else { 0.0 };
    Give {
        position_m: FLOOR_POSITION_M.hypot(FLOOR_OF_PATH * prepared.drive_path()),
        weight_n: weight(Quantity::Force),
        weight_nm: weight(Quantity::Torque),
    }
}

impl Give {
    /// Of `channel`; weight is shared while things are at `rest` against each other. The grip
    /// and the force along x, the push itself, are not.
    pub fn of(&self, channel: usize, rest: bool) -> f64 {
        match quantity(channel) {
            Quantity::Position => self.position_m,
            Quantity::Rotation => FLOOR_ROTATION_RAD,
            _ if !rest || NAMES.get(channel).is_some_and(|n| NOT_SHARED.contains(n)) => 0.0,
            Quantity::Force => self.weight_n,
            Quantity::Torque => self.weight_nm,
        }
    }
}
