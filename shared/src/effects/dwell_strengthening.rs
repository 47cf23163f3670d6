//! Contacts at rest grow stronger with the logarithm of time.
//!
//! `mu = mu (1 + strengthening ln(1 + age / cutoff))`, the age of each body's contact by the ageing law
//! `age' = 1 - v age / renewal`, `v` its mean slip speed: it grows at rest, sliding over the renewal distance makes it
//! anew, and slow sliding is stronger than fast (Dieterich 1979, Ruina 1983: rate and state friction). What does
//! not touch has no age. Elsewhere than at the fingertips (or the table where nothing is gripped) with the share
//! `elsewhere` of the strengthening.

use super::law::{ELSEWHERE, FrictionLaw, Law, Loads, Slip, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max};

/// See the module.
pub struct DwellStrengthening;

/// A contact is not made anew over less.
const LEAST_RENEWAL_M: f64 = 1e-7;
/// Sliding over less than this share of the renewal distance in a step is rest.
const LEAST_RENEWED: f64 = 1e-6;

/// Description.
pub const INFO: Info = Info {
    id: "dwell_strengthening",
    code: 3,
    summary: "friction grows with the logarithm of the time at rest, and sliding renews the contact",
    signature: "a peak at the onset of sliding that is higher the longer the object rested before (slow approach, pause)",
    on_robot: "a grasp that rested holds more than a fresh one: right after a regrasp or a slip the grip needs more reserve",
    source: "Dieterich 1979; Ruina 1983; Marone 1998, rate and state friction",
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
        Parameter::new("cutoff_s", "s", 0.05, 0.05, [0.001, 10.0], "age at which strengthening sets in"),
        Parameter::new(
            "renewal_m",
            "m",
            2e-5,
            2e-5,
            [1e-6, 5e-4],
            "distance of sliding over which the contact is made anew",
        )
        .tried_at(&[2e-6, 2e-5, 1e-4])
        // So short that any sliding renews the contact.
        .added(1e-6),
        ELSEWHERE,
    ],
};

impl<R: Real> Law<R> for DwellStrengthening {
    fn loads(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, ages: &mut [R; MEMORY], _: &mut Loads<R>) {
        let renewal_m = max(p[2], R::of(LEAST_RENEWAL_M));
        for ((age, speed), load) in ages.iter_mut().zip(c.slip_speed_m_s).zip(c.load_n) {
            let renewed = speed * c.dt_s / renewal_m;
            if !(load > R::zero()) {
                *age = R::zero();
            } else if renewed > R::of(LEAST_RENEWED) {
                let steady = renewal_m / speed;
                *age = steady + (*age - steady) * (-renewed).exp();
            } else {
                *age += c.dt_s;
            }
        }
    }

    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        ages: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        let age = ages.get(slip.body.index()).copied().unwrap_or(R::zero());
        let strengthening = p[0] * c.scope(slip.body, p[3]);
        if strengthening == R::zero() || !(age > R::zero()) {
            return;
        }
        let factor = R::one() + strengthening * (R::one() + age / max(p[1], R::of(1e-4))).ln();
        law.mu = law.mu.map(|mu| mu * factor);
    }
}
