//! The object's mass or centre of mass is not what was measured.
//!
//! `m = m (1 + fraction)`, and the weight acts at `com_x` along object X, which adds the
//! torque `r x m g` about the nominal centre. Inertial forces of the offset are left out:
//! they are small against weight at manipulation speeds.

use super::law::{Law, Loads, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, Vec3};

/// See the module.
pub struct MassError;

/// Description.
pub const INFO: Info = Info {
    id: "mass_error",
    code: 17,
    summary: "mass or centre of mass differs from the one given",
    signature: "vertical forces (fraction) or pitching moment (offset) wrong even at rest, independent of grip and speed",
    on_robot: "the load on the fingers is another than planned, also at rest: the grip that holds has to be in proportion",
    source: "rigid body statics",
    role: Role::Plain,
    parameters: &[
        Parameter::new("fraction", "1", 0.1, 0.0, [-0.9, 5.0], "relative error of the mass"),
        Parameter::new("com_x_m", "m", 0.004, 0.0, [-0.1, 0.1], "true centre of mass along object X"),
    ],
};

impl<R: Real> Law<R> for MassError {
    fn loads(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, _: &mut [R; MEMORY], loads: &mut Loads<R>) {
        loads.mass_kg *= R::one() + p[0];
        if p[1] != R::zero() {
            let arm = c.rotation.transform_vector(&Vec3::new(p[1], R::zero(), R::zero()));
            let weight = c.carrier.inverse_transform_vector(&loads.gravity_m_s2) * loads.mass_kg;
            loads.torque_nm += arm.cross(&weight);
        }
    }
}
