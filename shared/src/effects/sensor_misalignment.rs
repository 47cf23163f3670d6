//! A sensor's axes are turned against the frame in which it reports.
//!
//! Each finger sensor by a small rotation in gripper axes: about X and Z a share of the grip shows across it, about
//! Y, its normal, loads along the slide show across it. The pusher's in world axes. Force and torque turn alike:
//! `w' = w + r x w`, to first order.

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
    on_robot: "nothing moves otherwise: a part of the grip is read as load on the pad, so that slip seems nearer or further than it is",
    source: "sensor mounting; Traversaro et al. 2015, in situ calibration",
    role: Role::Sensing { of_typical: 1.0 / 3.0 },
    parameters: &[
        angle("finger1_x_rad", "finger 1 about gripper X"),
        angle("finger1_y_rad", "finger 1 about gripper Y"),
        angle("finger1_z_rad", "finger 1 about gripper Z"),
        angle("finger2_x_rad", "finger 2 about gripper X"),
        angle("finger2_y_rad", "finger 2 about gripper Y"),
        angle("finger2_z_rad", "finger 2 about gripper Z"),
        angle("pusher_x_rad", "pusher about world X"),
        angle("pusher_y_rad", "pusher about world Y"),
        angle("pusher_z_rad", "pusher about world Z"),
    ],
};

/// One angle.
const fn angle(name: &'static str, what: &'static str) -> Parameter {
    Parameter::new(name, "rad", 0.03, 0.0, [-0.3, 0.3], what)
}

impl<R: Real> Law<R> for SensorMisalignment {
    fn sense(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, reading: &mut Reading<R>) {
        let wrenches = reading.finger.iter_mut().chain([&mut reading.pusher]);
        let (turns, _) = p.as_chunks::<3>();
        for (w, turn) in wrenches.zip(turns) {
            let turn = Vec3::new(turn[0], turn[1], turn[2]);
            let (force, torque) = (Vec3::new(w[0], w[1], w[2]), Vec3::new(w[3], w[4], w[5]));
            let (force, torque) = (force + turn.cross(&force), torque + turn.cross(&torque));
            *w = [force.x, force.y, force.z, torque.x, torque.y, torque.z];
        }
    }
}
