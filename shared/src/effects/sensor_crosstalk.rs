//! The largest force leaks into a sensor's other channels.
//!
//! Each finger has shares of its own: `f_x += to_x N`, `f_z += to_z N`, and the torque about each axis by
//! `to_t N`, `N` the size of the normal force shown. The pusher has the same of its force along X. What smaller forces
//! leak is left out.

use super::law::{Law, Reading, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, Parameter, Role};
use crate::real::Real;

/// See the module.
pub struct SensorCrosstalk;

/// Place of a finger's normal force in its wrench.
const NORMAL: usize = 1;

/// Description.
pub const INFO: Info = Info {
    id: "sensor_crosstalk",
    code: 23,
    summary: "a sensor shows a share of its largest force in channels across it",
    signature: "tangential forces or torsion in proportion to grip even while nothing loads the object",
    on_robot: "nothing moves otherwise: a part of the grip is read as load or torsion, so that slip seems nearer or further than it is",
    source: "ATI F/T calibration, crosstalk matrix",
    role: Role::Sensing { of_typical: 1.0 / 3.0 },
    parameters: &[
        shared("finger1_to_x", "finger 1: normal force shown along gripper X"),
        shared("finger2_to_x", "finger 2: normal force shown along gripper X"),
        shared("finger1_to_z", "finger 1: normal force shown along gripper Z"),
        shared("finger2_to_z", "finger 2: normal force shown along gripper Z"),
        torque("finger1_to_tx_m", "finger 1: torque about gripper X for each newton of normal force"),
        torque("finger2_to_tx_m", "finger 2: torque about gripper X for each newton of normal force"),
        torque("finger1_to_ty_m", "finger 1: torque about gripper Y for each newton of normal force"),
        torque("finger2_to_ty_m", "finger 2: torque about gripper Y for each newton of normal force"),
        torque("finger1_to_tz_m", "finger 1: torque about gripper Z for each newton of normal force"),
        torque("finger2_to_tz_m", "finger 2: torque about gripper Z for each newton of normal force"),
        shared("pusher_to_y", "pusher: world X force shown along world Y"),
        shared("pusher_to_z", "pusher: world X force shown along world Z"),
        torque("pusher_to_tx_m", "pusher: torque about world X for each newton of world X force"),
        torque("pusher_to_ty_m", "pusher: torque about world Y for each newton of world X force"),
        torque("pusher_to_tz_m", "pusher: torque about world Z for each newton of world X force"),
    ],
};

/// Force shown across, as a share of the largest.
const fn shared(name: &'static str, what: &'static str) -> Parameter {
    Parameter::new(name, "1", 0.02, 0.0, [-0.2, 0.2], what)
}

/// Torque shown for each newton of the largest force.
const fn torque(name: &'static str, what: &'static str) -> Parameter {
    Parameter::new(name, "m", 0.0005, 0.0, [-0.02, 0.02], what)
}

impl<R: Real> Law<R> for SensorCrosstalk {
    fn sense(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, reading: &mut Reading<R>) {
        for (k, wrench) in reading.finger.iter_mut().enumerate() {
            let normal = wrench[NORMAL].abs();
            let across = wrench.iter_mut().enumerate().filter(|(channel, _)| *channel != NORMAL);
            for ((_, shown), share) in across.zip(p.iter().skip(k).step_by(2)) {
                *shown += *share * normal;
            }
        }
        let [push, across @ ..] = &mut reading.pusher;
        for (shown, share) in across.iter_mut().zip(p.iter().skip(10)) {
            *shown += *share * *push;
        }
    }
}
