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
//! N = N + (grip_gradient + N grip_gradient_relative) (x - (1 - at_middle) x_start + late dx/dt)
//! ```
//!
//! (a stiffness of jaw and pads that grows with their load, as that of rubber does, by its first two terms; a
//! jaw that takes time to give way lags behind a width that changes; one whose force goes by its opening has what was
//! commanded at the object's middle, `at_middle = 1`, one that is set as it closes where the trial starts), with `x` the
//! object coordinate of the pad's middle. The pads press along the face's normal. A slide towards +X then needs the push
//! `2 N (mu cos - sin)`. A jaw that presses strictly along gripper Y would need
//! `1 / (cos + mu sin)` times that: 0.4 % less at the typical slope and friction 0.4.
//!
//! A pad that cannot turn lies on the wedge's wider end first. With `M = pad_moment_nm`, the stiffness of a
//! pad against turning times `slope`, its centre of pressure is off its middle, along the object's X, by
//!
//! ```text
//! M / N                                 where the whole pad touches: |M| <= N a / 3
//! a (1 - sqrt(4 N a / (3 |M|)) / 3)     where it lifts off beyond
//! ```
//!
//! and its pressure is as much narrower as that of the strip: a pad on its edge holds less torsion (a strip of
//! half length `a` on springs, Winkler 1867; a disc of radius `a` is taken for it). Pads that turn with the
//! face, or are soft, have `M = 0`. Pads that were set up flat against the faces and do not follow when the object turns between
//! them by `b` have the moment of what the faces rise more than the pads: `M (e_x - set_up e_x at the start)`, up to
//! `2 M sin(b / 2)`.

use super::law::{FrictionLaw, Law, Slip, StepContext};
use crate::contact::{Contact, is_finger};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::model::FingerContact;
use crate::real::{Real, Vec3, abs, max, norm, sqrt};

/// A rise of the face by less than this share of its slope presses nowhere.
const LEAST_TURN: f64 = 1e-5;

/// See the module.
pub struct FaceTilt;

/// Description.
pub const INFO: Info = Info {
    id: "face_tilt",
    code: 11,
    summary: "gripped faces form a wedge, or friction changes along the object",
    signature: "tangential force or grip opening that drifts with the position along the object, the same in every run",
    on_robot: "the object is drawn or pushed out as it slides, so that a slip gets easier in one direction and harder in the other",
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
        Parameter::new("grip_gradient_1_m", "1/m", 4.0, 0.0, [-60.0, 60.0], "the same, over the grip")
            .added(0.0),
        Parameter::new(
            "pad_moment_nm",
            "N m",
            0.02,
            0.0,
            [-20.0, 20.0],
            "moment of each pad's pressure about its middle, towards object +X",
        )
        .added(0.0),
        Parameter::new(
            "set_up",
            "1",
            0.0,
            0.0,
            [0.0, 1.0],
            "share of it that pads do not have which were set up flat against the faces, until the object turns",
        )
        .tried_at(&[0.0, 1.0])
        .added(0.0),
        Parameter::new(
            "at_middle",
            "1",
            0.0,
            0.0,
            [0.0, 1.0],
            "share of the grip's gradient that is zero at the object's middle, the rest where the trial starts",
        )
        .tried_at(&[0.0, 1.0])
        .added(0.0),
    ],
};

/// How far the wedge moves the centre of pressure of a pad of half length `half_m` that presses with `load_n`,
/// and the standard deviation of the pressure about it, over that without a wedge.
fn pressed<R: Real>(moment_nm: R, load_n: R, half_m: R) -> (R, R) {
    let whole_nm = load_n * half_m;
    if !(whole_nm > R::zero()) {
        return (R::zero(), R::one());
    }
    let share = moment_nm / whole_nm;
    let size = abs(share);
    if size * R::of(3.0) <= R::one() {
        return (share * half_m, sqrt(R::one() - R::of(3.0) * share * share));
    }
    // A triangle of pressure, as long as this over the half length.
    let length = sqrt(R::of(4.0 / 3.0) / size);
    let offset_m = half_m * (R::one() - length / R::of(3.0));
    (if share < R::zero() { -offset_m } else { offset_m }, length * R::of(0.408_248_290_463_863))
}

/// The object's X axis in carrier axes.
fn along_x<R: Real>(c: &StepContext<R>) -> Vec3<R> {
    c.rotation.transform_vector(&Vec3::x())
}

/// The same when the pads closed on it, in the plane of the pads.
fn started<R: Real>(memory: &[R; MEMORY]) -> Vec3<R> {
    let z = memory[3];
    Vec3::new(sqrt(max(R::one() - z * z, R::zero())), R::zero(), z)
}

/// Object coordinate of the middle between the pads.
pub(super) fn pad_x_m<R: Real>(c: &StepContext<R>) -> R {
    -c.rotation.inverse_transform_vector(&c.position_m).x
}

/// How far the object has opened a jaw that gives way late: from where it closed, and `late_s`
/// times how fast `width` grows. There the jaw has its force; as far as it does not where `width` is zero. The last of
/// `memory` is the caller's.
pub(super) fn opened<R: Real>(
    width: R,
    [late_s, as_it_is]: [R; 2],
    c: &StepContext<R>,
    memory: &mut [R; MEMORY],
) -> R {
    let [closed, start, last, own] = *memory;
    let (start, last) = if closed == R::zero() { (width, width) } else { (start, last) };
    *memory = [R::one(), start, width, own];
    width - start * (R::one() - as_it_is) + late_s * (width - last) / max(c.dt_s, R::of(1e-6))
}

impl<R: Real> Law<R> for FaceTilt {
    fn grip(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, memory: &mut [R; MEMORY], grip_n: &mut R) {
        if memory[0] == R::zero() {
            memory[3] = along_x(c).z;
        }
        if p[2] != R::zero() || p[4] != R::zero() {
            *grip_n += (p[2] + p[4] * *grip_n) * opened(pad_x_m(c), [p[3], p[7]], c, memory);
        }
        memory[0] = R::one();
    }

    fn contact(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        memory: &[R; MEMORY],
        contact: &mut Contact<R>,
    ) {
        if !is_finger(contact.body) {
            return;
        }
        if p[5] != R::zero() {
            let half_m = match c.fingers {
                Some(
                    FingerContact::Disc { diameter_m: across_m } | FingerContact::Line { length_m: across_m },
                ) => across_m * R::of(0.5),
                Some(FingerContact::Point) | None => R::zero(),
            };
            let last_n = c.load_n[contact.body.index()];
            let load_n = if last_n > R::zero() { last_n } else { c.grip_cmd_n };
            let rises = along_x(c) - started(memory) * p[6];
            let much = norm(&rises);
            if much > R::of(LEAST_TURN) {
                let rises = rises / much;
                let [_, x, z] = contact.axes;
                let across_m = (x * contact.patch_m[0] + z * contact.patch_m[1]).dot(&rises);
                let (offset_m, narrower) = pressed(p[5] * much, load_n, half_m);
                let moved = rises * (offset_m + (narrower - R::one()) * across_m);
                contact.patch_m[0] += x.dot(&moved);
                contact.patch_m[1] += z.dot(&moved);
                contact.object_m += c.rotation.inverse_transform_vector(&moved);
                contact.lever_m += moved;
            }
        }
        if p[0] == R::zero() {
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
