//! Break-away friction above sliding friction, falling with slip speed (Stribeck).
//!
//! `mu(v) = mu (1 + excess exp(-(v / v_s)^2))`, after Stribeck 1902 in the exponential form
//! of Bo and Pavelescu 1982; elsewhere than at the fingertips (or the table where nothing is gripped) with the share
//! `elsewhere` of the excess.

use super::law::{ELSEWHERE, FrictionLaw, Law, Slip, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max};

/// See the module.
pub struct StaticFriction;

/// Description.
pub const INFO: Info = Info {
    id: "static_friction",
    code: 1,
    summary: "friction is higher before sliding begins than while it lasts",
    signature: "a force peak at the onset of sliding that decays once the object moves",
    on_robot: "it holds more than it keeps once it slides: a slip that has begun goes on under a load that it bore at rest",
    source: "Bo and Pavelescu 1982, exponential Stribeck law",
    role: Role::Plain,
    parameters: &[
        Parameter::new("excess", "1", 0.2, 0.0, [0.0, 2.0], "break-away over sliding friction, less one"),
        Parameter::new(
            "stribeck_speed_m_s",
            "m/s",
            0.002,
            0.002,
            [1e-4, 0.1],
            "slip speed at which the excess has fallen to 1/e",
        ),
        ELSEWHERE,
    ],
};

impl<R: Real> Law<R> for StaticFriction {
    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        let excess = p[0] * c.scope(slip.body, p[2]);
        if excess == R::zero() {
            return;
        }
        let x = slip.speed_m_s / max(p[1], R::of(1e-6));
        let factor = R::one() + excess * (-x * x).exp();
        law.mu = law.mu.map(|mu| mu * factor);
    }

    fn sliding_share(&self, p: &[R; MAX_PARAMETERS]) -> R {
        R::one() / (R::one() + max(p[0], R::zero()))
    }
}
