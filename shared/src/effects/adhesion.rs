//! Contacts stick with a pull-off force.
//!
//! Every whole contact bears a pull of up to `pull_off` and slides at `mu (N + pull_off)`:
//! the Coulomb law with an adhesive offset (Derjaguin 1934; pull-off as in Johnson, Kendall
//! and Roberts 1971).

use super::{FrictionLaw, Info, Law, MAX_PARAMETERS, Parameter, Slip, StepContext, text};
use crate::real::{Real, most};

/// See the module.
pub struct Adhesion;

/// Description.
pub const INFO: Info = Info {
    id: "adhesion",
    code: 14,
    summary: text("contacts stick: friction at zero load and a pull-off force"),
    signature: text(
        "friction force against grip is a straight line that misses the origin; a pull when a contact opens",
    ),
    source: text("Derjaguin 1934; Johnson, Kendall and Roberts 1971"),
    parameters: &[Parameter::new(
        "pull_off_n",
        "N",
        1.0,
        0.0,
        [0.0, 20.0],
        "greatest pull of one whole contact",
    )],
};

impl<R: Real> Law<R> for Adhesion {
    fn info(&self) -> &'static Info {
        &INFO
    }

    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        _: &StepContext<R>,
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        law.adhesion_n += most(p[0], R::zero()) * slip.share;
    }
}
