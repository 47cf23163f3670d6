//! The frames on CAN-FD, held against the DBC file by a library that reads such files.

use can_dbc::{ByteOrder, Dbc, Message, MessageId, ValueType};
use proptest::prelude::*;
use stickslip_shared::predictor::{flags, validity};
use stickslip_shared::wire::Mode;
use stickslip_unit::bus::{
    BusWrench, CLASSIC_STATE_BYTES, CLASSIC_STATE_ID, OWN_IDS, STATE_BYTES, STATE_ID, State, WRENCH_BYTES,
    WRENCH_ID, Wrench,
};
use stickslip_unit::source::WrenchSource;

fn dbc() -> Dbc {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/stickslip.dbc");
    let text = std::fs::read_to_string(path).expect("the DBC file");
    Dbc::try_from(text.as_str()).expect("a DBC file")
}

fn message(dbc: &Dbc, id: u16) -> &Message {
    dbc.messages()
        .iter()
        .find(|m| *m.id() == MessageId::Standard(id))
        .unwrap_or_else(|| panic!("no message {id:#x}"))
}

/// A signal's physical value, as the file says it lies in the frame.
fn signal(message: &Message, name: &str, frame: &[u8]) -> f64 {
    let s = message.signals().iter().find(|s| s.name() == name).unwrap_or_else(|| panic!("no signal {name}"));
    assert_eq!(*s.byte_order(), ByteOrder::LittleEndian);
    let raw = (0..s.size).fold(0u64, |raw, k| {
        let bit = s.start_bit + k;
        raw | u64::from(frame[(bit / 8) as usize] >> (bit % 8) & 1) << k
    });
    let value = match s.value_type() {
        ValueType::Signed => ((raw << (64 - s.size)) as i64 >> (64 - s.size)) as f64,
        ValueType::Unsigned => raw as f64,
    };
    value * s.factor + s.offset
}

const FORCES: [&str; 6] = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"];

#[test]
fn the_dbc_file_has_our_frames_with_our_lengths_and_no_others() {
    let dbc = dbc();
    let lengths = [WRENCH_BYTES, WRENCH_BYTES, STATE_BYTES, CLASSIC_STATE_BYTES];
    for (id, bytes) in OWN_IDS.into_iter().zip(lengths) {
        assert_eq!(*message(&dbc, id).size(), bytes as u64, "{id:#x}");
    }
    assert_eq!(dbc.messages().len(), OWN_IDS.len());
}

proptest! {
    #[test]
    fn a_wrench_reads_by_the_dbc_file_as_it_was_meant(
        values in prop::array::uniform6(-200.0f32..200.0),
        age_us in any::<u16>(), period_us in any::<u16>(), counter in any::<u8>(), valid in any::<bool>(),
    ) {
        let frame = Wrench { age_us, period_us, counter, valid, values }.encode();
        let dbc = dbc();
        for id in [WRENCH_ID, WRENCH_ID + 1] {
            let message = message(&dbc, id);
            for (k, (name, value)) in FORCES.iter().zip(values).enumerate() {
                let step = if k < 3 { 1e-4 } else { 1e-6 };
                let read = signal(message, name, &frame);
                prop_assert!((read - f64::from(value)).abs() <= step + 1e-6 * f64::from(value).abs(), "{name}");
            }
            prop_assert_eq!(signal(message, "Age", &frame), f64::from(age_us));
            prop_assert_eq!(signal(message, "Period", &frame), f64::from(period_us));
            prop_assert_eq!(signal(message, "Counter", &frame), f64::from(counter));
            prop_assert_eq!(signal(message, "Valid", &frame), f64::from(u8::from(valid)));
        }
        let back = Wrench::decode(&frame).unwrap().encode();
        for (again, first) in back.chunks(4).zip(frame.chunks(4)) {
            let counts = |word: &[u8]| i32::from_le_bytes(word.try_into().unwrap());
            // From 2^22 counts on (420 N, 4.2 N m) halves of a count are no `f32`.
            let slack = u32::from(counts(first).unsigned_abs() >= 1 << 22);
            prop_assert!(counts(again).abs_diff(counts(first)) <= slack, "{again:?} {first:?}");
        }
    }

    #[test]
    fn a_state_reads_by_the_dbc_file_as_it_was_meant(
        flags in any::<u32>(), validity in any::<u32>(), at_us in any::<u32>(), counter in any::<u8>(),
        holding in prop::option::of(0.0f32..500.0), advised in prop::option::of(0.0f32..500.0),
        drop in prop::option::of(0.0f32..60.0), used in prop::option::of(0.0f32..2.0), mode in 0usize..3,
    ) {
        let mode = [Mode::Safe, Mode::Ready, Mode::Running][mode];
        let state = State {
            flags, validity, at_us, holding_n: holding, advised_n: advised, drop_in_s: drop,
            used: [used, None], mode, counter,
        };
        let frame = state.encode();
        let dbc = dbc();
        let message = message(&dbc, STATE_ID);
        let read = |name| signal(message, name, &frame);
        prop_assert_eq!(read("Flags"), f64::from(flags));
        prop_assert_eq!(read("Validity"), f64::from(validity));
        prop_assert_eq!(read("SampleTime"), f64::from(at_us));
        prop_assert_eq!(read("Counter"), f64::from(counter));
        prop_assert_eq!(read("Mode"), f64::from(mode as u8));
        for (name, value, step, none) in [
            ("HoldingGrip", holding, 0.01, 655.35), ("AdvisedGrip", advised, 0.01, 655.35),
            ("DropIn", drop, 1e-3, 65.535), ("Used1", used, 0.01, 2.55), ("Used2", None, 0.01, 2.55),
        ] {
            let expected = value.map_or(none, f64::from);
            prop_assert!((read(name) - expected).abs() <= step / 2.0 + 1e-5 * expected, "{} {}", name, read(name));
        }
        prop_assert_eq!(State::decode(&frame).unwrap().encode(), frame);
    }

    #[test]
    fn a_classic_frame_of_a_state_reads_by_the_dbc_file_as_it_was_meant(
        flags in 0u32..1 << 14, validity in 0u32..1 << 24, counter in any::<u8>(),
        advised in prop::option::of(0.0f32..500.0), mode in 0usize..3,
    ) {
        let mode = [Mode::Safe, Mode::Ready, Mode::Running][mode];
        let state = State {
            flags, validity, at_us: 0, holding_n: None, advised_n: advised, drop_in_s: None,
            used: [None; 2], mode, counter,
        };
        let frame = state.encode_classic();
        let dbc = dbc();
        let message = message(&dbc, CLASSIC_STATE_ID);
        let read = |name| signal(message, name, &frame);
        prop_assert_eq!(read("Flags"), f64::from(flags));
        prop_assert_eq!(read("Mode"), f64::from(mode as u8));
        prop_assert_eq!(read("Validity"), f64::from(validity));
        prop_assert_eq!(read("Counter"), f64::from(counter));
        let expected = advised.map_or(655.35, f64::from);
        prop_assert!((read("AdvisedGrip") - expected).abs() <= 0.005 + 1e-5 * expected);
        let back = State::decode_classic(&frame).unwrap();
        prop_assert_eq!(back.encode_classic(), frame);
        prop_assert_eq!(State { advised_n: advised, ..back }, state);
    }

    #[test]
    fn any_bytes_are_survived_and_frames_of_another_length_refused(bytes in prop::collection::vec(any::<u8>(), 0..65)) {
        prop_assert_eq!(Wrench::decode(&bytes).is_some(), bytes.len() == WRENCH_BYTES);
        prop_assert!(State::decode(&bytes).is_none() || bytes.len() == STATE_BYTES);
        prop_assert!(State::decode_classic(&bytes).is_none() || bytes.len() == CLASSIC_STATE_BYTES);
        let mut source = BusWrench::default();
        let reading = source.take(&bytes, 1000);
        prop_assert!(reading.is_none() || bytes.len() == WRENCH_BYTES);
        prop_assert_eq!(source.losses().damaged, u32::from(bytes.len() != WRENCH_BYTES));
    }
}

#[test]
fn a_wrench_on_the_bus_has_its_senders_time_and_a_repeated_or_invalid_one_is_no_reading() {
    let wrench = Wrench { age_us: 700, period_us: 2000, counter: 1, valid: true, values: [1.0; 6] };
    let mut source = BusWrench::default();
    let reading = source.take(&wrench.encode(), 10_000).unwrap();
    assert_eq!((reading.at_us, reading.stands_us), (9_300, 3_700));
    assert_eq!(source.take(&wrench.encode(), 12_000), None);
    assert_eq!(source.take(&Wrench { counter: 2, valid: false, ..wrench }.encode(), 14_000), None);
    let spoilt = Wrench { counter: 3, values: [f32::NAN; 6], ..wrench };
    assert_eq!(source.take(&spoilt.encode(), 16_000), None);
    assert_eq!((source.losses().skipped, source.losses().faulty), (1, 2));
}

#[test]
fn every_flag_and_reason_for_doubt_has_its_bit_in_the_classic_frame() {
    // The highest of each.
    let state = State {
        flags: flags::UNSURE,
        validity: validity::CONE_INSTEAD,
        at_us: 0,
        holding_n: None,
        advised_n: None,
        drop_in_s: None,
        used: [None; 2],
        mode: Mode::Running,
        counter: 0,
    };
    let back = State::decode_classic(&state.encode_classic());
    assert_eq!(back, Some(state));
}

#[test]
fn wrenches_that_the_bus_lost_are_counted_by_their_counter_and_damaged_ones_once() {
    let wrench =
        |counter| Wrench { age_us: 0, period_us: 4000, counter, valid: true, values: [1.0; 6] }.encode();
    let mut source = BusWrench::default();
    for counter in (100..=255).chain(0..40) {
        // Lost are one, three across the wrap, and one behind one that was cut short.
        match counter {
            30 | 254..=255 | 0 | 21 => None,
            20 => source.take(&wrench(counter)[..20], 0),
            _ => source.take(&wrench(counter), 0),
        };
    }
    let losses = source.losses();
    assert_eq!((losses.lost, losses.damaged, losses.skipped), (5, 1, 0));
}
