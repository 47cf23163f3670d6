//! Friction coefficients by nonlinear least squares over the model.
//!
//! Unknown are the logarithms of the coefficients (positive, relative steps). The start is
//! the best point of a coarse grid, or of two, the solver Levenberg-Marquardt (the crate
//! `levenberg-marquardt`, after MINPACK). Every signal is weighed by the error that is left
//! in it, found anew after each of a few solves: what the model cannot reproduce whatever
//! its friction (a yaw from a defect that it does not know) has little say, and a single
//! trial that it misses altogether, because the grip was lost there, has hardly any
//! (weights of Cauchy's loss, Holland and Welsch 1977).

use levenberg_marquardt::LevenbergMarquardt;
use nalgebra::DVector;
use rayon::prelude::*;
use stickslip_shared::model::Model;

use super::intervals;
use super::problem::{Coefficient, Estimate, Problem, Unknown, mean_squares};
use super::windows::{SEEN, Seen, Windowed, resolution};
use crate::channels::COUNT;

/// Result of [`fit`].
pub struct Fit {
    /// Base with the new coefficients.
    pub model: Model<f64>,
    /// One for each coefficient that the scene has.
    pub estimates: Vec<Estimate>,
    /// 95 % intervals of the nuisance parameters.
    pub nuisances: Vec<[f64; 2]>,
    /// Places of trials that the calibrated model misses altogether.
    pub missed: Vec<usize>,
}

/// Solves, each with the weights that the last one left, until it moves the logarithms by less.
const ROUNDS: usize = 4;
const SETTLED: f64 = 1e-4;
/// The same of the last fit, which starts near its end.
const LAST_ROUNDS: usize = 20;
const LAST_SETTLED: f64 = 1e-5;
/// A solve ends where its step, relative, is this share of what counts as settled.
const FINER: f64 = 0.1;

/// Finds the coefficients of all contacts that the trials' scenes have, and what is `unknown` of `base` beside them.
pub fn fit(trials: &[&Windowed], offsets: &[f64; COUNT], (base, unknown): (&Model<f64>, Unknown<'_>)) -> Fit {
    let all = [Coefficient::Finger, Coefficient::Pusher, Coefficient::Support].into_iter().enumerate();
    let has = |k: usize| trials.iter().any(|w| w.prepared.frictions()[k]);
    let free: Vec<Coefficient> = all.filter(|(k, _)| has(*k)).map(|(_, of)| of).collect();
    let problem = Problem::new(trials, offsets, (base, unknown), free);
    let mut ends: Vec<Problem<'_>> = starts(&problem)
        .into_iter()
        .map(|at| solved(Problem { at, ..problem.clone() }, (ROUNDS, SETTLED)))
        .collect();
    if ends.len() > 1 {
        let costs: Vec<f64> = ends.iter().map(|end| cost(end, &end.at)).collect();
        let best = (0..ends.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b]));
        ends.swap(0, best.unwrap_or(0));
    }
    let problem = ends.swap_remove(0);
    let estimates = intervals::estimates(&problem, |_| true);
    let nuisances = intervals::of_nuisances(&problem);
    let missed = missed(&problem.weights);
    let mut model = problem.model(&problem.at);
    for e in &estimates {
        *e.coefficient.of(&mut model) = e.value;
    }
    Fit { model, estimates, nuisances, missed }
}

/// `problem` at its solution, and weighed there.
fn solved(mut problem: Problem<'_>, (rounds, settled): (usize, f64)) -> Problem<'_> {
    for _ in 0..rounds {
        problem.weigh();
        let before = problem.at.clone();
        let least = LevenbergMarquardt::new().with_patience(30).with_xtol(FINER * settled);
        (problem, _) = least.minimize(problem);
        if (&problem.at - before).norm() < settled {
            break;
        }
    }
    problem.weigh();
    problem
}

/// The coefficients of `fit` that are not left `open`, fitted once more with the others as the model has them, and their
/// intervals about that: on a plateau an open one may have been anywhere, and what fits beside it there need not fit beside
/// what is in the model. Where the fit ends depends no longer on where it started.
pub fn last(
    trials: &[&Windowed],
    offsets: &[f64; COUNT],
    (fit, unknown): (&mut Fit, Unknown<'_>),
    open: impl Fn(&Estimate) -> bool,
) {
    let all: Vec<Coefficient> = fit.estimates.iter().map(|e| e.coefficient).collect();
    let known: Vec<Coefficient> = fit.estimates.iter().filter(|e| !open(e)).map(|e| e.coefficient).collect();
    if known.is_empty() {
        return;
    }
    let problem = Problem::new(trials, offsets, (&fit.model, unknown), known.clone());
    let solved = solved(problem, (LAST_ROUNDS, LAST_SETTLED));
    fit.nuisances = intervals::of_nuisances(&solved);
    let (model, weights) = (solved.model(&solved.at), solved.weights);
    (fit.model, fit.missed) = (model, missed(&weights));
    if known.len() < all.len() {
        let around = Problem { weights, ..Problem::new(trials, offsets, (&fit.model, unknown), all) };
        for anew in intervals::estimates(&around, |c| known.contains(&c)) {
            let of_it = fit.estimates.iter_mut().filter(|e| e.coefficient == anew.coefficient);
            of_it.for_each(|e| (e.low, e.high, e.determined) = (anew.low, anew.high, anew.determined));
        }
    }
    for e in fit.estimates.iter_mut().filter(|e| known.contains(&e.coefficient)) {
        e.value = *e.coefficient.of(&mut fit.model);
        e.low = e.low.map(|low| low.min(e.value));
        e.high = e.high.map(|high| high.max(e.value));
    }
}

/// Places of the trials that have hardly any say.
fn missed(weights: &[[f64; SEEN]]) -> Vec<usize> {
    (0..weights.len()).filter(|i| misses(weights, *i)).collect()
}

/// Whether trial `i` has less than a tenth of the say that others have, in half of the signals.
fn misses(weights: &[[f64; SEEN]], i: usize) -> bool {
    let largest: [f64; SEEN] = std::array::from_fn(|k| weights.iter().map(|w| w[k]).fold(0.0, f64::max));
    let known = (0..SEEN).filter(|k| weights[i][*k].is_finite());
    let far = known.clone().filter(|k| weights[i][*k] < 0.1 * largest[*k]).count();
    2 * far > known.count()
}

/// The likelihood with the error of each signal in each trial unknown, as a cost.
fn cost(problem: &Problem<'_>, at: &DVector<f64>) -> f64 {
    let model = problem.model(at);
    let each = |w: &&Windowed| mean_squares(&w.plain_residual(problem.offsets, &model));
    let each: Vec<Seen> = problem.trials.par_iter().map(each).collect();
    let squares = each.into_iter().flat_map(|s| s.into_iter().enumerate());
    squares.filter(|(_, s)| s.is_finite()).map(|(k, s)| (s + resolution(k).powi(2)).ln()).sum()
}

/// Starts from a coarse grid: the cost has plateaus (contacts that never slide) and, where
/// rolling or sliding is a question of yes or no, steps; a derivative says nothing there.
/// The best with what is found beside friction as expected, and the best where one of that is a standard deviation away, if
/// it is better: with a plate that is too stiff or hollow friction makes up for it, and what is missed then has no say.
fn starts(problem: &Problem<'_>) -> Vec<DVector<f64>> {
    const GRID: [f64; 9] = [0.05, 0.1, 0.17, 0.25, 0.35, 0.5, 0.8, 1.4, 2.5];
    const ROUGH: [f64; 4] = [0.1, 0.2, 0.35, 0.7];
    let n = problem.free.len();
    let best_of = |grid: &[f64], beside: &dyn Fn(usize) -> f64, best: &mut (f64, DVector<f64>)| {
        for code in 0..grid.len().pow(n as u32) {
            let value = |k: usize| grid[code / grid.len().pow(k as u32) % grid.len()].ln();
            let at = DVector::from_fn(problem.at.len(), |k, _| if k < n { value(k) } else { beside(k) });
            let cost = cost(problem, &at);
            if cost < best.0 {
                *best = (cost, at);
            }
        }
    };
    let mut expected = (cost(problem, &problem.at), problem.at.clone());
    best_of(&GRID, &|k| problem.at[k], &mut expected);
    let mut away = expected.clone();
    for moved in n..problem.at.len() {
        for by in [-1.0, 1.0] {
            best_of(&ROUGH, &|k| problem.at[k] + if k == moved { by } else { 0.0 }, &mut away);
        }
    }
    let mut starts = vec![expected.1];
    if away.0 < expected.0 {
        starts.push(away.1);
    }
    starts
}
