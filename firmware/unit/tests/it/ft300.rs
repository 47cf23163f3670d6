//! The FT 300's stream.

use proptest::prelude::*;
use stickslip_shared::wire::{self, Calibration, Port, Sensor};
use stickslip_unit::fingers::Fingers;
use stickslip_unit::source::ft300::{BAUD, BYTE_US, Ft300, STOP, STOP_COUNT, TRANSMISSION_US, start_stream};
use stickslip_unit::source::{Losses, Reading, WrenchSource};

use super::bench::Unit;
use super::simulated::Robotiq;

fn feed(source: &mut Ft300, bytes: &[u8], at_us: u32) -> Vec<Reading> {
    bytes.iter().filter_map(|byte| source.take(*byte, at_us)).collect()
}

#[test]
fn the_sensor_begins_to_stream_when_asked_and_stops_when_told() {
    let mut sensor = Robotiq::default();
    // The manual's example of the request, its checksum included.
    assert_eq!(start_stream(), [0x09, 0x10, 0x01, 0x9a, 0x00, 0x01, 0x02, 0x02, 0x00, 0xcd, 0xca]);
    sensor.hear(&start_stream());
    assert!(sensor.streams);
    sensor.hear(&[STOP; STOP_COUNT]);
    assert!(!sensor.streams);
}

#[test]
fn a_reading_has_the_sensors_numbers_and_is_as_old_as_its_bytes_on_the_line() {
    let wrench = [12.34, -299.99, 0.01, 1.234, -29.999, 0.0];
    let mut source = Ft300::default();
    let found = feed(&mut source, &Robotiq::frame(wrench), 50_000);
    let [reading] = found[..] else { panic!("{found:?}") };
    for (got, sent) in reading.values.iter().zip(wrench) {
        assert!((got - sent).abs() < 1e-4, "{reading:?}");
    }
    assert_eq!(TRANSMISSION_US, 16 * 10 * 1_000_000 / BAUD);
    assert_eq!(reading.at_us, 50_000 - TRANSMISSION_US);
}

#[test]
fn a_damaged_frame_is_counted_and_the_next_one_read() {
    let mut source = Ft300::default();
    let mut bytes = Robotiq::frame([1.0; 6]).to_vec();
    bytes[7] ^= 0x10;
    bytes.extend(Robotiq::frame([2.0; 6]));
    let found = feed(&mut source, &bytes, 0);
    assert_eq!(found.len(), 1);
    assert!((found[0].values[0] - 2.0).abs() < 1e-6);
    assert_eq!(source.losses(), Losses { damaged: 1, skipped: 15, faulty: 0, lost: 0 });
}

#[test]
fn a_header_within_the_numbers_does_not_hide_a_frame() {
    // 0x4e20 / 100 = 200 N: the numbers themselves look like a header.
    let wrench = [200.0, 200.0, 200.0, 20.0, 20.0, 20.0];
    let frame = Robotiq::frame(wrench);
    for cut in 0..16 {
        let mut source = Ft300::default();
        let mut bytes = frame[cut..].to_vec();
        bytes.extend(frame.repeat(3));
        let found = feed(&mut source, &bytes, 0);
        assert!(found.len() >= 2, "cut {cut}: {}", found.len());
        assert!(found.iter().all(|r| (r.values[0] - 200.0).abs() < 1e-3));
    }
}

proptest! {
    #[test]
    fn any_bytes_are_survived_and_a_whole_frame_behind_them_is_found(
        garbage in prop::collection::vec(any::<u8>(), 0..200),
        at in any::<u32>(),
    ) {
        let mut source = Ft300::default();
        feed(&mut source, &garbage, at);
        let frames = Robotiq::frame([3.0, -4.0, 5.0, 0.1, 0.2, 0.3]).repeat(2);
        let found = feed(&mut source, &frames, at);
        // The garbage may end as a frame begins: then the first one is lost with it, never both.
        prop_assert!(!found.is_empty());
        prop_assert!((found[found.len() - 1].values[1] + 4.0).abs() < 1e-6);
    }
}

#[test]
fn a_reading_that_waited_on_the_way_is_as_old_as_it_is_also_of_a_sensor_whose_clock_is_its_own() {
    for ppm in [-1000.0, 0.0, 1000.0] {
        let mut unit = Unit::start(None);
        let sensors = [Sensor { port: Port::Ft300, finger: 1 }].into_iter().collect();
        assert_eq!(unit.request::<wire::SetSensors>(&sensors), Ok(()));
        let (mut oldest, mut youngest) = (0.0f64, 0.0f64);
        for k in 0..400u32 {
            // Frames of 100 Hz by the sensor's clock; one of five waits for up to 4.9 ms, one of fifty is lost.
            let measured_us = 20_000.0 + f64::from(k) * 10_000.0 * (1.0 + ppm * 1e-6);
            let waits_us = if k % 5 == 3 { f64::from(k * 37 % 4900) } else { 0.0 };
            if k % 50 == 20 {
                continue;
            }
            let come_us = (measured_us + f64::from(TRANSMISSION_US) + waits_us) as u32;
            let frame = Robotiq::frame([k as f32 * 0.01; 6]);
            unit.sensors.bytes(unit.between, &frame, come_us);
            let (_, _, reading) = unit.between.readings.try_receive().expect("a reading");
            let off_us = f64::from(reading.at_us) - measured_us;
            (oldest, youngest) = (oldest.min(off_us), youngest.max(off_us));
        }
        println!("{ppm} ppm: {oldest} to {youngest} us from when it was measured");
        // A sixteenth of a wait of 4.9 ms, and what a clock of 0.1 % is ahead.
        assert!(oldest > -200.0 && youngest < 500.0, "{ppm}: {oldest} {youngest}");
    }
}

#[test]
fn frames_that_are_missing_in_the_sensors_beat_are_counted_and_damaged_ones_once() {
    let mut unit = Unit::start(None);
    let sensors: wire::Sensors = [Sensor { port: Port::Ft300, finger: 0 }].into_iter().collect();
    assert_eq!(unit.request::<wire::SetSensors>(&sensors), Ok(()));
    let say = |unit: &Unit, k: u32, damaged: bool| {
        let mut frame = Robotiq::frame([k as f32 * 0.01; 6]);
        frame[7] ^= u8::from(damaged) << 4;
        // A clock 0.1 % fast, and bytes that wait for up to 3 ms.
        unit.sensors.bytes(unit.between, &frame, 20_000 + k * 9_990 + k * 37 % 3_000);
    };
    for k in 0..200u32 {
        match k {
            20 | 50..=52 => {}
            _ => say(&unit, k, k == 80),
        }
    }
    let counts = |unit: &Unit| {
        (unit.between.counters.readings_lost.get(), unit.between.counters.readings_damaged.get())
    };
    assert_eq!(counts(&unit), (4, 1));
    // A line that was silent for longer has no beat any more.
    (400..410).for_each(|k| say(&unit, k, false));
    // Of another assignment nothing is missing.
    assert_eq!(unit.request::<wire::SetSensors>(&sensors), Ok(()));
    (420..430).for_each(|k| say(&unit, k, false));
    assert_eq!(counts(&unit), (4, 1));
}

#[test]
fn frames_that_are_read_at_once_were_measured_one_after_the_other() {
    let mut unit = Unit::start(None);
    let sensors = [Sensor { port: Port::Ft300, finger: 0 }].into_iter().collect();
    assert_eq!(unit.request::<wire::SetSensors>(&sensors), Ok(()));
    let two = [Robotiq::frame([1.0; 6]), Robotiq::frame([2.0; 6])].concat();
    unit.sensors.bytes(unit.between, &two, 100_000);
    let found: Vec<u32> =
        std::iter::from_fn(|| unit.between.readings.try_receive()).map(|(_, _, r)| r.at_us).collect();
    assert_eq!(found[1], 100_000 - TRANSMISSION_US);
    assert!((found[1] - found[0]).abs_diff(16 * BYTE_US) <= 8, "{found:?}");
}

#[test]
fn a_late_reading_stands_no_longer_than_one_in_time() {
    // A finger with a matrix, three frames in time, a fourth 4 ms late, then none.
    for late_us in [0, 4_000] {
        let mut fingers = Fingers::new();
        fingers.assign(&[Sensor { port: Port::Ft300, finger: 0 }]).expect("one sensor");
        let matrix = core::array::from_fn(|i| core::array::from_fn(|j| f32::from(u8::from(i == j))));
        fingers.calibrate(&Calibration { finger: 0, matrix });
        let mut source = Ft300::default();
        let frame_us = |k: u32| 10_000 * (k + 1) + TRANSMISSION_US;
        for k in 0..4 {
            let come_us = frame_us(k) + if k == 3 { late_us } else { 0 };
            for reading in feed(&mut source, &Robotiq::frame([5.0; 6]), come_us) {
                assert!(fingers.take(Port::Ft300, 0, reading));
            }
        }
        // 8.3 ms on the line, a period and a half.
        let measured_us = 40_000;
        let stands_us = TRANSMISSION_US + 15_000;
        assert!(fingers.sample(measured_us + stands_us - 500).finger[0].is_some(), "{late_us}");
        assert!(fingers.sample(measured_us + stands_us + 500).finger[0].is_none(), "{late_us}");
    }
}
