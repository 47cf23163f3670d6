//! Fingertips stick with a pull-off force.
//!
//! Each finger pad bears a pull of up to `pull_off` and slides at `mu (N + pull_off)`:
//! the Coulomb law with an adhesive offset (Derjaguin 1934; pull-off as in Johnson, Kendall
//! and Roberts 1971). It takes a soft face to touch closely enough: a hard table or pusher under
//! a held object does not stick. Where nothing is gripped, the table is the contact.

use super::law::{FrictionLaw, Law, Slip, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max};

/// See the module.
pub struct Adhesion;

/// Description.
pub const INFO: Info = Info {
    id: "adhesion",
    code: 14,
    summary: "fingertips stick: friction at zero load and a pull-off force",
    signature: "friction force against grip is a straight line that misses the origin; a pull when a contact opens",
    on_robot: "light objects stick to the fingers: a small grip holds more than friction says, and an object may not come off when it is let go",
    source: "Derjaguin 1934; Johnson, Kendall and Roberts 1971",
    role: Role::Plain,
    parameters: &[Parameter::new(
        "pull_off_n",
        "N",
        1.0,
        0.0,
        [0.0, 20.0],
        "greatest pull of one finger (of the table where nothing is gripped)",
    )],
};

impl<R: Real> Law<R> for Adhesion {
    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if c.rubs(slip.body) {
            law.adhesion_n += max(p[0], R::zero()) * slip.share;
        }
    }
}
