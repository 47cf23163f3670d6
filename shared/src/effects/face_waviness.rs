//! Friction that varies periodically along the object.
//!
//! `mu = mu (1 + amplitude sin(2 pi x / wavelength + phase))` with `x` the object coordinate
//! of the pad's middle. To first order a wavy face of slope `s` does the same with
//! `amplitude = s / mu` (machining marks, ripples of an extruded face).

use super::{FrictionLaw, Info, Law, MAX_PARAMETERS, Parameter, Slip, StepContext};
use crate::contact::is_finger;
use crate::real::{Real, most};

/// See the module.
pub struct FaceWaviness;

/// Description.
pub const INFO: Info = Info {
    id: "face_waviness",
    code: 12,
    summary: "fingertip friction varies periodically along the object",
    signature: "force ripples that repeat at the same places of the object at any speed",
    source: "Berger 2002, waviness in friction measurements",
    parameters: &[
        Parameter::new(
            "amplitude",
            "1",
            0.1,
            0.0,
            [-0.9, 0.9],
            "relative amplitude of the friction coefficient",
        ),
        Parameter::new("wavelength_m", "m", 0.008, 0.008, [0.001, 0.1], "along object X"),
        Parameter::new("phase_rad", "rad", 0.0, 0.0, [-3.2, 3.2], "phase at the object's middle"),
    ],
};

impl<R: Real> Law<R> for FaceWaviness {
    fn info(&self) -> &'static Info {
        &INFO
    }

    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        _: &StepContext<R>,
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if p[0] == R::zero() || !is_finger(slip.body) {
            return;
        }
        let x = slip.object_m.x - slip.patch_m[0];
        let angle = R::two_pi() * x / most(p[1], R::of(1e-4)) + p[2];
        let factor = R::one() + p[0] * angle.sin();
        law.mu = law.mu.map(|mu| mu * factor);
    }
}
