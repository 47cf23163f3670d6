//! How wrong a model is, beside chance: error, what a perfect model would show, and the systematic
//! part.
//!
//! Everything is in units of the *run spread*: what one run of a sound rigid model may be off by
//! (scatter of repetitions, sensor noise, and the tolerance of [`crate::evidence::tolerance`]). It is
//! wider than the noise floor of [`crate::evidence::noise`], which holds no tolerance. The systematic part of a condition's misfit is estimated
//! without bias from products of different runs: `E[e_i e_j] = m^2` for `i != j`, whatever
//! the noise is. What of it stands above the floor is the excess: the misfit that an effect
//! has to explain.
//!
//! A run spread holds what varies from run to run in one direction only: where friction scatters, every channel may be off
//! by that, and a misfit across it hides in each of them. All features of a condition together, whitened, show it.

use std::collections::BTreeMap;

use statrs::statistics::Statistics;

use crate::channels::{COUNT, FINGER_FORCE};
use crate::evidence::tolerance::FORM;
use crate::fit::features::{FEATURES, Features};
use crate::fit::noise;
use crate::fit::phases::{BINS, Phase};
use crate::fit::problem::Problem;

/// Standard deviation of the product of two runs' errors, each a systematic part and noise of
/// one floor.
const CHANCE: f64 = 1.732;
/// What is beyond chance lies so many standard errors off.
const STANDARD_ERRORS: f64 = 3.0;

/// All features of a condition together are clearly off where their whitened mean square is beyond this: a right model leaves
/// one at most, of which tolerances are a part.
const CLEAR: f64 = 2.0;
/// A model is clearly off where this share of the conditions is, and so many of them.
const CLEAR_SHARE: f64 = 0.25;
const CLEAR_CONDITIONS: usize = 3;

/// Misfit of a model. See the module.
#[derive(Clone, Debug)]
pub struct Misfit {
    /// Root mean square error over runs and features.
    pub error: f64,
    /// What that is at least: three standard errors, over conditions, below that of all conditions but the worst.
    pub error_at_least: f64,
    /// The same for runs about the mean of their condition, with the floor.
    pub perfect_model: f64,
    /// Mean square of the systematic part of each feature over conditions; NaN where not measured.
    pub systematic: Features,
    /// Sum over features of the systematic square above the floor's own one.
    pub excess: f64,
    /// By channel and phase, worst first.
    pub places: Vec<Place>,
    /// Mean square of the whitened features of each condition; empty where no repetition tells what is chance.
    pub whitened: Vec<f64>,
}

/// Systematic misfit of one channel in one phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Channel.
    pub channel: usize,
    /// Phase.
    pub phase: Phase,
    /// Root mean square, in run spreads.
    pub size: f64,
    /// What the size is at least: three standard errors below that of all conditions but the worst.
    pub at_least: f64,
    /// A run of the condition where it is largest.
    pub run: usize,
}

impl Place {
    /// Whether it misses by more than `floors` run spreads, beyond chance.
    pub fn exceeds(&self, floors: f64) -> bool {
        self.size > floors && self.at_least > 1.0
    }
}

impl Misfit {
    /// What a channel misses by in a phase, where it is measured.
    pub fn at(&self, channel: usize, phase: Phase) -> Option<&Place> {
        self.places.iter().find(|p| (p.channel, p.phase) == (channel, phase))
    }

    /// Size of the worst place; zero where nothing is measured.
    pub fn worst(&self) -> f64 {
        self.places.first().map_or(0.0, |p| p.size)
    }

    /// What of it is beyond the form of the laws that explain the rest of `base`: each place less [`FORM`] of
    /// what was explained there, or in the mean of its channel's phases where that is more, as a sensor's constant error is
    /// fitted to all of them.
    #[must_use]
    pub fn beyond_form(&self, base: &Self) -> Self {
        let of_base: BTreeMap<(usize, Phase), f64> =
            base.places.iter().map(|p| ((p.channel, p.phase), p.size)).collect();
        let beyond = |size: f64, form2: f64| (size * size - form2).max(0.0).sqrt();
        let explained2 = |p: &Place| {
            let before = of_base.get(&(p.channel, p.phase)).copied().unwrap_or(0.0);
            (before * before - p.size * p.size).max(0.0)
        };
        let mut of_channel = [0.0; COUNT];
        for (channel, mean) in of_channel.iter_mut().enumerate().skip(FINGER_FORCE) {
            *mean = self.places.iter().filter(|p| p.channel == channel).map(explained2).mean();
        }
        let mut left = self.clone();
        for p in &mut left.places {
            // Poses have no constant error; where nothing is measured the mean is NaN.
            let form2 = FORM * FORM * explained2(p).max(of_channel[p.channel]);
            (p.size, p.at_least) = (beyond(p.size, form2), beyond(p.at_least, form2));
        }
        for (now, before) in left.whitened.iter_mut().zip(&base.whitened) {
            *now = (*now - FORM * FORM * (before - *now).max(0.0)).max(0.0);
        }
        left.places.sort_by(|a, b| b.size.total_cmp(&a.size));
        left
    }

    /// Whether the error of all features together is beyond chance larger than tolerances and scatter make that of a perfect
    /// model, or that of many conditions clearly is.
    #[must_use]
    pub fn is_beyond_perfect(&self) -> bool {
        self.error_at_least > self.perfect_model || self.clear_conditions().is_some()
    }

    /// Conditions whose features together are clearly off, of how many; `None` where they are too few for a model that is.
    #[must_use]
    pub fn clear_conditions(&self) -> Option<(usize, usize)> {
        let all = self.whitened.len();
        let clear = self.whitened.iter().filter(|w| **w > CLEAR).count();
        let fewest = CLEAR_CONDITIONS.max((CLEAR_SHARE * all as f64).ceil() as usize);
        (clear >= fewest).then_some((clear, all))
    }

    /// Whether a channel misses by more than `floors` run spreads in a phase, or all of them together clearly do.
    #[must_use]
    pub fn misses(&self, floors: f64) -> bool {
        self.exceeds(floors) || self.clear_conditions().is_some()
    }

    /// Whether some place misses by more than `floors` run spreads, beyond chance.
    pub fn exceeds(&self, floors: f64) -> bool {
        self.places.iter().any(|p| p.exceeds(floors))
    }
}

/// Misfit for residuals of the groups, sensor offsets already taken out.
pub fn of(problem: &Problem, residual: &[Features]) -> Misfit {
    let campaign = problem.campaign;
    // Residual of each run: its own at the starting model, moved as its group's mean has moved.
    let mut runs: Vec<Option<Features>> = vec![None; campaign.runs.len()];
    for (g, r) in problem.groups.iter().zip(residual) {
        let group = &campaign.groups[*g];
        let mean = noise::mean(group.runs.iter().map(|r| &problem.residuals[*r]));
        for run in &group.runs {
            let moved: Features = problem.residuals[*run]
                .iter()
                .enumerate()
                .map(|(f, e)| (e + r[f] - mean[f]) / problem.single_run[*g][f])
                .collect();
            runs[*run] = Some(moved);
        }
    }
    let mut systematic = vec![0.0; FEATURES];
    let mut count = vec![0.0; FEATURES];
    let (mut square, mut scatter, mut seen, mut scattered) = (0.0, 0.0, 0.0, 0.0);
    let mut of_conditions: Vec<f64> = Vec::new();
    // For each place: mean square of each condition.
    let mut by_place: BTreeMap<(usize, Phase), Vec<(f64, usize)>> = BTreeMap::new();
    for of in campaign.runs_of() {
        let Some(one) = of.first().copied() else { continue };
        let mut here: BTreeMap<(usize, Phase), (f64, f64)> = BTreeMap::new();
        let of: Vec<&Features> = of.iter().filter_map(|r| runs[*r].as_ref()).collect();
        let before = (square, seen);
        for f in 0..FEATURES {
            let x: Vec<f64> = of.iter().map(|e| e[f]).filter(|x| x.is_finite()).collect();
            let n = x.len() as f64;
            if x.is_empty() {
                continue;
            }
            let sum: f64 = x.iter().sum();
            let squares: f64 = x.iter().map(|x| x * x).sum();
            square += squares;
            seen += n;
            count[f] += 1.0;
            let part = if x.len() > 1 { (sum * sum - squares) / (n * (n - 1.0)) } else { squares - 1.0 };
            systematic[f] += part;
            let place = here.entry((f / BINS, Phase::of(f % BINS))).or_default();
            place.0 += part;
            place.1 += 1.0;
            if x.len() > 1 {
                scatter += (squares - sum * sum / n) * n / (n - 1.0);
                scattered += n;
            }
        }
        if seen > before.1 {
            of_conditions.push((square - before.0) / (seen - before.1));
        }
        for (place, (sum, n)) in here {
            by_place.entry(place).or_default().push((sum / n, one));
        }
    }
    let systematic: Features =
        systematic.iter().zip(&count).map(|(s, n)| if *n > 0.0 { s / n } else { f64::NAN }).collect();
    let excess = systematic.iter().filter(|s| s.is_finite()).map(|s| (s - 1.0).max(0.0)).sum();
    // The floor is no scatter: it is added where scatter was measured.
    let mut floor = 0.0;
    let mut floors = 0.0;
    for (g, one) in problem.groups.iter().map(|g| (g, &problem.single_run[*g])) {
        for f in problem.whiteners[*g].active.iter() {
            floor += problem.floor(*g, *f).powi(2) / (one[*f] * one[*f]);
            floors += 1.0;
        }
    }
    let perfect_model =
        if scattered > 0.0 { (scatter / scattered + floor / f64::max(floors, 1.0)).sqrt() } else { 1.0 };
    let mut places: Vec<Place> = by_place
        .into_iter()
        .map(|((channel, phase), squares)| {
            let n = squares.len() as f64;
            let mean = squares.iter().map(|s| s.0).sum::<f64>() / n;
            // A single condition in which the model fails altogether decides nothing.
            let (largest, run) = squares.iter().copied().fold((0.0, 0), |m, s| if s.0 > m.0 { s } else { m });
            let others = if n > 1.0 { (mean * n - largest) / (n - 1.0) } else { 0.0 };
            let least: f64 = others - STANDARD_ERRORS * CHANCE / n.sqrt();
            Place { channel, phase, size: mean.max(0.0).sqrt(), at_least: least.max(0.0).sqrt(), run }
        })
        .collect();
    places.sort_by(|a, b| b.size.total_cmp(&a.size));
    let error_at_least = without_the_worst(&of_conditions).max(0.0).sqrt();
    let mut whitened: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
    let repeated = problem.groups.iter().zip(residual).filter(|_| problem.noise.freedom > 0);
    for (g, r) in repeated {
        let whitener = &problem.whiteners[*g];
        let of = whitened.entry(campaign.groups[*g].condition).or_default();
        of.0 += whitener.square(r);
        of.1 += whitener.active.len() as f64;
    }
    Misfit {
        error: (square / f64::max(seen, 1.0)).sqrt(),
        error_at_least,
        perfect_model,
        systematic,
        excess,
        places,
        whitened: whitened.into_values().map(|(square, n)| square / f64::max(n, 1.0)).collect(),
    }
}

/// Mean of `squares` without the largest, less [`STANDARD_ERRORS`] of it.
fn without_the_worst(squares: &[f64]) -> f64 {
    let mut sorted = squares.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.pop();
    if sorted.len() < 2 {
        return 0.0;
    }
    let variance = sorted.iter().variance() / sorted.len() as f64;
    sorted.iter().mean() - STANDARD_ERRORS * variance.sqrt()
}
