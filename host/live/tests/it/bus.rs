//! A unit on a bus: frames as the kernel hands them over, through a pair of sockets, since not every kernel has CAN.

use std::os::fd::OwnedFd;
use std::os::unix::net::UnixDatagram;
use std::sync::atomic::{AtomicBool, Ordering};

use socketcan::CanFdSocket;
use stickslip_live::event::{Event, Happened};
use stickslip_live::state::State;
use stickslip_live::{bus, plain};
use stickslip_shared::predictor::{flags, validity};
use stickslip_shared::wire::Mode;
use stickslip_unit::bus::{CLASSIC_STATE_ID, STATE_ID, State as BusState, WRENCH_ID, Wrench};

/// `struct canfd_frame` of linux/can.h: identifier, length, flags (4: FD), two reserved, 64 bytes.
fn canfd(id: u16, data: &[u8]) -> [u8; 72] {
    let mut frame = [0; 72];
    frame[..4].copy_from_slice(&u32::from(id).to_ne_bytes());
    frame[4] = u8::try_from(data.len()).expect("64 at most");
    frame[5] = 4;
    frame[8..8 + data.len()].copy_from_slice(data);
    frame
}

/// `struct can_frame`: identifier, length, three reserved, 8 bytes.
fn can(id: u16, data: &[u8]) -> [u8; 16] {
    canfd(id, data)[..16].try_into().expect("16 bytes")
}

fn state(counter: u8, flags: u32) -> BusState {
    BusState {
        flags,
        validity: validity::POSE,
        at_us: 4000 * u32::from(counter),
        holding_n: Some(7.5),
        advised_n: Some(9.0),
        drop_in_s: None,
        used: [Some(0.62), None],
        mode: Mode::Running,
        counter,
    }
}

/// What is told of `frames`, until a frame that ends it.
fn told(frames: &[Vec<u8>]) -> Vec<Happened> {
    let (here, there) = UnixDatagram::pair().expect("a pair");
    for frame in frames {
        there.send(frame).expect("sent");
    }
    there.send(&canfd(STATE_ID, &state(255, 0).encode())).expect("sent");
    let stop = AtomicBool::new(false);
    let mut told = Vec::new();
    bus::watch(&CanFdSocket::from(OwnedFd::from(here)), "can0", &stop, &mut |what| {
        let ends = matches!(&what, Happened::Heard(state) if state.counter == 255);
        stop.store(ends, Ordering::Relaxed);
        told.push(what);
    })
    .expect("watched");
    told
}

fn seen(told: Vec<Happened>) -> State {
    let mut seen = State::default();
    for (tick, what) in told.into_iter().enumerate() {
        seen.take(&Event { at_s: tick as f64 * 0.004, what });
    }
    seen
}

#[test]
fn a_unit_on_the_bus_is_heard_as_its_encoder_says_it() {
    let wrench = Wrench {
        age_us: 300,
        period_us: 1000,
        counter: 7,
        valid: true,
        values: [0.5, -12.25, 1.0, 0.01, -0.002, 0.0],
    };
    let invalid = Wrench { valid: false, ..wrench };
    let told = told(&[
        canfd(WRENCH_ID, &wrench.encode()).to_vec(),
        canfd(WRENCH_ID + 1, &invalid.encode()).to_vec(),
        canfd(STATE_ID, &state(1, flags::SLIP_AHEAD_1 | flags::UNSURE).encode()).to_vec(),
        // Of somebody else.
        canfd(0x7ff, &[1, 2, 3]).to_vec(),
    ]);
    let Happened::Wrench(0, Some(values)) = told[0] else { panic!("{:?}", told[0]) };
    for (got, sent) in values.iter().zip(wrench.values) {
        assert!((got - sent).abs() < 1e-5, "{values:?}");
    }
    assert!(matches!(told[1], Happened::Wrench(1, None)), "{:?}", told[1]);
    let Happened::Heard(heard) = &told[2] else { panic!("{:?}", told[2]) };
    assert_eq!((heard.flags, heard.validity), (flags::SLIP_AHEAD_1 | flags::UNSURE, validity::POSE));
    assert_eq!((heard.used, heard.mode), ([Some(0.62), None], Mode::Running));
    assert_eq!(told.len(), 4, "{told:?}");
}

#[test]
fn what_the_bus_does_not_tell_is_shown_as_not_known_and_alarms_are_raised() {
    let frames = [
        canfd(STATE_ID, &state(1, 0).encode()).to_vec(),
        canfd(STATE_ID, &state(2, flags::SLIP_AHEAD_1).encode()).to_vec(),
    ];
    let mut told = told(&frames);
    // Not the one that ends it.
    told.pop();
    let seen = seen(told);
    assert_eq!(seen.alarms.iter().map(|alarm| alarm.flag).collect::<Vec<_>>(), [flags::SLIP_AHEAD_1]);
    assert_eq!(seen.alarms[0].foreseen_in_s, None, "the bus does not say when");
    let line = plain::line(&seen);
    for part in
        ["used 0.62 and -", "friction - (at least -)", "sag -", "grip with reserve 7.5 N", "slip ahead"]
    {
        assert!(line.contains(part), "`{part}` in {line}");
    }
    assert!(!line.contains("NaN"), "{line}");
}

#[test]
fn a_classic_frame_of_the_state_is_heard_with_what_it_has() {
    let sent = state(1, flags::DROP);
    let mut told = told(&[
        can(CLASSIC_STATE_ID, &sent.encode_classic()).to_vec(),
        canfd(CLASSIC_STATE_ID, &sent.encode()).to_vec(),
    ]);
    told.pop();
    let Happened::Heard(heard) = &told[0] else { panic!("{:?}", told[0]) };
    let expected = BusState { at_us: 0, holding_n: None, used: [None; 2], ..sent };
    assert_eq!(**heard, expected);
    assert!(matches!(told[1], Happened::Damaged(1)), "{:?}", told[1]);
    let seen = seen(told);
    assert_eq!(seen.alarms.iter().map(|alarm| alarm.flag).collect::<Vec<_>>(), [flags::DROP]);
    assert_eq!(seen.advised_grip_n, Some(9.0));
}

#[test]
fn lost_states_and_frames_of_another_length_are_counted() {
    let frames = [
        canfd(STATE_ID, &state(250, 0).encode()).to_vec(),
        // Three are lost, and one is repeated.
        canfd(STATE_ID, &state(254, 0).encode()).to_vec(),
        canfd(STATE_ID, &state(254, 0).encode()).to_vec(),
        canfd(STATE_ID, &state(3, 0).encode()[..20]).to_vec(),
        can(STATE_ID, &[0; 8]).to_vec(),
        canfd(WRENCH_ID, &[0; 12]).to_vec(),
    ];
    let line = seen(told(&frames)).line();
    assert_eq!((line.reports_lost, line.frames_damaged), (3, 3));
}

#[test]
fn a_counter_that_wraps_is_no_loss() {
    let frames = [250_u8, 251, 252, 253, 254].map(|n| canfd(STATE_ID, &state(n, 0).encode()).to_vec());
    let mut told = told(&frames);
    told.extend([0, 1].map(|n| Happened::Heard(Box::new(state(n, 0)))));
    assert_eq!(seen(told).line().reports_lost, 0);
}

#[test]
fn states_without_a_sample_count_as_no_samples() {
    let rate = |validity: u32| {
        let mut seen = State::default();
        for n in 0..50 {
            // A slow sensor: its reading stands for three ticks.
            let heard = BusState { validity, at_us: 12_000 * (n / 3), ..state(n as u8, flags::UNSURE) };
            seen.take(&Event { at_s: f64::from(n) * 0.004, what: Happened::Heard(Box::new(heard)) });
        }
        seen.line().samples_per_s
    };
    assert!((rate(validity::POSE) - 250.0).abs() < 0.1);
    assert_eq!((rate(validity::SAMPLE), rate(validity::WAITING)), (0.0, 0.0));
}

#[test]
fn a_silent_bus_is_said_once() {
    let (here, _there) = UnixDatagram::pair().expect("a pair");
    let (stop, begun) = (AtomicBool::new(false), std::time::Instant::now());
    let mut notes = Vec::new();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(std::time::Duration::from_millis(2500));
            stop.store(true, Ordering::Relaxed);
        });
        let socket = CanFdSocket::from(OwnedFd::from(here));
        bus::watch(&socket, "can0", &stop, &mut |what| notes.push(what)).expect("watched");
    });
    assert!(matches!(&notes[..], [Happened::Note(text)] if text.contains("can0")), "{notes:?}");
    assert!(begun.elapsed().as_secs_f64() > 1.0);
}

#[test]
fn an_interface_that_there_is_not_is_refused_with_a_way_out() {
    let error = bus::open("no-such-can").expect_err("refused").to_string();
    assert!(error.contains("no-such-can"), "{error}");
    assert!(error.contains("ip link set") || error.contains("modprobe can-raw"), "{error}");
}
