//! A sensor's axes are turned against the frame in which it reports.
//!
//! Each finger sensor by small angles about its normal, gripper Y, and about gripper Z (a share of
//! the grip then shows along the slide); the pusher's about world Y and Z. Force and torque turn alike: `w' = w + r x w`, to first order.

use super::{Info, Law, MAX_PARAMETERS, Parameter, Reading, StepContext, text};
use crate::real::{Real, Vec3};

/// See the module.
pub struct SensorMisalignment;

/// Description.
pub const INFO: Info = Info {
    id: "sensor_misalignment",
    code: 22,
    summary: text("a force sensor is mounted turned"),
    signature: text(
        "a share of the largest force appears in a channel across it, in proportion, with unchanged size",
    ),
    source: text("sensor mounting; Traversaro et al. 2015, in situ calibration"),
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
    fn info(&self) -> &'static Info {
        &INFO
    }

    fn sense(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, reading: &mut Reading<R>) {
        let zero = R::zero();
        let turn = |w: [R; 6], r: Vec3<R>| {
            let [a, b, c, d, e, f] = w;
            let (force, torque) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
            let (force, torque) = (force + r.cross(&force), torque + r.cross(&torque));
            [force.x, force.y, force.z, torque.x, torque.y, torque.z]
        };
        let [finger1, finger2] = reading.finger;
        let finger = |w, y, z| turn(w, Vec3::new(zero, y, z));
        reading.finger = [finger(finger1, p[0], p[4]), finger(finger2, p[1], p[5])];
        reading.pusher = turn(reading.pusher, Vec3::new(zero, p[2], p[3]));
    }
}
