//! The gripped faces are not parallel, or their friction changes along them.
//!
//! Both faces of the object rise towards +X by `slope` (a wedge of twice that angle), and
//! friction grows along object X:
//!
//! ```text
//! gap = gap - tan(slope) x,  normals turned by slope,  mu = mu (1 + friction_gradient x)
//! ```
//!
//! and a jaw that does not keep its force presses harder where the object is wider,
//!
//! ```text
//! N = N + (grip_gradient + N grip_gradient_relative) (x - x_start + late dx/dt)
//! ```
//!
//! (a stiffness of jaw and pads that grows with their load, as that of rubber does, by its first two terms; a
//! jaw that takes time to give way lags behind a width that changes), with `x` the object coordinate of the pad's middle: the pads are taken to lie flat on the
//! face and to press along its normal. A slide towards +X then needs the push
//! `2 N (mu cos - sin)`. A jaw that presses strictly along gripper Y would need
//! `1 / (cos + mu sin)` times that: 0.4 % less at the typical slope and friction 0.4.

use super::law::{FrictionLaw, Law, Slip, StepContext};
use crate::contact::{Contact, is_finger};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, max};

/// See the module.
pub struct FaceTilt;

/// Description.
pub const INFO: Info = Info {
    id: "face_tilt",
    code: 11,
    summary: "gripped faces form a wedge, or friction changes along the object",
    signature: "tangential force or grip opening that drifts with the position along the object, the same in every run",
    source: "wedge statics: Meriam, Statics, ch. 6",
    role: Role::Plain,
    parameters: &[
        Parameter::new(
            "slope_rad",
            "rad",
            0.01,
            0.0,
            [-0.1, 0.1],
            "rise of each gripped face towards object +X",
        ),
        Parameter::new(
            "friction_gradient_1_m",
            "1/m",
            6.0,
            0.0,
            [-30.0, 30.0],
            "relative change of fingertip friction along object X",
        ),
        Parameter::new(
            "grip_gradient_n_m",
            "N/m",
            100.0,
            0.0,
            [-2000.0, 2000.0],
            "rise of the grip force along object X",
        ),
        Parameter::new("late_s", "s", 0.0, 0.0, [0.0, 0.4], "delay of the jaw's motion")
            // The fit finds it.
            .tried_at(&[0.0]),
        Parameter::new("grip_gradient_1_m", "1/m", 4.0, 0.0, [-60.0, 60.0], "the same, over the grip"),
    ],
};

/// Object coordinate of the middle between the pads.
pub(super) fn pad_x_m<R: Real>(c: &StepContext<R>) -> R {
    -c.rotation.inverse_transform_vector(&c.position_m).x
}

/// How far the object has opened a jaw that gives way late: from where it closed, and `late_s`
/// times how fast `width` grows. There the jaw has its force.
pub(super) fn opened<R: Real>(width: R, late_s: R, c: &StepContext<R>, memory: &mut [R; MEMORY]) -> R {
    let [closed, start, last] = *memory;
    let (start, last) = if closed == R::zero() { (width, width) } else { (start, last) };
    *memory = [R::one(), start, width];
    width - start + late_s * (width - last) / max(c.dt_s, R::of(1e-6))
}

impl<R: Real> Law<R> for FaceTilt {
    fn grip(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, memory: &mut [R; MEMORY], grip_n: &mut R) {
        if p[2] != R::zero() || p[4] != R::zero() {
            *grip_n += (p[2] + p[4] * *grip_n) * opened(pad_x_m(c), p[3], c, memory);
        }
    }

    fn contact(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, contact: &mut Contact<R>) {
        if p[0] == R::zero() || !is_finger(contact.body) {
            return;
        }
        let (sin, cos) = p[0].sine_cosine();
        contact.gap_m -= sin / cos * (contact.object_m.x - contact.patch_m[0]);
        let [n, t, _] = contact.axes;
        contact.axes[0] = n * cos + t * sin;
        contact.axes[1] = t * cos - n * sin;
    }

    fn friction(
        &self,
        p: &[R; MAX_PARAMETERS],
        _: &StepContext<R>,
        _: &[R; MEMORY],
        slip: &Slip<R>,
        law: &mut FrictionLaw<R>,
    ) {
        if is_finger(slip.body) {
            let factor = max(R::one() + p[1] * (slip.object_m.x - slip.patch_m[0]), R::of(0.1));
            law.mu = law.mu.map(|mu| mu * factor);
        }
    }
}
