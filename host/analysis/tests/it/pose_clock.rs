//! How late the object's pose is behind the gripper's, against motions whose delay is known.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use stickslip_analysis::evidence::pose_clock::{self, Delay};
use stickslip_data::{Pose, Sample, Trial, TrialInfo, Wrench};

const STEP_S: f64 = 0.004;
/// When the gripper sets off, s.
const START_S: f64 = 0.2;
/// Free way until the pusher is touched, m.
const GAP_M: f64 = 6e-4;

/// How the object follows its gripper.
#[derive(Clone, Copy)]
enum Follows {
    /// At once, and is seen so much later, s.
    Late(f64),
    /// After so much play, m.
    Play(f64),
}

/// Way of a gripper that sets off within 20 ms, m.
fn way_m(speed_m_s: f64, t_s: f64) -> f64 {
    const RAMP_S: f64 = 0.02;
    let t_s = (t_s - START_S).max(0.0);
    if t_s < RAMP_S { 0.5 * speed_m_s * t_s * t_s / RAMP_S } else { speed_m_s * (t_s - 0.5 * RAMP_S) }
}

/// A push along X at this speed: the gripper moves an object that is 4 degrees askew in it until the pusher stands in its way.
fn push(speed_m_s: f64, follows: Follows, gap_m: f64, random: &mut ChaCha8Rng) -> Trial {
    let noise = Normal::new(0.0, 2e-5).expect("a deviation");
    let newtons = Normal::new(0.0, 0.02).expect("a deviation");
    let mut at = |x_m: f64, half_rad: f64| Pose {
        position_m: [x_m + noise.sample(random), noise.sample(random), 0.1 + noise.sample(random)],
        quaternion: [f64::cos(half_rad), 0.0, f64::sin(half_rad), 0.0],
    };
    // Held by the pusher the object stays where it is.
    let object_m = |t_s: f64| match follows {
        Follows::Late(late_s) => way_m(speed_m_s, t_s - late_s).min(gap_m),
        Follows::Play(play_m) => (way_m(speed_m_s, t_s) - play_m).clamp(0.0, gap_m),
    };
    let mut poses = Vec::new();
    for i in 0..200 {
        let t_s = f64::from(i) * STEP_S;
        poses.push((t_s, at(way_m(speed_m_s, t_s), 0.0), at(object_m(t_s), 0.035)));
    }
    let samples = poses.into_iter().map(|(t_s, gripper, object)| {
        let pressed_n = 2e4 * (way_m(speed_m_s, t_s) - gap_m).max(0.0);
        let force_n = [pressed_n.min(10.0) + newtons.sample(random), newtons.sample(random), 0.0];
        let pusher_wrench = Some(Wrench { force_n, torque_nm: [0.0; 3] });
        Sample { t_s, gripper: Some(gripper), object: Some(object), pusher_wrench, ..Sample::default() }
    });
    Trial { info: TrialInfo::default(), samples: samples.collect() }
}

/// Twelve pushes at 8 to 20 mm/s.
fn delay(follows: Follows, gap_m: f64) -> Option<Delay> {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let speeds = [0.008, 0.012, 0.02].into_iter().cycle().take(12);
    let trials: Vec<Trial> = speeds.map(|speed| push(speed, follows, gap_m, &mut random)).collect();
    Delay::measured(&trials.iter().collect::<Vec<_>>())
}

#[test]
fn an_object_that_is_seen_late_trails_the_gripper_by_that_time_at_each_speed() {
    for late_s in [-0.012, 0.008, 0.025, 0.06] {
        let found = delay(Follows::Late(late_s), GAP_M).expect("one delay");
        assert!((found.late_s - late_s).abs() < 4.0 * found.sd_s, "{late_s} s: {found:?}");
        assert!(found.sd_s < 5e-4 && found.trials == 12 && found.is_found(), "{late_s} s: {found:?}");
        assert_eq!(Delay::found_s(Some(found)), found.late_s);
    }
}

#[test]
fn an_object_that_is_seen_in_time_is_not_late() {
    let found = delay(Follows::Late(0.0), GAP_M).expect("a delay of nothing");
    assert!(found.late_s.abs() < 4.0 * found.sd_s && !found.is_found(), "{found:?}");
    assert_eq!(Delay::found_s(Some(found)), 0.0);
}

#[test]
fn an_object_that_trails_by_the_same_distance_at_each_speed_has_play_and_is_not_late() {
    for play_m in [1e-4, 2e-4] {
        let found = delay(Follows::Play(play_m), GAP_M);
        assert!(!found.is_some_and(|found| found.is_found()), "{play_m} m: {found:?}");
    }
}

#[test]
fn where_the_object_is_touched_as_soon_as_the_gripper_moves_no_delay_is_known() {
    assert_eq!(delay(Follows::Late(0.025), 0.0), None);
}

#[test]
fn seen_in_the_gripper_as_that_was_a_late_object_does_not_move_before_the_pusher_is_touched() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let trial = push(0.02, Follows::Late(0.025), GAP_M, &mut random);
    let farthest = |late_s: f64| {
        let before = |t_s: f64| way_m(0.02, t_s) < GAP_M;
        let seen = pose_clock::in_gripper(&trial, late_s);
        seen.iter().filter(|(t, _)| before(*t)).map(|(_, way)| way[0].abs()).fold(0.0, f64::max)
    };
    assert!(farthest(0.025) < 1.5e-4 && farthest(0.0) > 3.5e-4, "{} {}", farthest(0.025), farthest(0.0));
}
