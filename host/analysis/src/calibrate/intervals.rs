//! Intervals of the coefficients by resampling, which needs no derivative and no noise model.
//!
//! What is drawn anew are the weights of whole conditions and of whole signals ([`draws`]). For each coefficient the cost is tabled
//! along a scan of values, by trial and signal, as a
//! quadratic in the other coefficients (which each draw thus profiles out).

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::problem::{Coefficient, Estimate, Nuisance, Problem};
use super::windows::{SEEN, Seen};
use crate::evidence::draws::{self, DRAWS, Draw, RANGE, tail};

/// Most that another coefficient's logarithm follows along a scan from its place.
const FOLLOWS: f64 = 0.5;
/// The same of what is found beside them, standard deviations.
const FOLLOWS_NUISANCE: f64 = 3.0;
/// Ratio of upper to lower end up to which a coefficient counts as determined.
const DETERMINED: f64 = 1.65;

/// Cost of one scan value, by trial and signal: `a + 2 b'd + d'C d` in the other
/// coefficients' departure d.
#[derive(Clone)]
struct Cell {
    a: f64,
    b: DVector<f64>,
    c: DMatrix<f64>,
}

impl Cell {
    /// The cost where the others depart by `d`.
    fn at(&self, d: &DVector<f64>) -> f64 {
        self.a + 2.0 * self.b.dot(d) + d.dot(&(&self.c * d))
    }
}

/// Estimates of the coefficients that are `wanted`, at the solution of `problem`.
pub fn estimates(problem: &Problem<'_>, wanted: impl Fn(Coefficient) -> bool) -> Vec<Estimate> {
    let groups = conditions(problem);
    let draws = draws::draws(groups.iter().max().map_or(0, |g| g + 1), SEEN);
    let wanted = (0..problem.free.len()).filter(|k| wanted(problem.free[*k]));
    wanted.map(|k| estimate(problem, &groups, &draws, k)).collect()
}

/// Number of the condition of each trial, without gaps.
fn conditions(problem: &Problem<'_>) -> Vec<usize> {
    let mut seen: Vec<usize> = Vec::new();
    let mut place = |condition| match seen.iter().position(|c| *c == condition) {
        Some(at) => at,
        None => {
            seen.push(condition);
            seen.len() - 1
        }
    };
    problem.trials.iter().map(|w| place(w.condition)).collect()
}

fn estimate(problem: &Problem<'_>, groups: &[usize], draws: &[Draw], k: usize) -> Estimate {
    let best = problem.at[k].clamp(RANGE[0].ln(), RANGE[1].ln());
    let scan = draws::scan(best);
    let others: Vec<usize> = (0..problem.at.len()).filter(|i| *i != k).collect();
    let at = |x: f64| {
        let mut at = problem.at.clone();
        at[k] = x;
        at
    };
    let tables: Vec<Vec<Vec<Cell>>> = scan.iter().map(|x| table(problem, &at(*x), &others)).collect();
    let known = Known::of(problem);
    let sets: Vec<(usize, usize)> =
        draws.par_iter().filter_map(|d| set(&tables, groups, &known, d)).collect();
    let clusters = groups.iter().max().map_or(1, |g| g + 1);
    let even = Draw::even(clusters, SEEN);
    let followed: Vec<(Cell, DVector<f64>)> =
        tables.iter().map(|trials| followed(trials, groups, &known, &even)).collect();
    let of_conditions = |(trials, (_, d)): (&Vec<Vec<Cell>>, &(Cell, DVector<f64>))| {
        let mut out = vec![0.0; clusters];
        for (cells, group) in trials.iter().zip(groups) {
            out[*group] += cells.iter().map(|cell| cell.at(d)).sum::<f64>();
        }
        out
    };
    let by_condition: Vec<Vec<f64>> = tables.iter().zip(&followed).map(of_conditions).collect();
    let ends = draws::ends(&scan, best, &sets, &by_condition);
    // On a plateau that has an end, the nearest value that fits as well: the least squares value runs off to the
    // edge of the range.
    let costs: Vec<f64> = followed.iter().map(|(total, d)| total.at(d)).collect();
    let plateau = draws::fitting(&costs);
    let value = match (ends.places, plateau) {
        ([Some(_), None], Some((first, _))) => scan[first].min(best),
        ([None, Some(_)], Some((_, last))) => scan[last].max(best),
        _ => best,
    };
    let value = value.exp();
    let [low, high] = ends.logs.map(|end| end.map(f64::exp));
    let determined = low.zip(high).is_some_and(|(low, high)| high / low < DETERMINED);
    Estimate { coefficient: problem.free[k], value, low, high, determined }
}

/// Costs at `at` where the unknowns `others` depart from it, by trial and signal.
fn table(problem: &Problem<'_>, at: &DVector<f64>, others: &[usize]) -> Vec<Vec<Cell>> {
    let here = problem.residuals_at(at);
    let moved: Vec<Vec<Vec<Seen>>> = others
        .iter()
        .map(|i| {
            let mut at = at.clone();
            at[*i] += problem.step(*i);
            problem.residuals_at(&at)
        })
        .collect();
    let n = others.len();
    let cell = |trial: usize, signal: usize| {
        let mut cell = Cell { a: 0.0, b: DVector::zeros(n), c: DMatrix::zeros(n, n) };
        let weight = problem.weights[trial][signal];
        for (row, r) in here[trial].iter().enumerate() {
            let r = r[signal];
            if !r.is_finite() {
                continue;
            }
            let slope =
                DVector::from_fn(n, |i, _| (moved[i][trial][row][signal] - r) / problem.step(others[i]));
            cell.a += weight * r * r;
            cell.b += &slope * (weight * r);
            cell.c += &slope * slope.transpose() * weight;
        }
        cell
    };
    (0..here.len()).map(|trial| (0..SEEN).map(|signal| cell(trial, signal)).collect()).collect()
}

/// 95 % intervals of the nuisance parameters at the solution of `problem`: what is expected of them is drawn with the weights of
/// conditions and signals, so that one which the data do not show has the interval that was expected. The costs are those about
/// the solution, quadratic.
pub fn of_nuisances(problem: &Problem<'_>) -> Vec<[f64; 2]> {
    let all: Vec<usize> = (0..problem.at.len()).collect();
    let first = problem.free.len();
    let (groups, tables) = (conditions(problem), table(problem, &problem.at, &all));
    let clusters = groups.iter().max().map_or(0, |g| g + 1);
    let departures = problem.departures(&problem.at);
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
    let mut ends = vec![Vec::with_capacity(DRAWS); departures.len()];
    for draw in draws::draws(clusters, SEEN) {
        let of = |k: usize, ahead: f64| if k < first { 0.0 } else { departures[k - first] - ahead };
        let expected: Vec<f64> = all.iter().map(|_| StandardNormal.sample(&mut rng)).collect();
        let mut total = Cell {
            a: 0.0,
            b: DVector::from_fn(all.len(), |k, _| of(k, expected[k])),
            c: precision(all.len(), first),
        };
        add(&mut total, &tables, &groups, &draw);
        let Some(c) = total.c.cholesky() else { continue };
        let moved = -c.solve(&total.b);
        for (k, ends) in ends.iter_mut().enumerate() {
            ends.push(departures[k] + moved[first + k].clamp(-FOLLOWS_NUISANCE, FOLLOWS_NUISANCE));
        }
    }
    let tail = tail(clusters.max(1) as f64);
    let of_nuisance = |((nuisance, mut ends), here): ((&Nuisance, Vec<f64>), &f64)| {
        ends.push(*here);
        ends.sort_by(f64::total_cmp);
        let end = |share: f64| ends[(share * (ends.len() - 1) as f64).round() as usize];
        [end(tail).min(*here), end(1.0 - tail).max(*here)].map(|departure| nuisance.value(departure))
    };
    problem.unknown.nuisances.iter().zip(ends).zip(departures).map(of_nuisance).collect()
}

/// What is known beforehand of the unknowns beside the one that is scanned: the last of them depart from what is expected.
struct Known {
    before: Cell,
    follows: DVector<f64>,
}

impl Known {
    fn of(problem: &Problem<'_>) -> Self {
        let departures = problem.departures(&problem.at);
        let n = problem.at.len() - 1;
        let first = n - departures.len();
        let x = DVector::from_fn(n, |i, _| if i < first { 0.0 } else { departures[i - first] });
        let follows = DVector::from_fn(n, |i, _| if i < first { FOLLOWS } else { FOLLOWS_NUISANCE });
        Self { before: Cell { a: x.norm_squared(), b: x, c: precision(n, first) }, follows }
    }
}

/// How well `n` unknowns are known beforehand: those from `first` on, in standard deviations.
fn precision(n: usize, first: usize) -> DMatrix<f64> {
    DMatrix::from_diagonal(&DVector::from_fn(n, |i, _| if i < first { 1e-9 } else { 1.0 }))
}

/// Adds what the `trials` cost in one draw.
fn add(total: &mut Cell, trials: &[Vec<Cell>], groups: &[usize], draw: &Draw) {
    for (cells, group) in trials.iter().zip(groups) {
        for (cell, signal) in cells.iter().zip(&draw.signal) {
            let weight = draw.condition[*group] * signal;
            if weight > 0.0 {
                total.a += weight * cell.a;
                total.b += &cell.b * weight;
                total.c += &cell.c * weight;
            }
        }
    }
}

/// First and last place of the scan whose cost is that of the best one, for one draw.
fn set(tables: &[Vec<Vec<Cell>>], groups: &[usize], known: &Known, draw: &Draw) -> Option<(usize, usize)> {
    let cost = |trials: &Vec<Vec<Cell>>| {
        let (total, d) = followed(trials, groups, known, draw);
        total.at(&d)
    };
    draws::fitting(&tables.iter().map(cost).collect::<Vec<f64>>())
}

/// What the `trials` cost in one draw, and the departures of the other unknowns that make it least.
fn followed(trials: &[Vec<Cell>], groups: &[usize], known: &Known, draw: &Draw) -> (Cell, DVector<f64>) {
    let mut total = known.before.clone();
    add(&mut total, trials, groups, draw);
    let follow = total.c.clone().cholesky().map(|c| -c.solve(&total.b));
    let d = follow.unwrap_or_else(|| DVector::zeros(known.follows.len()));
    let d = d.zip_map(&known.follows, |x, most| x.clamp(-most, most));
    (total, d)
}
