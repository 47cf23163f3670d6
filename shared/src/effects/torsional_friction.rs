//! Torsion of the fingers' patches differs from the nominal geometry's.
//!
//! The effective friction radius of fingertips is `r + radius_change`: every point
//! moves outward from the centre of its patch by `radius_change`, so that the torsional limit
//! becomes `mu N (r + radius_change)` exactly (uniform disc of radius a: r = 2a/3; a patch
//! pressed at its rim: a; Goyal, Ruina and Papadopoulos 1991). A point contact is spread into
//! three points at that radius and so gets torsion `mu N radius_change` (the soft finger of
//! Salisbury 1982). What lies under a supported object is `support_pressure`.

use super::law::{Law, StepContext};
use crate::contact::{Contact, is_finger};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max, norm};

/// Points nearer to the centre of their patch have no outward direction, m.
const POINT_M: f64 = 1e-5;

/// A patch can shrink to nearly a point, not turn inside out.
const MOST_SHRUNK: f64 = -0.95;

/// See the module.
pub struct TorsionalFriction;

/// Description.
pub const INFO: Info = Info {
    id: "torsional_friction",
    code: 9,
    summary: "fingertips bear more (or less) torsion than their nominal shape",
    signature: "rotation or torque about the contact normal is wrong while forces in a straight slide are right",
    on_robot: "the object turns between the fingers at another moment than the pads' size says: held off its centre of mass it sags or stays level",
    source: "Goyal, Ruina and Papadopoulos 1991, limit surface; Salisbury 1982, soft finger",
    role: Role::Plain,
    parameters: &[Parameter::new(
        "radius_change_m",
        "m",
        0.002,
        0.0,
        [-0.02, 0.05],
        "effective friction radius less the nominal one",
    )],
};

impl<R: Real> Law<R> for TorsionalFriction {
    fn contact(
        &self,
        p: &[R; MAX_PARAMETERS],
        _: &StepContext<R>,
        _: &[R; MEMORY],
        contact: &mut Contact<R>,
    ) {
        if p[0] == R::zero() || !is_finger(contact.body) {
            return;
        }
        let out = contact.axes[1] * contact.patch_m[0] + contact.axes[2] * contact.patch_m[1];
        let radius = norm(&out);
        if !(radius > R::of(POINT_M)) {
            contact.spread_m = max(p[0], R::zero());
            return;
        }
        let change = max(p[0] / radius, R::of(MOST_SHRUNK));
        contact.lever_m += out * change;
        contact.patch_m = contact.patch_m.map(|at| at * (R::one() + change));
    }

    fn torsion_arm(&self, p: &[R; MAX_PARAMETERS], arm_m: R) -> R {
        max(arm_m + p[0], arm_m * R::of(1.0 + MOST_SHRUNK))
    }
}
