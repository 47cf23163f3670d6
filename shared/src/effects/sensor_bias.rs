//! Force sensors show constants on top of the truth.
//!
//! In each of the eighteen channels: fingers in gripper axes, the pusher in world axes.

use super::law::{Law, Reading, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, Parameter, Role};
use crate::real::Real;

/// See the module.
pub struct SensorBias;

/// Description.
pub const INFO: Info = Info {
    id: "sensor_bias",
    code: 20,
    summary: "force sensors have constant offsets",
    signature: "the same error in a channel in every run and phase, even before contact",
    on_robot: "nothing moves otherwise: what controller and prediction read is off by a constant, and shares of the friction limit with it",
    source: "ATI F/T manual, bias; MuJoCo and Vicon rigs zero sensors before each run",
    role: Role::Constants,
    parameters: &[
        force("finger1_fx_n", "added to finger 1, gripper X"),
        force("finger1_fy_n", "added to finger 1, gripper Y"),
        force("finger1_fz_n", "added to finger 1, gripper Z"),
        torque("finger1_tx_nm", "added to finger 1, about gripper X"),
        torque("finger1_ty_nm", "added to finger 1, about gripper Y"),
        torque("finger1_tz_nm", "added to finger 1, about gripper Z"),
        force("finger2_fx_n", "added to finger 2, gripper X"),
        force("finger2_fy_n", "added to finger 2, gripper Y"),
        force("finger2_fz_n", "added to finger 2, gripper Z"),
        torque("finger2_tx_nm", "added to finger 2, about gripper X"),
        torque("finger2_ty_nm", "added to finger 2, about gripper Y"),
        torque("finger2_tz_nm", "added to finger 2, about gripper Z"),
        force("pusher_fx_n", "added to the pusher, world X"),
        force("pusher_fy_n", "added to the pusher, world Y"),
        force("pusher_fz_n", "added to the pusher, world Z"),
        torque("pusher_tx_nm", "added to the pusher, about world X"),
        torque("pusher_ty_nm", "added to the pusher, about world Y"),
        torque("pusher_tz_nm", "added to the pusher, about world Z"),
    ],
};

/// Added to a force.
const fn force(name: &'static str, what: &'static str) -> Parameter {
    Parameter::new(name, "N", 0.25, 0.0, [-3.0, 3.0], what)
}

/// Added to a torque.
const fn torque(name: &'static str, what: &'static str) -> Parameter {
    Parameter::new(name, "N m", 0.003, 0.0, [-0.05, 0.05], what)
}

impl<R: Real> Law<R> for SensorBias {
    fn sense(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, reading: &mut Reading<R>) {
        let channels = reading.finger.iter_mut().flatten().chain(&mut reading.pusher);
        for (channel, bias) in channels.zip(p) {
            *channel += *bias;
        }
    }
}
