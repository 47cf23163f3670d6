//! The noise floor: the error that a perfect model would still show.
//!
//! Runs of one condition repeat each other; what differs between them no model of the
//! condition can predict: their pooled scatter ([`crate::evidence::noise`]) is the RMS error of a perfect
//! model.
//!
//! Whose scatter? The measurement's own holds, beside chance, what follows from differences
//! of the runs that were measured (how the object was placed, say), and the errors of a model
//! hold what that model makes of such differences: a rigid one that answers micrometres with
//! newtons scatters more than what it describes. All are upper bounds of chance; the least of
//! them is taken, one floor for all models that are compared.
//!
//! Where nothing is repeated the sensors' stated noise stands in; it lacks all that varies
//! from run to run, and the report says so.

use serde::Serialize;

use super::trial::TrialErrors;
use crate::channels::{Quantity, Signals, quantity};
use crate::evidence::noise::{Course, Pool, about_mean};
use crate::evidence::phases::Phase;
use stickslip_data::Description;

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

/// Whose scatter from run to run is looked at.
#[derive(Clone, Copy)]
enum Witness<'a> {
    /// The measurement's own.
    Measured(&'a [TrialErrors]),
    /// That of a model's errors.
    Errors(&'a [TrialErrors]),
}

impl Witness<'_> {
    fn course(&self, trial: usize, channel: usize, phase: Phase) -> &Course {
        match self {
            Self::Measured(all) => all[trial].measured(channel, phase),
            Self::Errors(all) => all[trial].error(channel, phase),
        }
    }

    fn white(&self, trial: usize, channel: usize) -> f64 {
        let (Self::Measured(all) | Self::Errors(all)) = self;
        all[trial].white[channel]
    }
}

/// The measurement, and the errors of each model.
fn witnesses(models: &[Vec<TrialErrors>]) -> impl Iterator<Item = Witness<'_>> {
    let measured = models.first().map(|first| Witness::Measured(first));
    measured.into_iter().chain(models.iter().map(|m| Witness::Errors(m)))
}

/// Floor of one channel and phase from `models`' errors of all trials; `conditions` are places
/// of runs that repeat each other, `stated` is the sensor's noise.
pub fn floor(
    conditions: &[Vec<usize>],
    models: &[Vec<TrialErrors>],
    channel: usize,
    phase: Phase,
    stated: f64,
) -> Floor {
    let pool = |witness: Witness| {
        let mut pool = Pool::default();
        for condition in conditions {
            let run = |k: &usize| (witness.course(*k, channel, phase), witness.white(*k, channel));
            pool.add(condition.iter().map(run));
        }
        pool
    };
    let pools: Vec<Pool> = witnesses(models).map(pool).collect();
    let repetitions = pools.iter().filter_map(Pool::floor).min_by(f64::total_cmp);
    if let Some(rms) = repetitions.filter(|rms| *rms > 0.0) {
        return Floor { rms, source: Source::Repetitions };
    }
    let rms = pools.first().map_or(0.0, Pool::white).max(stated);
    let source = if rms > 0.0 { Source::SensorNoise } else { Source::Unknown };
    Floor { rms, source }
}

/// What the runs' means of one channel and phase differ by, for each of `conditions`, after the
/// witness that shows the least; see the module.
pub fn repeated(
    conditions: &[Vec<usize>],
    models: &[Vec<TrialErrors>],
    channel: usize,
    phase: Phase,
) -> Vec<Vec<f64>> {
    let means = |witness: Witness| -> Vec<Vec<f64>> {
        let of = |c: &Vec<usize>| c.iter().map(|k| witness.course(*k, channel, phase).mean).collect();
        conditions.iter().map(of).collect()
    };
    let squares =
        |groups: &Vec<Vec<f64>>| -> f64 { groups.iter().map(|g| about_mean(g.iter().copied()).0).sum() };
    witnesses(models)
        .map(means)
        .filter(|groups| groups.iter().flatten().all(|x| x.is_finite()))
        .min_by(|a, b| squares(a).total_cmp(&squares(b)))
        .unwrap_or_default()
}
