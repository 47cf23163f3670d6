//! Fingertip friction that changes from trial to trial.
//!
//! `mu_k = mu (1 + rate k)` for trial `k = 0, 1, ...` of the data set, never below a tenth of
//! the base model's: pads polish or pick up dust. Yu et al. 2016 saw pushing friction change
//! over thousands of pushes.

use super::law::{FrictionLaw, Law, Slip, StepContext};
use crate::contact::is_finger;
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max};

/// See the module.
pub struct WearDrift;

/// Description.
pub const INFO: Info = Info {
    id: "wear_drift",
    code: 7,
    summary: "fingertip friction drifts from trial to trial",
    signature: "residuals of tangential force that go with the order in which the trials were run, not with their conditions",
    on_robot: "a grip that was enough is not after some hundred grasps (rate below zero): friction has to be learnt anew, or pads changed",
    source: "Archard 1953; Yu et al. 2016, More than a million ways to be pushed",
    role: Role::Order,
    parameters: &[Parameter::new(
        "rate_per_trial",
        "1",
        -0.0006,
        0.0,
        [-0.05, 0.05],
        "relative change of friction from one trial to the next",
    )],
};

impl<R: Real> Law<R> for WearDrift {
    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if is_finger(slip.body) {
            let factor = max(R::one() + p[0] * c.trial, R::of(0.1));
            law.mu = law.mu.map(|mu| mu * factor);
        }
    }
}
