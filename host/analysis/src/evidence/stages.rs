//! Before contact, pushed, end: a trial's stages from its measurements alone, without a model.
//!
//! Contact: [`crate::evidence::contact`]. End: after the last sample at which gripper or pusher move
//! faster than a quarter of their largest speed.

use std::ops::Range;

use nalgebra::UnitQuaternion;
use stickslip_data::{Pose, Sample, Trial};
use stickslip_shared::track::{Pose as Placed, Poses};

use crate::channels::{self, Signals};
use crate::evidence::contact;
use crate::run::motion::{denoised, interpolated};

/// Speeds are taken over this time.
const SPEED_S: f64 = 0.08;

/// Part of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, schemars::JsonSchema, serde::Serialize)]
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
    rest: usize,
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

    /// Samples before contact that are clear of it; none where it is not found.
    #[must_use]
    pub fn rest(&self) -> Range<usize> {
        0..self.rest
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
    let t_s: Vec<f64> = trial.samples.iter().map(|s| s.t_s).collect();
    let (origin, start) = (Placed::identity(), UnitQuaternion::identity());
    // Forces do not depend on where poses are counted from.
    let signals: Vec<Signals> =
        trial.samples.iter().map(|s| channels::measured(s, &origin, &start)).collect();
    let moving = moving(&t_s, &drive(trial, &t_s));
    let end = moving.iter().rposition(|m| *m).map_or(t_s.len(), |last| last + 1);
    let contact = contact::measured(&t_s, &signals).flatten();
    let rest = contact.map_or(0, |at| contact::clear_of(&t_s, at).end);
    Stages { contact, end, samples: t_s.len(), rest }
}

/// Gripper and pusher of a trial without the noise of their measurement; what is not measured rests.
fn drive(trial: &Trial, t_s: &[f64]) -> Vec<Poses<f64>> {
    let track = |of: fn(&Sample) -> Option<Pose>| {
        let known: Vec<_> = trial.samples.iter().map(|s| of(s).as_ref().map(channels::pose)).collect();
        interpolated(t_s, &known).map(|poses| denoised(t_s, &poses))
    };
    let (gripper, pusher) = (track(|s| s.gripper), track(|s| s.pusher));
    let at = |track: &Option<Vec<Placed<f64>>>, i: usize| track.as_ref().and_then(|t| t.get(i)).copied();
    let poses = |(i, t_s): (usize, &f64)| Poses {
        t_s: *t_s,
        carrier: at(&gripper, i).unwrap_or_else(Placed::identity),
        pusher: at(&pusher, i),
        support: None,
    };
    t_s.iter().enumerate().map(poses).collect()
}

/// Where gripper or pusher move faster than a quarter of their largest speed.
#[must_use]
pub fn moving(t_s: &[f64], poses: &[Poses<f64>]) -> Vec<bool> {
    // A rotation moves the object's ends, 50 mm away.
    const ARM_M: f64 = 0.05;
    let path = |from: &Placed<f64>, to: &Placed<f64>| {
        (to.position_m - from.position_m).norm() + ARM_M * to.rotation.angle_to(&from.rotation)
    };
    let speed = |i: usize| {
        let (a, b) = around(t_s, i, SPEED_S / 2.0);
        let (from, to, elapsed_s) = (poses.get(a)?, poses.get(b)?, t_s.get(b)? - t_s.get(a)?);
        let pusher = from.pusher.zip(to.pusher).map_or(0.0, |(from, to)| path(&from, &to));
        (elapsed_s > 0.0).then(|| path(&from.carrier, &to.carrier).max(pusher) / elapsed_s)
    };
    let speeds: Vec<f64> = (0..t_s.len()).map(|i| speed(i).unwrap_or(0.0)).collect();
    let largest = speeds.iter().copied().fold(0.0, f64::max);
    speeds.iter().map(|v| *v > 0.25 * largest && largest > 1e-5).collect()
}

/// First and last of the samples within `half_s` of sample `i`.
pub(super) fn around(t_s: &[f64], i: usize, half_s: f64) -> (usize, usize) {
    let from = t_s[..i].partition_point(|t| *t < t_s[i] - half_s);
    let to = (i + t_s[i..].partition_point(|t| *t <= t_s[i] + half_s)).saturating_sub(1).max(i);
    (from, to)
}
