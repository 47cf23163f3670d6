//! Claims about sag: what the plan means to slide is no sag, whatever segments the plan consists
//! of; what goes down across the slide is.

use crate::common::Noise;
use nalgebra::UnitQuaternion;
use stickslip_selftest::push;
use stickslip_shared::predictor::{Intent, Limits, Plan, Prediction, Predictor, Sample, Segment, flags};
use stickslip_shared::real::Vec3;
use stickslip_shared::track::Pose;

const DT_S: f32 = 0.004;
/// Rest, push, rest.
const REST_S: f32 = 0.4;
const PUSH_S: f32 = 1.5;
const SPEED_M_S: f32 = 0.01;
/// Of each pose, on each axis.
const NOISE_M: f32 = 3e-5;

/// Noise of a pose on all axes.
fn on_axes(noise: &mut Noise) -> Vec3<f32> {
    Vec3::from_fn(|_, _| noise.next() * NOISE_M)
}

/// A push along -X and `slope_rad` upwards: the object stays where it is in the world, but sags by
/// `sag_m`, evenly over the push. The gripper's rest is in the plan as `rest_m_s`, with the intent to
/// slide, as a plan made from noisy poses has it.
fn predictions(slope_rad: f32, sag_m: f32, rest_m_s: [[f32; 3]; 2]) -> Vec<Prediction> {
    let (scene, model, limits) = push(0.2, 0.4);
    assert_eq!(limits.sag_m, Limits::default().sag_m);
    let mut predictor = Predictor::new(scene, model, limits).unwrap();
    let along = [-slope_rad.cos() * SPEED_M_S, 0.0, slope_rad.sin() * SPEED_M_S];
    let mut plan = Plan::default();
    let [before, after] = rest_m_s;
    for (duration_s, velocity_m_s) in [(REST_S, before), (PUSH_S, along), (REST_S, after)] {
        let segment =
            Segment { duration_s, velocity_m_s, grip_n: 20.0, intent: Intent::Slide, ..Segment::default() };
        plan.segments.push(segment).unwrap();
    }
    predictor.set_plan(plan);
    let mut noise = Noise(7);
    let ticks = ((REST_S + PUSH_S + REST_S) / DT_S) as u32;
    (0..ticks)
        .map(|k| {
            let t_s = k as f32 * DT_S;
            let pushed_s = (t_s - REST_S).clamp(0.0, PUSH_S);
            let sagged = Vec3::new(0.0, 0.0, -sag_m * pushed_s / PUSH_S);
            let at = |p: Vec3<f32>| Pose { position_m: p, rotation: UnitQuaternion::identity() };
            predictor.tick(&Sample {
                t_s,
                grip_cmd_n: 20.0,
                gripper: Some(at(Vec3::from(along) * pushed_s + on_axes(&mut noise))),
                object: Some(at(sagged + on_axes(&mut noise))),
                pusher: Some(at(Vec3::new(-0.0503, 0.0, 0.0))),
                finger: [None; 2],
            })
        })
        .collect()
}

/// Directions that noise gives a gripper at rest: 0.2 to 3 mm/s.
const RANDOM: [[[f32; 3]; 2]; 3] = [
    [[0.0002, 0.0, 0.0003], [0.0008, 0.0002, -0.0025]],
    [[0.0, 0.0001, -0.0002], [-0.001, 0.0, 0.0012]],
    [[0.001, 0.0, 0.003], [0.0, 0.0, 0.0]],
];

fn most_sag(all: &[Prediction]) -> f32 {
    all.iter().fold(0.0, |m, p| m.max(p.sag_m))
}

#[test]
fn a_push_whose_object_keeps_its_height_raises_no_sag_whatever_the_plan_says_of_rest() {
    for rest_m_s in RANDOM {
        for slope_rad in [0.0, 0.17, -0.17] {
            let all = predictions(slope_rad, 0.0, rest_m_s);
            let most = most_sag(&all);
            assert!(most < 2e-4, "slope {slope_rad}, rest {rest_m_s:?}: {most} m");
            assert!(all.iter().all(|p| p.flags & flags::SAG == 0), "slope {slope_rad}, rest {rest_m_s:?}");
        }
    }
}

#[test]
fn sag_of_several_millimetres_is_raised_and_stated_within_a_fifth() {
    for rest_m_s in RANDOM {
        for sag_m in [3e-3, 5e-3] {
            let all = predictions(0.0, sag_m, rest_m_s);
            let (most, last) = (most_sag(&all), all[all.len() - 1].sag_m);
            assert!(
                (most / sag_m - 1.0).abs() < 0.2 && (last / sag_m - 1.0).abs() < 0.2,
                "{most}, {last} of {sag_m}"
            );
            let raised = all.iter().position(|p| p.flags & flags::SAG != 0).expect("raised");
            // Not before 1 mm, half of the limit; the look-ahead may be early.
            let sagged = sag_m * (raised as f32 * DT_S - REST_S) / PUSH_S;
            assert!((1e-3..2.4e-3).contains(&sagged), "raised at {sagged} of {sag_m}");
        }
    }
}

#[test]
fn a_turn_about_the_pads_is_no_sag() {
    // Held 30 mm off its centre and turned by 0.3 rad: the centre goes 9 mm down.
    let (mut scene, model, limits) = push(0.2, 0.4);
    scene.pusher = None;
    let mut predictor = Predictor::new(scene, model, limits).unwrap();
    let mut plan = Plan::default();
    plan.segments
        .push(Segment { duration_s: 10.0, grip_n: 20.0, intent: Intent::Pivot, ..Segment::default() })
        .unwrap();
    predictor.set_plan(plan);
    for k in 0..400 {
        let angle = 0.3 * (k as f32 / 300.0).min(1.0);
        let rotation = UnitQuaternion::from_scaled_axis(Vec3::new(0.0, angle, 0.0));
        let p = predictor.tick(&Sample {
            t_s: k as f32 * DT_S,
            grip_cmd_n: 20.0,
            gripper: Some(Pose::identity()),
            object: Some(Pose { position_m: rotation * Vec3::new(0.03, 0.0, 0.0), rotation }),
            pusher: None,
            finger: [None; 2],
        });
        assert!(p.sag_m.abs() < 1e-4 && p.flags & flags::SAG == 0, "tick {k}: {p:?}");
    }
}
