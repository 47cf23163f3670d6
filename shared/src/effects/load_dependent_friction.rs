//! A friction coefficient that falls (or rises) with load.
//!
//! `mu = mu (N / N0)^-exponent` with `N` the normal force of the whole contact and
//! `N0 = 20 N`, as for soft fingertips whose real contact area grows slower than the load
//! (exponent 1/3 for Hertz contact: Bowden and Tabor 1950; Xydas and Kao 1999). `N0` is a
//! constant because it and the base coefficient cannot be told apart. Elsewhere than at the fingertips (or the
//! table where nothing is gripped) with the share `elsewhere` of the exponent: hard contacts obey Amontons' law.

use super::law::{ELSEWHERE, FrictionLaw, Law, Slip, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max};

/// Load at which the base coefficient holds, N.
pub const REFERENCE_N: f64 = 20.0;
/// Lighter loads count as this much, N: the power law has no limit at zero.
const LEAST_N: f64 = 0.05;

/// See the module.
pub struct LoadDependentFriction;

/// Description.
pub const INFO: Info = Info {
    id: "load_dependent_friction",
    code: 4,
    summary: "the friction coefficient depends on the normal force",
    signature: "tangential force not proportional to grip: relatively stronger at low grip (exponent above zero)",
    on_robot: "twice the grip bears less than twice the load (exponent above zero): the grip that holds a heavy object is above the proportional one",
    source: "Bowden and Tabor 1950; Xydas and Kao 1999, soft finger contact",
    role: Role::Plain,
    parameters: &[
        Parameter::new(
            "exponent",
            "1",
            0.15,
            0.0,
            [-0.5, 0.9],
            "exponent of the fall with load; 1/3 for Hertz contact",
        ),
        ELSEWHERE,
    ],
};

impl<R: Real> Law<R> for LoadDependentFriction {
    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        let load = slip.patch_load_n;
        // Before the first step there is no load to go by.
        let exponent = p[0] * c.scope(slip.body, p[1]);
        if exponent == R::zero() || !(load > R::zero()) {
            return;
        }
        let ratio = max(load, R::of(LEAST_N)) / R::of(REFERENCE_N);
        let factor = (-exponent * ratio.ln()).exp();
        law.mu = law.mu.map(|mu| mu * factor);
    }
}
