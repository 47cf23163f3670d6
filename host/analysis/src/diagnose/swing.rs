//! Forces that swing while the object slides, which means over bins do not show.
//!
//! Stick-slip needs friction that falls with speed or grows at rest, and pads that give way; a
//! texture of the face that is shorter than a bin looks alike. In each part of the sliding path a
//! straight line is taken out of the force; what is left beyond the sensor's noise (as it is at
//! rest before the motion), and beyond what the model shows, is the swing.

use rayon::prelude::*;
use stickslip_shared::model::Model;

use crate::channels::{Signals, channel_words};
use crate::diagnose::structure::{self, Structure};
use crate::diagnose::verdict::RELEVANT;
use crate::fit::campaign::{Campaign, Run};
use crate::fit::features::{Bins, channel_name};
use crate::fit::phases::{BINS, Phase};

/// Share of the force above which a run swings. Friction of real surfaces varies by some per cent on its way.
const SWINGS: f64 = 0.05;
/// ... and standard deviations of the noise at rest: in motion a bench is seldom as quiet as at rest.
const STANDS_OUT: f64 = RELEVANT;
/// Fewest conditions that swing.
const FEWEST: usize = 2;
/// Samples of a part from which a line can be told.
const SHORTEST: usize = 8;
/// First channels of the forces: sum of the fingers, pusher.
const FORCES: [usize; 2] = [6, 18];

/// What swings most.
#[derive(Clone, Debug, PartialEq)]
pub struct Swing {
    /// Channel.
    pub channel: String,
    /// Root mean square over the runs that swing, N.
    pub rms_n: f64,
    /// The same as a share of the force.
    pub share: f64,
    /// Runs that swing, of how many.
    pub runs: (usize, usize),
    /// In standard deviations of the noise at rest.
    pub size: f64,
    /// On which quantities the share depends.
    pub depends_on: Vec<(&'static str, f64)>,
}

impl Swing {
    /// What it looks like, and what it may be.
    pub fn text(&self) -> String {
        format!(
            "{} oscillates by {:.2} N rms ({:.0} % of the force) while the object slides, in {} of {} runs: stick-slip (friction that falls with speed or grows at rest, between compliant pads) or a texture of the faces",
            channel_words(&self.channel),
            self.rms_n,
            100.0 * self.share,
            self.runs.0,
            self.runs.1
        )
    }

    /// As structure that a model leaves.
    pub fn structure(&self) -> Structure {
        Structure {
            channel: self.channel.clone(),
            phase: "swing in sliding",
            size: self.size,
            depends_on: self.depends_on.clone(),
        }
    }
}

/// The swing that `model` misses; `None` where fewer than two conditions swing.
pub fn missed(campaign: &Campaign, model: &Model<f64>) -> Option<Swing> {
    let swings = |run: &Run| {
        let measured = Swings::of(&run.bins, &run.prepared.measured);
        // The model is asked only where there is something to explain.
        let most = (0..FORCES.len() * 3).map(|k| measured.share(k, 0.0)).fold(0.0, f64::max);
        let modelled = (most > SWINGS)
            .then(|| Swings::of(&run.bins, &run.prepared.simulate_every(model, run.stride.min(2)).signals));
        std::array::from_fn::<(f64, f64, f64), 6, _>(|k| {
            let shown = modelled.as_ref().map_or(0.0, |m| m.sliding[k]);
            let beyond_n = measured.beyond(k, shown).sqrt();
            (beyond_n, measured.share(k, shown), beyond_n / measured.rest[k].sqrt().max(1e-4))
        })
    };
    let found: Vec<[(f64, f64, f64); 6]> = campaign.runs.par_iter().map(swings).collect();
    let of_channel = |k: usize| {
        let swinging: Vec<usize> =
            (0..found.len()).filter(|r| found[*r][k].1 > SWINGS && found[*r][k].2 > STANDS_OUT).collect();
        let mut conditions: Vec<usize> = swinging.iter().map(|r| campaign.runs[*r].condition).collect();
        conditions.sort_unstable();
        conditions.dedup();
        let rms = |of: fn(&(f64, f64, f64)) -> f64| {
            let squares: f64 = swinging.iter().map(|r| of(&found[*r][k]).powi(2)).sum();
            (squares / swinging.len().max(1) as f64).sqrt()
        };
        (conditions.len() >= FEWEST).then(|| Swing {
            channel: channel_name(FORCES[k / 3] + k % 3),
            rms_n: rms(|x| x.0),
            share: rms(|x| x.1),
            runs: (swinging.len(), found.len()),
            size: rms(|x| x.2),
            depends_on: structure::of_runs(campaign, &found.iter().map(|f| f[k].1).collect::<Vec<f64>>()),
        })
    };
    (0..FORCES.len() * 3).filter_map(of_channel).max_by(|a, b| a.rms_n.total_cmp(&b.rms_n))
}

/// Mean squares of the forces of one run about straight lines, N^2.
struct Swings {
    rest: [f64; 6],
    sliding: [f64; 6],
    /// Mean force of fingers and pusher in sliding, N.
    level_n: [f64; 2],
}

impl Swings {
    fn of(bins: &Bins, signals: &[Signals]) -> Self {
        let mut parts: Vec<Vec<Signals>> = vec![Vec::new(); BINS];
        bins.each(signals, |bin, x| parts[bin].push(*x));
        let about = |phase: Phase, channel: usize| {
            let (mut sum, mut n) = (0.0, 0.0);
            for (_, part) in parts.iter().enumerate().filter(|(b, _)| Phase::of(*b) == phase) {
                let y: Vec<f64> = part.iter().map(|s| s[channel]).filter(|x| x.is_finite()).collect();
                if y.len() >= SHORTEST {
                    sum += about_line(&y);
                    n += y.len() as f64 - 2.0;
                }
            }
            if n > 0.0 { sum / n } else { 0.0 }
        };
        let level = |first: usize| {
            let sliding = parts.iter().enumerate().filter(|(b, _)| Phase::of(*b) == Phase::Sliding);
            let forces: Vec<f64> = sliding
                .flat_map(|(_, p)| p)
                .map(|s| s[first..first + 3].iter().map(|x| x * x).sum::<f64>().sqrt())
                .filter(|x| x.is_finite())
                .collect();
            forces.iter().sum::<f64>() / forces.len().max(1) as f64
        };
        let channel = |k: usize| FORCES[k / 3] + k % 3;
        Self {
            rest: std::array::from_fn(|k| about(Phase::Before, channel(k))),
            sliding: std::array::from_fn(|k| about(Phase::Sliding, channel(k))),
            level_n: FORCES.map(level),
        }
    }

    /// Mean square beyond noise and what the model shows, N^2.
    fn beyond(&self, k: usize, shown: f64) -> f64 {
        (self.sliding[k] - self.rest[k] - shown).max(0.0)
    }

    fn share(&self, k: usize, shown: f64) -> f64 {
        let level_n = self.level_n[k / 3];
        if level_n > 0.0 { self.beyond(k, shown).sqrt() / level_n } else { 0.0 }
    }
}

/// Sum of squares of `y` about its straight line.
pub fn about_line(y: &[f64]) -> f64 {
    let n = y.len() as f64;
    let middle = (n - 1.0) / 2.0;
    let mean = y.iter().sum::<f64>() / n;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (i, y) in y.iter().enumerate() {
        let (x, y) = (i as f64 - middle, y - mean);
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    (yy - xy * xy / xx).max(0.0)
}
