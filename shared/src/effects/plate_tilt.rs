//! The pusher is not mounted square.
//!
//! A plane is turned about the pusher's own Y (`pitch`) and Z (`yaw`) axes, turns its normal
//! and meets one edge of the object first. A line, which is another tool on another mount, is
//! turned by `line` about Z (one end first) and keeps the face's normal. Small angles; a rod
//! or a sphere does not notice.

use super::law::{Law, StepContext};
use crate::contact::{Body, Contact};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::model::PusherContact;
use crate::real::{Real, max, norm};

/// See the module.
pub struct PlateTilt;

/// Description.
pub const INFO: Info = Info {
    id: "plate_tilt",
    code: 13,
    summary: "the pusher's face is not square to the push",
    signature: "a constant sideways share of the push force, and the object turns until it lies flat on the pusher",
    on_robot: "what is pushed turns until it lies flat, and a share of the push goes sideways into the fingers: it ends up askew",
    source: "rigid body geometry",
    role: Role::Mounting { square_rad: 6e-4 },
    parameters: &[
        Parameter::new("pitch_rad", "rad", 0.01, 0.0, [-0.1, 0.1], "about pusher Y"),
        Parameter::new("yaw_rad", "rad", 0.01, 0.0, [-0.1, 0.1], "about pusher Z"),
        Parameter::new("line_rad", "rad", 0.01, 0.0, [-0.1, 0.1], "of a line, about pusher Z"),
    ],
};

impl<R: Real> Law<R> for PlateTilt {
    fn contact(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        _: &[R; MEMORY],
        contact: &mut Contact<R>,
    ) {
        if contact.body != Body::Pusher || p[..3].iter().all(|x| *x == R::zero()) {
            return;
        }
        let [n, t1, t2] = contact.axes;
        match c.pusher {
            Some(PusherContact::Plane) => {
                // The point seen from the pusher's origin, on the turned axes.
                let from = n * contact.gap_m + t1 * contact.patch_m[0] + t2 * contact.patch_m[1];
                let turned = n + t1 * p[1] - t2 * p[0];
                let n = turned / norm(&turned);
                let t1 = t1 - n * n.dot(&t1);
                let t1 = t1 / max(norm(&t1), R::of(1e-6));
                contact.axes = [n, t1, n.cross(&t1)];
                contact.gap_m = n.dot(&from);
            }
            Some(PusherContact::Line { .. }) => contact.gap_m += contact.patch_m[0] * p[2],
            _ => {}
        }
    }
}
