//! The grip presses off the middle of the pads.
//!
//! All points of both fingertips move by the same offset in the pad's plane, gripper X and Z:
//! the centre of pressure and with it the centre of torsion. The wrench is still reported
//! about the pad's middle, so that a normal force `N` shows torques `-N offset` there.

use super::law::{Law, StepContext};
use crate::contact::{Contact, is_finger};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, Vec3};

/// See the module.
pub struct PressureOffset;

/// Description.
pub const INFO: Info = Info {
    id: "pressure_offset",
    code: 10,
    summary: "the fingers' centre of pressure is off the middle of the pads",
    signature: "finger torques in proportion to grip before anything moves; sliding or lifting turns the object",
    on_robot: "the object is held off the middle of the pads: it turns when it is lifted or slides, and bears less moment one way than the other",
    source: "Howe and Cutkosky 1996, limit surface about the centre of pressure",
    role: Role::Pressing { of_diameter: 0.03 },
    parameters: &[
        Parameter::new("offset_x_m", "m", 0.002, 0.0, [-0.01, 0.01], "along gripper X"),
        Parameter::new("offset_z_m", "m", 0.001, 0.0, [-0.01, 0.01], "along gripper Z"),
    ],
};

impl<R: Real> Law<R> for PressureOffset {
    fn contact(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        _: &[R; MEMORY],
        contact: &mut Contact<R>,
    ) {
        if !is_finger(contact.body) || (p[0] == R::zero() && p[1] == R::zero()) {
            return;
        }
        let offset = Vec3::new(p[0], R::zero(), p[1]);
        contact.lever_m += offset;
        contact.object_m += c.rotation.inverse_transform_vector(&offset);
    }
}
