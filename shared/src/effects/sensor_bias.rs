//! Force sensors show constants on top of the truth.
//!
//! Six of the eighteen channels, those in which biases pass for physics: along gripper X and Z
//! on each finger (push direction and weight), world X and Z on the pusher.

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
    source: "ATI F/T manual, bias; MuJoCo and Vicon rigs zero sensors before each run",
    role: Role::Plain,
    parameters: &[
        Parameter::new("finger1_fx_n", "N", 0.25, 0.0, [-3.0, 3.0], "added to finger 1, gripper X"),
        Parameter::new("finger1_fz_n", "N", 0.25, 0.0, [-3.0, 3.0], "added to finger 1, gripper Z"),
        Parameter::new("finger2_fx_n", "N", 0.25, 0.0, [-3.0, 3.0], "added to finger 2, gripper X"),
        Parameter::new("finger2_fz_n", "N", 0.25, 0.0, [-3.0, 3.0], "added to finger 2, gripper Z"),
        Parameter::new("pusher_fx_n", "N", 0.25, 0.0, [-3.0, 3.0], "added to the pusher, world X"),
        Parameter::new("pusher_fz_n", "N", 0.25, 0.0, [-3.0, 3.0], "added to the pusher, world Z"),
    ],
};

impl<R: Real> Law<R> for SensorBias {
    fn sense(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, reading: &mut Reading<R>) {
        let [finger1, finger2] = &mut reading.finger;
        for (wrench, [x, z]) in
            [(finger1, [p[0], p[1]]), (finger2, [p[2], p[3]]), (&mut reading.pusher, [p[4], p[5]])]
        {
            wrench[0] += x;
            wrench[2] += z;
        }
    }
}
