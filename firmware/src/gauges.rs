//! The tick's sample from strain gauges: the converter, the host's queue and the clock for
//! [`stickslip_shared::gauges`], which has the rules.

use core::sync::atomic::{AtomicU8, Ordering};

use embassy_time::Instant;
use stickslip_shared::gauges::{CHANNELS, GaugeModel};
use stickslip_shared::wire::{Calibration, Refusal};

use crate::board::Gauges;
use crate::queues::SAMPLES;
use crate::source::{FingerSource, Next};

/// Fingers, as bits, whose calibration was accepted since the start of the processor.
static CALIBRATED: AtomicU8 = AtomicU8::new(0);

/// A finger's calibration was accepted: it takes effect before any later command.
pub fn note_calibrated(finger: u8) {
    CALIBRATED.fetch_or(1 << (finger & 1), Ordering::Relaxed);
}

/// # Errors
/// A finger has no calibration: its wrench would be none.
pub fn check_calibrated() -> Result<(), Refusal> {
    match (!CALIBRATED.load(Ordering::Relaxed)).trailing_zeros() {
        finger @ 0..=1 => Err(Refusal::NotCalibrated { finger: finger as u8 }),
        _ => Ok(()),
    }
}

/// Gauges with their calibration and tare.
pub struct GaugeSource<G: Gauges> {
    gauges: G,
    model: GaugeModel,
}

impl<G: Gauges> GaugeSource<G> {
    /// Not calibrated.
    pub fn new(gauges: G) -> Self {
        Self { gauges, model: GaugeModel::new() }
    }

    /// For one run.
    pub fn restart(&mut self) {
        self.model.restart();
    }

    /// Sets one finger's matrix.
    pub fn calibrate(&mut self, calibration: &Calibration) {
        self.model.calibrate(calibration);
    }

    /// Grip set-point while the host sends none.
    pub fn set_grip(&mut self, force_n: f32) {
        self.model.set_grip(force_n);
    }

    /// Averages the coming half second as no load.
    pub fn tare(&mut self) {
        self.model.tare();
    }

    /// Reads the converter once; goes on with a tare.
    pub fn poll(&mut self) -> Option<[u16; CHANNELS]> {
        let counts = self.gauges.read()?;
        self.model.read(&counts);
        Some(counts)
    }
}

impl<G: Gauges> FingerSource for GaugeSource<G> {
    fn next(&mut self) -> Next {
        // The low 32 bits of the clock, as on the line.
        let now_us = Instant::now().as_micros() as u32;
        while let Some(sample) = SAMPLES.try_receive() {
            self.model.told(sample, now_us);
        }
        let Some(counts) = self.poll() else {
            return Next::Starved;
        };
        Next::Sample(self.model.sample(&counts, now_us))
    }
}
