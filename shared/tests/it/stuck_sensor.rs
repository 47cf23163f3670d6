//! A quiet converter repeats itself; a stuck sensor does nothing else. So does a camera.

use crate::common::{Noise, at, pose};
use nalgebra::UnitQuaternion;
use stickslip_shared::health::{Health, Repeats};

/// Poses of an object at rest with noise of 20 um, in steps of `step_m` (0: as they are).
fn poses(step_m: f64, noise: &mut Noise) -> stickslip_shared::track::Pose<f32> {
    let mut one = |centre_m: f64| {
        let x = centre_m + 2e-5 * f64::from(noise.next());
        if step_m > 0.0 { (x / step_m).round() * step_m } else { x }
    };
    pose(at(one(0.1), one(0.0), one(0.3)), UnitQuaternion::identity())
}

#[test]
fn a_pose_that_repeats_itself_is_frozen_within_three_samples_and_one_that_moves_again_is_used() {
    let (mut health, mut noise) = (Health::<f32>::default(), Noise(5));
    for tick in 0..250 {
        assert!(health.repeats(&poses(0.0, &mut noise)) == Repeats::No, "tick {tick}");
    }
    let last = poses(0.0, &mut noise);
    let told: Vec<bool> = (0..6).map(|_| health.repeats(&last) == Repeats::Frozen).collect();
    assert_eq!(told, [false, false, true, true, true, true]);
    assert!(health.repeats(&poses(0.0, &mut noise)) == Repeats::No);
}

#[test]
fn a_coarse_camera_and_one_of_31_hz_that_holds_its_poses_are_not_frozen_in_1000_s() {
    for (step_m, held) in [(1e-4, 1), (0.0, 8), (1e-4, 8)] {
        let (mut health, mut noise) = (Health::<f32>::default(), Noise(5));
        let mut accused = 0;
        for _ in 0..250_000 / held {
            let now = poses(step_m, &mut noise);
            accused += (0..held).filter(|_| health.repeats(&now) == Repeats::Frozen).count();
        }
        assert!(accused < 3, "{accused} with steps of {step_m} m, each held {held} times");
    }
}

#[test]
fn frames_of_a_slower_camera_that_are_held_are_found_out_and_rounding_at_rest_is_not() {
    // Steps, samples a frame, and within how many frames it is told; a camera of 60 Hz gives four or five samples each.
    for (step_m, held, within) in [(0.0, 8, Some(40)), (0.0, 4, Some(40)), (1e-4, 1, None), (2e-5, 1, None)] {
        let (mut health, mut noise) = (Health::<f32>::default(), Noise(7));
        let mut told = None;
        for frame in 0..50_000 {
            let now = poses(step_m, &mut noise);
            let samples = if held == 4 { 4 + usize::from(frame % 6 == 0) } else { held };
            let late = (0..samples).filter(|_| health.repeats(&now) == Repeats::Held).count();
            told = told.or((late > 0).then_some(frame));
        }
        match within {
            Some(most) => assert!(told.is_some_and(|f| f < most), "{held} samples a frame: {told:?}"),
            None => assert_eq!(told, None, "steps of {step_m} m"),
        }
    }
}

#[test]
fn an_object_of_a_simulation_without_noise_is_not_frozen_when_it_comes_to_rest() {
    let mut health = Health::<f32>::default();
    // 2 s at rest, 2 s at 20 mm/s, swung at 2 Hz for 2 s, at rest.
    for tick in 0..10_000 {
        let t_s = 0.004 * f64::from(tick);
        let moved_m = 0.02 * (t_s - 2.0).clamp(0.0, 2.0);
        let swung_m = 0.005 * (std::f64::consts::TAU * 2.0 * (t_s - 4.0).clamp(0.0, 2.0)).sin();
        let now = pose(at(0.1 + moved_m, swung_m, 0.3), UnitQuaternion::identity());
        assert!(health.repeats(&now) == Repeats::No, "at {t_s} s");
    }
}

#[test]
fn equal_counts_of_a_quiet_amplifier_are_no_stuck_sensor_and_a_stuck_one_is_found() {
    use stickslip_shared::predictor::{Limits, Sample as Tick, validity};
    let mut random = 1u32;
    let mut draw = move || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        random >> 8
    };
    let mut health = Health::<f32>::default();
    let limits = Limits::default();
    let mut check = |wrench: [f32; 6], t_s: f32| {
        let mut other = wrench;
        other[0] += t_s;
        let sample = Tick {
            t_s,
            grip_cmd_n: 20.0,
            gripper: None,
            object: None,
            pusher: None,
            finger: [Some(wrench), Some(other)],
        };
        health.check(&sample, &limits).1 & validity::STUCK != 0
    };
    // Each of six channels moves by a count in every second reading or less: one reading in ten is equal.
    let (mut wrench, mut accused, mut equal) = ([2.0f32; 6], 0, 0);
    for k in 0..250_000u32 {
        let before = wrench;
        for w in &mut wrench {
            *w = 2.0 + if draw() % 100 < 16 { 0.01 } else { 0.0 } * ((draw() % 3) as f32 - 1.0);
        }
        equal += u32::from(before == wrench);
        accused += u32::from(check(wrench, k as f32 * 0.004));
    }
    assert!(equal > 20_000, "{equal}");
    assert!(accused < 3, "{accused} false alarms in 1000 s");
    let found = (0..50).find(|k| check(wrench, 1000.0 + *k as f32 * 0.004));
    assert!(found.is_some_and(|k| k < 20), "{found:?}");
}
