//! The experiments that would tell sets of effects apart, and a plan of several.
//!
//! Each condition of the data is played once more with one of its recorded trials, at other grips, by the fit of
//! every set. How much a plan of trials is expected to tell about which set is true is the information between the
//! two (Lindley 1956), here its lower bound for Gaussians of equal covariance (Kolchinsky and Tracey 2017, with
//! Chernoff's distance):
//!
//! ```text
//! I >= -sum_i p_i ln sum_j p_j exp(-D_ij^2 / 8)
//! ```
//!
//! `p` are the probabilities of the sets, `D^2` sums over the trials the squared difference of two predictions. As
//! in `posterior`, a channel in a phase is one observation. Its variance is that of the mean of the trial's
//! repetitions: what differs from run to run averages out, the tolerance of a rigid model does not, nor does that the
//! law of an effect may be wrong by [`FORM`] of what it changes. So a plan does not repeat one trial for ever. It is
//! built greedily: the trial that adds most comes next (the information of a set of trials has diminishing returns).

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::model::Model;

use crate::channels::channel_words;
use crate::compare::verdict::readable;
use crate::evidence::tolerance::FORM;
use crate::fit::features::{FEATURES, Features, channel_name, quantity};
use crate::fit::phases::{BINS, Phase};
use crate::fit::problem::Problem;

/// Quantiles for 1 % false and 95 % right decisions.
const QUANTILES: f64 = 2.326 + 1.645;
/// Grips tried, as multiples of the recorded one.
const GRIPS: [f64; 3] = [0.6, 1.0, 1.5];
/// Information that differs by less is the same, bits: the larger difference comes first then.
const SAME_BITS: f64 = 1e-3;

/// A set of effects as it was fitted, and how probable it is.
pub struct Hypothesis<'a> {
    /// The model with it.
    pub model: &'a Model<f64>,
    /// Between 0 and 1; all together 1.
    pub probability: f64,
}

/// A condition and what the candidates predict there.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Experiment {
    /// In words.
    pub summary: String,
    /// Recorded trial whose motion is to be repeated.
    pub like_trial: String,
    /// Grip force, N.
    pub grip_n: Option<f64>,
    /// Speed, m/s or rad/s.
    pub speed: Option<f64>,
    /// Slope, rad.
    pub slope_rad: Option<f64>,
    /// Offset of the pusher, m.
    pub pusher_offset_m: Option<f64>,
    /// Channel in which the two likeliest differ most.
    pub channel: String,
    /// Phase in which they do.
    pub phase: &'static str,
    /// Difference of the predictions, in the channel's unit.
    pub difference: f64,
    /// Unit of the difference.
    pub unit: &'static str,
    /// Difference in standard deviations of one run.
    pub standard_deviations: f64,
    /// Runs that settle it with 1 % false and 95 % right decisions.
    pub runs: u64,
    /// Information that one run is expected to give about which set is true, a lower bound, bits.
    pub information_bits: f64,
}

/// One trial of a plan.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Planned {
    /// Recorded trial whose motion is to be repeated.
    pub like_trial: String,
    /// Grip force, N.
    pub grip_n: Option<f64>,
    /// Information that the plan is expected to give up to this trial, a lower bound, bits.
    pub information_bits: f64,
}

/// Trials that together give most information about which set of effects is true.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Plan {
    /// What is open before: the entropy of the sets' probabilities, bits.
    pub open_bits: f64,
    /// Information that all of it is expected to give, a lower bound, bits.
    pub information_bits: f64,
    /// In the order in which they add most: the first ones alone are the best shorter plan.
    pub trials: Vec<Planned>,
}

/// A condition, at one grip, and what every set predicts there.
struct Choice {
    group: usize,
    factor: f64,
    predicted: Vec<Features>,
}

/// All that could be measured, with what each of several sets predicts there.
pub struct Grid<'a> {
    problem: &'a Problem<'a>,
    probabilities: Vec<f64>,
    /// Each with what the model without effects predicts there: what an effect changes is the difference.
    choices: Vec<(Choice, Features)>,
}

impl<'a> Grid<'a> {
    /// Of the sets `of` beside the model `without` them.
    pub fn new(problem: &'a Problem<'a>, without: &Model<f64>, of: &[Hypothesis]) -> Self {
        use rayon::prelude::*;
        let campaign = problem.campaign;
        let mut seen = std::collections::BTreeSet::new();
        let groups = problem.groups.iter().copied();
        let groups: Vec<usize> = groups.filter(|g| seen.insert(campaign.groups[*g].condition)).collect();
        let choices = groups.par_iter().flat_map_iter(|group| {
            let run = problem.run_of(*group);
            let grips = GRIPS.iter().filter(|factor| run.info.grip_n.is_some() || **factor == 1.0);
            grips.map(move |factor| {
                let prepared = run.prepared.with_grip(*factor);
                let played =
                    |model: &Model<f64>| run.bins.modelled(&prepared.simulate_every(model, run.stride));
                let predicted = of.iter().map(|h| played(h.model)).collect();
                (Choice { group: *group, factor: *factor, predicted }, played(without))
            })
        });
        let probabilities = of.iter().map(|h| h.probability).collect();
        Self { problem, probabilities, choices: choices.collect() }
    }

    /// Squared difference between each two sets in `runs` repetitions of a choice.
    fn distances(&self, (choice, without): &(Choice, Features), runs: usize) -> Vec<f64> {
        let of = &choice.predicted;
        let (single, floors) = (&self.problem.single_run[choice.group], &self.problem.floors[choice.group]);
        let mut out = Vec::with_capacity(of.len() * of.len());
        for x in of {
            for y in of {
                let mut places: BTreeMap<(usize, Phase), (f64, f64)> = BTreeMap::new();
                for f in 0..FEATURES {
                    let floor2 = floors[f] * floors[f];
                    let of_run = (single[f] * single[f] - floor2).max(0.0) / runs as f64;
                    let changed = f64::max((x[f] - without[f]).abs(), (y[f] - without[f]).abs());
                    let d2 = (x[f] - y[f]).powi(2) / (floor2 + of_run + (FORM * changed).powi(2));
                    if d2.is_finite() {
                        let place = places.entry((f / BINS, Phase::of(f % BINS))).or_default();
                        *place = (place.0 + d2, place.1 + 1.0);
                    }
                }
                out.push(places.values().map(|(sum, n)| sum / n).sum());
            }
        }
        out
    }

    /// The conditions at which one run tells most, best first; described by how the two likeliest sets differ.
    pub fn experiments(&self, most: usize) -> Vec<Experiment> {
        let mut order: Vec<usize> = (0..self.probabilities.len()).collect();
        order.sort_by(|a, b| self.probabilities[*b].total_cmp(&self.probabilities[*a]));
        let [a, b, ..] = order[..] else { return Vec::new() };
        let mut out: Vec<Experiment> =
            self.choices.iter().filter_map(|choice| self.experiment(choice, [a, b])).collect();
        let rank = |e: &Experiment| ((e.information_bits / SAME_BITS).round(), e.standard_deviations);
        out.sort_by(|p, q| {
            let (p, q) = (rank(p), rank(q));
            q.0.total_cmp(&p.0).then(q.1.total_cmp(&p.1))
        });
        out.truncate(most);
        out
    }

    fn experiment(&self, choice: &(Choice, Features), [a, b]: [usize; 2]) -> Option<Experiment> {
        let Choice { group, factor, predicted } = &choice.0;
        let (run, x, y) = (self.problem.run_of(*group), &predicted[a], &predicted[b]);
        let (f, d) = (0..FEATURES)
            .map(|f| (f, (x[f] - y[f]) / self.problem.single_run[*group][f]))
            .filter(|d| d.1.is_finite())
            .max_by(|p, q| p.1.abs().total_cmp(&q.1.abs()))?;
        let (channel, phase) = (channel_name(f / BINS), Phase::of(f % BINS).name());
        let grip_n = run.info.grip_n.map(|n| n * factor);
        let unit = quantity(f).unit();
        let runs = ((QUANTILES / d).powi(2).ceil() as u64).max(1);
        let difference = (x[f] - y[f]).abs();
        let at = grip_n.map_or(String::new(), |n| format!(" with a grip of {n:.1} N"));
        let summary = format!(
            "repeat trial {}{at}: {} ({phase}) differs by {}, {:.1} standard deviations; {runs} run(s) of it decide",
            run.info.trial,
            channel_words(&channel),
            readable(difference, unit),
            d.abs()
        );
        Some(Experiment {
            summary,
            like_trial: run.info.trial.clone(),
            grip_n,
            speed: run.info.speed_m_s.or(run.info.speed_rad_s),
            slope_rad: run.info.slope_rad,
            pusher_offset_m: run.info.pusher_offset_m,
            channel,
            phase,
            difference,
            unit,
            standard_deviations: d.abs(),
            runs,
            information_bits: information_bits(&self.probabilities, &self.distances(choice, 1)),
        })
    }

    /// The `trials` that together tell most.
    #[must_use]
    pub fn plan(&self, trials: usize) -> Plan {
        let of = |k: usize, runs: usize| self.distances(&self.choices[k], runs);
        let planned = |(k, bits): &(usize, f64)| {
            let Choice { group, factor, .. } = &self.choices[*k].0;
            let info = &self.problem.run_of(*group).info;
            let (like_trial, grip_n) = (info.trial.clone(), info.grip_n.map(|n| n * factor));
            Planned { like_trial, grip_n, information_bits: *bits }
        };
        let order = greedy(&self.probabilities, self.choices.len(), trials, of);
        Plan {
            open_bits: entropy_bits(&self.probabilities),
            information_bits: order.last().map_or(0.0, |(_, bits)| *bits),
            trials: order.iter().map(planned).collect(),
        }
    }
}

/// Which of `choices` kinds of trials to make one after the other, and what all up to each tell together, bits.
/// `distances(k, runs)` are the squared differences of each two sets in so many repetitions of kind `k`.
#[must_use]
pub fn greedy(
    probabilities: &[f64],
    choices: usize,
    trials: usize,
    distances: impl Fn(usize, usize) -> Vec<f64>,
) -> Vec<(usize, f64)> {
    // Of each kind: in the repetitions that are planned, and in one more.
    let mut planned = vec![(0, vec![0.0; probabilities.len() * probabilities.len()]); choices];
    let mut further: Vec<Vec<f64>> = (0..choices).map(|k| distances(k, 1)).collect();
    let mut total = vec![0.0; probabilities.len() * probabilities.len()];
    let mut out = Vec::new();
    for _ in 0..trials {
        let next = |k: usize| {
            let change = planned[k].1.iter().zip(&further[k]).map(|(now, then)| then - now);
            let sum: Vec<f64> = total.iter().zip(change).map(|(t, c)| t + c).collect();
            (k, information_bits(probabilities, &sum), sum)
        };
        let bits = |b: f64| (b / SAME_BITS).round();
        // Where nothing is open any more, what parts the two that are hardest to part.
        let hardest = |sum: &[f64]| apart(sum, probabilities.len());
        let best = (0..choices)
            .map(next)
            .max_by(|p, q| bits(p.1).total_cmp(&bits(q.1)).then(hardest(&p.2).total_cmp(&hardest(&q.2))));
        let Some((k, told, sum)) = best else { break };
        total = sum;
        let (runs, now) = &mut planned[k];
        *runs += 1;
        *now = std::mem::replace(&mut further[k], distances(k, *runs + 1));
        out.push((k, told));
    }
    out
}

/// The least of the squared differences between two of `n` sets.
fn apart(distances: &[f64], n: usize) -> f64 {
    let pairs = (0..n).flat_map(|i| (0..i).map(move |j| i * n + j));
    pairs.filter_map(|at| distances.get(at).copied()).fold(f64::INFINITY, f64::min)
}

/// Entropy of `probabilities`, bits.
#[must_use]
pub fn entropy_bits(probabilities: &[f64]) -> f64 {
    let term = |p: &f64| if *p > 0.0 { -p * p.log2() } else { 0.0 };
    probabilities.iter().map(term).sum::<f64>().max(0.0)
}

/// What observations are expected to tell, at least, about which of several Gaussians of equal covariance they come
/// from, bits: `distances` has the squared difference in standard deviations of each two, row by row. Between
/// zero and the entropy of `probabilities`.
#[must_use]
pub fn information_bits(probabilities: &[f64], distances: &[f64]) -> f64 {
    let n = probabilities.len();
    let of = |(i, p): (usize, &f64)| {
        let row = distances.iter().skip(i * n).zip(probabilities);
        let alike: f64 = row.map(|(d2, q)| q * (-d2 / 8.0).exp()).sum();
        if *p > 0.0 { -p * alike.log2() } else { 0.0 }
    };
    probabilities.iter().enumerate().map(of).sum::<f64>().max(0.0)
}
