//! Normal force leaks into a fingertip sensor's other channels.
//!
//! `f_x += to_x N`, `f_z += to_z N`, `t_y += to_torsion N` on both fingers, `N` the size of
//! the normal force they show.

use super::{Info, Law, MAX_PARAMETERS, Parameter, Reading, StepContext};
use crate::real::Real;

/// See the module.
pub struct SensorCrosstalk;

/// Description.
pub const INFO: Info = Info {
    id: "sensor_crosstalk",
    code: 23,
    summary: "normal force leaks into the tangential channels of the finger sensors",
    signature: "tangential forces or torsion in proportion to grip even while nothing loads the object",
    source: "ATI F/T calibration, crosstalk matrix",
    parameters: &[
        Parameter::new(
            "to_x",
            "1",
            0.02,
            0.0,
            [-0.2, 0.2],
            "share of the normal force added along gripper X",
        ),
        Parameter::new(
            "to_z",
            "1",
            0.02,
            0.0,
            [-0.2, 0.2],
            "share of the normal force added along gripper Z",
        ),
        Parameter::new(
            "to_torsion_m",
            "m",
            0.0005,
            0.0,
            [-0.01, 0.01],
            "torque about gripper Y for each newton of normal force",
        ),
    ],
};

impl<R: Real> Law<R> for SensorCrosstalk {
    fn info(&self) -> &'static Info {
        &INFO
    }

    fn sense(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, reading: &mut Reading<R>) {
        for wrench in &mut reading.finger {
            let normal = wrench[1].abs();
            wrench[0] += p[0] * normal;
            wrench[2] += p[1] * normal;
            wrench[4] += p[2] * normal;
        }
    }
}
