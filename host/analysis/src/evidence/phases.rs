//! Splits a trial into before contact, sticking, onset, sliding and end: the phases of `compare`.
//! Onset and sliding follow the object's motion in the grasp; those of a fit's features, in `diagnose` and `add`, follow
//! the path in contact and are other samples ([`crate::fit::phases`]).
//!
//! The rule, with `sigma` the noise of the signal at hand (stated in dataset.toml, or found
//! from the differences of neighbouring samples where that is larger):
//!
//! - contact: by the measured forces ([`crate::evidence::contact`]). Where none is measured, or they
//!   change nowhere: the model's pusher touches and gripper or pusher have started to move; without
//!   a pusher (lift) the gripper starts to move.
//! - motion: the object, averaged over 20 ms, has left its start in the grasp by more than
//!   6 sigma, in position or in rotation, and goes further. Without measured poses: by the
//!   model's.
//! - onset: from the last sample within 2 sigma before that (at most 0.25 s earlier) until
//!   the speed first reaches 80 % of its median afterwards (20 ms to 0.3 s later).
//! - end: after the last sample at which gripper or pusher move faster than a quarter of
//!   their largest speed.
//!
//! Sticking lies between contact and onset, sliding between onset and end; any phase may
//! be empty.

use std::ops::Range;

use schemars::JsonSchema;
use serde::Serialize;

use crate::channels::{COUNT, Signals};
use crate::evidence::contact::{self, Evidence};
use crate::evidence::stages::{around, moving};
use crate::evidence::statistics::median;
use crate::run::simulate::{Prepared, Simulated};

/// Part of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Nothing pushes yet.
    BeforeContact,
    /// Pushed, and at rest in the grasp.
    Sticking,
    /// Begins to slide.
    Onset,
    /// Slides.
    Sliding,
    /// The drive has stopped.
    End,
}

/// In order of time.
pub const PHASES: [Phase; 5] =
    [Phase::BeforeContact, Phase::Sticking, Phase::Onset, Phase::Sliding, Phase::End];

impl Phase {
    /// As people read it.
    pub fn label(self) -> &'static str {
        match self {
            Phase::BeforeContact => "before contact",
            Phase::Sticking => "sticking",
            Phase::Onset => "onset",
            Phase::Sliding => "sliding",
            Phase::End => "end",
        }
    }

    /// As in a sentence: 'the error ... while sliding'.
    pub fn during(self) -> &'static str {
        match self {
            Phase::BeforeContact => "before contact",
            Phase::Sticking => "while sticking",
            Phase::Onset => "at the onset of sliding",
            Phase::Sliding => "while sliding",
            Phase::End => "after the motion",
        }
    }
}

/// The phases of one trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Phases {
    /// First sample of sticking, onset, sliding, end, and the number of samples.
    starts: [usize; 5],
    /// How contact was found.
    pub contact: Evidence,
    /// How motion was found.
    pub motion: Evidence,
}

impl Phases {
    /// Samples of `phase`; may be empty.
    pub fn range(&self, phase: Phase) -> Range<usize> {
        let k = phase as usize;
        let from = if k == 0 { 0 } else { self.starts[k - 1] };
        from..self.starts[k]
    }

    /// Orders the boundaries so that no phase has negative length.
    fn ordered(contact: usize, onset: usize, sliding: usize, end: usize, n: usize) -> [usize; 5] {
        let contact = contact.min(n);
        let onset = onset.clamp(contact, n);
        let sliding = sliding.clamp(onset, n);
        let end = end.clamp(contact, n);
        [contact, onset.min(end), sliding.min(end), end, n]
    }
}

const AVERAGE_S: f64 = 0.02;
const SPEED_S: f64 = 0.08;

/// Phases of a trial; `noise` is the standard deviation of each channel, zero where not stated.
pub fn split(prepared: &Prepared, simulated: &Simulated, noise: &Signals) -> Phases {
    let n = prepared.t_s.len();
    let moving = moving(&prepared.t_s, prepared.poses());
    let begin = moving.iter().position(|m| *m).unwrap_or(n);
    let end = moving.iter().rposition(|m| *m).map_or(n, |last| last + 1);
    let (contact_at, contact) = find_contact(prepared, simulated, begin);
    let (motion_at, motion) = find_motion(prepared, simulated, noise, end);
    let (onset, sliding) = motion_at.unwrap_or((n, n));
    Phases { starts: Phases::ordered(contact_at, onset, sliding, end, n), contact, motion }
}

fn find_contact(prepared: &Prepared, simulated: &Simulated, begin: usize) -> (usize, Evidence) {
    let n = prepared.t_s.len();
    let measured = contact::measured(&prepared.t_s, &prepared.measured);
    if let Some(Some(at)) = measured {
        return (at, Evidence::Measured);
    }
    if prepared.scene.pusher.is_none() {
        return (begin, if begin < n { Evidence::Drive } else { Evidence::Never });
    }
    match simulated.normal_n.iter().position(|f| f[2] > 0.0) {
        // A force that never changes: already in contact when the recording began.
        Some(at) if measured.is_none() || at <= 1 => (at.max(begin), Evidence::Model),
        _ => (n, Evidence::Never),
    }
}

/// Onset and beginning of sliding.
fn find_motion(
    prepared: &Prepared,
    simulated: &Simulated,
    noise: &Signals,
    end: usize,
) -> (Option<(usize, usize)>, Evidence) {
    let t = &prepared.t_s;
    let measured = coverage(&prepared.measured, 0..6) > 0.5;
    let (signals, evidence) = if measured {
        (&prepared.measured, Evidence::Measured)
    } else {
        (&simulated.signals, Evidence::Model)
    };
    // 30 micrometres and 0.3 mrad are usual for motion capture, where nothing is stated.
    let or = |stated: f64, usual: f64| if stated > 0.0 { stated } else { usual };
    let white = |range| if measured { white_noise(signals, range) } else { 0.0 };
    let sigma = [or(noise[0], 3e-5).max(white(0..3)), or(noise[3], 3e-4).max(white(3..6))];
    let position = smooth(t, signals, 0..3, AVERAGE_S);
    let rotation = smooth(t, signals, 3..6, AVERAGE_S);
    let p = prepared.start.position_m;
    let start = [p.x, p.y, p.z];
    // `max` passes over a NaN: either of the two may be missing.
    let away: Vec<f64> = position
        .iter()
        .zip(&rotation)
        .map(|(p, r)| (distance(p, &start) / sigma[0]).max(distance(r, &[0.0; 3]) / sigma[1]))
        .collect();
    let further = |i: usize| {
        let later = &away[i..];
        later.len() < 3 || later.iter().filter(|m| **m > 6.0).count() * 2 > later.len()
    };
    let Some(at) = (0..away.len()).find(|&i| away[i] > 6.0 && further(i)) else {
        return (None, Evidence::Never);
    };
    let onset = (0..at).rev().find(|&i| away[i] < 2.0 || t[at] - t[i] > 0.25).map_or(0, |i| i + 1);
    let speed: Vec<f64> = (0..t.len())
        .map(|i| {
            let (a, b) = around(t, i, SPEED_S / 2.0);
            let path = (distance(&position[a], &position[b]) / sigma[0])
                .max(distance(&rotation[a], &rotation[b]) / sigma[1]);
            path / (t[b] - t[a])
        })
        .collect();
    let after = speed[at..end.max(at)].iter().copied().filter(|v| v.is_finite());
    let usual = median(after).unwrap_or(0.0);
    let sliding = (at..t.len())
        .find(|&i| {
            let since = t[i] - t[at];
            since > 0.3 || (since >= 0.02 && speed[i] >= 0.8 * usual)
        })
        .unwrap_or(t.len());
    (Some((onset, sliding)), evidence)
}

/// Share of samples in which all of `range` was measured.
fn coverage(signals: &[Signals], range: Range<usize>) -> f64 {
    let full = signals.iter().filter(|s| s[range.clone()].iter().all(|x| x.is_finite())).count();
    full as f64 / signals.len().max(1) as f64
}

/// Mean of three channels over `width_s` around each sample; NaN where none was measured.
fn smooth(t_s: &[f64], signals: &[Signals], range: Range<usize>, width_s: f64) -> Vec<[f64; 3]> {
    (0..t_s.len())
        .map(|i| {
            let (a, b) = around(t_s, i, width_s / 2.0);
            mean(&signals[a..=b], range.clone())
        })
        .collect()
}

fn mean(signals: &[Signals], range: Range<usize>) -> [f64; 3] {
    let mut out = [f64::NAN; 3];
    for (o, k) in out.iter_mut().zip(range) {
        let (mut sum, mut count) = (0.0, 0.0);
        for x in signals.iter().map(|s| s[k]).filter(|x| x.is_finite()) {
            sum += x;
            count += 1.0;
        }
        *o = sum / count;
    }
    out
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

/// The largest of the channels' noises.
fn white_noise(signals: &[Signals], range: Range<usize>) -> f64 {
    debug_assert!(range.end <= COUNT);
    let of = |k: usize| crate::evidence::noise::white_noise(signals.iter().map(|s| s[k])).unwrap_or(0.0);
    range.map(of).fold(0.0, f64::max)
}
