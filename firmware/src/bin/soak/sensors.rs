//! Sensors on the other end of the unit's lines, and what goes wrong with them: gauges, a Robotiq FT 300, an ATI
//! NETCANOEM, wrenches on CAN. What is done is counted in [`DONE`]; when each finger's wrench was last
//! sound, and how long it stands, is noted for the judge of the 'sure' line.

use core::cell::Cell;
use core::convert::Infallible;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use critical_section::Mutex;
use embassy_time::{Duration, Instant, Ticker, Timer};
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};
use heapless::Deque;
use stickslip_firmware::board::current::COUNTS;
use stickslip_shared::wire::{Calibration, Port, Sensor, Sensors, TICK_US};
use stickslip_unit::bus::{CLASSIC_STATE_ID, STATE_ID, WRENCH_ID, Wrench};
use stickslip_unit::lines::Bus;
use stickslip_unit::source::ft300::{FRAME, PERIOD_US, STOP, TRANSMISSION_US, start_stream};

use crate::done::{DONE, Draw, count, value};

/// Which sensors measure in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Kind {
    /// None: the host's samples have wrenches.
    Host,
    /// Gauges on both fingers.
    Gauges,
    /// A serial sensor on finger 1, one of ATI's on finger 2.
    Bought,
    /// Frames on CAN for both.
    Can,
}

impl Kind {
    /// They take turns.
    pub fn of(run: u32) -> Self {
        [Self::Host, Self::Gauges, Self::Bought, Self::Can][run as usize % 4]
    }

    /// As commanded.
    pub fn sensors(self) -> Sensors {
        let ports = match self {
            Self::Host => return Sensors::new(),
            Self::Gauges => [Port::Gauges; 2],
            Self::Bought => [Port::Ft300, Port::Ati { base: BASE as u8 }],
            Self::Can => [Port::Can; 2],
        };
        ports.into_iter().zip(0..).map(|(port, finger)| Sensor { port, finger }).collect()
    }

    /// Of each finger.
    pub fn calibration(self, finger: u8) -> Calibration {
        let mut matrix = [[0.0; 6]; 6];
        for (k, row) in matrix.iter_mut().enumerate() {
            row[k] = if self == Self::Gauges { count_unit(k) } else { 1.0 };
        }
        Calibration { finger, matrix }
    }
}

/// N and N m of a gauge's count.
fn count_unit(k: usize) -> f32 {
    if k < 3 { 0.02 } else { 0.001 }
}

const BASE: u16 = 5;
/// Gauges' counts of an N and an N m of the simulated NETCANOEM.
const ATI_COUNTS: [u32; 2] = [1000, 100_000];

static KIND: AtomicU32 = AtomicU32::new(0);
static WRENCH: Mutex<Cell<[[f32; 6]; 2]>> = Mutex::new(Cell::new([[0.0; 6]; 2]));
/// Until when each finger's last sound wrench stands, by the unit's clock.
static STANDS: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];
/// The serial sensor streams.
static STREAMS: AtomicBool = AtomicBool::new(false);

/// Only these sensors send from now on.
pub fn connect(kind: Kind) {
    KIND.store(kind as u32, Ordering::Relaxed);
}

/// Which send.
pub fn connected() -> Kind {
    Kind::of(KIND.load(Ordering::Relaxed))
}

fn is(kind: Kind) -> bool {
    connected() == kind
}

/// What they measure now.
pub fn measure(wrench: [[f32; 6]; 2]) {
    critical_section::with(|cs| WRENCH.borrow(cs).set(wrench));
}

fn wrench(finger: usize, draw: &mut Draw) -> [f32; 6] {
    let exact = critical_section::with(|cs| WRENCH.borrow(cs).get()).get(finger).copied().unwrap_or([0.0; 6]);
    let mut k = 0;
    exact.map(|x| {
        k += 1;
        x + draw.noise() * if k <= 3 { 0.02 } else { 0.001 }
    })
}

pub fn now_us() -> u32 {
    Instant::now().as_micros() as u32
}

fn sound(finger: usize, at_us: u32, stands_us: u32) {
    if let Some(until) = STANDS.get(finger) {
        until.store(at_us.wrapping_add(stands_us), Ordering::Relaxed);
    }
}

/// For how long each finger's wrench has been out of date, us; negative while it stands.
pub fn overdue_us(finger: usize) -> i32 {
    let until = STANDS.get(finger).map_or(0, value);
    now_us().wrapping_sub(until).cast_signed()
}

/// The gauges' converters, a scan a tick: conversions that fail, channels at the end of their range.
pub async fn gauges(mut draw: Draw) -> ! {
    let mut fault = (0, 0);
    let mut ticker = Ticker::every(Duration::from_micros(u64::from(TICK_US)));
    loop {
        ticker.next().await;
        if !is(Kind::Gauges) {
            fault = (0, 0);
            critical_section::with(|cs| COUNTS.borrow(cs).set(Some([2048; 12])));
            continue;
        }
        if fault.0 == 0 && draw.once_in(120) {
            fault = (1 + draw.next() % 40, draw.next() % 3);
            count(&DONE.gauge_faults);
        }
        let mut counts = [0; 12];
        for (finger, six) in counts.chunks_exact_mut(6).enumerate() {
            let exact = wrench(finger, &mut draw);
            for (k, (count, x)) in six.iter_mut().zip(exact).enumerate() {
                *count = (2047.5 + x / count_unit(k)) as u16;
            }
        }
        let now_us = now_us();
        let faulty = fault.0 > 0;
        if faulty {
            fault.0 -= 1;
            match fault.1 {
                0 => count(&DONE.scans_failed),
                kind => {
                    counts[if kind == 1 { 3 } else { 8 }] = if draw.once_in(2) { 0 } else { 4095 };
                    count(&DONE.scans_saturated);
                }
            }
        }
        for finger in 0..2 {
            // Fault 1 is the first finger's, 2 the second's.
            if !faulty || fault.1 == 2 - finger {
                sound(finger as usize, now_us, TICK_US);
            }
        }
        let read = if faulty && fault.1 == 0 { None } else { Some(counts) };
        critical_section::with(|cs| COUNTS.borrow(cs).set(read));
    }
}

/// The line from a Robotiq FT 300: frames lost and damaged, plug pulled, errors of the receiver.
pub struct SerialOut {
    draw: Draw,
    due: Instant,
    frame: [u8; FRAME],
    at: usize,
    silent: u32,
}

impl SerialOut {
    pub fn new(draw: Draw) -> Self {
        Self { draw, due: Instant::now(), frame: [0; FRAME], at: FRAME, silent: 0 }
    }

    /// The next frame; `None` where none comes.
    fn next(&mut self) -> Option<[u8; FRAME]> {
        if !is(Kind::Bought) || !STREAMS.load(Ordering::Relaxed) {
            return None;
        }
        if self.silent > 0 {
            self.silent -= 1;
            return None;
        }
        let exact = wrench(0, &mut self.draw);
        let mut frame = [0; FRAME];
        frame[..2].copy_from_slice(&[0x20, 0x4e]);
        for (k, (pair, x)) in frame[2..14].chunks_exact_mut(2).zip(exact).enumerate() {
            let counts = (x * if k < 3 { 100.0 } else { 1000.0 }) as i16;
            pair.copy_from_slice(&counts.to_le_bytes());
        }
        let fault = self.draw.next() % 250;
        if fault == 0 {
            // At the end of its range: 327 N.
            frame[2..4].copy_from_slice(&i16::MAX.to_le_bytes());
        }
        let crc = modbus(&frame[..14]);
        frame[14..].copy_from_slice(&crc.to_le_bytes());
        match fault {
            0 => count(&DONE.saturated),
            1..=4 => {
                count(&DONE.readings_lost);
                return None;
            }
            5..=8 => {
                // Not in the head: that would be no frame at all.
                let at = 2 + self.draw.next() as usize % (FRAME - 2);
                frame[at] ^= 1 + (self.draw.next() % 255) as u8;
                count(&DONE.readings_damaged);
            }
            9 => {
                // The plug is pulled; put back, it must be asked to stream again.
                self.silent = 5 + self.draw.next() % 60;
                STREAMS.store(false, Ordering::Relaxed);
                count(&DONE.unplugged);
                return None;
            }
            _ => {
                let at_us = now_us().wrapping_sub(TRANSMISSION_US);
                sound(0, at_us, TRANSMISSION_US + PERIOD_US + PERIOD_US / 2);
            }
        }
        Some(frame)
    }
}

/// Modbus' CRC-16, bit by bit.
fn modbus(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xffff, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xa001 } else { crc >> 1 })
    })
}

impl ErrorType for SerialOut {
    type Error = ErrorKind;
}

impl Read for SerialOut {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        while self.at >= FRAME {
            Timer::at(self.due).await;
            self.due = Instant::now() + Duration::from_micros(u64::from(PERIOD_US));
            if let Some(frame) = self.next() {
                (self.frame, self.at) = (frame, 0);
            } else if is(Kind::Bought) && STREAMS.load(Ordering::Relaxed) && self.draw.once_in(20) {
                count(&DONE.readings_damaged);
                return Err(ErrorKind::Other);
            }
        }
        let rest = self.frame.get(self.at..).unwrap_or_default();
        let length = rest.len().min(buffer.len());
        if let (Some(to), Some(from)) = (buffer.get_mut(..length), rest.get(..length)) {
            to.copy_from_slice(from);
        }
        self.at += length;
        Ok(length)
    }
}

/// The line to it.
pub struct SerialIn;

impl ErrorType for SerialIn {
    type Error = Infallible;
}

impl Write for SerialIn {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        if bytes == start_stream() {
            STREAMS.store(true, Ordering::Relaxed);
        } else if bytes.iter().all(|byte| *byte == STOP) {
            STREAMS.store(false, Ordering::Relaxed);
        }
        Ok(bytes.len())
    }
    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A frame with its identifier.
type Frame = (u16, heapless::Vec<u8, 64>);

/// The bus, with wrenches and an ATI sensor on it: frames lost, too short, repeated, invalid, late by their senders'
/// clocks; a faulty sensor; the bus off.
pub struct SimulatedBus {
    draw: Draw,
    due: Instant,
    counter: u8,
    frames: Deque<Frame, 8>,
    /// Until then it is off.
    off: Option<Instant>,
    told_off: bool,
}

impl SimulatedBus {
    pub fn new(draw: Draw) -> Self {
        let due = Instant::now();
        Self { draw, due, counter: 0, frames: Deque::new(), off: None, told_off: false }
    }

    fn is_off(&mut self) -> bool {
        if self.off.is_some_and(|until| Instant::now() >= until) {
            self.off = None;
            self.due = Instant::now();
        }
        self.off.is_some()
    }

    fn say(&mut self, id: u16, data: &[u8]) {
        let _ = self.frames.push_back((id, heapless::Vec::from_slice(data).unwrap_or_default()));
    }

    /// What is sent in this period.
    fn period(&mut self) {
        if self.draw.once_in(900) {
            self.off = Some(Instant::now() + Duration::from_millis(u64::from(20 + self.draw.next() % 600)));
            count(&DONE.bus_off);
            return;
        }
        if is(Kind::Can) {
            self.counter = self.counter.wrapping_add(1);
            for finger in 0..2 {
                self.wrench(finger);
            }
        }
    }

    fn wrench(&mut self, finger: usize) {
        let period_us = TICK_US as u16;
        let values = wrench(finger, &mut self.draw);
        let mut sent = Wrench { age_us: 300, period_us, counter: self.counter, valid: true, values };
        let (mut short, mut good) = (false, false);
        match self.draw.next() % 400 {
            0..=3 => {
                count(&DONE.readings_lost);
                return;
            }
            4 | 5 => {
                short = true;
                count(&DONE.readings_damaged);
            }
            6 | 7 => {
                sent.valid = false;
                count(&DONE.readings_refused);
            }
            8 => sent.counter = self.counter.wrapping_sub(1),
            9 => {
                // Its sender's clock has made a step: older than the one before, and than any that stands.
                sent.age_us = 60_000;
                count(&DONE.clock_steps);
                count(&DONE.late_by_clock);
            }
            10 => {
                sent.values[0] = 1e4;
                count(&DONE.saturated);
            }
            _ => good = true,
        }
        let frame = sent.encode();
        let length = if short { 24 } else { frame.len() };
        if good {
            sound(finger, now_us().wrapping_sub(300), 300 + u32::from(period_us) * 3 / 2);
        }
        self.say(WRENCH_ID + finger as u16, frame.get(..length).unwrap_or_default());
    }

    /// The NETCANOEM's answer to a request.
    fn asked(&mut self, operation: u16, data: &[u8]) {
        if !is(Kind::Bought) {
            return;
        }
        let id = |operation: u16| BASE << 4 | operation;
        match operation {
            0 => self.gauges(id(0), id(1)),
            2 => {
                let row = usize::from(data.first().copied().unwrap_or(0));
                for pair in 0..3 {
                    let entry = |k: usize| if k == row { 1.0f32 } else { 0.0 }.to_be_bytes();
                    let (a, b) = (entry(2 * pair), entry(2 * pair + 1));
                    self.say(id(2 + pair as u16), [a, b].as_flattened());
                }
            }
            7 => self.say(id(7), ATI_COUNTS.map(u32::to_be_bytes).as_flattened()),
            // N and N m.
            8 => self.say(id(8), &[2, 3]),
            _ => {}
        }
    }

    fn gauges(&mut self, first: u16, second: u16) {
        let values = wrench(1, &mut self.draw);
        let mut gauges = [[0; 2]; 6];
        for (k, (gauge, x)) in gauges.iter_mut().zip(values).enumerate() {
            *gauge = ((x * ATI_COUNTS[k / 3] as f32) as i16).to_be_bytes();
        }
        let [a, b, c, d, e, f] = gauges;
        let (mut head, tail) = ([[0; 2], a, c, e], [b, d, f]);
        match self.draw.next() % 400 {
            0..=3 => {
                count(&DONE.readings_lost);
                return;
            }
            4 | 5 => {
                // Its second half alone is no reading.
                count(&DONE.readings_lost);
                count(&DONE.readings_damaged);
            }
            6 | 7 => {
                // It says that it is at the end of its range; the half that follows is refused.
                head[0] = [0, 2];
                self.say(first, head.as_flattened());
                count(&DONE.readings_refused);
                count(&DONE.readings_damaged);
            }
            8 => {
                self.say(first, head.as_flattened().get(..7).unwrap_or_default());
                count(&DONE.readings_damaged);
                count(&DONE.readings_damaged);
            }
            _ => {
                sound(1, now_us(), 6_000);
                self.say(first, head.as_flattened());
            }
        }
        self.say(second, tail.as_flattened());
    }
}

impl Bus for SimulatedBus {
    async fn read(&mut self, data: &mut [u8; 64]) -> Option<(u16, usize)> {
        loop {
            if self.is_off() {
                self.frames.clear();
                if !core::mem::replace(&mut self.told_off, true) {
                    count(&DONE.readings_damaged);
                }
                return None;
            }
            if let Some((id, bytes)) = self.frames.pop_front() {
                self.told_off = false;
                data.get_mut(..bytes.len())?.copy_from_slice(&bytes);
                return Some((id, bytes.len()));
            }
            Timer::at(self.due).await;
            self.due += Duration::from_micros(u64::from(TICK_US));
            self.period();
        }
    }

    async fn write(&mut self, id: u16, data: &[u8]) {
        // Dropped by the caller where it waits too long.
        let state = id == STATE_ID || id == CLASSIC_STATE_ID;
        if !state {
            count(&DONE.requests_begun);
        }
        if self.is_off()
            && let Some(until) = self.off
        {
            Timer::at(until).await;
        }
        if state {
            count(&DONE.states);
        } else {
            count(&DONE.asked);
            self.asked(id & 0xf, data);
        }
    }
}
