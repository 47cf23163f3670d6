//! The fingers press less than commanded.
//!
//! `N = N_command (1 - fraction) - offset` (friction and hysteresis of the gripper's drive).

use super::law::{Law, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::Real;

/// See the module.
pub struct GripForceLoss;

/// Description.
pub const INFO: Info = Info {
    id: "grip_force_loss",
    code: 15,
    summary: "the grip that acts is below the commanded one",
    signature: "normal and tangential finger forces both too small by the same share (fraction) or amount (offset)",
    on_robot: "the fingers press less than was commanded: slip and drop come at a smaller load than the command lets expect",
    source: "transmission losses: Townsend and Salisbury 1987",
    role: Role::Plain,
    parameters: &[
        Parameter::new("fraction", "1", 0.1, 0.0, [-0.5, 0.9], "share of the command that is lost"),
        Parameter::new("offset_n", "N", 1.0, 0.0, [-10.0, 10.0], "constant loss"),
    ],
};

impl<R: Real> Law<R> for GripForceLoss {
    fn grip(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, _: &mut [R; MEMORY], grip_n: &mut R) {
        *grip_n = *grip_n * (R::one() - p[0]) - p[1];
    }
}
