//! Fingertip wrenches from strain gauges: `wrench = C (counts - tare)` for each finger,
//! with a 6 x 6 calibration matrix `C` (N and N m a count) that the host sets.

use stickslip_shared::wire::{Calibration, Sample};

use crate::board::Gauges;
use crate::queues::SAMPLES;
use crate::source::{FingerSource, Next};

/// Ticks averaged by a tare: half a second.
const TARE_TICKS: u32 = 125;
/// Counts this close to an end of the converter's 12 bits are not a measurement.
const SATURATION: u16 = 8;
const FULL_SCALE: u16 = 4095;

/// Gauges with their calibration, tare and the newest poses from the host.
pub struct GaugeSource<G: Gauges> {
    gauges: G,
    matrix: [[[f32; 6]; 6]; 2],
    offset: [f32; 12],
    taring: Option<(u32, [u32; 12])>,
    newest: Option<Sample>,
    grip_n: f32,
    seq: u32,
}

impl<G: Gauges> GaugeSource<G> {
    /// Not calibrated: wrenches are zero until the host sends both matrices.
    pub fn new(gauges: G) -> Self {
        Self {
            gauges,
            matrix: [[[0.0; 6]; 6]; 2],
            offset: [f32::from(FULL_SCALE) / 2.0; 12],
            taring: None,
            newest: None,
            grip_n: f32::NAN,
            seq: 0,
        }
    }

    /// For one run.
    pub fn restart(&mut self) {
        self.newest = None;
        self.seq = 0;
    }

    /// Sets one finger's matrix.
    pub fn calibrate(&mut self, calibration: &Calibration) {
        if let Some(matrix) = self.matrix.get_mut(usize::from(calibration.finger)) {
            *matrix = calibration.matrix;
        }
    }

    /// Grip set-point for samples of which the host tells none.
    pub fn set_grip(&mut self, force_n: f32) {
        self.grip_n = force_n;
    }

    /// Averages the coming half second as no load.
    pub fn tare(&mut self) {
        self.taring = Some((0, [0; 12]));
    }

    /// Reads the converter once; goes on with a tare.
    pub fn poll(&mut self) -> Option<[u16; 12]> {
        let counts = self.gauges.read()?;
        if let Some((ticks, sums)) = &mut self.taring {
            *ticks += 1;
            for (sum, count) in sums.iter_mut().zip(counts) {
                *sum += u32::from(count);
            }
            if *ticks == TARE_TICKS {
                for (offset, sum) in self.offset.iter_mut().zip(sums) {
                    *offset = *sum as f32 / TARE_TICKS as f32;
                }
                self.taring = None;
            }
        }
        Some(counts)
    }

    fn wrench(&self, finger: usize, counts: &[u16; 12]) -> Option<[f32; 6]> {
        let (from, to) = (finger * 6, finger * 6 + 6);
        let counts = counts.get(from..to)?;
        let offset = self.offset.get(from..to)?;
        let sound = SATURATION..=FULL_SCALE - SATURATION;
        if !counts.iter().all(|count| sound.contains(count)) {
            return None;
        }
        let matrix = self.matrix.get(finger)?;
        let mut wrench = [0.0; 6];
        for (out, row) in wrench.iter_mut().zip(matrix) {
            for ((entry, count), zero) in row.iter().zip(counts).zip(offset) {
                *out += entry * (f32::from(*count) - zero);
            }
        }
        Some(wrench)
    }
}

impl<G: Gauges> FingerSource for GaugeSource<G> {
    fn next(&mut self) -> Next {
        while let Some(sample) = SAMPLES.try_receive() {
            self.newest = Some(sample);
        }
        let Some(counts) = self.poll() else {
            return Next::Starved;
        };
        let seq = self.seq;
        self.seq = seq.wrapping_add(1);
        let told = self.newest;
        Next::Sample(Sample {
            seq,
            t_us: seq.wrapping_mul(stickslip_shared::wire::TICK_US),
            grip_cmd_n: told.map_or(self.grip_n, |sample| sample.grip_cmd_n),
            gripper: told.and_then(|sample| sample.gripper),
            object: told.and_then(|sample| sample.object),
            pusher: told.and_then(|sample| sample.pusher),
            finger: [self.wrench(0, &counts), self.wrench(1, &counts)],
        })
    }
}
