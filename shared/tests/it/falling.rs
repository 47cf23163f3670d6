//! A fall is one in the grasp: the gripper's own speed has no part in it.

use nalgebra::UnitQuaternion;
use stickslip_shared::model::{Base, FingerContact, Friction, Model, Object, Scene, Shape};
use stickslip_shared::predictor::{Intent, Limits, Plan, Prediction, Predictor, Sample, Segment, flags};
use stickslip_shared::real::Vec3;
use stickslip_shared::track::Pose;

const DT: f64 = 0.004;
const WEIGHT_N: f64 = 0.2 * 9.81;
const MU: f64 = 0.4;
/// Ticks before the grip is opened, and after.
const HELD: usize = 100;
const OPEN: usize = 50;

/// A gripper that moves up at `speed_m_s` all the time, its plan says so, and opens after [`HELD`] ticks to `open_n`.
fn carried(speed_m_s: f64, open_n: f64) -> Vec<Prediction> {
    let (across, along) =
        (0.2 * 2.0 * 0.025f64.powi(2) / 12.0, 0.2 * (0.1f64.powi(2) + 0.025f64.powi(2)) / 12.0);
    let scene = Scene {
        gravity_m_s2: [0.0, 0.0, -9.81],
        object: Object {
            shape: Shape::Prism { length_m: 0.1, side_m: 0.025 },
            mass_kg: 0.2,
            inertia_kg_m2: [[across, 0.0, 0.0], [0.0, along, 0.0], [0.0, 0.0, along]],
        },
        fingers: Some(FingerContact::Disc { diameter_m: 0.02 }),
        pusher: None,
        support: None,
    };
    let friction = Friction { finger: MU, pusher: 0.25, support: 0.3 };
    let mut predictor =
        Predictor::<f64>::new(scene, Model::base(Base::Hard, friction), Limits::default()).unwrap();
    let full_n = 1.5 * WEIGHT_N / (2.0 * MU);
    // A motion that may slide: the model's fall is told as it is, not weighed against the load.
    let segment = |duration_s, grip_n: f64| Segment {
        duration_s,
        velocity_m_s: [0.0, 0.0, speed_m_s as f32],
        angular_rad_s: [0.0; 3],
        grip_n: grip_n as f32,
        intent: Intent::Slide,
    };
    let mut plan = Plan::default();
    plan.segments.push(segment((HELD as f64 * DT) as f32, full_n)).unwrap();
    plan.segments.push(segment(100.0, open_n)).unwrap();
    predictor.set_plan(plan);
    let (mut fallen_m, mut falls_m_s) = (0.0, 0.0);
    let ticks = (0..HELD + OPEN).map(|tick| {
        let t_s = tick as f64 * DT;
        let grip_n = if tick < HELD { full_n } else { open_n };
        let carried_n = (2.0 * MU * grip_n).min(WEIGHT_N);
        falls_m_s += (WEIGHT_N - carried_n) / 0.2 * DT;
        fallen_m += falls_m_s * DT;
        let at = |below_m: f64| Pose {
            position_m: Vec3::new(0.0, 0.0, speed_m_s * t_s - below_m),
            rotation: UnitQuaternion::identity(),
        };
        let finger = [-1.0, 1.0].map(|side| Some([0.0, side * grip_n, 0.5 * carried_n, 0.0, 0.0, 0.0]));
        let sample = Sample {
            t_s,
            grip_cmd_n: grip_n,
            gripper: Some(at(0.0)),
            object: Some(at(fallen_m)),
            pusher: None,
            finger,
        };
        predictor.tick(&sample)
    });
    ticks.collect()
}

#[test]
fn an_object_held_fast_is_not_said_to_fall_however_fast_it_is_carried() {
    let full_n = 1.5 * WEIGHT_N / (2.0 * MU);
    for speed_m_s in [-1.0, -0.3, -0.06, 0.06, 0.3, 1.0] {
        for (tick, p) in carried(speed_m_s, full_n).iter().enumerate() {
            assert_eq!(p.drop_in_s, None, "{speed_m_s} m/s, tick {tick}");
            assert_eq!(p.flags & flags::DROP, 0, "{speed_m_s} m/s, tick {tick}");
        }
    }
}

#[test]
fn an_object_that_falls_is_said_to_at_the_same_time_whether_the_gripper_stands_or_moves() {
    // A fifth of the weight is still borne: 7.8 m/s^2 in the grasp.
    let open_n = 0.2 * WEIGHT_N / (2.0 * MU);
    let first = |speed_m_s: f64| carried(speed_m_s, open_n).iter().position(|p| p.drop_in_s.is_some());
    let standing = first(0.0).expect("a drop is foreseen");
    assert!(standing <= HELD, "foreseen in tick {standing}, the grip opens in {HELD}");
    for speed_m_s in [-1.0, -0.3, 0.3, 1.0] {
        let tick = first(speed_m_s).expect("a drop is foreseen");
        // One step of the look-ahead, 20 ms: which of its steps is the last is a matter of rounding.
        assert!(tick.abs_diff(standing) <= 5, "{speed_m_s} m/s: tick {tick}, standing {standing}");
    }
}
