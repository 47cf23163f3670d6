//! The noise floor of a comparison, and the scatter behind the test for lack of fit.
//!
//! The floor is that of [`crate::evidence::noise`]: what differs between runs of one condition in
//! the measurement, whatever its cause. It is a property of the data, so a model's failures do
//! not depend on what it is compared with. Where forces are tared, the floor is that of the
//! tared measurement.
//!
//! The test of the runs' mean errors needs chance alone. Both the measurement's scatter and
//! that of the model's own residuals are upper bounds of it (the first holds what follows from
//! measured differences of the runs, the second what the model makes of them): the
//! lesser is taken, again whatever other model is looked at.
//!
//! Where nothing is repeated the sensors' stated noise stands in; it lacks all that varies
//! from run to run, and the report says so.

use schemars::JsonSchema;
use serde::Serialize;

use super::tare::{NORMAL, Tare};
use super::trial::TrialErrors;
use crate::channels::{Quantity, Signals, quantity};
use crate::evidence::noise::{Course, Pool, about_mean};
use crate::evidence::phases::Phase;
use stickslip_data::Description;

/// Where a floor comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, JsonSchema, Serialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
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

/// Course of the measurement, less `rest` where forces are tared.
fn tared(trial: &TrialErrors, channel: usize, phase: Phase, by: f64) -> Course {
    let mut course = *trial.measured(channel, phase);
    course.shift(-by);
    course
}

/// What a tare takes out of the measurement of `channel` in each of `runs`, without a model: its
/// mean before contact, of the fingers' normal forces only the imbalance (a wrong grip is no
/// offset). Zeros where a run lacks that time: then nothing may be taken out of any.
fn rests(runs: &[usize], trials: &[TrialErrors], channel: usize, tare: Tare) -> Vec<f64> {
    let of = |k: &usize| {
        let rest = &trials[*k].rest;
        match NORMAL.contains(&channel) {
            true => 0.5 * (rest[NORMAL[0]] + rest[NORMAL[1]]),
            false => rest[channel],
        }
    };
    let found: Vec<f64> = runs.iter().map(of).collect();
    let all = tare == Tare::BeforeContact && found.iter().all(|x| x.is_finite());
    if all { found } else { vec![0.0; runs.len()] }
}

/// Floor of one channel and phase; `conditions` are places of runs that repeat each other,
/// `stated` is the sensor's noise.
pub fn floor(
    conditions: &[Vec<usize>],
    trials: &[TrialErrors],
    (channel, phase): (usize, Phase),
    tare: Tare,
    stated: f64,
) -> Floor {
    let mut pool = Pool::default();
    for condition in conditions {
        let rests = rests(condition, trials, channel, tare);
        let courses: Vec<(Course, f64)> = condition
            .iter()
            .zip(rests)
            .map(|(k, rest)| (tared(&trials[*k], channel, phase, rest), trials[*k].white[channel]))
            .collect();
        pool.add(courses.iter().map(|(course, white)| (course, *white)));
    }
    if let Some(rms) = pool.floor().filter(|rms| *rms > 0.0) {
        return Floor { rms, source: Source::Repetitions };
    }
    let rms = pool.white().max(stated);
    let source = if rms > 0.0 { Source::SensorNoise } else { Source::Unknown };
    Floor { rms, source }
}

/// What the runs' means of one channel and phase differ by, for each of `conditions`: in the
/// measurement or in the model's residuals, whichever is less; see the module.
pub fn repeated(
    conditions: &[Vec<usize>],
    trials: &[TrialErrors],
    (channel, phase): (usize, Phase),
    tare: Tare,
) -> Vec<Vec<f64>> {
    let measured = |c: &Vec<usize>| -> Vec<f64> {
        let rests = rests(c, trials, channel, tare);
        c.iter().zip(rests).map(|(k, rest)| tared(&trials[*k], channel, phase, rest).mean).collect()
    };
    let residual =
        |c: &Vec<usize>| -> Vec<f64> { c.iter().map(|k| trials[*k].course(channel, phase).mean).collect() };
    let squares =
        |groups: &Vec<Vec<f64>>| -> f64 { groups.iter().map(|g| about_mean(g.iter().copied()).0).sum() };
    [conditions.iter().map(measured).collect::<Vec<_>>(), conditions.iter().map(residual).collect()]
        .into_iter()
        .filter(|groups| groups.iter().flatten().all(|x| x.is_finite()))
        .min_by(|a, b| squares(a).total_cmp(&squares(b)))
        .unwrap_or_default()
}
