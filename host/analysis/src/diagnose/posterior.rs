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
//! The law of an effect may be wrong by [`FORM`] of what it explains. A wrong form is wrong in every condition
//! alike: in each place it is one unknown `e`, which adds `e f_c` to condition `c`, `f_c` being [`FORM`] of what
//! the set explains there. Its estimate is taken off at the price of its uncertainty. Places are not independent
//! either, as one law acts in all of them: the largest `e` has a standard normal density, the others are within
//! it. So an effect that only takes up what another's law leaves wins a few units by it, however many conditions
//! and places there are.
//!
//! Before the data each of `n` effects is as likely as any other: a set of `k` has `n^-k` of the empty one. What
//! is not listed is as likely as one that is, and may be missing
//!
//! - beside a set: it leaves no place with a systematic misfit beyond the form of laws that would be worth a name
//!   ([`RELEVANT`]), for `n^-(k+1)`;
//! - in place of it, and only look like it. The more a set explains, the less likely that is by chance: a
//!   direction at random in `2 m` dimensions beyond the set's own has all but `1 - rho` of its square in the set with
//!   probability `(1 - rho)^m`, and there are `n^k` sets. `m` follows from how often that happens (`ALIKE`).

use std::collections::BTreeMap;

use rand::{Rng, SeedableRng};
use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::effects::REGISTRY;

use crate::diagnose::select::{Held, explained};
use crate::diagnose::verdict::RELEVANT;
use crate::evidence::tolerance::FORM;
use crate::fit::Free;
use crate::fit::features::{FEATURES, Features};
use crate::fit::phases::{BINS, Phase};
use crate::fit::problem::Problem;

/// Degrees of freedom of a place's residual: with 4 a set that leaves one place hugely wrong wins over one that
/// leaves several a little wrong, with many a single place decides.
const FREEDOM: f64 = 10.0;
/// Draws of the weights of the conditions.
const DRAWS: usize = 400;
/// An effect that is not listed is explained to four fifths by a listed one in one case of ten (blind tests of the
/// first rig: 89 to 92 % get no name).
const ALIKE: [f64; 2] = [0.8, 0.1];
/// The sets that are listed have this probability together.
pub const CREDIBLE: f64 = 0.95;

/// A set with this share of the probability of what is named is about as probable, if it has this much itself.
const AS_PROBABLE: f64 = 0.5;
/// Less of a probability is none worth speaking of.
pub const LEAST: f64 = 0.05;

/// Whether two sets have the same effects, in whatever order.
#[must_use]
pub fn same(a: &[&'static str], b: &[&'static str]) -> bool {
    a.len() == b.len() && a.iter().all(|id| b.contains(id))
}

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
    /// That something which is not listed is missing beside one of them.
    pub beside: f64,
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

    /// Sets of effects that are about as probable as those `named`, or more, and no more of them: what the probabilities do not
    /// tell apart, the choice cannot. A set that holds all that are named is another matter: whether more is missing is
    /// decided by what more explains.
    #[must_use]
    pub fn as_probable(&self, named: &[&'static str]) -> Vec<Vec<&'static str>> {
        let with = |set: &Weighed| named.iter().all(|id| set.effects.contains(id));
        let of_named = self.sets.iter().find(|s| same(&s.effects, named)).map_or(0.0, |s| s.probability);
        let others = self.sets.iter().filter(|s| !s.effects.is_empty() && !with(s));
        let enough = f64::max(LEAST, AS_PROBABLE * of_named);
        others
            .filter(|s| s.effects.len() <= named.len() && s.probability >= enough)
            .map(|s| s.effects.clone())
            .collect()
    }

    /// That effect `id` is missing, alone or beside others.
    #[must_use]
    pub fn of(&self, id: &str) -> f64 {
        // `sum` of nothing is -0.
        0.0 + self.sets.iter().filter(|s| s.effects.contains(&id)).map(|s| s.probability).sum::<f64>()
    }
}

/// Square of the residual of each place of each condition, in run spreads.
type Places = Vec<BTreeMap<(usize, Phase), f64>>;

/// Weighs `fits`, each on held-out conditions, the first of them without any effect to name; `unnamed` effects of a
/// fit count as absent, and so do the first `given` of each model.
pub fn posterior(
    problem: &Problem,
    given: usize,
    fits: &[&Held],
    unnamed: impl Fn(&Held, &'static str) -> bool,
) -> Posterior {
    let Some(first) = fits.first() else { return Posterior::default() };
    let mut sets: BTreeMap<Vec<&'static str>, Fitted> = BTreeMap::new();
    let base = places(problem, &first.residual);
    let even = vec![1.0; problem.campaign.conditions];
    for held in fits {
        let ids = effects(held, given, &unnamed);
        let places = places(problem, &held.residual);
        let left = of_each_place(&places, &base);
        let total = log_density(&left, &even);
        if sets.get(&ids).is_none_or(|s| total > s.total) {
            sets.insert(ids, Fitted { held, places, left, total });
        }
    }
    let best = sets.values().max_by(|a, b| a.total.total_cmp(&b.total)).map_or(*first, |s| s.held);
    let conditions = problem.campaign.conditions as f64;
    let tempered = 1.0 / (1.0 + (conditions - 1.0) * between_conditions(problem, &best.residual));
    let ln_n = (REGISTRY.len() as f64).ln();
    let chance = (ln_n - ALIKE[1].ln()) / -(1.0 - ALIKE[0]).ln();
    // Logarithm of the probability that something unlisted looks so much like a set.
    let looks_like = |ids: &Vec<&str>, held: &Held| {
        let left = (1.0 - explained(&first.misfit, &held.misfit)).clamp(f64::MIN_POSITIVE, 1.0);
        (ids.len() as f64 * ln_n + chance * left.ln()).min(0.0)
    };
    let most_alike = sets.iter().map(|(ids, s)| looks_like(ids, s.held)).fold(0.0, f64::min);
    let (mut rows, mut named) = (Vec::new(), Vec::new());
    for (ids, s) in sets {
        let k = ids.len() as f64;
        let (beside, instead) = match ids.is_empty() {
            // Nothing that is listed: yet one of the sets explains what it does.
            true => (0.0, (most_alike - ln_n).exp()),
            false => ((-(k + 1.0) * ln_n).exp(), (looks_like(&ids, s.held) - ln_n).exp()),
        };
        rows.push((of_each_place(&completed(&s.places, s.held, first), &base), (beside + instead).ln()));
        rows.push((s.left, -k * ln_n));
        named.push((ids, if beside > 0.0 { beside / (beside + instead) } else { 0.0 }));
    }
    let mean = weights(&rows, problem.campaign.conditions, tempered);
    let mut out = Posterior { conditions: conditions * tempered, ..Posterior::default() };
    for ((effects, share), row) in named.into_iter().zip(mean.chunks(2)) {
        let [complete, alone] = *row else { break };
        let beside = complete * share;
        out.beside += beside;
        out.unlisted += complete - beside;
        out.sets.push(Weighed { effects, probability: alone + beside });
    }
    out.sets.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    out
}

/// A set of effects as it was fitted best.
struct Fitted<'a> {
    held: &'a Held,
    places: Places,
    left: Vec<LeftInPlace>,
    total: f64,
}

/// `places` of `held` as something beside its effects would leave them that takes up what is worth a name.
fn completed(places: &Places, held: &Held, first: &Held) -> Places {
    let mut out = places.clone();
    for p in held.beyond(first).places.iter().filter(|p| p.exceeds(RELEVANT)) {
        for x2 in out.iter_mut().filter_map(|m| m.get_mut(&(p.channel, p.phase))) {
            *x2 *= (RELEVANT / p.size).powi(2);
        }
    }
    out
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

/// What a set leaves in a channel of a phase, by condition.
#[derive(Clone, Debug, Default)]
pub struct LeftInPlace {
    /// Condition, residual in run spreads, and [`FORM`] of what is explained there.
    pub seen: Vec<(usize, f64, f64)>,
}

impl LeftInPlace {
    /// Logarithm of its density but for a constant, `weight` being how much each condition counts, and `e`.
    fn log_density(&self, weight: &[f64]) -> (f64, f64) {
        let of = |c: usize| weight.get(c).copied().unwrap_or(0.0);
        let sum = |f: &dyn Fn(f64, f64) -> f64| {
            self.seen.iter().map(|(c, x, form)| of(*c) * f(*x, *form)).sum::<f64>()
        };
        let precision = 1.0 + sum(&|_, form| form * form);
        let e = sum(&|x, form| x * form) / precision;
        let left = sum(&|x, form| ((x - e * form).powi(2) / FREEDOM).ln_1p());
        (-0.5 * ((FREEDOM + 1.0) * left + precision.ln()), e)
    }
}

/// The same of all places.
fn log_density(places: &[LeftInPlace], weight: &[f64]) -> f64 {
    let (sum, e) = places
        .iter()
        .map(|p| p.log_density(weight))
        .fold((0.0, 0.0_f64), |(sum, most), (one, e)| (sum + one, most.max(e)));
    sum - 0.5 * e * e
}

/// `left` by place; `base` is what the model misses without effects.
fn of_each_place(left: &Places, base: &Places) -> Vec<LeftInPlace> {
    let mut out: BTreeMap<(usize, Phase), LeftInPlace> = BTreeMap::new();
    for (c, m) in left.iter().enumerate() {
        for (at, x2) in m {
            let base2 = base.get(c).and_then(|m| m.get(at)).copied().unwrap_or(0.0);
            let form = FORM * (base2 - x2).max(0.0).sqrt();
            out.entry(*at).or_default().seen.push((c, x2.sqrt(), form));
        }
    }
    out.into_values().collect()
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

/// Probability of each of `rows` (what it leaves by place, logarithm of the prior), as the mean over weights of the
/// conditions; of these as many count as their number by `tempered` (0 to 1).
#[must_use]
pub fn weights(rows: &[(Vec<LeftInPlace>, f64)], conditions: usize, tempered: f64) -> Vec<f64> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let mut out = vec![0.0; rows.len()];
    for _ in 0..DRAWS {
        let mut weight: Vec<f64> =
            (0..conditions).map(|_| -f64::ln(rng.random_range(f64::MIN_POSITIVE..1.0))).collect();
        let sum: f64 = weight.iter().sum();
        weight.iter_mut().for_each(|w| *w *= tempered * conditions as f64 / sum);
        let logs: Vec<f64> =
            rows.iter().map(|(places, prior)| log_density(places, &weight) + prior).collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let all: f64 = logs.iter().map(|l| (l - most).exp()).sum();
        for (o, l) in out.iter_mut().zip(&logs) {
            *o += (l - most).exp() / all / DRAWS as f64;
        }
    }
    out
}
