//! Friction of the fingers' patches: arm of torsion, friction while sliding, and what the model's effects make of the
//! limit.

use crate::contact::{Body, SLOTS};
use crate::model::{FingerContact, Model, Scene};
use crate::real::{Real, Vec3, max, min, sqrt};
use crate::step::{Workspace, effect_hooks};

/// By the model's effects: friction while sliding over that at rest, by how much the object's pose is late in s, and the arm
/// of a finger's torsional friction in m.
// A function of its own: it is called where a predictor begins and where it takes another model.
#[inline(never)]
pub(super) fn of_effects<R: Real>(scene: &Scene<R>, model: &Model<R>) -> [R; 3] {
    effect_hooks(model).fold(
        [R::one(), R::zero(), patch_arm(scene)],
        |[sliding, late_s, arm_m], (_, law, p)| {
            [sliding * law.sliding_share(p), late_s + law.pose_late_s(p), law.torsion_arm(p, arm_m)]
        },
    )
}

/// Arm of a finger's torsional friction by the shape of its patch: torsion limit over force limit.
pub(super) fn patch_arm<R: Real>(scene: &Scene<R>) -> R {
    match scene.fingers {
        Some(FingerContact::Disc { diameter_m }) => diameter_m * R::of(1.0 / 3.0),
        Some(FingerContact::Line { length_m }) => length_m * R::of(0.5),
        _ => R::zero(),
    }
}

/// What the model's effects make of the fingers' friction limit under a load along `load`
/// (carrier axes, any length): a factor on the base coefficient.
pub(super) fn effects_on_friction<R: Real>(
    model: &Model<R>,
    work: &Workspace<R, SLOTS>,
    load: &Vec3<R>,
) -> R {
    let (mut limit, mut normal) = (R::zero(), R::zero());
    for (c, answer) in work.contacts.iter().zip(work.answers()) {
        if matches!(c.body, Body::Finger1 | Body::Finger2) {
            let [force_n, ..] = answer.force_n;
            let bound = max(force_n + answer.adhesion_n, R::zero());
            limit += coefficient_along(&answer.mu, c.axes[1].dot(load), c.axes[2].dot(load)) * bound;
            normal += max(force_n, R::zero());
        }
    }
    let base = model.friction.finger * normal;
    if base > R::zero() { limit / base } else { R::one() }
}

/// Coefficient of an elliptic cone in the direction of a load with the components `a` and `b`
/// along the tangents; the mean where it has none.
fn coefficient_along<R: Real>(mu: &[R; 2], a: R, b: R) -> R {
    let size = sqrt(a * a + b * b);
    if mu[0] == mu[1] || !(size > R::of(1e-6)) || !(min(mu[0], mu[1]) > R::zero()) {
        return (mu[0] + mu[1]) * R::of(0.5);
    }
    let (a, b) = (a / mu[0], b / mu[1]);
    size / sqrt(a * a + b * b)
}
