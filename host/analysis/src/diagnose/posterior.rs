//! How probable each set of effects is, among those that were fitted, and that it is none of them.
//!
//! A channel in a phase of a held-out condition is one observation, however many bins it has: `x`, the root
//! mean square of its residual in run spreads, with the density of Student's t. Features of one phase are
//! wrong together, and tolerances are part of the run spread; a loss summed over all of them as if they were
//! independent would make a tenth of a run spread overwhelming.
//!
//! Conditions are not independent either: what a model lacks, it lacks in many of them alike. With
//! `r` the mean correlation of residuals between conditions, `C` conditions count as
//! `C / (1 + (C - 1) r)` (design effect, Kish 1965). Which conditions were measured is chance:
//! probabilities are means over Dirichlet weights of the conditions (Bayesian bootstrap of held-out scores,
//! pseudo-BMA+, Yao et al. 2018).
//!
//! The law of an effect may be wrong by [`FORM`] of what it explains: that much is noise of each set's own,
//! in each place that it explains. An effect that only takes up what another's law leaves wins nothing by it.
//!
//! Before the data each of `n` effects is as likely as any other: a set of `k` has `n^-k` of the
//! empty one. What is not listed is a set of the largest size that does as the best of the fitted sets, and leaves
//! no place with a systematic misfit that would be worth a name ([`RELEVANT`]).

use std::collections::BTreeMap;

use rand::{Rng, SeedableRng};
use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::effects::REGISTRY;

use crate::diagnose::misfit::FORM;
use crate::diagnose::select::Held;
use crate::diagnose::verdict::RELEVANT;
use crate::fit::Free;
use crate::fit::features::{FEATURES, Features};
use crate::fit::phases::{BINS, Phase};
use crate::fit::problem::Problem;

/// Degrees of freedom of a place's residual: with 4 a set that leaves one place hugely wrong wins over one that
/// leaves several a little wrong, with many a single place decides.
const FREEDOM: f64 = 10.0;
/// Draws of the weights of the conditions.
const DRAWS: usize = 400;
/// Effects of the set that stands for what is not listed.
const UNLISTED: f64 = 3.0;
/// The sets that are listed have this probability together.
const CREDIBLE: f64 = 0.95;

/// A set of effects and its probability.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Weighed {
    /// Their identifiers, in alphabetical order; empty: nothing is missing.
    pub effects: Vec<&'static str>,
    /// Between 0 and 1.
    pub probability: f64,
}

/// Probabilities of all sets that were fitted, most probable first.
#[derive(Clone, Debug, Default)]
pub struct Posterior {
    /// The sets.
    pub sets: Vec<Weighed>,
    /// That none of them is what is missing.
    pub unlisted: f64,
    /// As many conditions as count.
    pub conditions: f64,
}

impl Posterior {
    /// The most probable sets that together have 95 % of what the sets have.
    #[must_use]
    pub fn credible(&self) -> Vec<Weighed> {
        let all: f64 = self.sets.iter().map(|s| s.probability).sum();
        let mut sum = 0.0;
        let mut out = Vec::new();
        for s in &self.sets {
            if sum >= CREDIBLE * all {
                break;
            }
            sum += s.probability;
            out.push(s.clone());
        }
        out
    }

    /// That effect `id` is missing, alone or beside others.
    #[must_use]
    pub fn of(&self, id: &str) -> f64 {
        self.sets.iter().filter(|s| s.effects.contains(&id)).map(|s| s.probability).sum()
    }
}

/// Square of the residual of each place of each condition, in run spreads.
type Places = Vec<BTreeMap<(usize, Phase), f64>>;

/// Weighs `fits`, each on held-out conditions, the first of them without any effect to name; `unnamed` effects of a fit count as absent, and so do the
/// first `given` of each model.
pub fn posterior(
    problem: &Problem,
    given: usize,
    fits: &[&Held],
    unnamed: impl Fn(&Held, &'static str) -> bool,
) -> Posterior {
    let mut sets: BTreeMap<Vec<&'static str>, (f64, Places)> = BTreeMap::new();
    let mut best: Option<(f64, &Held, Places)> = None;
    let base = fits.first().map_or_else(Places::new, |held| places(problem, &held.residual));
    for held in fits {
        let ids = effects(held, given, &unnamed);
        let places = places(problem, &held.residual);
        let total = scores(&places, &base).iter().sum::<f64>();
        if best.as_ref().is_none_or(|b| total > b.0) {
            best = Some((total, held, places.clone()));
        }
        if sets.get(&ids).is_none_or(|s| total > s.0) {
            sets.insert(ids, (total, places));
        }
    }
    let Some((_, held, mut within)) = best else { return Posterior::default() };
    let conditions = problem.campaign.conditions as f64;
    let tempered = 1.0 / (1.0 + (conditions - 1.0) * between_conditions(problem, &held.residual));
    let prior = -(REGISTRY.len() as f64).ln();
    let mut rows: Vec<(Vec<f64>, f64)> =
        sets.iter().map(|(ids, (_, p))| (scores(p, &base), prior * ids.len() as f64)).collect();
    for p in held.misfit.places.iter().filter(|p| p.size > RELEVANT && p.at_least > 1.0) {
        for x2 in within.iter_mut().filter_map(|m| m.get_mut(&(p.channel, p.phase))) {
            *x2 *= (RELEVANT / p.size).powi(2);
        }
    }
    rows.push((scores(&within, &base), prior * UNLISTED));
    let mean = weights(&rows, tempered);
    let unlisted = mean.last().copied().unwrap_or(0.0);
    let mut out: Vec<Weighed> =
        sets.into_keys().zip(mean).map(|(effects, probability)| Weighed { effects, probability }).collect();
    out.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    Posterior { sets: out, unlisted, conditions: conditions * tempered }
}

/// Identifiers of the effects of a fit but for the first `given`, in alphabetical order.
pub fn effects(
    held: &Held,
    given: usize,
    unnamed: impl Fn(&Held, &'static str) -> bool,
) -> Vec<&'static str> {
    let mut out: Vec<&'static str> = held
        .free
        .iter()
        .filter_map(|f| match f {
            Free::Effect { slot, effect, .. } if *slot >= given => Some(*effect),
            _ => None,
        })
        .collect();
    out.sort_unstable();
    out.dedup();
    out.retain(|id| !unnamed(held, id));
    out
}

/// Group, feature and residual in run spreads, wherever it is measured.
fn in_spreads<'a>(
    problem: &'a Problem,
    residual: &'a [Features],
) -> impl Iterator<Item = (usize, usize, f64)> + 'a {
    let of = problem.groups.iter().zip(residual).flat_map(move |(g, r)| {
        problem.whiteners[*g].active.iter().map(move |f| (*g, *f, r[*f] / problem.single_run[*g][*f]))
    });
    of.filter(|(_, _, x)| x.is_finite())
}

fn places(problem: &Problem, residual: &[Features]) -> Places {
    let mut sums: Vec<BTreeMap<(usize, Phase), (f64, f64)>> =
        vec![BTreeMap::new(); problem.campaign.conditions];
    for (g, f, x) in in_spreads(problem, residual) {
        let here = &mut sums[problem.campaign.groups[g].condition];
        let place = here.entry((f / BINS, Phase::of(f % BINS))).or_default();
        place.0 += x * x;
        place.1 += 1.0;
    }
    sums.into_iter().map(|m| m.into_iter().map(|(k, (sum, n))| (k, sum / n)).collect()).collect()
}

/// Logarithm of the density of each condition, but for a constant; `base` is what the model misses without
/// effects.
fn scores(places: &Places, base: &Places) -> Vec<f64> {
    let one = |x2: f64, base2: f64| {
        let variance = 1.0 + FORM * FORM * (base2 - x2).max(0.0);
        -0.5 * (FREEDOM + 1.0) * (x2 / variance / FREEDOM).ln_1p() - 0.5 * variance.ln()
    };
    let of_base = |c: usize, at: &(usize, Phase)| base.get(c).and_then(|m| m.get(at)).copied().unwrap_or(0.0);
    places.iter().enumerate().map(|(c, m)| m.iter().map(|(at, x2)| one(*x2, of_base(c, at))).sum()).collect()
}

/// Mean correlation of the residuals between conditions, over features; at least zero.
fn between_conditions(problem: &Problem, residual: &[Features]) -> f64 {
    let mut sums = vec![(0.0, 0.0, 0.0); FEATURES];
    for (_, f, x) in in_spreads(problem, residual) {
        let (sum, squares, n) = &mut sums[f];
        *sum += x;
        *squares += x * x;
        *n += 1.0;
    }
    let (mut products, mut squares) = (0.0, 0.0);
    for (sum, square, n) in sums.into_iter().filter(|s| s.2 > 1.0) {
        products += (sum * sum - square) / (n - 1.0);
        squares += square;
    }
    if squares > 0.0 { (products / squares).clamp(0.0, 1.0) } else { 0.0 }
}

/// Probability of each of `rows` (held-out scores of the conditions, logarithm of the prior), as the mean over weights
/// of the conditions; of these as many count as their number by `tempered` (0 to 1).
#[must_use]
pub fn weights(rows: &[(Vec<f64>, f64)], tempered: f64) -> Vec<f64> {
    let conditions = rows.iter().map(|r| r.0.len()).max().unwrap_or(0);
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let mut out = vec![0.0; rows.len()];
    for _ in 0..DRAWS {
        let mut weight: Vec<f64> =
            (0..conditions).map(|_| -f64::ln(rng.random_range(f64::MIN_POSITIVE..1.0))).collect();
        let sum: f64 = weight.iter().sum();
        weight.iter_mut().for_each(|w| *w *= conditions as f64 / sum);
        let logs: Vec<f64> = rows
            .iter()
            .map(|(s, prior)| tempered * s.iter().zip(&weight).map(|(s, w)| s * w).sum::<f64>() + prior)
            .collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let all: f64 = logs.iter().map(|l| (l - most).exp()).sum();
        for (o, l) in out.iter_mut().zip(&logs) {
            *o += (l - most).exp() / all / DRAWS as f64;
        }
    }
    out
}
