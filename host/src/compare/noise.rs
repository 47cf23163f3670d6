//! The noise floor: the error that a perfect model would still show.
//!
//! Runs of one condition repeat each other; what differs between them no model of the
//! condition can predict. The floor of a channel and phase has two parts: the scatter of
//! the error's course from run to run (means over eight sections of the phase, pooled over
//! conditions) and the noise from sample to sample. A perfect model's RMS error equals it.
//! Where nothing is repeated the sensors' stated noise stands in; it lacks all that varies
//! from run to run, and the report says so.

use serde::Serialize;

use super::trial::{SECTIONS, TrialErrors};
use crate::channels::{Quantity, Signals, quantity};
use crate::dataset::Description;
use crate::phases::Phase;

/// Where a floor comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Scatter of runs of the same condition.
    Repetitions,
    /// Noise that dataset.toml states, or seen from sample to sample where it states less.
    SensorNoise,
    /// Neither: no floor.
    Unknown,
}

/// RMS error of a perfect model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Floor {
    /// SI unit of the channel.
    pub rms: f64,
    /// Where from.
    pub source: Source,
}

/// Stated noise of each channel; 0 where dataset.toml says nothing.
pub fn sensor_noise(description: &Description) -> Signals {
    let s = &description.sensors;
    std::array::from_fn(|k| {
        let sensor = if k < 18 { &s.finger } else { &s.pusher };
        match quantity(k) {
            Quantity::Position => s.pose.position_noise_m,
            Quantity::Rotation => s.pose.rotation_noise_rad,
            Quantity::Force => sensor.force_noise_n,
            Quantity::Torque => sensor.torque_noise_nm,
        }
    })
}

/// Floor of one channel and phase from the runs of each condition; `stated` is the sensor's
/// noise.
pub fn floor(conditions: &[Vec<&TrialErrors>], channel: usize, phase: Phase, stated: f64) -> Floor {
    let (mut squares, mut degrees, mut samples, mut runs) = (0.0, 0.0, 0.0, 0.0);
    let mut white_sq = 0.0;
    for condition in conditions {
        let known: Vec<&&TrialErrors> =
            condition.iter().filter(|t| t.raw(channel, phase).is_known()).collect();
        for t in &known {
            samples += f64::from(t.raw(channel, phase).samples);
            white_sq += t.white[channel].powi(2);
            runs += 1.0;
        }
        for section in 0..SECTIONS {
            let values: Vec<f64> = known
                .iter()
                .map(|t| t.raw(channel, phase).sections[section])
                .filter(|x| x.is_finite())
                .collect();
            if values.len() > 1 {
                let n = values.len() as f64;
                let mean = values.iter().sum::<f64>() / n;
                squares += values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
                degrees += n - 1.0;
            }
        }
    }
    let white_sq = if runs > 0.0 { white_sq / runs } else { 0.0 };
    if degrees > 0.0 {
        // A section's mean holds its share of the sample noise already.
        let in_section = (samples / runs / SECTIONS as f64).max(1.0);
        let between = (squares / degrees - white_sq / in_section).max(0.0);
        let rms = (between + white_sq).sqrt();
        if rms > 0.0 {
            return Floor { rms, source: Source::Repetitions };
        }
    }
    let rms = stated.max(white_sq.sqrt());
    let source = if rms > 0.0 { Source::SensorNoise } else { Source::Unknown };
    Floor { rms, source }
}
