//! Friction and grip that vary periodically along the object.
//!
//! `mu = mu (1 + amplitude sin(a))`, `a = 2 pi x / wavelength + phase`, with `x` the object
//! coordinate of the pad's middle. To first order a wavy face of slope `s` does the same with
//! `amplitude = s / mu` (machining marks, ripples of an extruded face). A jaw that does not
//! keep its force answers to the height, of which that slope is the derivative:
//! `N = N + grip (h - (1 - at_middle) h_start + late dh/dt)`, `h = -cos(a)`: a force that goes by the place on the object has
//! `at_middle = 1`, one that is as commanded where the trial starts 0.

use super::face_tilt::{opened, pad_x_m};
use super::law::{FrictionLaw, Law, Slip, StepContext};
use crate::contact::is_finger;
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max};

/// See the module.
pub struct FaceWaviness;

/// Description.
pub const INFO: Info = Info {
    id: "face_waviness",
    code: 12,
    summary: "fingertip friction or grip varies periodically along the object",
    signature: "force ripples that repeat at the same points of the object at any speed",
    on_robot: "how much a grip holds depends on where the object is taken, and changes while it slides",
    source: "Berger 2002, waviness in friction measurements",
    role: Role::Plain,
    parameters: &[
        Parameter::new(
            "amplitude",
            "1",
            0.1,
            0.0,
            [-0.9, 0.9],
            "relative amplitude of the friction coefficient, mean over the pad",
        ),
        Parameter::new("wavelength_m", "m", 0.008, 0.008, [0.001, 0.1], "along object X")
            // A wave is found only from near its length.
            .tried_at(&[0.002, 0.004, 0.008, 0.012, 0.016, 0.024, 0.032]),
        Parameter::new("phase_rad", "rad", 0.0, 0.0, [-3.2, 3.2], "phase at the object's middle"),
        Parameter::new("grip_n", "N", 0.5, 0.0, [-20.0, 20.0], "amplitude of the grip force"),
        Parameter::new("late_s", "s", 0.0, 0.0, [0.0, 0.4], "delay of the jaw's motion")
            // The fit finds it.
            .tried_at(&[0.0]),
        Parameter::new(
            "at_middle",
            "1",
            0.0,
            0.0,
            [0.0, 1.0],
            "share of the grip's wave that is there where the trial starts",
        )
        .tried_at(&[0.0])
        .added(0.0),
    ],
};

fn angle<R: Real>(p: &[R; MAX_PARAMETERS], x_m: R) -> R {
    R::two_pi() * x_m / max(p[1], R::of(1e-4)) + p[2]
}

impl<R: Real> Law<R> for FaceWaviness {
    fn grip(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, memory: &mut [R; MEMORY], grip_n: &mut R) {
        if p[3] != R::zero() {
            *grip_n += p[3] * opened(-angle(p, pad_x_m(c)).sine_cosine().1, [p[4], p[5]], c, memory);
        }
    }

    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        _: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if p[0] == R::zero() || !is_finger(slip.body) {
            return;
        }
        let x = slip.object_m.x - slip.patch_m[0];
        let factor = R::one() + p[0] * angle(p, x).sine_cosine().0;
        law.mu = law.mu.map(|mu| mu * factor);
    }
}
