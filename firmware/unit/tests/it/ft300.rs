//! The FT 300's stream.

use proptest::prelude::*;
use stickslip_unit::source::ft300::{BAUD, Ft300, STOP, STOP_COUNT, TRANSMISSION_US, start_stream};
use stickslip_unit::source::{Losses, Reading, WrenchSource};

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
    assert_eq!(source.losses(), Losses { damaged: 1, skipped: 15, faulty: 0 });
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
