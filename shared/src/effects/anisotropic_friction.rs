//! Fingertip friction that differs along and across the object.
//!
//! `mu_x = mu sqrt(ratio)`, `mu_across = mu / sqrt(ratio)` along the object's X axis and
//! across it: the elliptic cone of Michalowski and Mroz 1978 (brushed or machined faces). The
//! mean coefficient in the geometric sense stays the base model's.

use super::law::{FrictionLaw, Law, Slip, StepContext};
use crate::contact::is_finger;
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max, sqrt};

/// See the module.
pub struct AnisotropicFriction;

/// Description.
pub const INFO: Info = Info {
    id: "anisotropic_friction",
    code: 5,
    summary: "fingertip friction differs along and across the object's length",
    signature: "a push force too high (or low) while forces or sag across it are too low (or high)",
    on_robot: "an object slips more easily along one axis of its faces: the grip that holds depends on the direction of the load",
    source: "Michalowski and Mroz 1978, elliptic friction cone",
    role: Role::Plain,
    parameters: &[Parameter::new(
        "ratio",
        "1",
        1.4,
        1.0,
        [0.2, 5.0],
        "friction along object X over friction across it",
    )],
};

impl<R: Real> Law<R> for AnisotropicFriction {
    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        _: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if p[0] == R::one() || !is_finger(slip.body) {
            return;
        }
        let root = sqrt(max(p[0], R::of(1e-3)));
        law.mu = [law.mu[0] * root, law.mu[1] / root];
    }
}
