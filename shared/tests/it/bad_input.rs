//! What cannot be solved gets a typed status in a bounded number of evaluations, and leaves
//! the last good state alone.

use heapless::Vec;
use nalgebra::UnitQuaternion;
use stickslip_selftest::push;
use stickslip_shared::cone::{Bodies, ContactPoint, Solution, SolveBudget, SolveStatus, solve};
use stickslip_shared::model::{Model, Scene, SupportContact};
use stickslip_shared::predictor::{Limits, ModelError, Predictor, Sample, validity};
use stickslip_shared::real::Vec3;
use stickslip_shared::track::Pose;

type Points = Vec<ContactPoint<f32>, 16>;

fn bodies() -> Bodies<f32> {
    Bodies {
        mass_kg: 0.2,
        inertia_kg_m2: [[2e-5, 0.0, 0.0], [0.0, 1.8e-4, 0.0], [0.0, 0.0, 1.8e-4]],
        jaw_mass_kg: 0.3,
        dt_s: 0.004,
        free: [0.0, 0.0, -0.04, 0.0, 0.0, 0.0, -0.5],
    }
}

fn point(x: f32, y: f32, normal: Vec3<f32>, approach_m_s: f32) -> ContactPoint<f32> {
    let t1 = Vec3::z();
    ContactPoint {
        lever_m: Vec3::new(x, y, 0.0),
        axes: [normal, t1, normal.cross(&t1)],
        jaw: 0.0,
        bias_m_s: [-approach_m_s, 0.0, 0.0],
        stiffness_n_s_m: [4e4; 3],
        mu: [0.4; 2],
        adhesion_n: 0.0,
        viscous_n_s_m: 0.0,
    }
}

fn solved(points: &Points, bodies: &Bodies<f32>) -> Solution<f32, 16> {
    let options = SolveBudget::present();
    let s = solve(points, bodies, &[0.0; 7], &options);
    // A Newton step is four evaluations; what has begun may add some.
    let work = 4 * s.iterations + s.evaluations;
    assert!(work <= options.max_work + 8, "{work} evaluations");
    if s.status != SolveStatus::BadInput {
        assert!(s.velocity.iter().all(|v| v.is_finite()), "{s:?}");
    }
    s
}

#[test]
fn numbers_that_are_none_are_refused_wherever_they_stand() {
    let good = point(0.0, -0.0125, Vec3::y(), 0.001);
    type Spoil = fn(&mut ContactPoint<f32>, f32);
    let spoils: [Spoil; 7] = [
        |p, x| p.lever_m.x = x,
        |p, x| p.axes[0].y = x,
        |p, x| p.axes[2].x = x,
        |p, x| p.bias_m_s[1] = x,
        |p, x| p.stiffness_n_s_m[0] = x,
        |p, x| p.mu[1] = x,
        |p, x| p.adhesion_n = x,
    ];
    for (k, spoil) in spoils.into_iter().enumerate() {
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for place in 0..3 {
                let mut points: Points = (0..3).map(|_| good).collect();
                spoil(&mut points[place], x);
                assert_eq!(solved(&points, &bodies()).status, SolveStatus::BadInput, "field {k}, {x}");
            }
        }
    }
}

#[test]
fn bodies_without_a_positive_mass_and_inertia_are_refused() {
    let points: Points = [point(0.0, -0.0125, Vec3::y(), 0.001)].into_iter().collect();
    for x in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let cases = [
            Bodies { mass_kg: x, ..bodies() },
            Bodies { jaw_mass_kg: x, ..bodies() },
            Bodies { dt_s: x, ..bodies() },
        ];
        for b in cases {
            assert_eq!(solved(&points, &b).status, SolveStatus::BadInput, "{b:?}");
        }
    }
    let mut rod = bodies();
    rod.inertia_kg_m2[0][0] = 0.0;
    let mut indefinite = bodies();
    indefinite.inertia_kg_m2[1][2] = 2e-4;
    indefinite.inertia_kg_m2[2][1] = 2e-4;
    for b in [rod, indefinite] {
        assert_eq!(solved(&points, &b).status, SolveStatus::BadInput);
    }
}

#[test]
fn without_contacts_the_object_flies_free() {
    let s = solved(&Points::new(), &bodies());
    assert_eq!(s.status, SolveStatus::Solved);
    assert_eq!(s.velocity, bodies().free);
}

#[test]
fn coincident_contacts_share_the_force_of_one() {
    let one: Points = [point(0.0, -0.0125, Vec3::y(), 0.001)].into_iter().collect();
    let four: Points = (0..4)
        .map(|_| {
            let p = one[0];
            ContactPoint { stiffness_n_s_m: p.stiffness_n_s_m.map(|k| k * 0.25), ..p }
        })
        .collect();
    let (a, b) = (solved(&one, &bodies()), solved(&four, &bodies()));
    assert_eq!((a.status, b.status), (SolveStatus::Solved, SolveStatus::Solved));
    let sum: f32 = b.force_n.iter().map(|f| f[0]).sum();
    assert!((sum - a.force_n[0][0]).abs() < 1e-3 * a.force_n[0][0], "{sum} of {:?}", a.force_n);
}

#[test]
fn an_object_crushed_between_advancing_walls_is_squeezed_in_bounded_time() {
    for speed in [0.01, 1.0, 100.0] {
        let walls: Points = [-0.01, 0.01]
            .into_iter()
            .flat_map(|x| [point(x, -0.0125, Vec3::y(), speed), point(x, 0.0125, -Vec3::y(), speed)])
            .collect();
        let s = solved(&walls, &bodies());
        assert_eq!(s.status, SolveStatus::Solved, "{speed}");
        // Both walls press with stiffness times approach; the object stays between them.
        for f in &s.force_n {
            assert!((f[0] - 4e4 * speed).abs() < 1e-3 * 4e4 * speed, "{f:?}");
        }
    }
}

fn scene(mass_kg: f32) -> Scene<f32> {
    push(mass_kg, 0.4).0
}

fn model(finger: f32) -> Model<f32> {
    push(0.2, finger).1
}

#[test]
fn masses_and_friction_out_of_bounds_are_refused_by_name() {
    for mass_kg in [0.0, -0.2, f32::NAN, f32::INFINITY] {
        let refused = Predictor::new(scene(mass_kg), model(0.4), Limits::default()).err();
        assert_eq!(refused, Some(ModelError::Mass), "{mass_kg}");
    }
    for mu in [-0.1, 10.1, f32::NAN, f32::INFINITY] {
        let refused = Predictor::new(scene(0.2), model(mu), Limits::default()).err();
        assert_eq!(refused, Some(ModelError::Friction), "{mu}");
    }
}

#[test]
fn a_sample_that_is_none_is_marked_and_the_state_kept() {
    let mut predictor = Predictor::new(scene(0.2), model(0.4), Limits::default()).unwrap();
    let pose = Pose::identity();
    let sample = |k: u32| Sample {
        t_s: k as f32 * 0.004,
        grip_cmd_n: 20.0,
        gripper: Some(pose),
        object: (k == 0).then_some(pose),
        pusher: Some(Pose { position_m: Vec3::new(-0.06, 0.0, 0.0), ..pose }),
        finger: [Some([0.0, 20.0, 0.0, 0.0, 0.0, 0.0]); 2],
    };
    let mut last = predictor.tick(&sample(0));
    for k in 1..20 {
        last = predictor.tick(&sample(k));
    }
    let bad = [
        Sample { t_s: f32::NAN, ..sample(20) },
        Sample { grip_cmd_n: f32::INFINITY, ..sample(20) },
        Sample { gripper: None, ..sample(20) },
        sample(3),
    ];
    for s in bad {
        let p = predictor.tick(&s);
        assert_ne!(p.validity & validity::SAMPLE, 0, "{s:?}");
        assert_eq!(p.position_m, last.position_m);
    }
    let p = predictor.tick(&sample(20));
    assert_eq!(p.validity & validity::SAMPLE, 0);
    assert!(p.position_m.iter().zip(last.position_m).all(|(a, b)| (a - b).abs() < 1e-6));
}

/// A plate above the object that comes down on it with `speed`, and a table below.
fn press() -> Scene<f32> {
    Scene { fingers: None, support: Some(SupportContact::Patch), ..scene(0.2) }
}

#[test]
fn an_object_crushed_between_plate_and_table_is_said_to_be_and_the_last_good_state_kept() {
    let mut predictor = Predictor::new(press(), model(0.4), Limits::default()).unwrap();
    let object = Pose::identity();
    // The plate's +X, its normal into the object, points down.
    let down = UnitQuaternion::from_axis_angle(&Vec3::y_axis(), core::f32::consts::FRAC_PI_2);
    let sample = |k: u32, height_m: f32| Sample {
        t_s: k as f32 * 0.004,
        grip_cmd_n: 0.0,
        gripper: None,
        object: (k == 0).then_some(object),
        pusher: Some(Pose { position_m: Vec3::new(0.0, 0.0, height_m), rotation: down }),
        finger: [None; 2],
    };
    let mut last = predictor.tick(&sample(0, 0.0126));
    let mut good = last;
    let (mut contradictory, mut k) = (0, 1);
    while contradictory < 12 && k < 400 {
        last = predictor.tick(&sample(k, 0.0126 - 1.6e-5 * k as f32));
        assert!(last.solver_iterations <= 60, "{last:?}");
        if last.solver_status == SolveStatus::Contradiction {
            contradictory += 1;
            assert_ne!(last.validity & validity::SOLVER, 0);
            assert_eq!((last.position_m, last.quaternion), (good.position_m, good.quaternion));
        } else {
            assert_eq!(contradictory, 0, "{last:?}");
            good = last;
        }
        k += 1;
    }
    assert_eq!(contradictory, 12, "{last:?}");
    // Half a millimetre of steel is not pressed away: the object has hardly moved until then.
    assert!(good.position_m[2].abs() < 1e-3, "{good:?}");
    // The plate is lifted: the model goes on from where it was.
    let free = predictor.tick(&sample(k, 0.013));
    assert_eq!(free.validity & validity::SOLVER, 0, "{free:?}");
    assert!((free.position_m[2] - good.position_m[2]).abs() < 2e-3, "{free:?}");
}

#[test]
fn limits_under_which_no_alarm_could_be_raised_are_refused_by_name() {
    use stickslip_shared::predictor::Limit;
    type Spoil = fn(&mut Limits) -> &mut f32;
    let fields: [(Limit, Spoil); 10] = [
        (Limit::Horizon, |l| &mut l.horizon_s),
        (Limit::Sag, |l| &mut l.sag_m),
        (Limit::Rotation, |l| &mut l.rotation_rad),
        (Limit::Slip, |l| &mut l.slip_m_s),
        (Limit::TargetUtilisation, |l| &mut l.target_utilisation),
        (Limit::Divergence, |l| &mut l.divergence_m),
        (Limit::SlipWarning, |l| &mut l.slip_warning_s),
        (Limit::DropWarning, |l| &mut l.drop_warning_s),
        (Limit::ForceRange, |l| &mut l.force_range_n),
        (Limit::TorqueRange, |l| &mut l.torque_range_nm),
    ];
    let (scene, model, _) = push(0.2, 0.4);
    for (name, field) in fields {
        for wrong in [f32::NAN, f32::INFINITY, -1.0] {
            let mut limits = Limits::default();
            *field(&mut limits) = wrong;
            let refused = Predictor::new(scene.clone(), model.clone(), limits).err();
            assert_eq!(refused, Some(ModelError::Limit(name)), "{wrong}");
        }
    }
}

#[test]
fn outlines_pushers_and_feet_that_are_none_are_refused_by_name() {
    use stickslip_shared::model::{PusherContact, Shape};
    let refused = |change: &dyn Fn(&mut Scene<f32>)| {
        let (mut scene, model, _) = push(0.2, 0.4);
        change(&mut scene);
        Predictor::new(scene, model, Limits::default()).err()
    };
    let polygon = |corners: &[[f32; 2]]| {
        let vertices_m = Vec::from_slice(corners).expect("few");
        refused(&|s| s.object.shape = Shape::Polygon { vertices_m: vertices_m.clone(), height_m: 0.02 })
    };
    let square = [[0.02, -0.02], [0.02, 0.02], [-0.02, 0.02], [-0.02, -0.02]];
    assert_eq!(polygon(&square), None);
    let mut clockwise = square;
    clockwise.reverse();
    assert_eq!(polygon(&clockwise), Some(ModelError::Polygon));
    // A dent, a star that winds twice, and an outline beside the centre of mass.
    assert_eq!(
        polygon(&[[0.02, -0.02], [0.005, 0.0], [0.02, 0.02], [-0.02, 0.0]]),
        Some(ModelError::Polygon)
    );
    assert_eq!(polygon(&square.map(|[x, y]| [x + 0.05, y])), Some(ModelError::Polygon));
    for wrong in [f32::NAN, -0.001, f32::INFINITY] {
        let tip = refused(&|s| s.pusher = Some(PusherContact::Point { tip_radius_m: wrong }));
        assert_eq!(tip, Some(ModelError::Pusher), "{wrong}");
    }
    let line = refused(&|s| s.pusher = Some(PusherContact::Line { length_m: 0.0 }));
    assert_eq!(line, Some(ModelError::Pusher));
    let feet = refused(&|s| s.support = Some(SupportContact::Points(Vec::new())));
    assert_eq!(feet, Some(ModelError::Support));
}

#[test]
fn a_look_ahead_that_cannot_be_solved_foresees_no_drop_and_its_flags_are_unsure() {
    use stickslip_shared::predictor::{Intent, Plan, Segment, flags};
    let (mut scene, model, limits) = push(0.2, 0.4);
    scene.pusher = None;
    let mut predictor = Predictor::new(scene, model, limits).expect("sound");
    let still = Segment {
        duration_s: 0.05,
        velocity_m_s: [0.0; 3],
        angular_rad_s: [0.0; 3],
        grip_n: 30.0,
        intent: Intent::Hold,
    };
    let mut plan = Plan { start_s: 0.0, segments: Vec::new() };
    let _ = plan.segments.push(still);
    // A speed that is none: the step ahead cannot be made.
    let _ = plan.segments.push(Segment { velocity_m_s: [f32::NAN, 0.0, 0.0], duration_s: 1.0, ..still });
    predictor.set_plan(plan);
    let wrench = |side: f32| Some([0.0, side * 30.0, 0.98, 0.0, 0.0, 0.0]);
    let mut last = None;
    for k in 0..6u8 {
        let sample = Sample {
            t_s: f32::from(k) * 0.004,
            grip_cmd_n: 30.0,
            gripper: Some(Pose::identity()),
            object: Some(Pose::identity()),
            pusher: None,
            finger: [wrench(-1.0), wrench(1.0)],
        };
        last = Some(predictor.tick(&sample));
    }
    let p = last.expect("six ticks");
    assert_eq!(p.solver_status, SolveStatus::Solved, "the present is solved");
    assert_ne!(p.validity & validity::FORESIGHT, 0, "{:#b}", p.validity);
    assert_eq!(p.drop_in_s, None);
    assert_eq!(p.flags & flags::DROP, 0);
    assert_ne!(p.flags & flags::UNSURE, 0);
}

/// Whether an object that the fingers let fall from 0.4 s on, with 0.4 of its weight borne, is said to be seen wrongly within
/// 40 ms; `share` of its fall is in the pose.
fn falls_and_is_said_to_be_seen_wrongly(share: f32) -> bool {
    use crate::common::Noise;
    let (mut scene, model, limits) = push(0.2, 0.4);
    scene.pusher = None;
    let mut predictor = Predictor::new(scene, model, limits).expect("sound");
    let mut noise = Noise(5);
    (0..110u16).any(|k| {
        let t_s = f32::from(k) * 0.004;
        let fallen_s = (t_s - 0.4).max(0.0);
        let borne_n = if fallen_s > 0.0 { 0.4 } else { 0.98 };
        let mut wrench = |side: f32| Some([0.0, side * 30.0, borne_n + 0.002 * noise.next(), 0.0, 0.0, 0.0]);
        let finger = [wrench(-1.0), wrench(1.0)];
        let sunk_m = share * 0.5 * 5.8 * fallen_s * fallen_s;
        let position_m = Vec3::new(1e-5 * noise.next(), 0.0, 1e-5 * noise.next() - sunk_m);
        let object = Some(Pose { position_m, ..Pose::identity() });
        let gripper = Some(Pose::identity());
        let p = predictor.tick(&Sample { t_s, grip_cmd_n: 30.0, gripper, object, pusher: None, finger });
        p.validity & validity::POSE != 0
    })
}

#[test]
fn a_pose_that_does_not_show_a_fall_that_the_fingers_feel_is_doubted_and_one_that_does_is_not() {
    assert!(falls_and_is_said_to_be_seen_wrongly(0.0));
    assert!(!falls_and_is_said_to_be_seen_wrongly(1.0));
}
