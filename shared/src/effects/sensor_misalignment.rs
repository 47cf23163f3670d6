//! A sensor's axes are turned against the frame in which it reports.
//!
//! Each finger sensor by small angles about its normal, gripper Y, and about gripper Z (a share of
//! the grip then shows along the slide); the pusher's about world Y and Z. Force and torque turn alike: `w' = w + r x w`, to first order.

use super::law::{Law, Reading, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, Parameter, Role};
use crate::real::{Real, Vec3};

/// See the module.
pub struct SensorMisalignment;

/// Description.
pub const INFO: Info = Info {
    id: "sensor_misalignment",
    code: 22,
    summary: "a force sensor is mounted turned",
    signature: "a share of the largest force appears in a channel across it, in proportion, with unchanged size",
    source: "sensor mounting; Traversaro et al. 2015, in situ calibration",
    role: Role::Plain,
    parameters: &[
        Parameter::new("finger1_rad", "rad", 0.03, 0.0, [-0.3, 0.3], "finger 1 about gripper Y"),
        Parameter::new("finger2_rad", "rad", 0.03, 0.0, [-0.3, 0.3], "finger 2 about gripper Y"),
        Parameter::new("pusher_y_rad", "rad", 0.03, 0.0, [-0.3, 0.3], "pusher about world Y"),
        Parameter::new("pusher_z_rad", "rad", 0.03, 0.0, [-0.3, 0.3], "pusher about world Z"),
        Parameter::new("finger1_z_rad", "rad", 0.03, 0.0, [-0.3, 0.3], "finger 1 about gripper Z"),
        Parameter::new("finger2_z_rad", "rad", 0.03, 0.0, [-0.3, 0.3], "finger 2 about gripper Z"),
    ],
};

impl<R: Real> Law<R> for SensorMisalignment {
    fn sense(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, reading: &mut Reading<R>) {
        let [one, two] = &mut reading.finger;
        // One loop: the code is there once.
        for (w, y, z) in [(one, p[0], p[4]), (two, p[1], p[5]), (&mut reading.pusher, p[2], p[3])] {
            let turn = Vec3::new(R::zero(), y, z);
            let (force, torque) = (Vec3::new(w[0], w[1], w[2]), Vec3::new(w[3], w[4], w[5]));
            let (force, torque) = (force + turn.cross(&force), torque + turn.cross(&torque));
            *w = [force.x, force.y, force.z, torque.x, torque.y, torque.z];
        }
    }
}
