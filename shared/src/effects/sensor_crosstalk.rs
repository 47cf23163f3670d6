//! The largest force leaks into a sensor's other channels.
//!
//! Fingers: `f_x += to_x N`, `f_z += to_z N` (each finger its own share), `t_y += to_torsion N`
//! on both, `N` the size of the normal force shown. Pusher: `f_y += pusher_to_y f_x`.

use super::law::{Law, Reading, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, Parameter, Role};
use crate::real::Real;

/// See the module.
pub struct SensorCrosstalk;

/// Description.
pub const INFO: Info = Info {
    id: "sensor_crosstalk",
    code: 23,
    summary: "a sensor shows a share of its largest force in channels across it",
    signature: "tangential forces or torsion in proportion to grip even while nothing loads the object",
    source: "ATI F/T calibration, crosstalk matrix",
    role: Role::Plain,
    parameters: &[
        Parameter::new(
            "finger1_to_x",
            "1",
            0.02,
            0.0,
            [-0.2, 0.2],
            "finger 1: normal force shown along gripper X",
        ),
        Parameter::new(
            "finger2_to_x",
            "1",
            0.02,
            0.0,
            [-0.2, 0.2],
            "finger 2: normal force shown along gripper X",
        ),
        Parameter::new(
            "finger1_to_z",
            "1",
            0.02,
            0.0,
            [-0.2, 0.2],
            "finger 1: normal force shown along gripper Z",
        ),
        Parameter::new(
            "finger2_to_z",
            "1",
            0.02,
            0.0,
            [-0.2, 0.2],
            "finger 2: normal force shown along gripper Z",
        ),
        Parameter::new(
            "to_torsion_m",
            "m",
            0.0005,
            0.0,
            [-0.01, 0.01],
            "torque about gripper Y for each newton of normal force",
        ),
        Parameter::new(
            "pusher_to_y",
            "1",
            0.02,
            0.0,
            [-0.2, 0.2],
            "pusher: world X force shown along world Y",
        ),
    ],
};

impl<R: Real> Law<R> for SensorCrosstalk {
    fn sense(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, reading: &mut Reading<R>) {
        let [finger1, finger2] = &mut reading.finger;
        for (wrench, to_x, to_z) in [(finger1, p[0], p[2]), (finger2, p[1], p[3])] {
            let normal = wrench[1].abs();
            wrench[0] += to_x * normal;
            wrench[2] += to_z * normal;
            wrench[4] += p[4] * normal;
        }
        reading.pusher[1] += p[5] * reading.pusher[0];
    }
}
