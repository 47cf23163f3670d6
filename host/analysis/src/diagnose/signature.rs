//! What an effect changes, and what the data show, side by side: the picture on an effect's card.
//!
//! The change is that of the fitted model with the effect against the fitted model without it; friction is
//! fitted in both. It is no test: the choice is made on held-out conditions.

use std::collections::BTreeMap;

use crate::diagnose::select::Held;
use crate::fit::features::{FEATURES, channel_name, quantity};
use crate::fit::phases::{BINS, Phase};
use crate::fit::problem::Problem;

/// One channel in one phase, root mean squares over conditions and bins.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Channel.
    pub channel: String,
    /// Phase.
    pub phase: &'static str,
    /// What the effect changes, in run spreads.
    pub change: f64,
    /// What the model without it leaves, in run spreads.
    pub left: f64,
    /// What the effect changes, SI.
    pub change_si: f64,
    /// Unit of that.
    pub unit: &'static str,
}

/// The marks of the model `with` an effect against `base`, largest change first.
#[must_use]
pub fn signature(problem: &Problem, base: &Held, with: &Held) -> Vec<Mark> {
    // Squares of change and rest in run spreads, of the change in SI, and how many.
    let mut sums: BTreeMap<(usize, Phase), ([f64; 3], f64)> = BTreeMap::new();
    let groups = problem.groups.iter().zip(&base.solution.predicted).zip(&with.solution.predicted);
    for (((g, without), with), left) in groups.zip(&base.residual) {
        let spread = &problem.single_run[*g];
        for f in (0..FEATURES).filter(|f| left[*f].is_finite()) {
            let change = with[f] - without[f];
            let squares = [change / spread[f], left[f] / spread[f], change].map(|x| x * x);
            if squares.iter().all(|x| x.is_finite()) {
                let sum = sums.entry((f / BINS, Phase::of(f % BINS))).or_default();
                (0..3).for_each(|k| sum.0[k] += squares[k]);
                sum.1 += 1.0;
            }
        }
    }
    let mut marks: Vec<Mark> = sums
        .into_iter()
        .map(|((channel, phase), (sum, n))| {
            let [change, left, change_si] = sum.map(|s| (s / n).sqrt());
            let unit = quantity(channel * BINS).unit();
            Mark { channel: channel_name(channel), phase: phase.name(), change, left, change_si, unit }
        })
        .collect();
    marks.sort_by(|a, b| b.change.total_cmp(&a.change));
    marks
}
