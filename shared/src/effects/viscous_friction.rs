//! Friction that rises with slip speed.
//!
//! `mu(v) = mu + viscosity v`, the viscous term of Armstrong-Helouvry 1991 per unit of load.
//! The speed is that at the end of the step (with the load of the step before): the law is implicit and
//! stable at any step. A negative viscosity, for which friction falls with speed, takes the
//! speed of the step before: it destabilises by itself, whatever the step. Elsewhere than at the fingertips (or the
//! table where nothing is gripped) with the share `elsewhere` of the viscosity.

use super::law::{ELSEWHERE, FrictionLaw, Law, Slip, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::Real;

/// See the module.
pub struct ViscousFriction;

/// Description.
pub const INFO: Info = Info {
    id: "viscous_friction",
    code: 2,
    summary: "friction rises in proportion to slip speed",
    signature: "tangential forces that differ between fast and slow runs in proportion to speed, at the same grip",
    on_robot: "fast slips are braked by more friction than slow ones: a slow creep begins below the load at which a fast push slides",
    source: "Armstrong-Helouvry 1991, Control of Machines with Friction",
    role: Role::Plain,
    parameters: &[
        Parameter::new(
            "viscosity_s_m",
            "s/m",
            2.0,
            0.0,
            [-5.0, 50.0],
            "rise of the friction coefficient with slip speed",
        ),
        ELSEWHERE,
    ],
};

impl<R: Real> Law<R> for ViscousFriction {
    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        let viscosity_s_m = p[0] * c.scope(slip.body, p[1]);
        if viscosity_s_m > R::zero() {
            law.viscosity_s_m += viscosity_s_m;
        } else {
            let rise = viscosity_s_m * slip.speed_m_s;
            law.mu = law.mu.map(|mu| mu + rise);
        }
    }
}
