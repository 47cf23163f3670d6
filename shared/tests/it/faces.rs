//! Contacts that come, go and change the face: whose memory is whose.

use crate::common::{at, hard, obj4, still, turn};
use nalgebra::UnitQuaternion;
use stickslip_shared::contact::{Body, SLOTS};
use stickslip_shared::model::{FingerContact, PusherContact, Scene, SupportContact};
use stickslip_shared::real::{Rotation, Vec3};
use stickslip_shared::shape::{Extent, Face};
use stickslip_shared::step::{Moving, State, step, support_under};

type S = State<f64, SLOTS>;

fn fixed(position_m: Vec3<f64>, rotation: Rotation<f64>) -> Moving<f64> {
    Moving {
        position_m,
        rotation,
        velocity_m_s: Vec3::zeros(),
        angular_rad_s: Vec3::zeros(),
        reference_m: position_m,
    }
}

fn scene(fingers: bool, pusher: Option<PusherContact<f64>>) -> Scene<f64> {
    Scene {
        gravity_m_s2: [0.0, 0.0, -9.81],
        object: obj4(),
        fingers: fingers.then_some(FingerContact::Disc { diameter_m: 0.02 }),
        pusher,
        support: None,
    }
}

#[test]
fn a_pad_point_that_leaves_the_face_keeps_neither_load_nor_spring() {
    let (scene, model, drive) = (scene(true, None), hard(0.4, 0.3, 0.3), still(0.004, 20.0));
    let mut state: S = State::held(&scene, &model, &drive, Vec3::zeros(), UnitQuaternion::identity());
    for _ in 0..20 {
        step(&scene, &model, &mut state, &drive);
    }
    let pad = Body::Finger1.slots();
    assert!(state.slots[pad.clone()].iter().all(|s| s.load_n > 0.5), "all six points bear");
    // The object now ends at the middle of the pads: half of their points are off it.
    state.position_m.x = -0.05;
    let out = step(&scene, &model, &mut state, &drive);
    let on: Vec<usize> = out.contacts.iter().map(|c| c.slot).collect();
    let off: Vec<usize> = pad.filter(|k| !on.contains(k)).collect();
    assert!((1..6).contains(&off.len()), "{off:?}");
    for k in off {
        assert_eq!(state.slots[k].load_n, 0.0, "slot {k}");
        assert_eq!(state.slots[k].spring_m, [0.0; 2], "slot {k}");
    }
}

#[test]
fn a_corner_keeps_its_memory_when_the_nearest_face_changes_and_others_begin_anew() {
    let scene = scene(false, Some(PusherContact::Plane));
    let model = hard(0.4, 0.3, 0.3);
    // A prism on its edge over a plane below: tilted a little less, then a little more than 45 degrees.
    let above = turn([0.0, 1.0, 0.0], -std::f64::consts::FRAC_PI_2);
    let tilted = |degrees: f64| turn([1.0, 0.0, 0.0], degrees.to_radians());
    let mut drive = still(0.004, 0.0);
    let depth = 0.0125 * 2f64.sqrt();
    drive.pusher = Some(fixed(at(0.0, 0.0, -depth + 1e-6), above));
    let mut state: S = State::held(&scene, &model, &drive, Vec3::zeros(), tilted(44.9));
    for _ in 0..3 {
        step(&scene, &model, &mut state, &drive);
        state.rotation = tilted(44.9);
        state.position_m = Vec3::zeros();
    }
    let marked = |state: &S, out: &stickslip_shared::step::StepOutput<f64, SLOTS>| {
        let near = out.contacts.iter().filter(|c| c.body == Body::Pusher && state.slots[c.slot].load_n > 0.0);
        near.map(|c| (c.slot, c.object_m)).collect::<Vec<_>>()
    };
    let out = step(&scene, &model, &mut state.clone(), &drive);
    let edge = marked(&state, &out);
    assert_eq!(edge.len(), 2, "the two ends of the edge bear: {edge:?}");
    for (k, (slot, _)) in edge.iter().enumerate() {
        state.slots[*slot].slip_m = 0.01 * (k + 1) as f64;
    }
    state.rotation = tilted(45.1);
    state.position_m = Vec3::zeros();
    let out = step(&scene, &model, &mut state, &drive);
    for c in out.contacts.iter().filter(|c| c.body == Body::Pusher) {
        let before = edge.iter().position(|(_, p)| (p - c.object_m).norm() < 1e-9);
        let slip_m = state.slots[c.slot].slip_m;
        match before {
            Some(k) => assert!((slip_m - 0.01 * (k + 1) as f64).abs() < 1e-3, "corner {k}: {slip_m}"),
            None => assert!(slip_m < 1e-3, "slot {} belongs to another corner now: {slip_m}", c.slot),
        }
    }
    assert_eq!(marked(&state, &out).len(), 2);
}

#[test]
fn a_fast_approach_is_not_missed_in_steps_of_20_ms() {
    // 0.5 m/s over 20 ms is 10 mm: from 9 mm away the rod reaches the object within the step.
    let mut scene = scene(false, Some(PusherContact::Point { tip_radius_m: 0.005 }));
    scene.support = Some(SupportContact::Patch);
    let model = hard(0.4, 0.3, 0.3);
    let mut drive = still(0.02, 0.0);
    drive.support = Some(support_under(&scene, &Vec3::zeros(), &UnitQuaternion::identity(), &Vec3::z()));
    let start = at(-0.05 - 0.005 - 0.009, 0.0, 0.0);
    drive.pusher =
        Some(Moving { velocity_m_s: at(0.5, 0.0, 0.0), ..fixed(start, UnitQuaternion::identity()) });
    let mut state: S = State::held(&scene, &model, &drive, Vec3::zeros(), UnitQuaternion::identity());
    let out = step(&scene, &model, &mut state, &drive);
    assert!(out.normal_n[2] > 0.0, "the pusher's force: {:?}", out.normal_n);
    // Non-penetration at the end of the step: the tip has come 1 mm beyond where the face was.
    assert!((state.position_m.x - 0.001).abs() < 1e-4, "{}", state.position_m.x);
}

#[test]
fn an_answer_far_from_solved_leaves_the_state_and_says_so() {
    use stickslip_shared::solve::{Follows, SolveBudget, SolveStatus};
    use stickslip_shared::step::{Workspace, step_in};
    let mut scene = scene(true, Some(PusherContact::Plane));
    scene.support = None;
    let model = hard(0.4, 0.3, 0.3);
    let mut drive = still(0.004, 20.0);
    // A plane that strikes at 20 mm/s, and a solver that may not iterate.
    let struck = fixed(at(-0.05, 0.0, 0.0), UnitQuaternion::identity());
    drive.pusher = Some(Moving { velocity_m_s: at(0.02, 0.0, 0.0), ..struck });
    let mut state: S = State::held(&scene, &model, &drive, Vec3::zeros(), UnitQuaternion::identity());
    let before = state.clone();
    let hurried = SolveBudget { max_work: 1, ..SolveBudget::present() };
    let out = step_in(&scene, &model, &mut state, &drive, &hurried, &mut Workspace::new());
    assert_ne!(out.status, SolveStatus::Solved);
    assert!(out.residual_n > 10.0, "{} N", out.residual_n);
    assert!(!out.followed);
    assert_eq!(
        (state.position_m, state.velocity, state.slots),
        (before.position_m, before.velocity, before.slots)
    );
    // A study of the solver may follow it.
    let all = SolveBudget { follows: Follows::Any, ..hurried };
    assert!(step_in(&scene, &model, &mut state, &drive, &all, &mut Workspace::new()).followed);
    assert!(state.time_s > before.time_s);
}

/// Regular polygon of so many corners, stretched along X.
fn polygon(corners: u32) -> Extent<f64> {
    let corner = |k| {
        let (s, c) = (std::f64::consts::TAU * f64::from(k) / f64::from(corners)).sin_cos();
        [0.05 * c, 0.03 * s]
    };
    Extent::Polygon((0..corners).map(corner).collect())
}

/// Mean place, mean square radius and mean radius of a face, counted on a grid.
fn counted(face: &Face<f64>) -> ([f64; 2], f64, f64) {
    const FINE: i32 = 600;
    let (mut n, mut place, mut square, mut radius) = (0.0, [0.0; 2], 0.0, 0.0);
    for i in -FINE..FINE {
        for j in -FINE..FINE {
            let at = [i, j].map(|k| 0.06 * (f64::from(k) + 0.5) / f64::from(FINE));
            if face.covers(at) {
                n += 1.0;
                place = [place[0] + at[0], place[1] + at[1]];
                square += at[0] * at[0] + at[1] * at[1];
                radius += at[0].hypot(at[1]);
            }
        }
    }
    (place.map(|x| x / n), square / n, radius / n)
}

#[test]
fn points_of_a_face_have_its_middle_and_radius_of_gyration_and_its_torsional_friction_within_1_5_percent() {
    let extents = [Extent::Rectangle([0.035, 0.011]), Extent::Rectangle([0.02, 0.02]), Extent::Disc(0.03)];
    for extent in extents.into_iter().chain([3, 4, 5, 6, 8].map(polygon)) {
        let face = Face {
            number: 0,
            normal: Vec3::z(),
            centre_m: Vec3::zeros(),
            axes: [Vec3::x(), Vec3::y()],
            extent,
        };
        let points = face.samples();
        let sum =
            |of: &dyn Fn(&Vec3<f64>) -> f64| points.iter().map(|(at, share)| share * of(at)).sum::<f64>();
        let (middle, square, radius) = counted(&face);
        let what = format!("{:?}", face.extent);
        assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-12, "{what}");
        assert!((sum(&|at| at.x) - middle[0]).abs() < 1e-4, "{what}");
        assert!((sum(&|at| at.y) - middle[1]).abs() < 1e-4, "{what}");
        assert!((sum(&|at| at.norm_squared()) / square - 1.0).abs() < 5e-3, "{what}");
        let torsion = sum(&|at| at.norm()) / radius;
        println!("{what}: torsion {torsion:.4}");
        assert!((torsion - 1.0).abs() < 0.015, "{what}: {torsion}");
    }
}

/// Travel of the pusher for each radian by which it turns a face, less the arm of the push: how far from the middle the
/// centre of rotation is. A push along Y (or X) at `arm_m` on the other axis, in steady sliding.
fn centre_of_rotation_m(points: &[([f64; 2], f64)], arm_m: f64, across: usize) -> f64 {
    let (mut near, mut far) = (1e-5, 10.0);
    for _ in 0..60 {
        let c: f64 = f64::sqrt(near * far);
        let (mut force, mut moment) = (0.0, 0.0);
        for (at, share) in points {
            let (x, y) = (at[across] - c, at[1 - across]);
            let speed = x.hypot(y).max(1e-12);
            force += share * x / speed;
            moment += share * (at[across] * x + at[1 - across] * y) / speed;
        }
        if moment.abs() > arm_m * force.abs() { near = c } else { far = c }
    }
    far
}

#[test]
fn a_push_turns_the_points_of_a_rectangle_as_it_turns_the_face_within_5_percent_and_2_5_rms() {
    const FINE: i32 = 100;
    for ratio in [1.0, 1.3, 1.7, 1.8, 2.4, 4.0] {
        let half = [0.03 * ratio, 0.03];
        let face = Face {
            number: 0,
            normal: Vec3::z(),
            centre_m: Vec3::zeros(),
            axes: [Vec3::x(), Vec3::y()],
            extent: Extent::Rectangle(half),
        };
        let points: Vec<_> = face.samples().iter().map(|(at, share)| ([at.x, at.y], *share)).collect();
        let at = |i: i32, k: usize| half[k] * (2.0 * (f64::from(i) + 0.5) / f64::from(FINE) - 1.0);
        let cell = f64::from(FINE).powi(-2);
        let fine: Vec<_> =
            (0..FINE).flat_map(|i| (0..FINE).map(move |j| ([at(i, 0), at(j, 1)], cell))).collect();
        for across in [0, 1] {
            let (mut square, count) = (0.0, 13);
            for k in 1..=count {
                let arm = half[across] * f64::from(k) / f64::from(count + 1);
                let turn = |of: &[([f64; 2], f64)]| 1.0 / (centre_of_rotation_m(of, arm, across) + arm);
                let off = turn(&points) / turn(&fine) - 1.0;
                assert!(off.abs() < 0.05, "{ratio} {across} {arm}: {off}");
                square += off * off;
            }
            let rms = (square / f64::from(count)).sqrt();
            println!("{ratio} {across}: {rms:.4}");
            assert!(rms < 0.025, "{ratio} {across}: {rms}");
        }
    }
}
