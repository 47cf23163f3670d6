//! Force sensors are miscalibrated in scale.
//!
//! All channels of each finger times `1 + finger1` or `1 + finger2`, those of the pusher times
//! `1 + pusher`.
//! The balance of forces shows it: the sensors no longer sum to the object's weight.

use super::law::{Law, Reading, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, Parameter, Role};
use crate::real::Real;

/// See the module.
pub struct SensorGain;

/// Description.
pub const INFO: Info = Info {
    id: "sensor_gain",
    code: 21,
    summary: "force sensors read too much or too little by a constant share",
    signature: "forces that do not balance: fingers and pusher disagree in proportion to the force",
    on_robot: "nothing moves otherwise: forces are read too large or too small, and the grip that is thought to hold is off by that share",
    source: "ATI F/T calibration, gain error",
    role: Role::Sensing { of_typical: 0.0 },
    parameters: &[
        Parameter::new("finger1", "1", 0.05, 0.0, [-0.5, 0.5], "relative error of finger 1"),
        Parameter::new("finger2", "1", 0.05, 0.0, [-0.5, 0.5], "relative error of finger 2"),
        Parameter::new("pusher", "1", 0.05, 0.0, [-0.5, 0.5], "relative error of the pusher"),
    ],
};

impl<R: Real> Law<R> for SensorGain {
    fn sense(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, reading: &mut Reading<R>) {
        let [finger1, finger2] = &mut reading.finger;
        for (wrench, error) in [(finger1, p[0]), (finger2, p[1]), (&mut reading.pusher, p[2])] {
            *wrench = wrench.map(|x| x * (R::one() + error));
        }
    }
}
