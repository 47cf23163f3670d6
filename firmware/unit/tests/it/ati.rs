//! ATI's NETCANOEM.

use embedded_can::{Frame, StandardId};
use proptest::prelude::*;
use stickslip_unit::source::ati::{Ati, Received};
use stickslip_unit::source::{Reading, WrenchSource};

use super::simulated::{Can, Netcanoem};

fn sensor() -> Netcanoem {
    let mut matrix = [[0.0; 6]; 6];
    for (i, row) in matrix.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = (i * 6 + j) as f32 * 10.0 - 100.0;
        }
    }
    // Pounds and pound inches.
    Netcanoem { base: 0x20, counts: [1_000_000, 2_000_000], units: [1, 1], matrix, gauges: [0; 6], status: 0 }
}

/// One tick: the request goes out, the answers come in.
fn tick(source: &mut Ati, sensor: &Netcanoem, now_us: u32) -> Option<Reading> {
    let asked: Can = source.request(now_us)?.frame()?;
    let answers = sensor.answer(&asked);
    answers.iter().filter_map(|frame| source.take(Received::of(frame)?, now_us + 300)).last()
}

fn ready(sensor: &Netcanoem) -> Ati {
    let mut source = Ati::new(0x20).unwrap();
    for k in 0..8 {
        assert!(!source.is_ready());
        assert_eq!(tick(&mut source, sensor, k * 4000), None);
    }
    assert!(source.is_ready());
    source
}

#[test]
fn a_reading_is_the_sensors_matrix_times_its_gauges_in_newtons() {
    let mut sensor = sensor();
    let mut source = ready(&sensor);
    sensor.gauges = [100, -200, 300, -400, 500, -32768];
    let reading = tick(&mut source, &sensor, 100_000).expect("a reading");
    for (k, value) in reading.values.iter().enumerate() {
        let sum: f64 = (0..6).map(|j| f64::from(sensor.matrix[k][j]) * f64::from(sensor.gauges[j])).sum();
        let unit = if k < 3 { 4.448_221_615 / 1e6 } else { 0.112_984_829 / 2e6 };
        assert!((f64::from(*value) - sum * unit).abs() < 1e-5 * (sum * unit).abs().max(1e-3), "{k}: {value}");
    }
    assert_eq!(reading.at_us, 100_300);
}

#[test]
fn an_answer_that_does_not_come_is_asked_for_again_and_not_before() {
    let mut source = Ati::new(0x20).unwrap();
    let first = source.request(0).expect("counts a unit");
    assert_eq!(source.request(4_000), None);
    assert_eq!(source.request(20_000), Some(first));
}

#[test]
fn a_half_reading_is_none_and_halves_of_two_readings_are_not_put_together() {
    let sensor = sensor();
    let mut source = ready(&sensor);
    let asked: Can = source.request(0).unwrap().frame().unwrap();
    let halves = sensor.answer(&asked);
    let take = |source: &mut Ati, half: &Can, at_us| source.take(Received::of(half).unwrap(), at_us);
    // The first one is lost.
    assert_eq!(take(&mut source, &halves[1], 0), None);
    assert_eq!(source.losses().damaged, 1);
    // The second one is lost, and a later one comes.
    assert_eq!(take(&mut source, &halves[0], 10_000), None);
    assert_eq!(take(&mut source, &halves[1], 14_000), None);
    assert_eq!(source.losses().damaged, 2);
    assert_eq!(take(&mut source, &halves[0], 20_000), None);
    assert!(take(&mut source, &halves[1], 20_200).is_some());
}

#[test]
fn a_sensor_that_says_it_is_faulty_measures_nothing() {
    let mut sensor = sensor();
    let mut source = ready(&sensor);
    sensor.status = 0x0080;
    assert_eq!(tick(&mut source, &sensor, 0), None);
    assert_eq!((source.status(), source.losses().faulty), (0x0080, 1));
    sensor.status = 0;
    assert!(tick(&mut source, &sensor, 4000).is_some());
}

#[test]
fn frames_of_wrong_length_other_sensors_and_unknown_units_are_refused_and_nothing_is_lost() {
    let sensor = sensor();
    let mut source = ready(&sensor);
    for operation in 0..16u16 {
        for length in [0, 1, 5, 7] {
            let frame = Can::new(StandardId::new(0x200 + operation).unwrap(), &vec![0xff; length]).unwrap();
            assert_eq!(source.take(Received::of(&frame).unwrap(), 0), None);
        }
    }
    assert_eq!(source.losses().damaged, 64);
    let other = Can::new(StandardId::new(0x310).unwrap(), &[0; 8]).unwrap();
    assert_eq!(source.take(Received::of(&other).unwrap(), 0), None);
    assert_eq!(source.losses().skipped, 1);
    assert!(tick(&mut source, &sensor, 8000).is_some());
    assert!(Ati::new(0x80).is_err());

    let strange = Netcanoem { units: [9, 1], ..self::sensor() };
    let mut source = Ati::new(0x20).unwrap();
    for k in 0..20 {
        assert_eq!(tick(&mut source, &strange, k * 20_000), None);
    }
    assert!(!source.is_ready());
}

#[test]
fn a_matrix_with_a_number_that_is_none_is_not_taken() {
    let mut sensor = sensor();
    sensor.matrix[3][2] = f32::NAN;
    let mut source = Ati::new(0x20).unwrap();
    for k in 0..50 {
        assert_eq!(tick(&mut source, &sensor, k * 20_000), None);
    }
    assert!(!source.is_ready() && source.losses().damaged > 0);
}

proptest! {
    #[test]
    fn any_frames_are_survived_and_the_sensor_is_read_after_them(
        frames in prop::collection::vec((0u16..0x800, prop::collection::vec(any::<u8>(), 0..9), any::<u32>()), 0..100)
    ) {
        let mut source = Ati::new(0x20).unwrap();
        for (id, data, at_us) in &frames {
            let _ = source.take(Received { id: *id, data }, *at_us);
        }
        let sensor = sensor();
        let mut read = None;
        for k in 0..12 {
            read = tick(&mut source, &sensor, 5_000_000 + k * 20_000);
        }
        prop_assert!(read.is_some());
    }
}
