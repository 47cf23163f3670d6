//! Strain gauges: what is no measurement is none.

use stickslip_shared::gauges::{CHANNELS, GaugeModel, MAX_AGE_US, TARE_READINGS};
use stickslip_shared::wire::{Calibration, Pose, Sample};

const QUIET: [u16; CHANNELS] = [2000; CHANNELS];

fn calibrated() -> GaugeModel {
    let mut model = GaugeModel::new();
    for finger in [0, 1] {
        let mut matrix = [[0.0; 6]; 6];
        for (k, row) in matrix.iter_mut().enumerate() {
            row[k] = 0.01;
        }
        model.calibrate(&Calibration { finger, matrix });
    }
    model.tare();
    for _ in 0..TARE_READINGS {
        model.read(&QUIET);
    }
    model
}

fn told(seq: u32, x: f32) -> Sample {
    let pose = |x| Some(Pose { position_m: [x, 0.0, 0.0], quaternion: [1.0, 0.0, 0.0, 0.0] });
    Sample {
        seq,
        t_us: 0,
        grip_cmd_n: 20.0,
        gripper: pose(0.0),
        object: pose(x),
        pusher: None,
        finger: [None; 2],
    }
}

#[test]
fn a_finger_without_a_calibration_has_no_wrench() {
    let mut model = GaugeModel::new();
    assert_eq!(model.uncalibrated(), Some(0));
    assert_eq!(model.sample(&QUIET, 0).finger, [None; 2]);
    model.calibrate(&Calibration { finger: 0, matrix: [[1e-3; 6]; 6] });
    assert_eq!(model.uncalibrated(), Some(1));
    let [first, second] = model.sample(&QUIET, 4000).finger;
    assert!(first.is_some() && second.is_none());
    assert_eq!(calibrated().uncalibrated(), None);
}

#[test]
fn counts_become_newtons_after_calibration_and_tare() {
    let mut model = calibrated();
    let mut counts = QUIET;
    counts[7] += 100;
    let [first, second] = model.sample(&counts, 0).finger;
    assert_eq!(first, Some([0.0; 6]));
    let second = second.expect("calibrated");
    assert!((second[1] - 1.0).abs() < 1e-5 && second[0] == 0.0, "{second:?}");
}

#[test]
fn an_object_pose_is_a_measurement_once_and_old_poses_are_none() {
    let mut model = calibrated();
    model.told(told(0, 0.1), 0);
    let first = model.sample(&QUIET, 1000);
    assert!(first.object.is_some() && first.gripper.is_some());
    assert_eq!(first.grip_cmd_n, 20.0);
    // The host is silent: the object is not measured again, the gripper's pose stands a while.
    let second = model.sample(&QUIET, 5000);
    assert!(second.object.is_none() && second.gripper.is_some());
    let stale = model.sample(&QUIET, MAX_AGE_US + 1);
    assert!(stale.object.is_none() && stale.gripper.is_none(), "{stale:?}");
    assert!(stale.grip_cmd_n.is_nan(), "the grip is not known either");
    model.told(told(1, 0.1), 30_000);
    assert!(model.sample(&QUIET, 30_500).object.is_some());
}

#[test]
fn time_is_the_clocks_also_over_failed_conversions_and_the_wrap_of_the_clock() {
    let mut model = calibrated();
    let start = u32::MAX - 10_000;
    let at: Vec<u32> = [0u32, 4000, 8000, 28_000]
        .into_iter()
        .map(|t| model.sample(&QUIET, start.wrapping_add(t)).t_us)
        .collect();
    // Four ticks without a conversion lie between the last two.
    assert_eq!(at, [0, 4000, 8000, 28_000]);
}

#[test]
fn equal_counts_of_a_quiet_amplifier_are_no_stuck_sensor_and_a_stuck_one_is_found() {
    use stickslip_shared::health::Health;
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
