//! Before contact, pushed, end: a trial's stages from its measurements alone, without a model.
//!
//! Contact: the pusher's force (where there is no pusher sensor, the fingers' forces), averaged
//! over five samples, has left its mean of the first 50 ms by more than five standard deviations
//! and by more than 2 % of its largest change. End: after the last sample at which gripper or
//! pusher move faster than a quarter of their largest speed.

use std::ops::Range;

use crate::evidence::noise::white_noise;
use stickslip_data::{Pose, Sample, Trial};

const BASELINE_S: f64 = 0.05;
const AVERAGE: usize = 5;
const SIGMAS: f64 = 5.0;
const SHARE: f64 = 0.02;
const SPEED_WINDOW_S: f64 = 0.04;

/// Part of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Nothing pushes yet.
    BeforeContact,
    /// From contact until the drive stops.
    Pushed,
    /// The drive has stopped.
    End,
}

/// In order of time.
pub const STAGES: [Stage; 3] = [Stage::BeforeContact, Stage::Pushed, Stage::End];

impl Stage {
    /// As people read it.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Stage::BeforeContact => "before contact",
            Stage::Pushed => "pushed",
            Stage::End => "end",
        }
    }
}

/// The stages of one trial, as sample indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stages {
    /// First sample in contact; `None` where no force ever changes, or nothing is measured: then
    /// all samples until the end count as pushed.
    pub contact: Option<usize>,
    /// First sample after the motion; the number of samples where it never stops.
    pub end: usize,
    samples: usize,
}

impl Stages {
    /// Samples of `stage`; may be empty.
    #[must_use]
    pub fn range(&self, stage: Stage) -> Range<usize> {
        let contact = self.contact.unwrap_or(0).min(self.samples);
        let end = self.end.clamp(contact, self.samples);
        match stage {
            Stage::BeforeContact => 0..contact,
            Stage::Pushed => contact..end,
            Stage::End => end..self.samples,
        }
    }

    /// Stage of a sample, as its place in [`STAGES`].
    #[must_use]
    pub fn of(&self, sample: usize) -> usize {
        STAGES.iter().position(|stage| self.range(*stage).contains(&sample)).unwrap_or(0)
    }
}

/// Finds the stages of `trial`.
#[must_use]
pub fn stages(trial: &Trial) -> Stages {
    let samples = &trial.samples;
    let pusher = |sample: &Sample| {
        let force = sample.pusher_wrench.map_or([f64::NAN; 3], |wrench| wrench.force_n);
        force.to_vec()
    };
    let fingers = |sample: &Sample| {
        let force = |finger: usize| sample.finger[finger].map_or([f64::NAN; 3], |wrench| wrench.force_n);
        [force(0), force(1)].concat()
    };
    let measured = |forces: &[Vec<f64>]| {
        forces.iter().filter(|force| force.iter().any(|f| !f.is_nan())).count() * 2 > forces.len()
    };
    let by_pusher: Vec<_> = samples.iter().map(pusher).collect();
    let forces = if measured(&by_pusher) { by_pusher } else { samples.iter().map(fingers).collect() };
    Stages { contact: contact(samples, &forces), end: end(samples), samples: samples.len() }
}

fn contact(samples: &[Sample], forces: &[Vec<f64>]) -> Option<usize> {
    let start_s = samples.first()?.t_s;
    let early = samples.iter().take_while(|sample| sample.t_s - start_s <= BASELINE_S).count();
    let channels = forces.first()?.len();
    let mut change = vec![0.0; forces.len()];
    let mut variance = 0.0;
    for channel in 0..channels {
        let values: Vec<f64> = forces.iter().filter_map(|force| force.get(channel)).copied().collect();
        let first = values.get(..early).unwrap_or_default();
        let base = mean(first);
        let sigma = white_noise(values.iter().copied()).unwrap_or(0.0);
        if base.is_nan() {
            continue;
        }
        variance += sigma * sigma;
        for (at, change) in change.iter_mut().enumerate() {
            let around = values.get(at..(at + AVERAGE).min(values.len())).unwrap_or_default();
            let away = mean(around) - base;
            if !away.is_nan() {
                *change += away * away;
            }
        }
    }
    let largest = change.iter().copied().fold(0.0, f64::max).sqrt();
    let threshold = (SIGMAS * (variance / AVERAGE as f64).sqrt()).max(SHARE * largest);
    let at = change.iter().position(|change| change.sqrt() > threshold)?;
    // The window looks ahead: the change is at its far end when it first shows.
    Some((at + AVERAGE - 1).min(forces.len()))
}

fn end(samples: &[Sample]) -> usize {
    let speeds: Vec<f64> = (0..samples.len()).map(|at| speed(samples, at)).collect();
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    let last = speeds.iter().rposition(|speed| *speed > 0.25 * fastest);
    last.map_or(samples.len(), |last| last + 1)
}

/// Speed of gripper and pusher about a sample, rotation counted at an arm of 50 mm.
fn speed(samples: &[Sample], at: usize) -> f64 {
    const ARM_M: f64 = 0.05;
    let Some(here) = samples.get(at) else { return 0.0 };
    let half_s = SPEED_WINDOW_S / 2.0;
    let from = samples
        .get(..at)
        .and_then(|before| before.iter().rev().take_while(|sample| here.t_s - sample.t_s <= half_s).last());
    let to = samples
        .get(at..)
        .and_then(|after| after.iter().take_while(|sample| sample.t_s - here.t_s <= half_s).last());
    let (from, to) = (from.unwrap_or(here), to.unwrap_or(here));
    let path = |from: Option<Pose>, to: Option<Pose>| match (from, to) {
        (Some(from), Some(to)) => {
            let (from, to) = (crate::channels::pose(&from), crate::channels::pose(&to));
            (to.position_m - from.position_m).norm() + ARM_M * to.rotation.angle_to(&from.rotation)
        }
        _ => 0.0,
    };
    let elapsed_s = to.t_s - from.t_s;
    if elapsed_s <= 0.0 {
        return 0.0;
    }
    (path(from.gripper, to.gripper) + path(from.pusher, to.pusher)) / elapsed_s
}

fn mean(values: &[f64]) -> f64 {
    let (sum, count) = values
        .iter()
        .filter(|value| !value.is_nan())
        .fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}
