//! Compliant contacts: the object moves before it slips.
//!
//! Springs in series with the base model's: `1 / k' = 1 / k + compliance`, for each whole
//! contact; tangential displacement before sliding is `F_t compliance` (Cattaneo 1938, Mindlin
//! 1949, here linear) as long as all of the contact sticks.
//!
//! Parts of a real contact slip before all of it slides. A spring of reach `z = mu N / k` that is moved by `s` loses
//! `microslip |ds| / z` of its length: force follows `mu N (1 - exp(-microslip s / z)) / microslip` until it slides. That is
//! Dahl's law (1968; bristles as in LuGre) with `microslip` 1, and slides from `1.5 z` on, as Mindlin's spheres do, with
//! 0.6. `step` does it at the end of each step.
//!
//! Fingertips stiffen as they are pressed: curved ones by Hertz's and Mindlin's laws with `N^(1/3)`, rough faces with `N`
//! (Johnson 1985, 7.2 and 13.4; Xydas and Kao 1999). Their stiffness goes with the load to the power of `stiffening`; the
//! compliances are those at 20 N. Along the face it is the load that each finger bears: where the object is pushed towards one
//! of them, that one is stiffer. What stiffens does so by new contact, which is not stressed: the spring keeps its force as the
//! load grows, and its stretch as it falls (Mindlin and Deresiewicz 1953). Pressed in, both are as stiff as under the commanded
//! grip.
//!
//! The pusher, and the support beside fingertips, is another body, with a compliance of its own: a plate on its sensor and
//! arm gives way by micrometres under a push, and the object turns on it by milliradians, much more where it is pressed near
//! an edge. The pusher's face bears as an even foundation does (`contact::spread`), where without this effect the corners do
//! alone. Faces are not that flat: `pusher_rim` of the stiffness lies at the two ends of the face along pusher Z, as where it
//! is hollow. It decides how far an object turns that is pressed near an edge. Along its face a plate gives way more than into it
//! (`pusher_shear`): solids that touch by `(2 - nu) / (2 - 2 nu)` (Mindlin 1949), a sensor's flexures by up to 2. An object that
//! turns with the fingers while a plate still holds it loads it by micrometres: this decides how much. It begins to slide as
//! gradually as the fingertips do.
//!
//! A flat disc of radius `a` resists turning by `pad_torsion K a²`, `K` its tangential stiffness: 0.5 for a layer pressed
//! evenly, 0.6 to 0.8 where pressure falls towards the rim (`a` being that of the disc with the same torsional friction), 1.0
//! to 1.2 for a half-space (Johnson 1985, 3.7 and 7.2). Three points at `a` bear 0.35 of the load, three at `0.487 a` the rest,
//! so that torsional friction stays `2/3 mu N a`, and share `K` as the ratio wants: what is stiff at the rim also begins to
//! slide there (`contact::spread`). 0.95 is the most that they can. With 0 the pad is a ring of `2a/3`, whose ratio is 4/9.
//!
//! The face of a sheared pad is beside its finger, and the grip presses on it there: `pad_carry` of the mean stretch of the
//! pad's springs, 1 for a face that goes along as it is. A block's shear is itself a moment that its pressure must balance: it
//! rises towards the leading edge by `F h / (2 N)`, `h` the pad's height, and where that is more the sum is below 0.

use super::law::{Law, StepContext};
use crate::contact::{Body, Contact, is_finger};
use crate::effect::{Expected, Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::model::FingerContact;
use crate::real::{Real, abs, clamp, max};
use crate::shape::ROUND;

/// See the module.
pub struct ContactCompliance;

/// Description.
pub const INFO: Info = Info {
    id: "contact_compliance",
    code: 8,
    summary: "fingertips (support, pusher) deform under load before they slip",
    signature: "displacement in proportion to force before sliding, rounded onset of sliding, sag at lift-off",
    on_robot: "the object moves by tenths of a millimetre before it slips: where it ends up is off by that, and motion alone is no slip",
    source: "Mindlin 1949; Dahl 1968; Johnson 1985, Contact Mechanics",
    // Fingertips of 2e5 N/m under 40 N.
    role: Role::Compliance { normal_m: 2e-4 },
    parameters: &[
        Parameter::new(
            "tangential_m_n",
            "m/N",
            2e-05,
            0.0,
            [0.0, 0.001],
            "tangential displacement for each newton on one contact",
        )
        .expected(Expected::ReadOff),
        Parameter::new(
            "normal_m_n",
            "m/N",
            5e-06,
            0.0,
            [0.0, 0.001],
            "normal displacement for each newton on one contact",
        )
        // A layer is pressed in less than it is sheared, a bonded one much less.
        .expected(Expected::Share(0.5, [0.05, 1.0])),
        Parameter::new(
            "pusher_m_n",
            "m/N",
            2e-6,
            0.0,
            [0.0, 1e-4],
            "displacement of the pusher, and of the support beside fingertips, for each newton pressed on it",
        )
        // A steel fixture to a plate on the flexures of its force sensor.
        .expected(Expected::Usual(1e-6, [0.0, 1e-5]))
        .added(0.0),
        Parameter::new(
            "microslip",
            "1",
            0.6,
            0.0,
            [0.0, 1.0],
            "how gradually contacts go over to sliding: 0 at once, 0.6 as Mindlin's spheres, 1 as Dahl's",
        )
        .tried_at(&[0.0, 1.0])
        // Sphere and plane of one material, by Mindlin's law.
        .expected(Expected::Usual(0.6, [0.0, 1.0]))
        .added(0.0),
        Parameter::new(
            "stiffening",
            "1",
            0.33,
            0.0,
            [0.0, 1.0],
            "how fingertips stiffen with their load: exponent of stiffness over load, 0 rubber bonded flat, 1/3 Hertz, 1 rough faces",
        )
        // The fit finds it.
        .tried_at(&[0.0])
        .expected(Expected::Usual(HERTZ, [0.0, 1.0]))
        .added(0.0),
        Parameter::new(
            "pusher_rim",
            "1",
            0.33,
            0.0,
            [0.0, 1.0],
            "share of a pusher's face's stiffness at its ends along pusher Z: 0 an even face, 1 its rim alone",
        )
        // The fit finds it.
        .tried_at(&[0.0])
        // Between an even face and one that is hollow.
        .expected(Expected::Usual(1.0 / 3.0, [0.0, 1.0]))
        .added(0.0),
        Parameter::new(
            "pad_torsion",
            "1",
            0.6,
            0.0,
            [0.0, 0.95],
            "torsional stiffness of a flat disc fingertip over its tangential one and its radius squared: 0.5 an even layer, 0.95 nearly a half-space, 0 a ring's 4/9",
        )
        // The fit finds it.
        .tried_at(&[0.0])
        // Hard contacts hardly turn before they slide: as a ring of points.
        .expected(Expected::UsualBesideReadOff(TORSION, [0.45, 0.95]))
        .added(0.0),
        Parameter::new(
            "pusher_shear",
            "1",
            SHEAR,
            0.0,
            [0.0, 3.0],
            "how much more compliant the pusher (support) is along its face than into it, over the latter: 0 alike, 0.4 a contact of solids, 1 a force sensor's flexures",
        )
        // The fit finds it.
        .tried_at(&[0.0])
        .expected(Expected::Usual(SHEAR, [0.0, 2.0]))
        .added(0.0),
        Parameter::new(
            "pad_carry",
            "1",
            1.0,
            0.0,
            [-2.0, 2.0],
            "how far the pressure of a sheared pad moves with the object, over the shear: 0 it stays under the finger, 1 it goes along",
        )
        // The fit finds it.
        .tried_at(&[0.0])
        .expected(Expected::UsualBesideReadOff(0.5, [-1.0, 1.5]))
        .added(0.0),
    ],
};

/// Exponent of a pad's stiffness over the grip: curved faces by Hertz's law. Flat ones that are bonded have 0, rough ones 1.
pub const HERTZ: f64 = 1.0 / 3.0;
/// Usual torsional stiffness of a flat disc over its tangential one and its radius squared: a ring 4/9, a layer pressed evenly
/// 0.5, a half-space 1.0 or more.
pub const TORSION: f64 = 0.6;
/// How much more a pusher gives way along its face than into it, over the latter: solids that touch by (2 - nu) / (2 - 2 nu) - 1 of
/// Mindlin's law, 0.2 to 0.5, six-axis force sensors by up to 1.
const SHEAR: f64 = 0.4;
/// A ratio below this is none.
const LEAST_TORSION: f64 = 1e-3;
/// Grip at which a fingertip that stiffens has the compliance of the parameters, N.
const REFERENCE_N: f64 = 20.0;
/// Lighter grips count as this much, N: the power law has no limit at zero.
const LEAST_N: f64 = 0.5;

/// A fingertip's compliance under a load (N) over that of the parameters, with its `stiffening`.
// Asked for three times: flash.
#[inline(never)]
pub fn compliance_at<R: Real>(grip_n: R, stiffening: R) -> R {
    let ratio = max(grip_n, R::of(LEAST_N)) / R::of(REFERENCE_N);
    (-stiffening * ratio.ln()).exp()
}

/// Compliance of one pad along its face at a grip (N), m/N, with the effect's parameters.
pub fn tangential_m_n<R: Real>(parameters: &[R; MAX_PARAMETERS], grip_n: R) -> R {
    parameters[0] * compliance_at(grip_n, parameters[4])
}

/// Puts the outer points of both fingers' discs where the inner ones are, and the inner ones there: what that changes in a
/// prediction, points cannot tell of discs.
pub fn exchange_points<R: Real>(parameters: &mut [R; MAX_PARAMETERS]) {
    parameters[6] = -parameters[6];
}

impl<R: Real> Law<R> for ContactCompliance {
    fn contact(
        &self,
        p: &[R; MAX_PARAMETERS],
        context: &StepContext<R>,
        _: &[R; MEMORY],
        contact: &mut Contact<R>,
    ) {
        // k / (1 + k c) is 1 / (1 / k + c), and k itself for c = 0.
        let softer = |k: R, c: R| k / (R::one() + k * max(c, R::zero()));
        let [mut tangential, mut normal, microslip] =
            if context.rubs(contact.body) { [p[0], p[1], p[3]] } else { [p[2] + p[2] * p[7], p[2], p[3]] };
        if p[4] != R::zero() && is_finger(contact.body) && context.grip_cmd_n > R::zero() {
            normal *= compliance_at(context.grip_cmd_n, p[4]);
            let [load_n, rate_n_s] = match contact.body {
                Body::Finger1 => [context.load_n[0], context.load_rate_n_s[0]],
                _ => [context.load_n[1], context.load_rate_n_s[1]],
            };
            let now_n = if load_n > R::zero() { load_n } else { context.grip_cmd_n };
            tangential *= compliance_at(now_n, p[4]);
            if rate_n_s > R::zero() {
                let before = p[0] * compliance_at(now_n - rate_n_s * context.dt_s, p[4]);
                let k = contact.tangential_n_m;
                contact.eased = clamp(softer(k, before) / softer(k, tangential), R::zero(), R::one());
            }
        }
        contact.tangential_n_m = softer(contact.tangential_n_m, tangential);
        contact.normal_n_m = softer(contact.normal_n_m, normal);
        contact.microslip = clamp(microslip, R::zero(), R::one());
        if let (true, Some(stretch_m)) = (p[8] != R::zero(), context.stretch_m.get(contact.body.index())) {
            let moved = (contact.axes[1] * stretch_m[0] + contact.axes[2] * stretch_m[1]) * p[8];
            contact.lever_m += moved;
            contact.object_m += context.rotation.inverse_transform_vector(&moved);
        }
        let disc = contact.face != ROUND && matches!(context.fingers, Some(FingerContact::Disc { .. }));
        contact.profile = match contact.body {
            Body::Pusher if p[2] > R::zero() => Some(clamp(p[5], R::zero(), R::one())),
            Body::Finger1 | Body::Finger2 if disc && abs(p[6]) > R::of(LEAST_TORSION) => Some(p[6]),
            _ => None,
        };
    }
}
