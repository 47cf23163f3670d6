//! Fingertip wrenches from strain gauges, and the host's poses beside them:
//! `wrench = C (counts - tare)` for each finger, with a 6 x 6 calibration matrix `C` (N and N m a count).
//!
//! No registers and no clock of its own, so that it runs in tests on the host. A finger without a
//! calibration has no wrench. What the host last sent has an age: a pose is a measurement once,
//! when it is new, and the prescribed bodies' poses stand for [`MAX_AGE_US`]; older ones
//! are none, so that a stalled host or camera does not pass for an object at rest.

use crate::wire::{Calibration, Sample};

/// Channels: six gauges of each of two fingers.
pub const CHANNELS: usize = 12;
/// Readings averaged by a tare: half a second of ticks.
pub const TARE_READINGS: u32 = 125;
/// Counts this close to an end of the converter's 12 bits are not a measurement.
const SATURATION: u16 = 8;
const FULL_SCALE: u16 = 4095;
/// Age beyond which the host's poses of gripper and pusher, and its grip command, count as not known, us:
/// five ticks, more than the jitter of a USB serial line (1 to 16 ms), in which the fastest plan here moves
/// 0.5 mm (25 mm/s).
pub const MAX_AGE_US: u32 = 20_000;

/// The host's newest sample, and when it came by the board's clock.
#[derive(Clone, Copy, Debug)]
struct Newest {
    sample: Sample,
    at_us: u32,
    /// Its object pose has not been used yet.
    new: bool,
}

/// Calibration, tare, and the host's newest sample.
#[derive(Clone, Debug)]
pub struct GaugeModel {
    matrix: [Option<[[f32; 6]; 6]>; 2],
    offset: [f32; CHANNELS],
    taring: Option<(u32, [u32; CHANNELS])>,
    newest: Option<Newest>,
    grip_n: f32,
    seq: u32,
    began_us: Option<u32>,
}

impl Default for GaugeModel {
    fn default() -> Self {
        Self::new()
    }
}

impl GaugeModel {
    /// Not calibrated.
    pub const fn new() -> Self {
        Self {
            matrix: [None; 2],
            offset: [FULL_SCALE as f32 / 2.0; CHANNELS],
            taring: None,
            newest: None,
            grip_n: f32::NAN,
            seq: 0,
            began_us: None,
        }
    }

    /// For one run; calibration, tare and grip set-point stay.
    pub fn restart(&mut self) {
        self.newest = None;
        self.seq = 0;
        self.began_us = None;
    }

    /// Sets one finger's matrix.
    pub fn calibrate(&mut self, calibration: &Calibration) {
        if let Some(matrix) = self.matrix.get_mut(usize::from(calibration.finger)) {
            *matrix = Some(calibration.matrix);
        }
    }

    /// The first finger (0 or 1) without a calibration.
    pub fn uncalibrated(&self) -> Option<u8> {
        self.matrix.iter().position(Option::is_none).map(|k| k as u8)
    }

    /// Grip set-point while the host sends none.
    pub fn set_grip(&mut self, force_n: f32) {
        self.grip_n = force_n;
    }

    /// Averages the coming half second as no load.
    pub fn tare(&mut self) {
        self.taring = Some((0, [0; CHANNELS]));
    }

    /// Goes on with a tare.
    pub fn read(&mut self, counts: &[u16; CHANNELS]) {
        let Some((readings, sums)) = &mut self.taring else { return };
        *readings += 1;
        for (sum, count) in sums.iter_mut().zip(counts) {
            *sum += u32::from(*count);
        }
        if *readings == TARE_READINGS {
            for (offset, sum) in self.offset.iter_mut().zip(sums) {
                *offset = *sum as f32 / TARE_READINGS as f32;
            }
            self.taring = None;
        }
    }

    /// A sample of the host came at `at_us` by the board's clock.
    pub fn told(&mut self, sample: Sample, at_us: u32) {
        self.newest = Some(Newest { sample, at_us, new: true });
    }

    /// The sample of the tick at `now_us` by the board's clock, which may wrap around.
    pub fn sample(&mut self, counts: &[u16; CHANNELS], now_us: u32) -> Sample {
        let seq = self.seq;
        self.seq = seq.wrapping_add(1);
        let began_us = *self.began_us.get_or_insert(now_us);
        let finger = [self.wrench(0, counts), self.wrench(1, counts)];
        let fresh = self.newest.as_mut().filter(|n| now_us.wrapping_sub(n.at_us) <= MAX_AGE_US);
        let (mut gripper, mut object, mut pusher, mut grip_cmd_n) = (None, None, None, self.grip_n);
        if let Some(newest) = fresh {
            (gripper, pusher) = (newest.sample.gripper, newest.sample.pusher);
            object = newest.sample.object.filter(|_| newest.new);
            newest.new = false;
            grip_cmd_n = newest.sample.grip_cmd_n;
        }
        Sample { seq, t_us: now_us.wrapping_sub(began_us), grip_cmd_n, gripper, object, pusher, finger }
    }

    fn wrench(&self, finger: usize, counts: &[u16; CHANNELS]) -> Option<[f32; 6]> {
        let matrix = self.matrix.get(finger)?.as_ref()?;
        let own = finger * 6..finger * 6 + 6;
        let (counts, offset) = (counts.get(own.clone())?, self.offset.get(own)?);
        let sound = SATURATION..=FULL_SCALE - SATURATION;
        if !counts.iter().all(|count| sound.contains(count)) {
            return None;
        }
        let mut wrench = [0.0; 6];
        for (out, row) in wrench.iter_mut().zip(matrix) {
            for ((entry, count), zero) in row.iter().zip(counts).zip(offset) {
                *out += entry * (f32::from(*count) - zero);
            }
        }
        Some(wrench)
    }
}
