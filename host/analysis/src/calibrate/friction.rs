//! Friction coefficients by nonlinear least squares over the model.
//!
//! Unknown are the logarithms of the coefficients (positive, relative steps). The start is
//! the best point of a coarse grid, the solver Levenberg-Marquardt (the crate
//! `levenberg-marquardt`, after MINPACK). Every signal is weighed by the error that is left
//! in it, found anew after each of a few solves: what the model cannot reproduce whatever
//! its friction (a yaw from a defect that it does not know) has little say, and a single
//! trial that it misses altogether, because the grip was lost there, has hardly any
//! (weights of Cauchy's loss, Holland and Welsch 1977).

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use rayon::prelude::*;
use serde::Serialize;
use stickslip_shared::model::Model;

use super::intervals;
use super::windows::{SEEN, Seen, Windowed, resolution};
use crate::channels::COUNT;

/// Which coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coefficient {
    /// Both fingers.
    Finger,
    /// Pusher or edge.
    Pusher,
    /// Table or platform.
    Support,
}

impl Coefficient {
    /// Its place in a model.
    pub fn of(self, model: &mut Model<f64>) -> &mut f64 {
        match self {
            Self::Finger => &mut model.friction.finger,
            Self::Pusher => &mut model.friction.pusher,
            Self::Support => &mut model.friction.support,
        }
    }
}

/// What is known about a coefficient.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// Which.
    pub coefficient: Coefficient,
    /// Value in the calibrated model. Where `determined` is false, only its bounds mean anything.
    pub value: f64,
    /// Lower end of the 95 % interval (`None`: no bound on that side).
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// Whether the data determine it: bounds on both sides, closer than a factor of 1.65.
    pub determined: bool,
}

/// Result of [`fit`].
pub struct Fit {
    /// Base with the new coefficients.
    pub model: Model<f64>,
    /// One for each coefficient that the scene has.
    pub estimates: Vec<Estimate>,
    /// Places of trials that the calibrated model misses altogether.
    pub missed: Vec<usize>,
}

/// Coefficients beyond these are not believed.
pub const RANGE: [f64; 2] = [0.02, 5.0];
/// Relative step of the difference quotients: above the kinks of stick and slip.
pub const STEP: f64 = 0.01;
/// Solves, each with the weights that the last one left.
const ROUNDS: usize = 4;
/// Square of the error, in units of the usual one, at which a trial's say is halved.
const FAR: f64 = 9.0;

/// A least squares problem with fixed weights.
pub struct Problem<'a> {
    /// Calibration trials.
    pub trials: &'a [&'a Windowed],
    /// Unknown coefficients.
    pub free: Vec<Coefficient>,
    /// Their logarithms.
    pub at: DVector<f64>,
    /// Weight of each signal in each trial: one over its squared scale.
    pub weights: Vec<[f64; SEEN]>,
    offsets: &'a [f64; COUNT],
    base: &'a Model<f64>,
}

impl Problem<'_> {
    /// The base with the coefficients at the logarithms `at`.
    pub fn model(&self, at: &DVector<f64>) -> Model<f64> {
        let mut model = self.base.clone();
        for (c, x) in self.free.iter().zip(at.iter()) {
            *c.of(&mut model) = x.exp().clamp(RANGE[0], RANGE[1]);
        }
        model
    }

    /// Residuals of each trial, not weighted.
    pub fn residuals_at(&self, at: &DVector<f64>) -> Vec<Vec<Seen>> {
        let model = self.model(at);
        self.trials.par_iter().map(|w| w.residual(self.offsets, &model)).collect()
    }

    fn weighted(&self, at: &DVector<f64>) -> DVector<f64> {
        let each = self.residuals_at(at);
        let values = each.iter().zip(&self.weights).flat_map(|(rows, weights)| {
            rows.iter().flat_map(move |row| {
                row.iter().zip(weights).map(|(r, w)| if r.is_finite() { r * w.sqrt() } else { 0.0 })
            })
        });
        DVector::from_vec(values.collect())
    }

    /// Weights from the residuals at the present coefficients.
    fn weigh(&mut self) {
        let squares: Vec<Seen> = self.residuals_at(&self.at).iter().map(|r| mean_squares(r)).collect();
        let usual: Seen = std::array::from_fn(|k| {
            let mut known: Vec<f64> = squares.iter().map(|s| s[k]).filter(|s| s.is_finite()).collect();
            known.sort_by(f64::total_cmp);
            let median = known.get(known.len() / 2).copied().unwrap_or(0.0);
            median.max(resolution(k).powi(2))
        });
        let weight =
            |s: &Seen| std::array::from_fn(|k| 1.0 / (usual[k] * (1.0 + s[k].max(0.0) / (FAR * usual[k]))));
        self.weights = squares.iter().map(weight).collect();
    }
}

/// Mean square of each signal over the windows; NaN where it was not measured.
fn mean_squares(rows: &[Seen]) -> Seen {
    std::array::from_fn(|k| {
        let known = rows.iter().map(|r| r[k]).filter(|x| x.is_finite());
        let (sum, count) = known.fold((0.0, 0.0), |(s, n), x| (s + x * x, n + 1.0));
        sum / count
    })
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.at = x.clone();
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.weighted(&self.at))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns: Vec<DVector<f64>> = (0..self.free.len())
            .map(|k| {
                let moved = |by: f64| {
                    let mut x = self.at.clone();
                    x[k] += by;
                    self.weighted(&x)
                };
                (moved(STEP) - moved(-STEP)) / (2.0 * STEP)
            })
            .collect();
        Some(DMatrix::from_columns(&columns))
    }
}

/// Finds the coefficients of all contacts that the trials' scenes have.
pub fn fit(trials: &[&Windowed], offsets: &[f64; COUNT], base: &Model<f64>) -> Fit {
    let has = |f: &dyn Fn(&Windowed) -> bool| trials.iter().any(|w| f(w));
    let mut free = Vec::new();
    if has(&|w| w.prepared.scene.fingers.is_some()) {
        free.push(Coefficient::Finger);
    }
    if has(&|w| w.prepared.scene.pusher.is_some() && !on_platform(w)) {
        free.push(Coefficient::Pusher);
    }
    if has(&|w| w.prepared.scene.support.is_some() || on_platform(w)) {
        free.push(Coefficient::Support);
    }
    let mut start = base.clone();
    let at = DVector::from_iterator(free.len(), free.iter().map(|c| c.of(&mut start).max(RANGE[0]).ln()));
    let mut problem = Problem { trials, offsets, base, free, at, weights: vec![[1.0; SEEN]; trials.len()] };
    coarse(&mut problem);
    for _ in 0..ROUNDS {
        problem.weigh();
        let before = problem.at.clone();
        (problem, _) = LevenbergMarquardt::new().with_patience(30).minimize(problem);
        if (&problem.at - before).norm() < 1e-4 {
            break;
        }
    }
    problem.weigh();
    let estimates = intervals::estimates(&problem);
    let missed = (0..trials.len()).filter(|i| misses(&problem.weights, *i)).collect();
    Fit { model: problem.model(&problem.at), estimates, missed }
}

/// Whether trial `i` has less than a tenth of the say that others have, in half of the signals.
fn misses(weights: &[[f64; SEEN]], i: usize) -> bool {
    let largest: [f64; SEEN] = std::array::from_fn(|k| weights.iter().map(|w| w[k]).fold(0.0, f64::max));
    let known = (0..SEEN).filter(|k| weights[i][*k].is_finite());
    let far = known.clone().filter(|k| weights[i][*k] < 0.1 * largest[*k]).count();
    2 * far > known.count()
}

/// Whether the pusher is a plane under the object: it has the support's friction.
fn on_platform(w: &Windowed) -> bool {
    w.prepared.rests() && w.prepared.scene.support.is_none()
}

/// Start from a coarse grid: the cost has plateaus (contacts that never slide) and, where
/// rolling or sliding is a question of yes or no, steps; a derivative says nothing there.
/// The cost is the likelihood with the error of each signal in each trial unknown.
fn coarse(problem: &mut Problem<'_>) {
    const GRID: [f64; 9] = [0.05, 0.1, 0.17, 0.25, 0.35, 0.5, 0.8, 1.4, 2.5];
    let cost = |at: &DVector<f64>| -> f64 {
        let model = problem.model(at);
        let each = |w: &&Windowed| mean_squares(&w.plain_residual(problem.offsets, &model));
        let each: Vec<Seen> = problem.trials.par_iter().map(each).collect();
        let squares = each.into_iter().flat_map(|s| s.into_iter().enumerate());
        squares.filter(|(_, s)| s.is_finite()).map(|(k, s)| (s + resolution(k).powi(2)).ln()).sum()
    };
    let n = problem.free.len();
    let mut best = (cost(&problem.at), problem.at.clone());
    for code in 0..GRID.len().pow(n as u32) {
        let value = |k: usize| GRID[code / GRID.len().pow(k as u32) % GRID.len()].ln();
        let at = DVector::from_fn(n, |k, _| value(k));
        let cost = cost(&at);
        if cost < best.0 {
            best = (cost, at);
        }
    }
    problem.at = best.1;
}
