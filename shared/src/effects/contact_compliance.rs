//! Compliant contacts: the object moves before it slips.
//!
//! Springs in series with the base model's: `1 / k' = 1 / k + compliance`, for each whole
//! contact; tangential displacement before sliding is `F_t compliance` (Cattaneo 1938, Mindlin
//! 1949, here linear). Fingers and support; the pusher is taken as stiff.

use super::law::{Law, StepContext};
use crate::contact::{Body, Contact};
use crate::effect::{Info, MAX_PARAMETERS, Parameter, Role};
use crate::real::{Real, max};

/// See the module.
pub struct ContactCompliance;

/// Description.
pub const INFO: Info = Info {
    id: "contact_compliance",
    code: 8,
    summary: "fingertips (and support) deform under load before they slip",
    signature: "displacement in proportion to force before sliding, rounded onset of sliding, sag at lift-off",
    source: "Mindlin 1949; Johnson 1985, Contact Mechanics",
    // Fingertips of 2e5 N/m under 40 N.
    role: Role::Compliance { normal_m: 2e-4 },
    parameters: &[
        Parameter::new(
            "tangential_m_n",
            "m/N",
            2e-05,
            0.0,
            [0.0, 0.001],
            "tangential displacement for each newton on one contact",
        ),
        Parameter::new(
            "normal_m_n",
            "m/N",
            5e-06,
            0.0,
            [0.0, 0.001],
            "normal displacement for each newton on one contact",
        ),
    ],
};

impl<R: Real> Law<R> for ContactCompliance {
    fn contact(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, contact: &mut Contact<R>) {
        if contact.body == Body::Pusher {
            return;
        }
        // k / (1 + k c) is 1 / (1 / k + c), and k itself for c = 0.
        let softer = |k: R, c: R| k / (R::one() + k * max(c, R::zero()));
        contact.tangential_n_m = softer(contact.tangential_n_m, p[0]);
        contact.normal_n_m = softer(contact.normal_n_m, p[1]);
    }
}
