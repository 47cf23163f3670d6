//! The tick's sample from sensors of all rates, and the host's poses beside them: what is no measurement is none.

use proptest::prelude::*;
use stickslip_shared::wire::{Calibration, Grasp, Port, Pose, Refusal, Sample, Sensor};
use stickslip_unit::bus::OWN_IDS;
use stickslip_unit::fingers::{Fingers, TARE_US};
use stickslip_unit::host_clock::MAX_AGE_US;
use stickslip_unit::source::ft300::Ft300;
use stickslip_unit::source::gauges::{CHANNELS, Gauges};
use stickslip_unit::source::{Reading, WrenchSource};

use super::simulated::Robotiq;

const QUIET: [u16; CHANNELS] = [2000; CHANNELS];
const BOTH: [Sensor; 2] =
    [Sensor { port: Port::Gauges, finger: 0 }, Sensor { port: Port::Gauges, finger: 1 }];

fn diagonal(finger: u8, entry: f32) -> Calibration {
    let mut matrix = [[0.0; 6]; 6];
    for (k, row) in matrix.iter_mut().enumerate() {
        row[k] = entry;
    }
    Calibration { finger, matrix }
}

/// Reads the converters at `now_us`.
fn read(fingers: &mut Fingers, counts: &[u16; CHANNELS], now_us: u32) {
    for finger in [0, 1] {
        if let Some(reading) = Gauges::new(finger).take(counts, now_us) {
            fingers.take(Port::Gauges, finger, reading);
        }
    }
}

fn sample(fingers: &mut Fingers, counts: &[u16; CHANNELS], now_us: u32) -> Sample {
    read(fingers, counts, now_us);
    fingers.sample(now_us)
}

/// Gauges with matrix and tare; its clock begins at zero again.
fn calibrated() -> Fingers {
    let mut fingers = Fingers::new();
    fingers.assign(&BOTH).unwrap();
    for finger in [0, 1] {
        fingers.calibrate(&diagonal(finger, 0.01));
    }
    fingers.tare();
    for k in 0..=125 {
        read(&mut fingers, &QUIET, (k * 4000_u32).wrapping_sub(1_000_000));
    }
    assert!(!fingers.is_taring());
    fingers
}

fn pose(x: f32) -> Pose {
    Pose { position_m: [x, 0.0, 0.0], quaternion: [1.0, 0.0, 0.0, 0.0] }
}

fn told(seq: u32, x: f32) -> Sample {
    Sample {
        seq,
        t_us: 0,
        grip_cmd_n: 20.0,
        gripper: Some(pose(0.0)),
        object: Some(pose(x)),
        pusher: None,
        finger: [None; 2],
    }
}

#[test]
fn a_finger_without_a_calibration_has_no_wrench() {
    let mut fingers = Fingers::new();
    fingers.assign(&BOTH).unwrap();
    assert_eq!(fingers.uncalibrated(), Some(0));
    assert_eq!(sample(&mut fingers, &QUIET, 0).finger, [None; 2]);
    fingers.calibrate(&diagonal(0, 1e-3));
    assert_eq!(fingers.uncalibrated(), Some(1));
    let [first, second] = sample(&mut fingers, &QUIET, 4000).finger;
    assert!(first.is_some() && second.is_none());
    assert_eq!(calibrated().uncalibrated(), None);
}

#[test]
fn counts_become_newtons_after_calibration_and_tare() {
    let mut fingers = calibrated();
    let mut counts = QUIET;
    counts[7] += 100;
    let [first, second] = sample(&mut fingers, &counts, 0).finger;
    assert_eq!(first, Some([0.0; 6]));
    let second = second.expect("calibrated");
    assert!((second[1] - 1.0).abs() < 1e-5 && second[0] == 0.0, "{second:?}");
}

#[test]
fn a_failed_conversion_or_a_saturated_channel_is_no_measurement() {
    let mut fingers = calibrated();
    assert!(sample(&mut fingers, &QUIET, 0).finger[0].is_some());
    assert_eq!(fingers.sample(4000).finger, [None; 2]);
    let mut counts = QUIET;
    counts[3] = 4095;
    let [first, second] = sample(&mut fingers, &counts, 8000).finger;
    assert!(first.is_none() && second.is_some());
}

#[test]
fn an_object_pose_is_a_measurement_once_and_old_poses_are_none() {
    let mut fingers = calibrated();
    fingers.told(told(0, 0.1), 0);
    let first = sample(&mut fingers, &QUIET, 1000);
    assert!(first.object.is_some() && first.gripper.is_some());
    assert_eq!(first.grip_cmd_n, 20.0);
    // The host is silent: the object is not measured again, the gripper's pose stands a while.
    let second = sample(&mut fingers, &QUIET, 5000);
    assert!(second.object.is_none() && second.gripper.is_some());
    let stale = sample(&mut fingers, &QUIET, MAX_AGE_US + 1);
    assert!(stale.object.is_none() && stale.gripper.is_none(), "{stale:?}");
    assert!(stale.grip_cmd_n.is_nan(), "the grip is not known either");
    fingers.told(told(1, 0.1), 30_000);
    assert!(sample(&mut fingers, &QUIET, 30_500).object.is_some());
}

#[test]
fn stored_poses_stand_in_for_a_host_that_never_spoke_and_not_for_one_that_fell_silent() {
    let mut fingers = calibrated();
    fingers.set_grasp(Some(Grasp { gripper: pose(0.5), object: pose(0.6) }));
    fingers.set_grip(17.0);
    let first = sample(&mut fingers, &QUIET, 0);
    assert_eq!((first.gripper, first.object), (Some(pose(0.5)), Some(pose(0.6))));
    assert_eq!(first.grip_cmd_n, 17.0, "the stored set-point: without one nothing is predicted");
    let second = sample(&mut fingers, &QUIET, 4000);
    assert_eq!((second.gripper, second.object), (Some(pose(0.5)), None));
    assert!(fingers.is_alone());
    fingers.told(told(0, 0.1), 5000);
    assert_eq!(sample(&mut fingers, &QUIET, 8000).gripper, Some(pose(0.0)));
    let stale = sample(&mut fingers, &QUIET, 100_000);
    assert!(stale.gripper.is_none() && !fingers.is_alone());
}

#[test]
fn time_is_the_clocks_also_over_failed_conversions_and_the_wrap_of_the_clock() {
    let mut fingers = calibrated();
    let start = u32::MAX - 10_000;
    let at: Vec<u32> = [0u32, 4000, 8000, 28_000]
        .into_iter()
        .map(|t| sample(&mut fingers, &QUIET, start.wrapping_add(t)).t_us)
        .collect();
    // Four ticks without a conversion lie between the last two.
    assert_eq!(at, [0, 4000, 8000, 28_000]);
}

#[test]
fn sensors_of_different_rates_are_merged_by_their_times_and_lost_frames_are_no_measurement() {
    let mut fingers = Fingers::new();
    let ft300 = Sensor { port: Port::Ft300, finger: 1 };
    fingers.assign(&[BOTH[0], ft300]).unwrap();
    fingers.calibrate(&diagonal(0, 0.01));
    fingers.calibrate(&diagonal(1, 1.0));
    let mut source = Ft300::default();
    let mut measured = 0;
    // A second at 250 Hz; the FT 300's frames end every 10 ms, but for two that are lost after half a second.
    for now_us in (0..1_000_000).step_by(4000) {
        for end_us in (0..1_000_000).step_by(10_000).filter(|t| now_us - 4000 < *t && *t <= now_us) {
            if (500_000..520_000).contains(&end_us) {
                continue;
            }
            let load = end_us as f32 * 1e-5;
            for byte in Robotiq::frame([0.0, load, 0.0, 0.0, 0.0, 0.0]) {
                if let Some(reading) = source.take(byte, end_us as u32) {
                    assert!(fingers.take(Port::Ft300, 1, reading));
                }
            }
        }
        let [first, second] = sample(&mut fingers, &QUIET, now_us as u32).finger;
        assert!(first.is_some(), "the fast one has every tick");
        if let Some(wrench) = second {
            measured += 1;
            // Never older than the frame and its delay.
            assert!((now_us as f32 * 1e-5 - wrench[1]) <= 0.1501, "{now_us}: {wrench:?}");
        } else {
            assert!((500_000..530_000).contains(&now_us), "{now_us}");
        }
    }
    assert!((243..250).contains(&measured), "{measured}");
}

#[test]
fn a_reading_that_is_late_not_finite_or_of_another_port_is_not_used() {
    let mut fingers = calibrated();
    let reading = |at_us, x| Reading { at_us, stands_us: 10_000, values: [x; 6] };
    assert!(fingers.take(Port::Gauges, 0, reading(8000, 2100.0)));
    let before = fingers.sample(8000).finger;
    assert!(!fingers.take(Port::Gauges, 0, reading(4000, 9.0)), "late");
    assert!(!fingers.take(Port::Gauges, 0, reading(8000, 9.0)), "twice");
    assert!(!fingers.take(Port::Gauges, 0, reading(12_000, f32::NAN)), "not finite");
    assert!(!fingers.take(Port::Can, 0, reading(12_000, 9.0)), "not its sensor");
    assert!(!fingers.take(Port::Gauges, 2, reading(12_000, 9.0)), "no such finger");
    assert_eq!(fingers.sample(8000).finger, before);
}

#[test]
fn two_sensors_for_one_finger_are_refused_and_the_old_ones_stay() {
    let mut fingers = calibrated();
    let sensor = |port, finger| Sensor { port, finger };
    let refused = |fingers: &mut Fingers, list: &[Sensor]| fingers.assign(list).unwrap_err();
    let doubled = [sensor(Port::Gauges, 0), sensor(Port::Ft300, 0)];
    assert_eq!(refused(&mut fingers, &doubled), Refusal::RoleTaken { finger: 0 });
    let one = [sensor(Port::Ft300, 0), sensor(Port::Ft300, 1)];
    assert_eq!(refused(&mut fingers, &one), Refusal::PortTaken { port: Port::Ft300 });
    assert!(matches!(refused(&mut fingers, &[sensor(Port::Can, 2)]), Refusal::OutOfRange { .. }));
    assert!(matches!(
        refused(&mut fingers, &[sensor(Port::Ati { base: 128 }, 0)]),
        Refusal::OutOfRange { .. }
    ));
    assert_eq!(fingers.sensors().collect::<Vec<_>>(), BOTH);
    assert!(sample(&mut fingers, &QUIET, 0).finger.iter().all(Option::is_some), "matrix and tare are kept");
    let ati = [sensor(Port::Ati { base: 1 }, 0), sensor(Port::Ati { base: 2 }, 1)];
    assert_eq!(fingers.assign(&ati), Ok(()));
    assert_eq!(fingers.uncalibrated(), Some(0), "another sensor has another matrix");
}

#[test]
fn an_ati_sensor_shares_no_identifier_and_no_bus_with_the_units_own_frames_of_wrenches() {
    let mut fingers = calibrated();
    let ati = |base, finger| Sensor { port: Port::Ati { base }, finger };
    for base in 0..128 {
        let answer = fingers.assign(&[ati(base, 0)]);
        let own = OWN_IDS.iter().any(|id| (u16::from(base) << 4..=u16::from(base) << 4 | 0xf).contains(id));
        assert_eq!(answer, if own { Err(Refusal::BaseTaken { base }) } else { Ok(()) });
        assert_eq!(own, base == 0x11 || base == 0x12);
    }
    let can = |finger| Sensor { port: Port::Can, finger };
    for mixed in [[ati(5, 0), can(1)], [can(0), ati(5, 1)]] {
        assert_eq!(fingers.assign(&mixed), Err(Refusal::ClassicBus));
    }
    assert_eq!(fingers.sensors().collect::<Vec<_>>(), [ati(127, 0)], "the old ones stay");
    assert_eq!(fingers.assign(&[ati(5, 0), Sensor { port: Port::Gauges, finger: 1 }]), Ok(()));
}

#[test]
fn the_oldest_reading_that_is_used_says_when_a_sample_was_measured() {
    let mut fingers = Fingers::new();
    fingers.assign(&[BOTH[0], Sensor { port: Port::Can, finger: 1 }]).unwrap();
    fingers.calibrate(&diagonal(0, 0.01));
    fingers.calibrate(&diagonal(1, 1.0));
    let measured = |fingers: &mut Fingers, now_us| (fingers.sample(now_us).t_us, fingers.measured_us());
    assert_eq!(measured(&mut fingers, 1_000), (0, 1_000), "none is there");
    let reading = |at_us| Reading { at_us, stands_us: 20_000, values: [1.0; 6] };
    assert!(fingers.take(Port::Gauges, 0, reading(4_500)));
    assert_eq!(measured(&mut fingers, 5_000), (4_000, 4_500));
    assert!(fingers.take(Port::Can, 1, reading(3_000)));
    assert_eq!(measured(&mut fingers, 9_000), (8_000, 3_000));
    // The second one does not stand any more.
    assert_eq!(measured(&mut fingers, 24_000), (23_000, 4_500));
    assert_eq!(measured(&mut fingers, 60_000), (59_000, 60_000));
}

#[test]
fn a_pause_in_the_readings_begins_a_tare_anew() {
    let mut fingers = Fingers::new();
    fingers.assign(&BOTH).unwrap();
    fingers.tare();
    let mut loaded = QUIET;
    loaded[0] += 500;
    for k in 0..50 {
        read(&mut fingers, &loaded, k * 4000);
    }
    for k in 0..=TARE_US / 4000 {
        assert!(fingers.is_taring());
        read(&mut fingers, &QUIET, 1_000_000 + k * 4000);
    }
    assert!(!fingers.is_taring());
    assert_eq!(fingers.offsets(), [[2000.0; 6]; 2]);
}

proptest! {
    #[test]
    fn any_readings_are_survived_and_no_wrench_is_not_finite(
        readings in prop::collection::vec((any::<u32>(), any::<u32>(), any::<[f32; 6]>(), 0u8..3), 0..60)
    ) {
        let mut fingers = calibrated();
        fingers.tare();
        for (at_us, stands_us, values, finger) in readings {
            fingers.take(Port::Gauges, finger, Reading { at_us, stands_us, values });
            let sample = fingers.sample(at_us);
            // Huge values may overflow in the product: the predictor's own check refuses those.
            for wrench in sample.finger.iter().flatten() {
                prop_assert!(wrench.iter().all(|x| x.is_finite()) || values.iter().any(|v| v.abs() > 1e30));
            }
        }
    }
}
