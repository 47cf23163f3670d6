//! Contacts at rest grow stronger with the logarithm of time.
//!
//! `mu = mu (1 + strengthening ln(1 + rest / cutoff))`, `rest` the time since the point last
//! slipped (or since the trial began): Dieterich 1972, the static branch of rate and state
//! friction. Sliding resets it.

use super::law::{FrictionLaw, Law, Slip, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max};

/// See the module.
pub struct DwellStrengthening;

/// Description.
pub const INFO: Info = Info {
    id: "dwell_strengthening",
    code: 3,
    summary: "break-away friction grows with the logarithm of the time at rest",
    signature: "a peak at the onset of sliding that is higher the longer the object rested before (slow approach, pause)",
    source: "Dieterich 1972; Marone 1998, rate and state friction",
    role: Role::Plain,
    parameters: &[
        Parameter::new(
            "strengthening",
            "1",
            0.05,
            0.0,
            [0.0, 0.5],
            "relative rise of friction for each e-fold of rest time",
        ),
        Parameter::new(
            "cutoff_s",
            "s",
            0.05,
            0.05,
            [0.001, 10.0],
            "rest time at which strengthening sets in",
        ),
    ],
};

impl<R: Real> Law<R> for DwellStrengthening {
    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        _: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if !(slip.rest_s > R::zero()) || p[0] == R::zero() {
            return;
        }
        let factor = R::one() + p[0] * (R::one() + slip.rest_s / max(p[1], R::of(1e-4))).ln();
        law.mu = law.mu.map(|mu| mu * factor);
    }
}
