//! The unit on CAN-FD: wrenches in, flags and grip out (`docs/stickslip.dbc`).
//!
//! Standard identifiers, low byte first, no remote frames. A number that is not known has the largest value of
//! its field. Frames of another length are refused. On a bus with a sensor that knows classic frames only no CAN-FD frame is sent:
//! the state is then one classic frame with what a gripper's controller acts on.

use stickslip_shared::predictor::Prediction;
use stickslip_shared::wire::{Mode, TelemetryReport};

use crate::source::{Losses, Reading, WrenchSource, count};

/// Identifier of the wrench of finger 0; of finger 1 it is one more.
pub const WRENCH_ID: u16 = 0x110;
/// Identifier of the unit's state.
pub const STATE_ID: u16 = 0x120;
/// Identifier of the unit's state in a classic frame.
pub const CLASSIC_STATE_ID: u16 = 0x121;
/// Identifiers of all of the unit's own frames.
pub const OWN_IDS: [u16; 4] = [WRENCH_ID, WRENCH_ID + 1, STATE_ID, CLASSIC_STATE_ID];
/// Bytes of a wrench's frame.
pub const WRENCH_BYTES: usize = 32;
/// Bytes of a state's frame.
pub const STATE_BYTES: usize = 24;
/// Bytes of a state's classic frame.
pub const CLASSIC_STATE_BYTES: usize = 8;
/// Bits of the flags in it; two of the mode follow.
const CLASSIC_FLAGS: u32 = 14;

/// N and N m of a count.
const FORCE_N: f32 = 1e-4;
const TORQUE_NM: f32 = 1e-6;
/// N of a count of a grip force.
const GRIP_N: f32 = 0.01;
/// A wrench on the bus stands for one and a half of its periods, us. Its sender may say a shorter one.
const LONGEST_STANDS_US: u32 = 50_000;

/// A wrench on the bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench {
    /// Age of the measurement when it was sent, us.
    pub age_us: u16,
    /// Time from one to the next, us.
    pub period_us: u16,
    /// Counts the frames of a finger.
    pub counter: u8,
    /// The sender measured it.
    pub valid: bool,
    /// N and N m.
    pub values: [f32; 6],
}

impl Wrench {
    /// As bytes of a frame. Values beyond the field's range are at its end; not finite ones make it invalid.
    pub fn encode(&self) -> [u8; WRENCH_BYTES] {
        let mut frame = [0; WRENCH_BYTES];
        let valid = self.valid && self.values.iter().all(|x| x.is_finite());
        for (k, (word, value)) in frame.as_chunks_mut::<4>().0.iter_mut().zip(self.values).enumerate() {
            // A cast keeps within the range of the type.
            let counts = rounded(value / if k < 3 { FORCE_N } else { TORQUE_NM }) as i32;
            *word = counts.to_le_bytes();
        }
        let [a0, a1] = self.age_us.to_le_bytes();
        let [p0, p1] = self.period_us.to_le_bytes();
        if let Some(rest) = frame.last_chunk_mut::<8>() {
            *rest = [a0, a1, p0, p1, self.counter, u8::from(valid), 0, 0];
        }
        frame
    }

    /// From a frame's bytes; `None` where they are not a wrench's.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let frame: &[u8; WRENCH_BYTES] = bytes.try_into().ok()?;
        let mut values = [0.0; 6];
        for (k, (value, word)) in values.iter_mut().zip(frame.as_chunks::<4>().0).enumerate() {
            let counts = i32::from_le_bytes(*word);
            *value = counts as f32 * if k < 3 { FORCE_N } else { TORQUE_NM };
        }
        let [a0, a1, p0, p1, counter, valid, ..] = *frame.last_chunk::<8>()?;
        Some(Self {
            age_us: u16::from_le_bytes([a0, a1]),
            period_us: u16::from_le_bytes([p0, p1]),
            counter,
            valid: valid == 1,
            values,
        })
    }
}

/// Half away from zero; the bits are the same everywhere, beyond 2^23 there is nothing to round.
fn rounded(x: f32) -> f32 {
    if x.abs() < 8_388_608.0 { (x + 0.5_f32.copysign(x)) as i32 as f32 } else { x }
}

/// One finger's wrenches on the bus, as a source.
#[derive(Clone, Debug, Default)]
pub struct BusWrench {
    losses: Losses,
    /// Of the next frame.
    counter: Option<u8>,
}

impl BusWrench {
    /// Nothing received.
    pub const fn new() -> Self {
        Self { losses: Losses::NONE, counter: None }
    }
}

impl WrenchSource for BusWrench {
    type Input<'a> = &'a [u8];

    fn take(&mut self, bytes: &[u8], at_us: u32) -> Option<Reading> {
        let Some(wrench) = Wrench::decode(bytes) else {
            count(&mut self.losses.damaged);
            // It is not missing besides.
            self.counter = self.counter.map(|counter| counter.wrapping_add(1));
            return None;
        };
        let missing = self.counter.map_or(0, |due| wrench.counter.wrapping_sub(due));
        // A counter that stands still is a sender that repeats itself.
        if missing == u8::MAX {
            count(&mut self.losses.skipped);
            return None;
        }
        self.losses.lost = self.losses.lost.saturating_add(u32::from(missing));
        self.counter = Some(wrench.counter.wrapping_add(1));
        if !wrench.valid {
            count(&mut self.losses.faulty);
            return None;
        }
        let (age_us, period_us) = (u32::from(wrench.age_us), u32::from(wrench.period_us));
        let stands_us = (age_us + period_us + period_us / 2).min(LONGEST_STANDS_US);
        Some(Reading { at_us: at_us.wrapping_sub(age_us), stands_us, values: wrench.values })
    }

    fn losses(&self) -> Losses {
        self.losses
    }
}

/// What the unit says each tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// `predictor::flags`.
    pub flags: u32,
    /// `predictor::validity`.
    pub validity: u32,
    /// Low 32 bits of the unit's clock when the sample was measured, us.
    pub at_us: u32,
    /// Grip force of each finger that holds, N; `None`: not known.
    pub holding_n: Option<f32>,
    /// Grip force of each finger to be commanded, N.
    pub advised_n: Option<f32>,
    /// Time until the grasp is lost, s; `None`: not ahead.
    pub drop_in_s: Option<f32>,
    /// Share of friction in use of each finger, by the measured wrench.
    pub used: [Option<f32>; 2],
    /// What the unit does.
    pub mode: Mode,
    /// Counts the frames.
    pub counter: u8,
}

fn word(value: Option<f32>, unit: f32) -> [u8; 2] {
    let counts = value.filter(|x| x.is_finite()).map(|x| (rounded(x / unit) as u16).min(u16::MAX - 1));
    counts.unwrap_or(u16::MAX).to_le_bytes()
}

fn unword(bytes: [u8; 2], unit: f32) -> Option<f32> {
    let counts = u16::from_le_bytes(bytes);
    (counts != u16::MAX).then_some(f32::from(counts) * unit)
}

fn share(value: Option<f32>) -> u8 {
    let counts = value.filter(|x| x.is_finite()).map(|x| (rounded(x * 100.0) as u8).min(u8::MAX - 1));
    counts.unwrap_or(u8::MAX)
}

impl State {
    /// Of a report.
    pub fn of(report: &TelemetryReport) -> Self {
        let Prediction { flags, validity, holding_grip_n, drop_in_s, finger, .. } = report.prediction;
        Self {
            flags,
            validity,
            at_us: report.at_us,
            holding_n: holding_grip_n,
            advised_n: report.advised_grip_n,
            drop_in_s,
            used: finger.map(|f| f.measured_utilisation),
            mode: report.mode,
            counter: report.seq as u8,
        }
    }

    /// As bytes of a frame.
    pub fn encode(&self) -> [u8; STATE_BYTES] {
        let [h0, h1] = word(self.holding_n, GRIP_N);
        let [a0, a1] = word(self.advised_n, GRIP_N);
        let [d0, d1] = word(self.drop_in_s, 1e-3);
        let [u0, u1] = self.used.map(share);
        let mode = self.mode as u8;
        let words = [
            self.flags.to_le_bytes(),
            self.validity.to_le_bytes(),
            self.at_us.to_le_bytes(),
            [h0, h1, a0, a1],
            [d0, d1, u0, u1],
            [mode, self.counter, 0, 0],
        ];
        let mut frame = [0; STATE_BYTES];
        frame.iter_mut().zip(words.as_flattened()).for_each(|(out, byte)| *out = *byte);
        frame
    }

    /// From a frame's bytes; `None` where they are not a state's.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let (words, []) = bytes.as_chunks::<4>() else { return None };
        let [flags, validity, at_us, [h0, h1, a0, a1], [d0, d1, u0, u1], [mode, counter, ..]] = *words else {
            return None;
        };
        let used = |counts: u8| (counts != u8::MAX).then_some(f32::from(counts) * 0.01);
        Some(Self {
            flags: u32::from_le_bytes(flags),
            validity: u32::from_le_bytes(validity),
            at_us: u32::from_le_bytes(at_us),
            holding_n: unword([h0, h1], GRIP_N),
            advised_n: unword([a0, a1], GRIP_N),
            drop_in_s: unword([d0, d1], 1e-3),
            used: [used(u0), used(u1)],
            mode: mode_of(mode)?,
            counter,
        })
    }

    /// As bytes of a classic frame: flags, mode, validity, advised grip and counter.
    pub fn encode_classic(&self) -> [u8; CLASSIC_STATE_BYTES] {
        let bits = self.flags | (self.mode as u32) << CLASSIC_FLAGS;
        let [f0, f1, ..] = bits.to_le_bytes();
        let [v0, v1, v2, _] = self.validity.to_le_bytes();
        let [a0, a1] = word(self.advised_n, GRIP_N);
        [f0, f1, v0, v1, v2, a0, a1, self.counter]
    }

    /// From a classic frame's bytes, what is not in it being not known, the time 0; `None` where they are not a state's.
    pub fn decode_classic(bytes: &[u8]) -> Option<Self> {
        let [f0, f1, v0, v1, v2, a0, a1, counter] = *bytes else { return None };
        let bits = u16::from_le_bytes([f0, f1]);
        Some(Self {
            flags: u32::from(bits) & ((1 << CLASSIC_FLAGS) - 1),
            validity: u32::from_le_bytes([v0, v1, v2, 0]),
            at_us: 0,
            holding_n: None,
            advised_n: unword([a0, a1], GRIP_N),
            drop_in_s: None,
            used: [None; 2],
            mode: mode_of((bits >> CLASSIC_FLAGS) as u8)?,
            counter,
        })
    }
}

fn mode_of(number: u8) -> Option<Mode> {
    [Mode::Safe, Mode::Ready, Mode::Running].get(usize::from(number)).copied()
}
