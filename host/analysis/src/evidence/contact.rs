//! When something first pushes the object, from the measured forces: one rule for every command.
//!
//! Contact is the first sample at which the pusher's force, averaged over 20 ms, has left its mean of
//! the first 50 ms by more than five standard deviations of that average and by more than 2 % of its
//! largest change. The window looks ahead, and the touch is at its far end when the change first
//! shows: a step is dated to its own sample, and nothing before it happens. Where the pusher's force
//! is not measured, or nothing pushes (a lift), the fingers' forces tell: what both exert together,
//! in which the grip cancels, is the weight until then.
//!
//! On trials of the rig it is found at the true sample or the next one; an average about the sample
//! itself finds it two samples early, and the gripper's motion a lift up to five samples early.

use std::ops::Range;

use schemars::JsonSchema;
use serde::Serialize;

use crate::channels::Signals;
use crate::evidence::noise::white_noise;

/// What a boundary was found from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Evidence {
    /// Measured force, or measured motion of the object.
    Measured,
    /// The model's.
    Model,
    /// Motion of the gripper.
    Drive,
    /// It did not happen.
    Never,
}

/// The force at rest is its mean over this time.
const BASELINE_S: f64 = 0.05;
/// The force is averaged over this time.
const AVERAGE_S: f64 = 0.02;
/// A change counts beyond this many standard deviations of the average ...
const SIGMAS: f64 = 5.0;
/// ... and beyond this share of the largest change.
const SHARE: f64 = 0.02;
/// The last samples before contact count for no phase, s: in a model the touch comes earlier or
/// later by the time in which the drive crosses the noise of the poses (0.03 mm at some mm/s), and
/// one sample of it is newtons.
const SEAM_S: f64 = 0.04;

/// First sample in contact. `Some(None)`: the force changes nowhere; `None`: neither the pusher's
/// nor both fingers' forces are measured in more than half of the samples. `signals` are rows of
/// [`crate::channels`], `t_s` their times.
#[must_use]
pub fn measured(t_s: &[f64], signals: &[Signals]) -> Option<Option<usize>> {
    let pusher = signals.iter().map(|s| [s[18], s[19], s[20]]).collect();
    let fingers = || signals.iter().map(|s| [s[6] + s[12], s[7] + s[13], s[8] + s[14]]).collect();
    let known = |forces: &Vec<[f64; 3]>| {
        2 * forces.iter().filter(|f| f.iter().all(|x| x.is_finite())).count() > forces.len()
    };
    let forces = Some(pusher).filter(known).or_else(|| Some(fingers()).filter(known))?;
    Some(leaves_rest(t_s, &forces))
}

/// Samples before `contact` that are clear of it; at least half of them stay.
#[must_use]
pub fn clear_of(t_s: &[f64], contact: usize) -> Range<usize> {
    let Some(at) = t_s.get(contact) else { return 0..t_s.len() };
    0..t_s[..contact].partition_point(|t| *t < at - SEAM_S).max(contact.div_ceil(2))
}

/// First sample at which a force has left its value at rest.
fn leaves_rest(t_s: &[f64], forces: &[[f64; 3]]) -> Option<usize> {
    let start_s = t_s.first()?;
    let early = t_s.partition_point(|t| *t <= start_s + BASELINE_S);
    let ends: Vec<usize> = (0..t_s.len()).map(|at| window_end(t_s, at)).collect();
    let averaged = ends.iter().enumerate().map(|(at, end)| end - at).max()?;
    let mut change_sq = vec![0.0; forces.len()];
    let mut variance = 0.0;
    for axis in 0..3 {
        let values = || forces.iter().map(|force| force[axis]);
        variance += white_noise(values()).unwrap_or(0.0).powi(2);
        // Sums up to each sample: means over windows cost nothing.
        let (mut sums, mut sum) = (vec![(0.0, 0.0)], (0.0, 0.0));
        for x in values() {
            if x.is_finite() {
                sum = (sum.0 + x, sum.1 + 1.0);
            }
            sums.push(sum);
        }
        let mean = |from: usize, to: usize| (sums[to].0 - sums[from].0) / (sums[to].1 - sums[from].1);
        let rest = mean(0, early);
        for (at, change) in change_sq.iter_mut().enumerate() {
            let away = mean(at, ends[at]) - rest;
            if away.is_finite() {
                *change += away * away;
            }
        }
    }
    let largest = change_sq.iter().copied().fold(0.0, f64::max).sqrt();
    let limit = (SIGMAS * (variance / averaged as f64).sqrt()).max(SHARE * largest);
    let at = change_sq.iter().position(|change| change.sqrt() > limit)?;
    Some(ends[at] - 1)
}

/// End of the window of [`AVERAGE_S`] that begins at sample `at`; it holds that sample at least.
fn window_end(t_s: &[f64], at: usize) -> usize {
    // Half a microsecond: time stamps are decimal.
    let until_s = t_s[at] + AVERAGE_S - 5e-7;
    at + t_s[at..].partition_point(|t| *t < until_s).max(1)
}
