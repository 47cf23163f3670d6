//! Fitting model parameters to a data set: Gauss-Newton on whitened features.
//!
//! Minimises the generalised least squares loss of `diagnose::gls` over friction and effect
//! parameters, with constant sensor errors as nuisance within the stated uncertainty.
//! Intervals come from resampling whole conditions, so that they stay honest where the
//! model is wrong.

pub mod campaign;
pub mod features;
pub mod gls;
pub mod noise;
pub mod phases;
pub mod problem;
pub mod screen;

use crate::model::candidate::CandidateEffect;
use nalgebra::{DMatrix, DVector};
use rand::{Rng, SeedableRng};
use serde::Serialize;
use stickslip_shared::effects::{Info, Parameter};
use stickslip_shared::model::Model;
use thiserror::Error;

use crate::fit::campaign::Campaign;
use crate::fit::features::{FEATURES, Features};
use crate::fit::gls::{Gram, Prior};
use crate::fit::phases::BINS;
use crate::fit::problem::{Problem, difference};
use crate::fit::screen::{Start, screen};

/// Parts of the conditions that are held out in turn.
pub const FOLDS: usize = 10;

/// A parameter of the model that is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Free {
    /// Friction of the fingertips.
    FingerFriction,
    /// Friction of the pusher.
    PusherFriction,
    /// Friction of the table.
    SupportFriction,
    /// A parameter of an effect.
    Effect {
        /// Place of the effect in the model.
        slot: usize,
        /// Place of the parameter in its description.
        parameter: usize,
        /// Its description.
        #[serde(skip)]
        of: &'static Parameter,
    },
}

impl Free {
    /// All parameters of the effect in `slot`.
    pub fn of_effect(info: &'static Info, slot: usize) -> Vec<Free> {
        let each = info.parameters.iter().enumerate();
        each.map(|(parameter, of)| Free::Effect { slot, parameter, of }).collect()
    }

    /// The same parameter once the effect in `gone` is taken out; `None` for its own.
    pub fn without_slot(&self, gone: usize) -> Option<Free> {
        match *self {
            Free::Effect { slot, .. } if slot == gone => None,
            Free::Effect { slot, parameter, of } if slot > gone => {
                Some(Free::Effect { slot: slot - 1, parameter, of })
            }
            other => Some(other),
        }
    }

    /// Value in `model`; NaN where it does not have it.
    pub fn get(&self, model: &Model<f64>) -> f64 {
        match self {
            Free::FingerFriction => model.friction.finger,
            Free::PusherFriction => model.friction.pusher,
            Free::SupportFriction => model.friction.support,
            Free::Effect { slot, parameter, .. } => model
                .effects
                .get(*slot)
                .and_then(|e| e.parameters.get(*parameter))
                .copied()
                .unwrap_or(f64::NAN),
        }
    }

    /// Sets it, within its bounds.
    pub fn set(&self, model: &mut Model<f64>, value: f64) {
        let (low, high) = self.bounds();
        let value = value.clamp(low, high);
        match self {
            Free::FingerFriction => model.friction.finger = value,
            Free::PusherFriction => model.friction.pusher = value,
            Free::SupportFriction => model.friction.support = value,
            Free::Effect { slot, parameter, .. } => {
                if let Some(p) = model.effects.get_mut(*slot).and_then(|e| e.parameters.get_mut(*parameter)) {
                    *p = value;
                }
            }
        }
    }

    /// Smallest and largest value that makes sense.
    pub fn bounds(&self) -> (f64, f64) {
        match self.described() {
            Some(p) => (p.low, p.high),
            None => (1e-3, 5.0),
        }
    }

    /// `change` within what a linear model may be trusted: friction at most doubles or halves.
    pub fn limited(&self, model: &Model<f64>, change: f64) -> f64 {
        match self {
            Free::Effect { .. } => change,
            _ => {
                let value = self.get(model).max(0.02);
                change.clamp(-0.5 * value, value)
            }
        }
    }

    /// Step of finite differences.
    fn step(&self, model: &Model<f64>) -> f64 {
        let value = self.get(model);
        let size = match self.described() {
            Some(p) => {
                let scale = (p.typical - p.neutral).abs();
                if scale > 0.0 { 0.1 * scale } else { 0.1 * p.typical.abs().max(1e-6) }
            }
            None => 0.02 * value.abs().max(0.05),
        };
        let (low, high) = self.bounds();
        if value + size > high && value - size >= low { -size } else { size }
    }

    /// Value where nothing is known: the one given, and for an effect that of its description.
    fn home(&self, given: &Model<f64>) -> f64 {
        match self.described() {
            Some(p) => p.neutral,
            None => self.get(given),
        }
    }

    fn described(&self) -> Option<&'static Parameter> {
        match self {
            Free::Effect { of, .. } => Some(of),
            _ => None,
        }
    }

    /// The coefficient's name in a model file; none for a parameter of an effect.
    pub fn coefficient(&self) -> Option<&'static str> {
        match self {
            Free::FingerFriction => Some("finger"),
            Free::PusherFriction => Some("pusher"),
            Free::SupportFriction => Some("support"),
            Free::Effect { .. } => None,
        }
    }

    /// Name with unit suffix; effects as `effect.parameter`.
    pub fn name(&self, model: &Model<f64>) -> String {
        match self {
            Free::Effect { slot, of, .. } => {
                let info = model.effects.get(*slot).and_then(stickslip_shared::effects::Effect::info);
                format!("{}.{}", info.map_or("effect", |i| i.id), of.name)
            }
            _ => format!("friction.{}", self.coefficient().unwrap_or_default()),
        }
    }

    /// Unit as people write it.
    pub fn unit(&self) -> &'static str {
        self.described().map_or("1", |p| p.unit)
    }
}

/// The friction coefficients that the data set's contacts have.
pub fn base_parameters(campaign: &Campaign) -> Vec<Free> {
    let any = |f: &dyn Fn(&stickslip_shared::model::Scene<f64>) -> bool| {
        campaign.runs.iter().any(|r| f(&r.prepared.scene))
    };
    let mut out = Vec::new();
    if any(&|s| s.fingers.is_some()) {
        out.push(Free::FingerFriction);
    }
    if any(&|s| s.pusher.is_some()) {
        out.push(Free::PusherFriction);
    }
    if any(&|s| s.support.is_some()) || campaign.runs.iter().any(|r| r.prepared.on_platform()) {
        out.push(Free::SupportFriction);
    }
    out
}

/// How a fit is done.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Most Gauss-Newton iterations.
    pub iterations: usize,
    /// Resamples of the conditions for the intervals; 0: none.
    pub resamples: usize,
    /// Of the resampling.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { iterations: 8, resamples: 400, seed: 1 }
    }
}

/// One fitted parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// See [`Free::name`].
    pub name: String,
    /// Best value.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Unit.
    pub unit: &'static str,
}

/// Why nothing can be fitted.
#[derive(Debug, Error)]
pub enum FitError {
    /// Nothing to fit to.
    #[error("no trial can be simulated: {0}")]
    NoTrials(String),
    /// Nothing to fit.
    #[error("no free parameter: the data set has no contact whose friction could be fitted")]
    NoParameters,
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fit {
    /// With the best values.
    pub model: Model<f64>,
    /// One for each free parameter.
    pub estimates: Vec<Estimate>,
    /// Covariance of the free parameters, robust to a wrong noise model (clustered by condition).
    pub covariance: Vec<Vec<f64>>,
    /// What cannot be told apart or seen, in words.
    pub notes: Vec<String>,
    /// Loss before and after.
    pub loss: (f64, f64),
    /// Held-out loss of each group at the solution.
    pub held_out: Vec<f64>,
    /// Number of iterations made.
    pub iterations: usize,
}

/// Fits `free` parameters of `model` to all trials of `campaign`.
///
/// # Errors
/// Where no trial can be simulated or nothing is free.
pub fn calibrate(
    campaign: &Campaign,
    model: &Model<f64>,
    free: &[Free],
    options: &Options,
) -> Result<Fit, FitError> {
    if campaign.runs.is_empty() {
        let why = campaign.refused.first().map_or("the data set is empty".into(), ToString::to_string);
        return Err(FitError::NoTrials(why));
    }
    if free.is_empty() {
        return Err(FitError::NoParameters);
    }
    // The noise model is estimated around the first solution and once more around the second.
    let first = first_fit(campaign, model, free, options.iterations);
    let problem = Problem::new(campaign, &first);
    let before = solve(&problem, model, free, 0).loss.0;
    let solution = solve(&problem, &first, free, options.iterations);
    let (solution, seen, kept) = keep_unseen(&problem, solution, model, free, options.iterations);
    let mut fit = summary(&problem, solution, before, &seen, options);
    restore(&mut fit, model, free, &seen, kept);
    Ok(fit)
}

/// Puts parameters that the data do not determine back to where they were: without this a fit
/// runs them to a bound, and other data miss by that. Returns the solution, what is still
/// free, and notes about what is not.
fn keep_unseen(
    problem: &Problem,
    mut solution: Solution,
    given: &Model<f64>,
    free: &[Free],
    iterations: usize,
) -> (Solution, Vec<Free>, Vec<String>) {
    let mut seen = free.to_vec();
    let mut kept = Vec::new();
    for f in free {
        let at = seen.iter().position(|s| s == f).unwrap_or(0);
        let covariance = clustered_covariance(&solution.grams, &problem.priors(&seen, 0), seen.len());
        let value = f.get(&solution.model);
        let (low, high) = f.bounds();
        let sd = covariance[(at, at)].sqrt();
        let wide = match f {
            Free::Effect { .. } => 0.5 * (high - low),
            // Not better than the prior's own width.
            _ => 0.8 * crate::fit::noise::FRICTION_PRIOR * value,
        };
        let determined = sd > 0.0 && sd < wide && value > low && value < high;
        if determined || seen.len() == 1 {
            continue;
        }
        let home = f.home(given);
        let mut model = solution.model.clone();
        f.set(&mut model, home);
        let mut others = seen.clone();
        others.remove(at);
        let without = solve(problem, &model, &others, iterations);
        if without.loss.1 < 1.02 * solution.loss.1 + 9.0 {
            kept.push(format!("{} is not visible in these data: stays at {home:.3}", f.name(given)));
            (solution, seen) = (without, others);
        }
    }
    (solution, seen, kept)
}

/// Gives `fit` an estimate for every one of `free` again: what was kept has no interval.
fn restore(fit: &mut Fit, given: &Model<f64>, free: &[Free], seen: &[Free], kept: Vec<String>) {
    let place = |f: &Free| seen.iter().position(|s| s == f);
    let estimates = free
        .iter()
        .map(|f| match place(f) {
            Some(at) => fit.estimates[at].clone(),
            None => {
                let (low, high) = f.bounds();
                let value = f.get(&fit.model);
                Estimate { name: f.name(given), value, low, high, unit: f.unit() }
            }
        })
        .collect();
    let covariance = free
        .iter()
        .map(|a| {
            free.iter()
                .map(|b| match (place(a), place(b)) {
                    (Some(i), Some(j)) => fit.covariance[i][j],
                    _ => 0.0,
                })
                .collect()
        })
        .collect();
    fit.estimates = estimates;
    fit.covariance = covariance;
    fit.notes.extend(kept);
}

/// Dampings tried in a step, each ten times the one before: past the edge at which a contact
/// lets go a full step is worthless, however short the way to go is.
const DAMPINGS: usize = 6;
/// Friction that differs by this factor may be another way of contact.
const FAR: f64 = 1.5;
/// Friction coefficients tried before a fit: fingers, then pusher (rubber platforms grip hard).
const TRIED: [&[f64]; 3] = [&[0.15, 0.4, 0.8], &[0.1, 0.25, 0.7, 2.5], &[0.15, 0.3, 0.6, 2.5]];

/// Cost of a model in which single failures of the simulation or of the model weigh little:
/// the sum of `e^2 / (1 + e^2 / 100)` over features of at most 24 groups.
pub fn robust_cost(campaign: &Campaign, model: &Model<f64>) -> f64 {
    let step = campaign.groups.len().div_ceil(24).max(1);
    let groups: Vec<usize> = (0..campaign.groups.len()).step_by(step).collect();
    let channels = noise::channel_noise(&campaign.description.sensors);
    let predicted = campaign.simulate_groups(model, &groups);
    let mut total = 0.0;
    for (g, p) in groups.iter().zip(&predicted) {
        let measured = &campaign.runs[campaign.groups[*g].runs[0]].measured;
        for (f, (y, x)) in measured.iter().zip(p).enumerate() {
            let (noise, uncertainty) = channels[f / BINS];
            let e = (y - x) / (10.0 * noise + uncertainty);
            if e.is_finite() {
                total += e * e / (1.0 + e * e / 100.0);
            }
        }
    }
    total
}

/// `model` with `free` friction fitted, from the values given and from a rough start: what fits
/// best by `robust_cost`.
pub fn first_fit(campaign: &Campaign, model: &Model<f64>, free: &[Free], iterations: usize) -> Model<f64> {
    basins(campaign, model, free, iterations).swap_remove(0)
}

/// As [`first_fit`], and after it the other models met on the way whose friction is far from
/// it: where contacts stick there that slip here, an effect acts otherwise, and what a model
/// without it fits best need not be near what one with it does.
pub fn basins(campaign: &Campaign, model: &Model<f64>, free: &[Free], iterations: usize) -> Vec<Model<f64>> {
    let from = |start: &Model<f64>| solve(&Problem::new(campaign, start), start, free, iterations).model;
    let rough = rough_start(campaign, model, free);
    let mut tries = vec![model.clone(), from(model)];
    if rough != *model {
        tries.extend([from(&rough), rough]);
    }
    let mut ranked: Vec<(f64, Model<f64>)> =
        tries.into_iter().map(|m| (robust_cost(campaign, &m), m)).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut out: Vec<Model<f64>> = Vec::new();
    for (_, m) in ranked {
        if out.iter().all(|other| apart(campaign, &m, other)) {
            out.push(m);
        }
    }
    out
}

/// Whether the friction of two models differs so much that contacts may stick in one and slip in
/// the other.
pub fn apart(campaign: &Campaign, a: &Model<f64>, b: &Model<f64>) -> bool {
    base_parameters(campaign).iter().any(|f| (f.get(a) / f.get(b)).ln().abs() > FAR.ln())
}

/// `model` with all combinations of friction coefficients that are tried before a fit.
pub fn friction_grid(campaign: &Campaign, model: &Model<f64>) -> Vec<Model<f64>> {
    let mut out = vec![model.clone()];
    for free in base_parameters(campaign) {
        let varied = |m: &Model<f64>| -> Vec<Model<f64>> {
            let with = |value: &f64| {
                let mut m = m.clone();
                free.set(&mut m, *value);
                m
            };
            std::iter::once(m.clone()).chain(tried(&free).iter().map(with)).collect()
        };
        out = out.iter().flat_map(varied).collect();
    }
    out
}

fn tried(free: &Free) -> &'static [f64] {
    match free {
        Free::FingerFriction => TRIED[0],
        Free::PusherFriction => TRIED[1],
        _ => TRIED[2],
    }
}

/// `model` with those of the `free` friction coefficients that fit best on a coarse grid, by a
/// robust cost: far from the truth an object may be dropped, and least squares would look nowhere
/// else. A coefficient that is not free stays exactly where it is: moved here it would never come
/// back, and take up what else the model lacks.
pub fn rough_start(campaign: &Campaign, model: &Model<f64>, free: &[Free]) -> Model<f64> {
    let cost = |model: &Model<f64>| robust_cost(campaign, model);
    let mut best = (cost(model), model.clone());
    for _ in 0..2 {
        for coefficient in free.iter().filter(|f| f.coefficient().is_some()) {
            for value in tried(coefficient) {
                let mut changed = best.1.clone();
                coefficient.set(&mut changed, *value);
                let c = cost(&changed);
                if c < best.0 {
                    best = (c, changed);
                }
            }
        }
    }
    best.1
}

/// Intervals, covariance and notes of a solution.
pub fn summary(problem: &Problem, solution: Solution, before: f64, free: &[Free], options: &Options) -> Fit {
    let prior = problem.priors(free, 0);
    let covariance = clustered_covariance(&solution.grams, &prior, free.len());
    let intervals = resample(&solution.grams, &prior, free.len(), options);
    let model = solution.model;
    let estimates: Vec<Estimate> = free
        .iter()
        .enumerate()
        .map(|(k, f)| {
            let (low, high) = f.bounds();
            let value = f.get(&model);
            let [a, b] = intervals.get(k).copied().unwrap_or([f64::NAN; 2]);
            Estimate {
                name: f.name(&model),
                value,
                low: (value + a).clamp(low, high),
                high: (value + b).clamp(low, high),
                unit: f.unit(),
            }
        })
        .collect();
    let notes = notes(&estimates, &covariance, free);
    let folds = gls::fold_solutions(&solution.grams, &prior, FOLDS);
    let held_out = gls::held_out(&solution.grams, &folds);
    Fit {
        model,
        estimates,
        covariance: (0..free.len()).map(|i| (0..free.len()).map(|j| covariance[(i, j)]).collect()).collect(),
        notes,
        loss: (before, solution.loss.1),
        held_out,
        iterations: solution.iterations,
    }
}

/// Where Gauss-Newton ended.
#[derive(Clone, Debug)]
pub struct Solution {
    /// With the best values.
    pub model: Model<f64>,
    /// Gram matrices around it (parameters, offsets, residual).
    pub grams: Vec<Gram>,
    /// Coarse prediction of each group at it.
    pub predicted: Vec<Features>,
    /// Residual of each group at it.
    pub residual: Vec<Features>,
    /// Sensitivities of the groups' features, one list for each free parameter.
    pub columns: Vec<Vec<Features>>,
    /// Fitted sensor offsets.
    pub offsets: Vec<f64>,
    /// Loss at the start and here.
    pub loss: (f64, f64),
    /// Iterations made.
    pub iterations: usize,
}

/// Loss minimised over the offsets, and the offsets.
fn profile(problem: &Problem, residual: &[Features]) -> (f64, Vec<f64>) {
    gls::least(&problem.grams(residual, &[]), &problem.priors(&[], 0))
}

/// Columns of the sensitivities of the groups' features to `free`.
pub fn sensitivities(
    problem: &Problem,
    model: &Model<f64>,
    predicted: &[Features],
    free: &[Free],
) -> Vec<Vec<Features>> {
    let with = |f: &Free, step: f64| {
        let mut changed = model.clone();
        f.set(&mut changed, f.get(model) + step);
        (f.get(&changed) - f.get(model), problem.predict(&changed))
    };
    let size = |all: &[Features]| -> f64 {
        problem.groups.iter().zip(all).map(|(g, r)| problem.whiteners[*g].square(r)).sum()
    };
    let changed = |with: &[Features]| -> f64 {
        size(&with.iter().zip(predicted).map(|(w, p)| difference(w, p, 1.0)).collect::<Vec<_>>())
    };
    let here = size(&problem.residual(predicted));
    free.iter()
        .map(|f| {
            let step = f.step(model);
            let mut forward = with(f, step);
            // A small step that changes more than there is to explain has passed the edge at which a
            // contact lets go: the other side tells how things change on this one.
            let change = changed(&forward.1);
            if change > here + (problem.groups.len() * FEATURES) as f64 {
                let back = with(f, -step);
                if back.0 != 0.0 && changed(&back.1) < change {
                    forward = back;
                }
            }
            let (step, with) = forward;
            with.iter()
                .zip(predicted)
                .map(|(w, p)| difference(w, p, if step == 0.0 { f64::INFINITY } else { step }))
                .collect()
        })
        .collect()
}

/// What a fit minimises, at `model`.
pub fn loss_at(problem: &Problem, model: &Model<f64>, free: &[Free]) -> f64 {
    profile(problem, &problem.residual(&problem.predict(model))).0 + penalty(problem, model, free)
}

/// What the prior of `free` costs.
fn penalty(problem: &Problem, model: &Model<f64>, free: &[Free]) -> f64 {
    free.iter().filter_map(|f| problem.prior(f).map(|(m, p)| p * (m - f.get(model)).powi(2))).sum()
}

/// Gauss-Newton with Levenberg damping from `model`.
pub fn solve(problem: &Problem, model: &Model<f64>, free: &[Free], iterations: usize) -> Solution {
    solve_with(problem, model, free, iterations, &[])
}

/// As [`solve`]; the sensitivities of the first parameters are `known` near enough and only
/// computed anew at the end.
pub fn solve_with(
    problem: &Problem,
    model: &Model<f64>,
    free: &[Free],
    iterations: usize,
    known: &[Vec<Features>],
) -> Solution {
    // Those of `known`, until they are no longer near enough.
    let mut old = known.len();
    let columns_at = |model: &Model<f64>, predicted: &[Features], old: usize| -> Vec<Vec<Features>> {
        let mut columns = known[..old].to_vec();
        columns.extend(sensitivities(problem, model, predicted, &free[old..]));
        columns
    };
    // How far the parameters that have a prior are from its mean, and what that costs.
    let home = |model: &Model<f64>| -> Vec<f64> {
        free.iter().map(|f| problem.prior(f).map_or(0.0, |(mean, _)| mean - f.get(model))).collect()
    };
    let penalty = |model: &Model<f64>| penalty(problem, model, free);
    let mut model = model.clone();
    let mut predicted = problem.predict(&model);
    let mut residual = problem.residual(&predicted);
    let (start, mut offsets) = profile(problem, &residual);
    let start = start + penalty(&model);
    let mut here = start;
    let mut damping = 1e-3;
    let mut made = 0;
    let mut columns = columns_at(&model, &predicted, old);
    let mut grams = problem.grams(&residual, &columns);
    for _ in 0..iterations {
        made += 1;
        let n = free.len();
        let prior = problem.priors(free, 0);
        let mut damped = prior.clone();
        let total: DMatrix<f64> =
            grams.iter().fold(DMatrix::zeros(prior.len() + 1, prior.len() + 1), |a, g| a + &g.matrix);
        let mut accepted = false;
        for _ in 0..DAMPINGS {
            let mut towards = home(&model);
            for k in 0..n {
                let precision = prior.precision[k] + damping * total[(k, k)];
                // The damping pulls to where we are, the prior to its mean; of what the data do not
                // tell here it pulls nothing, for on the way there a contact may let go.
                let told = total[(k, k)] > prior.precision[k];
                if let Some(d) = towards.get_mut(k) {
                    *d *= if told && precision > 0.0 { prior.precision[k] / precision } else { 0.0 };
                }
                damped.precision[k] = precision;
            }
            let Some(x) = gls::solve_towards(grams.iter().map(|g| (1.0, g)), &damped, &towards) else {
                break;
            };
            let mut trial = model.clone();
            for (k, f) in free.iter().enumerate() {
                f.set(&mut trial, f.get(&model) + f.limited(&model, x[k]));
            }
            let p = problem.predict(&trial);
            let r = problem.residual(&p);
            let (loss, o) = profile(problem, &r);
            let loss = loss + penalty(&trial);
            if loss < here {
                accepted = here - loss > 1e-3 * here + 0.1;
                (model, predicted, residual, offsets, here) = (trial, p, r, o, loss);
                damping = (damping * 0.2).max(1e-6);
                columns = columns_at(&model, &predicted, old);
                grams = problem.grams(&residual, &columns);
                break;
            }
            damping = (damping * 10.0).min(1e3);
        }
        if !accepted {
            if old == 0 {
                break;
            }
            columns.splice(..old, sensitivities(problem, &model, &predicted, &free[..old]));
            grams = problem.grams(&residual, &columns);
            (old, damping) = (0, 1e-3);
        }
    }
    if old > 0 {
        columns.splice(..old, sensitivities(problem, &model, &predicted, &free[..old]));
        grams = problem.grams(&residual, &columns);
    }
    Solution { model, grams, predicted, residual, columns, offsets, loss: (start, here), iterations: made }
}

/// Covariance of the first `n` coefficients: `A^-1 (sum of squared scores by condition) A^-1`.
pub fn clustered_covariance(grams: &[Gram], prior: &Prior, n: usize) -> DMatrix<f64> {
    let size = prior.len();
    let mut a = DMatrix::from_diagonal(&DVector::from_row_slice(&prior.precision));
    for g in grams {
        a += g.matrix.view((0, 0), (size, size));
    }
    for i in 0..size {
        a[(i, i)] += 1e-12 + 1e-9 * a[(i, i)];
    }
    let Some(x) = gls::solve(grams.iter().map(|g| (1.0, g)), prior) else {
        return DMatrix::from_element(n, n, f64::NAN);
    };
    let conditions = grams.iter().map(|g| g.condition + 1).max().unwrap_or(0);
    let mut scores = vec![DVector::zeros(size); conditions];
    for g in grams {
        scores[g.condition] += g.matrix.view((0, size), (size, 1)) - g.matrix.view((0, 0), (size, size)) * &x;
    }
    let mut middle = DMatrix::zeros(size, size);
    for s in &scores {
        middle += s * s.transpose();
    }
    let used = scores.iter().filter(|s| s.norm() > 0.0).count().max(2) as f64;
    middle *= used / (used - 1.0);
    // The prior's own spread belongs to the offsets.
    for i in 0..size {
        middle[(i, i)] += prior.precision[i];
        // What its bound holds does not vary.
        if x[i].abs() >= prior.bound[i] {
            a[(i, i)] *= 1e9;
        }
    }
    match a.cholesky() {
        Some(c) => {
            let inverse = c.inverse();
            (&inverse * middle * &inverse).view((0, 0), (n, n)).into_owned()
        }
        None => DMatrix::from_element(n, n, f64::NAN),
    }
}

/// 95 % interval of each coefficient's deviation from the best one, by resampling whole conditions.
fn resample(grams: &[Gram], prior: &Prior, n: usize, options: &Options) -> Vec<[f64; 2]> {
    let conditions = grams.iter().map(|g| g.condition + 1).max().unwrap_or(0);
    if options.resamples < 20 || conditions < 3 {
        return Vec::new();
    }
    let Some(best) = gls::solve(grams.iter().map(|g| (1.0, g)), prior) else { return Vec::new() };
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(options.seed);
    let mut draws: Vec<Vec<f64>> = vec![Vec::with_capacity(options.resamples); n];
    for _ in 0..options.resamples {
        let mut weight = vec![0.0; conditions];
        for _ in 0..conditions {
            weight[rng.random_range(0..conditions)] += 1.0;
        }
        if let Some(x) = gls::solve(grams.iter().map(|g| (weight[g.condition], g)), prior) {
            for k in 0..n {
                draws[k].push(x[k] - best[k]);
            }
        }
    }
    draws
        .iter_mut()
        .map(|d| {
            d.sort_by(f64::total_cmp);
            let at = |q: f64| {
                d.get((q * (d.len().max(1) - 1) as f64).round() as usize).copied().unwrap_or(f64::NAN)
            };
            [at(0.025), at(0.975)]
        })
        .collect()
}

fn notes(estimates: &[Estimate], covariance: &DMatrix<f64>, free: &[Free]) -> Vec<String> {
    let mut out = Vec::new();
    for (k, e) in estimates.iter().enumerate() {
        let (low, high) = free[k].bounds();
        let sd = covariance[(k, k)].sqrt();
        let wide = match free[k] {
            Free::Effect { .. } => 0.5 * (high - low),
            _ => 0.8 * noise::FRICTION_PRIOR * e.value,
        };
        if !sd.is_finite() || sd > wide || covariance[(k, k)] == 0.0 {
            out.push(format!("{} is not visible in these data", e.name));
        } else if e.value <= low || e.value >= high {
            out.push(format!("{} ended at its bound {}", e.name, e.value));
        }
        for j in 0..k {
            let r = covariance[(k, j)] / (covariance[(k, k)] * covariance[(j, j)]).sqrt();
            if r.abs() > 0.97 {
                out.push(format!(
                    "these data do not separate {} and {} (correlation {r:.3}): only a combination of them is determined",
                    estimates[j].name, e.name
                ));
            }
        }
    }
    out
}

/// Models from which the fit of `model` with one more effect may start: the best two by
/// screening on `model` and on other ways of contact, or the effect as given where it cannot
/// be screened.
pub fn starts(
    campaign: &Campaign,
    model: &Model<f64>,
    free: &[Free],
    effect: stickslip_shared::effects::Effect<f64>,
) -> Vec<Model<f64>> {
    let screened = effect.info().map(|info| {
        let problem = Problem::new(campaign, model);
        let mut ways = basins(campaign, model, free, 0);
        ways.retain(|m| apart(campaign, m, model));
        let bases: Vec<Solution> =
            std::iter::once(model).chain(&ways).map(|m| solve(&problem, m, free, 0)).collect();
        let trial = CandidateEffect { info, program: None };
        let starts = screen(&problem, &bases.iter().collect::<Vec<_>>(), free, &trial).starts;
        let of_first = starts.iter().find(|s| s.on == 0);
        let mut out: Vec<_> = starts.iter().take(2).collect();
        out.extend(of_first.filter(|s| !out.iter().any(|o| o.on == s.on)));
        let slot = model.effects.len();
        let mut all = free.to_vec();
        all.extend(Free::of_effect(info, slot));
        let reached = |s: &Start| within_reach(&problem, &bases[s.on], s, &all, slot);
        out.into_iter().map(reached).collect::<Vec<_>>()
    });
    match screened {
        Some(starts) if !starts.is_empty() => starts,
        _ => {
            let mut given = model.clone();
            let _ = given.effects.push(effect);
            vec![given]
        }
    }
}

/// `start`, or as much of the way there from `on` as does not make matters worse: past the edge at
/// which a contact lets go, first order says nothing.
pub fn within_reach(
    problem: &Problem,
    on: &Solution,
    start: &Start,
    free: &[Free],
    slot: usize,
) -> Model<f64> {
    let mut model = start.model.clone();
    for share in [1.0, 0.7, 0.4, 0.15] {
        for f in free {
            let from = match f {
                Free::Effect { slot: s, of, .. } if *s == slot && of.typical == of.neutral => continue,
                Free::Effect { slot: s, of, .. } if *s == slot => of.neutral,
                _ => f.get(&on.model),
            };
            f.set(&mut model, from + share * (f.get(&start.model) - from));
        }
        if loss_at(problem, &model, free) < on.loss.1 {
            return model;
        }
    }
    start.model.clone()
}
