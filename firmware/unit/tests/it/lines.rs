//! The tasks at the serial line and the bus, with the clock in the test's hands.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::{Future, pending, poll_fn};
use std::pin::pin;
use std::rc::Rc;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use embassy_time::{Duration, Instant, MockDriver};
use embedded_can::{Frame, Id, StandardId};
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};
use stickslip_shared::wire::{self, Mode, Port, Sensor, Sensors, TICK_US};
use stickslip_unit::bus::{CLASSIC_STATE_ID, STATE_BYTES, STATE_ID, State, WRENCH_ID, Wrench};
use stickslip_unit::lines::{Bus, bus, serial};
use stickslip_unit::source::ft300::{PERIOD_US, TRANSMISSION_US};

use super::bench::Unit;
use super::simulated::{Can, Netcanoem, Robotiq};

/// The clock is one for all tests.
fn clock() -> MutexGuard<'static, ()> {
    static CLOCK: Mutex<()> = Mutex::new(());
    let turn = CLOCK.lock().unwrap_or_else(PoisonError::into_inner);
    MockDriver::get().reset();
    turn
}

/// Runs a task while time passes in steps of 0.1 ms; `ends` looks on, and says when it is enough.
fn run(task: impl Future<Output = Infallible>, mut ends: impl FnMut(u64) -> bool) {
    let mut task = pin!(task);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        // What it does at once may take several steps of its own.
        for _ in 0..8 {
            let Poll::Pending = task.as_mut().poll(&mut context);
        }
        if ends(Instant::now().as_micros()) {
            return;
        }
        MockDriver::get().advance(Duration::from_micros(100));
    }
}

fn assigned(list: &[(Port, u8)]) -> Unit {
    let mut unit = Unit::start(None);
    let sensors: Sensors =
        list.iter().map(|(port, finger)| Sensor { port: *port, finger: *finger }).collect();
    assert_eq!(unit.request::<wire::SetSensors>(&sensors), Ok(()));
    unit
}

fn readings(unit: &Unit) -> usize {
    std::iter::from_fn(|| unit.between.readings.try_receive()).count()
}

/// A Robotiq FT 300 at the other end.
#[derive(Default)]
struct Plug {
    sensor: Robotiq,
    out: bool,
    begun: usize,
    due_us: u64,
    fails: bool,
}

#[derive(Clone, Default)]
struct Serial(Rc<RefCell<Plug>>);

impl ErrorType for Serial {
    type Error = ErrorKind;
}

impl Read for Serial {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, ErrorKind> {
        poll_fn(|_| {
            let mut plug = self.0.borrow_mut();
            let now_us = Instant::now().as_micros();
            if std::mem::take(&mut plug.fails) {
                return Poll::Ready(Err(ErrorKind::Other));
            }
            if plug.out || !plug.sensor.streams || now_us < plug.due_us {
                return Poll::Pending;
            }
            plug.due_us = now_us + u64::from(PERIOD_US);
            bytes[..16].copy_from_slice(&Robotiq::frame([1.0; 6]));
            Poll::Ready(Ok(16))
        })
        .await
    }
}

impl Write for Serial {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        let mut plug = self.0.borrow_mut();
        let before = plug.sensor.streams;
        plug.sensor.hear(bytes);
        plug.begun += usize::from(plug.sensor.streams && !before);
        plug.due_us = Instant::now().as_micros() + u64::from(TRANSMISSION_US);
        Ok(bytes.len())
    }
    async fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

async fn never<T>(task: impl Future<Output = T>) -> Infallible {
    task.await;
    pending().await
}

#[test]
fn a_silent_serial_sensor_is_asked_to_stream_again_and_where_none_is_assigned_nobody_is() {
    let _turn = clock();
    let unit = Unit::start(None);
    let line = Serial::default();
    let task = never(serial(unit.between, unit.sensors, line.clone(), line.clone()));
    run(task, |now_us| now_us >= 1_000_000);
    assert_eq!(line.0.borrow().begun, 0, "no sensor is assigned");

    MockDriver::get().reset();
    let unit = assigned(&[(Port::Ft300, 0)]);
    let (mut found, mut back_us) = (0, None);
    let task = never(serial(unit.between, unit.sensors, line.clone(), line.clone()));
    run(task, |now_us| {
        found += readings(&unit);
        let mut plug = line.0.borrow_mut();
        // Half a second of stream, then the plug is out; back, the sensor has lost its supply.
        plug.out = (500_000..800_000).contains(&now_us);
        plug.sensor.streams &= !plug.out;
        if now_us == 700_000 {
            assert!(plug.begun >= 2, "asked again while it is out");
        }
        if now_us > 800_000 && plug.sensor.streams {
            back_us = back_us.or(Some(now_us));
        }
        now_us >= 1_500_000
    });
    assert!(back_us.expect("it streams again") <= 910_000, "{back_us:?}");
    // 0.4 s and 0.6 s at 100 Hz.
    assert!((92..=102).contains(&found), "{found}");
}

#[test]
fn an_error_of_the_serial_line_is_counted_and_the_stream_is_read_on() {
    let _turn = clock();
    let unit = assigned(&[(Port::Ft300, 0)]);
    let line = Serial::default();
    let mut after = 0;
    let task = never(serial(unit.between, unit.sensors, line.clone(), line.clone()));
    run(task, |now_us| {
        if now_us == 400_000 {
            line.0.borrow_mut().fails = true;
        }
        let found = readings(&unit);
        after += if now_us > 410_000 { found } else { 0 };
        now_us >= 800_000
    });
    assert_eq!((unit.between.counters.readings_damaged.get(), line.0.borrow().begun), (1, 1));
    assert!(after >= 38, "{after}");
}

/// A bus: frames that come, frames that went out, and whether it is off.
#[derive(Default)]
struct Wire {
    come: VecDeque<(u16, Vec<u8>)>,
    sent: Vec<(u64, u16, Vec<u8>)>,
    off: bool,
    /// Takes no frame: nobody else is there.
    alone: bool,
    ati: Option<Netcanoem>,
}

#[derive(Clone, Default)]
struct Controller(Rc<RefCell<Wire>>);

impl Bus for Controller {
    async fn read(&mut self, data: &mut [u8; 64]) -> Option<(u16, usize)> {
        poll_fn(|_| {
            let mut wire = self.0.borrow_mut();
            if wire.off {
                return Poll::Ready(None);
            }
            let Some((id, bytes)) = wire.come.pop_front() else { return Poll::Pending };
            data[..bytes.len()].copy_from_slice(&bytes);
            Poll::Ready(Some((id, bytes.len())))
        })
        .await
    }

    async fn write(&mut self, id: u16, data: &[u8]) {
        poll_fn(|_| {
            let mut wire = self.0.borrow_mut();
            if wire.off || wire.alone {
                return Poll::Pending;
            }
            wire.sent.push((Instant::now().as_micros(), id, data.to_vec()));
            let asked = Can::new(StandardId::new(id).expect("11 bits"), data);
            if let (Some(ati), Some(asked)) = (&wire.ati, asked) {
                let answers = ati.answer(&asked).into_iter().map(|can| {
                    let Id::Standard(id) = can.id else { panic!("{can:?}") };
                    (id.as_raw(), can.data)
                });
                let answers: Vec<_> = answers.collect();
                wire.come.extend(answers);
            }
            Poll::Ready(())
        })
        .await;
    }
}

fn state(counter: u8) -> State {
    State {
        flags: 1 << 9,
        validity: 1 << 6,
        at_us: 0,
        holding_n: None,
        advised_n: Some(12.0),
        drop_in_s: None,
        used: [None; 2],
        mode: Mode::Running,
        counter,
    }
}

/// Tells the unit's state each tick.
fn tell(unit: &Unit, now_us: u64) {
    if now_us.is_multiple_of(u64::from(TICK_US)) {
        unit.between.tell(state((now_us / u64::from(TICK_US)) as u8));
    }
}

#[test]
fn with_an_ati_sensor_on_the_bus_only_classic_frames_are_sent_and_its_readings_come_each_tick() {
    let _turn = clock();
    let unit = assigned(&[(Port::Ati { base: 5 }, 1)]);
    let line = Controller::default();
    let ati = Netcanoem {
        base: 5,
        counts: [1; 2],
        units: [2, 3],
        matrix: [[1.0; 6]; 6],
        gauges: [1; 6],
        status: 0,
    };
    line.0.borrow_mut().ati = Some(ati);
    let mut found = 0;
    run(never(bus(unit.between, unit.sensors, line.clone())), |now_us| {
        tell(&unit, now_us);
        found += readings(&unit);
        now_us >= 400_000
    });
    let wire = line.0.borrow();
    assert!(wire.sent.iter().all(|(_, _, data)| data.len() <= 8), "a classic frame has 8 bytes");
    let states: Vec<_> = wire.sent.iter().filter(|(_, id, _)| *id == CLASSIC_STATE_ID).collect();
    assert!((99..=101).contains(&states.len()), "one a tick: {}", states.len());
    let last = State::decode_classic(&states[99].2).expect("a state");
    assert_eq!((last.flags, last.validity, last.mode, last.counter), (1 << 9, 1 << 6, Mode::Running, 99));
    // Counts, units and six rows first.
    assert!((90..=92).contains(&found), "{found}");
    assert_eq!(unit.between.counters.frames_unsent.get(), 0);
}

#[test]
fn without_an_ati_sensor_the_state_goes_out_as_one_can_fd_frame_a_tick() {
    let _turn = clock();
    let unit = assigned(&[(Port::Can, 0)]);
    let line = Controller::default();
    run(never(bus(unit.between, unit.sensors, line.clone())), |now_us| {
        tell(&unit, now_us);
        now_us >= 40_000
    });
    let wire = line.0.borrow();
    assert!(wire.sent.iter().all(|(_, id, data)| (*id, data.len()) == (STATE_ID, STATE_BYTES)));
    assert!((10..=11).contains(&wire.sent.len()), "{:?}", wire.sent);
}

#[test]
fn a_frame_that_the_bus_does_not_take_within_a_tick_is_counted_and_readings_come_all_the_same() {
    let _turn = clock();
    let unit = assigned(&[(Port::Can, 0)]);
    let line = Controller::default();
    line.0.borrow_mut().alone = true;
    let mut found = 0;
    run(never(bus(unit.between, unit.sensors, line.clone())), |now_us| {
        if now_us.is_multiple_of(u64::from(TICK_US)) {
            let counter = (now_us / u64::from(TICK_US)) as u8;
            let wrench = Wrench { age_us: 0, period_us: 4000, counter, valid: true, values: [1.0; 6] };
            line.0.borrow_mut().come.push_back((WRENCH_ID, wrench.encode().to_vec()));
        }
        // Half as many: each waits for a tick.
        if now_us.is_multiple_of(2 * u64::from(TICK_US)) && now_us < 360_000 {
            unit.between.tell(state(0));
        }
        found += readings(&unit);
        now_us >= 400_000
    });
    let counters = &unit.between.counters;
    assert_eq!((counters.frames_unsent.get(), line.0.borrow().sent.len()), (45, 0));
    assert_eq!((found, counters.readings_lost.get(), counters.readings_damaged.get()), (100, 0, 0));
}

#[test]
fn each_time_that_the_bus_is_disturbed_counts_once_however_long_it_lasts() {
    let _turn = clock();
    let unit = assigned(&[(Port::Can, 0)]);
    let line = Controller::default();
    run(never(bus(unit.between, unit.sensors, line.clone())), |now_us| {
        let mut wire = line.0.borrow_mut();
        wire.off = (50_000..90_000).contains(&now_us) || (150_000..400_000).contains(&now_us);
        if now_us.is_multiple_of(10_000) {
            wire.come.push_back((0x7ff, vec![1]));
        }
        now_us >= 500_000
    });
    assert_eq!(unit.between.counters.readings_damaged.get(), 2);
}
