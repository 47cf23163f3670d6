//! Friction that rises with slip speed.
//!
//! `mu(v) = mu + viscosity v`, the viscous term of Armstrong-Helouvry 1991 per unit of load.
//! The speed is that at the end of the step (with the load of the step before): the law is implicit and
//! stable at any step. A negative viscosity, for which friction falls with speed, takes the
//! speed of the step before: it destabilises by itself, whatever the step.

use super::law::{FrictionLaw, Law, Slip, StepContext};
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
    source: "Armstrong-Helouvry 1991, Control of Machines with Friction",
    role: Role::Plain,
    parameters: &[Parameter::new(
        "viscosity_s_m",
        "s/m",
        2.0,
        0.0,
        [-5.0, 50.0],
        "rise of the friction coefficient with slip speed",
    )],
};

impl<R: Real> Law<R> for ViscousFriction {
    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        _: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if p[0] > R::zero() {
            law.viscosity_s_m += p[0];
        } else {
            let rise = p[0] * slip.speed_m_s;
            law.mu = law.mu.map(|mu| mu + rise);
        }
    }
}
