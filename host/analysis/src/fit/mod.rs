//! Fitting model parameters to a data set: Gauss-Newton on whitened features.
//!
//! Minimises a generalised least squares loss ([`gls`]) over friction and effect parameters
//! ([`free`]), with constant sensor errors as nuisance within the stated uncertainty
//! ([`engine`]). Intervals come from whole conditions, those of friction from whole channels too ([`intervals`]).

pub mod alignment;
pub mod campaign;
pub mod carried;
pub mod closing;
pub mod common_floor;
pub mod constants;
pub mod edges;
pub mod engine;
pub mod features;
pub mod free;
pub mod gls;
pub mod intervals;
pub mod loading;
pub mod noise;
pub mod phases;
pub mod placing;
pub mod points;
pub mod problem;
pub mod screen;
pub mod search;
pub mod sensing;
pub mod sharing;
pub mod uneven;
pub mod unrepeated;

use stickslip_shared::model::Model;
use thiserror::Error;

use crate::evidence::tolerance::FORM;
use crate::fit::campaign::Campaign;
use crate::fit::problem::Problem;
use crate::left_out::LeftOut;

pub use engine::{Descent, Place, Solution, descend, go_on, sensitivities, solve};
pub use free::{Free, base_parameters};
pub use intervals::{Estimate, clustered_covariance};
pub use search::{
    MANY, across_edges, apart, basins, first_fit, friction_grid, likely, robust_cost, rough_start,
    solve_across, starts, within_reach,
};

/// Parts of the conditions that are held out in turn.
pub const FOLDS: usize = 10;

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
    /// Parameters that the data do not show: they stay where they were.
    pub unseen: Vec<Free>,
    /// Loss before and after.
    pub loss: (f64, f64),
    /// Held-out loss of each group at the solution.
    pub held_out: Vec<f64>,
    /// Number of iterations made.
    pub iterations: usize,
    /// Trials that were used.
    pub trials: usize,
    /// Trials that were not, and why.
    pub left_out: Vec<LeftOut>,
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
    let before = Place::of(&problem, model.clone(), free).loss;
    let solution = solve_across(&problem, &first, free, options.iterations);
    Ok(of_solution(&problem, (solution, before), model, free, options))
}

/// The fit that ended in a `solution`, the loss `before` it; what the data do not determine stays as in the `given` model.
pub fn of_solution(
    problem: &Problem,
    (solution, before): (Solution, f64),
    given: &Model<f64>,
    free: &[Free],
    options: &Options,
) -> Fit {
    let (solution, seen, kept) = keep_unseen(problem, solution, given, free, options.iterations);
    let mut fit = summary(problem, solution, before, &seen, options);
    restore(&mut fit, free, &seen, kept);
    fit.unseen = free.iter().copied().filter(|f| !seen.contains(f)).collect();
    fit
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
        let from = Place::of(problem, model, &others);
        let without = descend(problem, from, &others, iterations, &[]);
        if without.place.loss < 1.02 * solution.loss.1 + 9.0 {
            kept.push(format!("{} is not visible in these data: stays at {home:.3}", f.name()));
            (solution, seen) = (without.end(problem, &others), others);
        }
    }
    (solution, seen, kept)
}

/// Gives `fit` an estimate for every one of `free` again: what was kept has no interval.
fn restore(fit: &mut Fit, free: &[Free], seen: &[Free], kept: Vec<String>) {
    let place = |f: &Free| seen.iter().position(|s| s == f);
    let estimates = free
        .iter()
        .map(|f| match place(f) {
            Some(at) => fit.estimates[at].clone(),
            None => {
                let (low, high) = f.bounds();
                let value = f.get(&fit.model);
                Estimate { name: f.name(), value, low, high, unit: f.unit() }
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

/// Intervals, covariance and notes of a solution. An interval holds what other conditions would say, and what the law of the
/// effect may be wrong by.
pub fn summary(problem: &Problem, solution: Solution, before: f64, free: &[Free], options: &Options) -> Fit {
    let prior = problem.priors(free, 0);
    let covariance = clustered_covariance(&solution.grams, &prior, free.len());
    let intervals =
        intervals::resample(&solution.grams, &prior, free.len(), (options.resamples, options.seed));
    let model = &solution.model;
    let estimates: Vec<Estimate> = free
        .iter()
        .enumerate()
        .map(|(k, f)| {
            let (low, high) = f.bounds();
            let value = f.get(model);
            if f.coefficient().is_some() && !intervals.is_empty() {
                let [low, high] = intervals::of_friction(problem, &solution, free, k);
                return Estimate { name: f.name(), value, low, high, unit: f.unit() };
            }
            let [a, b] = intervals.get(k).copied().unwrap_or([f64::NAN; 2]);
            let form = FORM * f.departure(model).abs();
            // What is unknown stays so.
            let side = |d: f64| if d.is_nan() { d } else { d.max(0.0).hypot(form) };
            Estimate {
                name: f.name(),
                value,
                low: (value - side(-a)).clamp(low, high),
                high: (value + side(b)).clamp(low, high),
                unit: f.unit(),
            }
        })
        .collect();
    let notes = intervals::notes(&estimates, &covariance, free);
    let folds = gls::fold_solutions(&solution.grams, &prior, FOLDS);
    let held_out = gls::held_out(&solution.grams, &folds);
    Fit {
        model: solution.model,
        estimates,
        covariance: (0..free.len()).map(|i| (0..free.len()).map(|j| covariance[(i, j)]).collect()).collect(),
        notes,
        unseen: Vec::new(),
        loss: (before, solution.loss.1),
        held_out,
        iterations: solution.iterations,
        trials: problem.trials(),
        left_out: problem.left_out(),
    }
}
