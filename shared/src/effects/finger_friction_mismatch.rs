//! One fingertip grips better than the other.
//!
//! `mu_1 = mu (1 + mismatch)`, `mu_2 = mu (1 - mismatch)`: the mean stays the base model's
//! (pads of different wear, age or cleanliness).

use super::law::{FrictionLaw, Law, Slip, StepContext};
use crate::contact::Body;
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::Real;

/// See the module.
pub struct FingerFrictionMismatch;

/// Description.
pub const INFO: Info = Info {
    id: "finger_friction_mismatch",
    code: 6,
    summary: "finger 1 and finger 2 have different friction",
    signature: "tangential forces that differ between the two fingers, with a yaw moment that balances them",
    on_robot: "the finger with less friction slips first and the object turns about the other: the grip must do for the weaker one",
    source: "Johansson and Westling 1984, friction measured for each digit",
    role: Role::Plain,
    parameters: &[Parameter::new(
        "mismatch",
        "1",
        0.15,
        0.0,
        [-0.9, 0.9],
        "half the relative difference, finger 1 above finger 2 where positive",
    )],
};

impl<R: Real> Law<R> for FingerFrictionMismatch {
    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        _: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        let factor = match slip.body {
            Body::Finger1 => R::one() + p[0],
            Body::Finger2 => R::one() - p[0],
            _ => return,
        };
        law.mu = law.mu.map(|mu| mu * factor);
    }
}
