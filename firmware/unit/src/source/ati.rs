//! ATI's NETCANOEM: gauge readings and calibration matrix on CAN.
//!
//! Standard identifiers of 11 bits: seven of the sensor's base, four of an operation. Numbers have the high
//! byte first. The sensor only answers:
//!
//! | operation | request | answer |
//! |---|---|---|
//! | 0 read gauges | none | 0: status word, gauges 0, 2, 4; 1: gauges 1, 3, 5 (signed, 16 bits) |
//! | 2 read a row of the matrix | row | 2, 3, 4: two `f32` each |
//! | 7 counts a unit | none | 7: of force, of torque (32 bits) |
//! | 8 units | none | 8: code of the force unit, of the torque unit |
//!
//! `wrench = matrix x gauges / counts a unit`. Sources: ATI 9610-05-1030, NETCANOEM installation and
//! operation manual; codes of the units as in ATI 9620-05-NET FT, 11.6.

use embedded_can::{Frame, Id, StandardId};

use super::{Losses, Reading, WrenchSource, count};

const READ_GAUGES: u8 = 0;
const MORE_GAUGES: u8 = 1;
const READ_ROW: u8 = 2;
const ROW_END: u8 = 4;
const COUNTS_A_UNIT: u8 = 7;
const UNITS: u8 = 8;

/// The second half of a reading comes within so long of the first, us: a frame of 8 bytes lasts 0.13 ms at
/// 1 Mbit/s, 0.5 ms at 250 kbit/s, and a tick of the control task (3.2 ms where it takes its 400,000 instructions) may lie
/// between the two, each time where requests and ticks have an unlucky phase. Less than a tick: the next reading's.
const HALVES_US: u32 = 3_800;
/// An answer that has not come after so long is asked for again, us: five ticks.
const PATIENCE_US: u32 = 20_000;
/// A reading stands for one and a half ticks: it is asked for in each.
const STANDS_US: u32 = 6_000;

/// A request: identifier and data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Of 11 bits.
    pub id: StandardId,
    /// The row that is asked for, where one is.
    pub row: Option<u8>,
}

impl Request {
    /// As a frame of the bus at hand; `None` where that makes no such frame.
    pub fn frame<F: Frame>(&self) -> Option<F> {
        match self.row {
            Some(row) => F::new(self.id, &[row]),
            None => F::new(self.id, &[]),
        }
    }
}

/// What is still to be learnt before readings can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Counts,
    Units,
    /// A row of the matrix, and the pairs of it that came.
    Row(u8, u8),
    Readings,
}

/// Why the base is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotABase;

/// One sensor on the bus.
#[derive(Clone, Debug)]
pub struct Ati {
    base: u8,
    step: Step,
    asked_us: Option<u32>,
    /// Force and torque: counts a unit, and N or N m of a unit.
    counts: [f32; 2],
    unit: [f32; 2],
    matrix: [[f32; 6]; 6],
    /// Status and even gauges of a reading, and when they came.
    half: Option<(u32, [i16; 3])>,
    status: u16,
    losses: Losses,
}

impl Ati {
    /// The sensor with this base identifier.
    ///
    /// # Errors
    /// More than seven bits.
    pub fn new(base: u8) -> Result<Self, NotABase> {
        if base > 0x7f {
            return Err(NotABase);
        }
        Ok(Self {
            base,
            step: Step::Counts,
            asked_us: None,
            counts: [1.0; 2],
            unit: [1.0; 2],
            matrix: [[0.0; 6]; 6],
            half: None,
            status: 0,
            losses: Losses::default(),
        })
    }

    /// Its base identifier.
    pub fn base(&self) -> u8 {
        self.base
    }

    /// Whether a frame's identifier is of this sensor.
    pub fn owns(&self, id: u16) -> bool {
        id >> 4 == u16::from(self.base)
    }

    /// What the sensor last said of itself; zero: healthy.
    pub fn status(&self) -> u16 {
        self.status
    }

    /// Whether matrix and units are known.
    pub fn is_ready(&self) -> bool {
        self.step == Step::Readings
    }

    /// What to ask now, once a tick: a reading where all else is known; else what is missing, again
    /// where its answer is overdue.
    pub fn request(&mut self, now_us: u32) -> Option<Request> {
        let waiting = self.asked_us.is_some_and(|asked| now_us.wrapping_sub(asked) < PATIENCE_US);
        if waiting && self.step != Step::Readings {
            return None;
        }
        self.asked_us = Some(now_us);
        let (operation, row) = match &mut self.step {
            Step::Counts => (COUNTS_A_UNIT, None),
            Step::Units => (UNITS, None),
            Step::Row(row, pairs) => {
                *pairs = 0;
                (READ_ROW, Some(*row))
            }
            Step::Readings => (READ_GAUGES, None),
        };
        let id = StandardId::new(u16::from(self.base) << 4 | u16::from(operation))?;
        Some(Request { id, row })
    }

    fn learn(&mut self, next: Step) {
        self.step = next;
        self.asked_us = None;
    }

    /// An answer of the operation; `None` where it is not what the protocol says or was not asked for.
    fn answer(&mut self, operation: u8, data: &[u8], at_us: u32) -> Option<Option<Reading>> {
        match (self.step, operation, data) {
            (Step::Counts, COUNTS_A_UNIT, _) => {
                let [force, torque] = pair(data)?.map(u32::from_be_bytes);
                if force == 0 || torque == 0 {
                    return None;
                }
                self.counts = [force as f32, torque as f32];
                self.learn(Step::Units);
            }
            (Step::Units, UNITS, [force, torque]) => {
                self.unit = [force_unit_n(*force)?, torque_unit_nm(*torque)?];
                self.learn(Step::Row(0, 0));
            }
            (Step::Row(row, pairs), READ_ROW..=ROW_END, _) if operation == READ_ROW + pairs => {
                let two = pair(data)?.map(f32::from_be_bytes);
                if !two.iter().all(|entry| entry.is_finite()) {
                    return None;
                }
                let entries =
                    self.matrix.get_mut(usize::from(row))?.chunks_exact_mut(2).nth(usize::from(pairs))?;
                entries.iter_mut().zip(two).for_each(|(entry, new)| *entry = new);
                match (row, pairs) {
                    (_, 0 | 1) => self.step = Step::Row(row, pairs + 1),
                    (0..5, _) => self.learn(Step::Row(row + 1, 0)),
                    _ => self.learn(Step::Readings),
                }
            }
            (Step::Readings, READ_GAUGES, [high, low, gauges @ ..]) => {
                self.half = None;
                self.status = u16::from_be_bytes([*high, *low]);
                let gauges = three(gauges)?;
                if self.status != 0 {
                    count(&mut self.losses.faulty);
                } else {
                    self.half = Some((at_us, gauges));
                }
            }
            (Step::Readings, MORE_GAUGES, _) => {
                let odd = three(data)?;
                // A half without its other, or with that of another reading, is no reading.
                let (first_us, even) = self.half.take()?;
                if at_us.wrapping_sub(first_us) > HALVES_US {
                    return None;
                }
                return Some(Some(self.reading(even, odd, first_us)));
            }
            _ => return None,
        }
        Some(None)
    }

    fn reading(&self, even: [i16; 3], odd: [i16; 3], at_us: u32) -> Reading {
        let mut gauges = [0.0; 6];
        for (pair, (even, odd)) in gauges.chunks_exact_mut(2).zip(even.into_iter().zip(odd)) {
            if let [first, second] = pair {
                (*first, *second) = (f32::from(even), f32::from(odd));
            }
        }
        let mut values = [0.0; 6];
        for (k, (value, row)) in values.iter_mut().zip(&self.matrix).enumerate() {
            let [counts, unit] =
                if k < 3 { [self.counts[0], self.unit[0]] } else { [self.counts[1], self.unit[1]] };
            let sum: f32 = row.iter().zip(gauges).map(|(entry, gauge)| entry * gauge).sum();
            *value = sum / counts * unit;
        }
        Reading { at_us, stands_us: STANDS_US, values }
    }
}

/// Identifier and data of a frame; `None` for extended identifiers and remote frames.
pub struct Received<'a> {
    /// Of 11 bits.
    pub id: u16,
    /// 0 to 8 bytes.
    pub data: &'a [u8],
}

impl<'a> Received<'a> {
    /// Of a frame of the bus at hand.
    pub fn of<F: Frame>(frame: &'a F) -> Option<Self> {
        match frame.id() {
            Id::Standard(id) if frame.is_data_frame() => Some(Self { id: id.as_raw(), data: frame.data() }),
            _ => None,
        }
    }
}

impl WrenchSource for Ati {
    type Input<'a> = Received<'a>;

    fn take(&mut self, frame: Received<'_>, at_us: u32) -> Option<Reading> {
        if !self.owns(frame.id) {
            count(&mut self.losses.skipped);
            return None;
        }
        let answer = self.answer((frame.id & 0xf) as u8, frame.data, at_us);
        if answer.is_none() {
            count(&mut self.losses.damaged);
        }
        answer.flatten()
    }

    fn losses(&self) -> Losses {
        self.losses
    }
}

fn pair(data: &[u8]) -> Option<[[u8; 4]; 2]> {
    match *data {
        [a, b, c, d, e, f, g, h] => Some([[a, b, c, d], [e, f, g, h]]),
        _ => None,
    }
}

fn three(data: &[u8]) -> Option<[i16; 3]> {
    match *data {
        [a, b, c, d, e, f] => Some([[a, b], [c, d], [e, f]].map(i16::from_be_bytes)),
        _ => None,
    }
}

/// N of a unit of force: lbf, N, klbf, kN, kgf, gf.
fn force_unit_n(code: u8) -> Option<f32> {
    [4.448_221_6, 1.0, 4_448.221_6, 1_000.0, 9.806_65, 9.806_65e-3]
        .get(usize::from(code).checked_sub(1)?)
        .copied()
}

/// N m of a unit of torque: lbf in, lbf ft, N m, N mm, kgf cm, kN m.
fn torque_unit_nm(code: u8) -> Option<f32> {
    [0.112_984_83, 1.355_817_9, 1.0, 1e-3, 9.806_65e-2, 1_000.0]
        .get(usize::from(code).checked_sub(1)?)
        .copied()
}
