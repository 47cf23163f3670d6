//! Friction coefficients by nonlinear least squares over the model.
//!
//! Unknown are the logarithms of the coefficients (positive, relative steps). The start is
//! the best point of a coarse grid, the solver Levenberg-Marquardt (the crate
//! `levenberg-marquardt`, after MINPACK). Intervals take the trial as the unit of
//! independence: the sandwich covariance of the estimate, clustered by trial (Liang and
//! Zeger 1986), since friction varies from run to run and residuals within a run do not
//! average out.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use rayon::prelude::*;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};
use stickslip_shared::model::{Model, PusherContact};

use super::residual;
use super::windows::Windowed;
use crate::channels::COUNT;

/// Which coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coefficient {
    /// Both fingers.
    Finger,
    /// Pusher, edge or platform.
    Pusher,
    /// Table.
    Support,
}

impl Coefficient {
    fn of(self, model: &mut Model<f64>) -> &mut f64 {
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
    /// 95 % interval where determined; otherwise the range that fits the data equally well
    /// (`None`: no bound on that side).
    pub low: Option<f64>,
    /// See `low`.
    pub high: Option<f64>,
    /// Whether the data determine it.
    pub determined: bool,
}

/// Result of [`fit`].
pub struct Fit {
    /// Base with the new coefficients.
    pub model: Model<f64>,
    /// One for each coefficient that the scene has.
    pub estimates: Vec<Estimate>,
}

/// Coefficients beyond these are not believed.
const RANGE: [f64; 2] = [0.02, 5.0];
/// Standard error of the logarithm beyond which a coefficient is not determined.
const VAGUE: f64 = 0.25;
/// Relative step of the difference quotients: above the kinks of stick and slip.
const STEP: f64 = 0.01;

struct Problem<'a> {
    trials: &'a [&'a Windowed],
    offsets: &'a [f64; COUNT],
    scale: &'a [f64; COUNT],
    base: &'a Model<f64>,
    free: Vec<Coefficient>,
    at: DVector<f64>,
}

impl Problem<'_> {
    fn model(&self, at: &DVector<f64>) -> Model<f64> {
        let mut model = self.base.clone();
        for (c, x) in self.free.iter().zip(at.iter()) {
            *c.of(&mut model) = x.exp().clamp(RANGE[0], RANGE[1]);
        }
        model
    }

    /// Residuals of each trial.
    fn each(&self, at: &DVector<f64>) -> Vec<DVector<f64>> {
        let model = self.model(at);
        self.trials.par_iter().map(|w| residual(w, self.offsets, self.scale, &model)).collect()
    }

    fn cost(&self, at: &DVector<f64>) -> f64 {
        self.each(at).iter().map(DVector::norm_squared).sum()
    }

    /// Derivatives of each trial's residuals.
    fn slopes(&self, at: &DVector<f64>) -> Vec<DMatrix<f64>> {
        let columns: Vec<Vec<DVector<f64>>> = (0..self.free.len())
            .map(|k| {
                let moved = |by: f64| {
                    let mut x = at.clone();
                    x[k] += by;
                    self.each(&x)
                };
                let (up, down) = (moved(STEP), moved(-STEP));
                up.into_iter().zip(down).map(|(u, d)| (u - d) / (2.0 * STEP)).collect()
            })
            .collect();
        (0..self.trials.len())
            .map(|i| DMatrix::from_columns(&columns.iter().map(|c| c[i].clone()).collect::<Vec<_>>()))
            .collect()
    }
}

fn stacked(parts: &[DVector<f64>]) -> DVector<f64> {
    DVector::from_iterator(parts.iter().map(DVector::len).sum(), parts.iter().flat_map(|p| p.iter().copied()))
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
        Some(stacked(&self.each(&self.at)))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let parts = self.slopes(&self.at);
        let rows = parts.iter().map(DMatrix::nrows).sum();
        let mut out = DMatrix::zeros(rows, self.free.len());
        let mut at = 0;
        for p in &parts {
            out.rows_mut(at, p.nrows()).copy_from(p);
            at += p.nrows();
        }
        Some(out)
    }
}

/// Finds the coefficients of all contacts that the trials' scenes have.
pub fn fit(trials: &[&Windowed], offsets: &[f64; COUNT], scale: &[f64; COUNT], base: &Model<f64>) -> Fit {
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
    let mut problem = Problem { trials, offsets, scale, base, free, at };
    coarse(&mut problem);
    let (problem, _) = LevenbergMarquardt::new().with_patience(30).minimize(problem);
    let estimates = judge(&problem);
    Fit { model: problem.model(&problem.at), estimates }
}

/// Whether the pusher is a plane under the object: it has the support's friction.
fn on_platform(w: &Windowed) -> bool {
    let normal = |p: &stickslip_shared::track::Poses<f64>| {
        p.pusher.map(|p| p.rotation.transform_vector(&nalgebra::Vector3::x()))
    };
    let down = nalgebra::Vector3::from(w.prepared.scene.gravity_m_s2);
    matches!(w.prepared.scene.pusher, Some(PusherContact::Plane))
        && w.prepared.poses().first().and_then(normal).is_some_and(|n| n.dot(&down) < -0.7 * down.norm())
}

/// Start from a coarse grid: the cost has plateaus (contacts that never slide) and, where
/// rolling or sliding is a question of yes or no, steps; a derivative says nothing there.
fn coarse(problem: &mut Problem<'_>) {
    const GRID: [f64; 9] = [0.05, 0.1, 0.17, 0.25, 0.35, 0.5, 0.8, 1.4, 2.5];
    let n = problem.free.len();
    let mut best = problem.cost(&problem.at);
    for code in 0..GRID.len().pow(n as u32) {
        let value = |k: usize| GRID[code / GRID.len().pow(k as u32) % GRID.len()].ln();
        let at = DVector::from_fn(n, |k, _| value(k));
        let cost = problem.cost(&at);
        if cost < best {
            best = cost;
            problem.at = at;
        }
    }
}

/// Intervals, or bounds where the data do not determine a coefficient.
fn judge(problem: &Problem<'_>) -> Vec<Estimate> {
    let n = problem.free.len();
    let (parts, slopes) = (problem.each(&problem.at), problem.slopes(&problem.at));
    let mut normal = DMatrix::<f64>::zeros(n, n);
    let mut between = DMatrix::<f64>::zeros(n, n);
    for (r, j) in parts.iter().zip(&slopes) {
        normal += j.transpose() * j;
        let g = j.transpose() * r;
        between += &g * g.transpose();
    }
    let clusters = problem.trials.len() as f64;
    let quantile = StudentsT::new(0.0, 1.0, (clusters - 1.0).max(1.0)).map_or(2.0, |t| t.inverse_cdf(0.975));
    // Clusters are few: the usual correction.
    between *= clusters / (clusters - n as f64).max(1.0);
    let rows: usize = parts.iter().filter(|p| p.norm() > 0.0).map(DVector::len).sum();
    let cost: f64 = parts.iter().map(DVector::norm_squared).sum();
    let variance = cost / (rows.max(2) - 1) as f64;
    let inverse = normal.clone().try_inverse();
    (0..n)
        .map(|k| {
            let coefficient = problem.free[k];
            let value = problem.at[k].exp().clamp(RANGE[0], RANGE[1]);
            let error = inverse.as_ref().map(|h| {
                let sandwich = (h * &between * h)[(k, k)].max(0.0);
                let plain = (h[(k, k)] * variance).max(0.0);
                sandwich.max(plain).sqrt()
            });
            let inside = value > RANGE[0] * 1.01 && value < RANGE[1] * 0.99;
            match error.filter(|e| inside && normal[(k, k)] > 1e-9 && *e < VAGUE && e.is_finite()) {
                Some(e) => Estimate {
                    coefficient,
                    value,
                    low: Some(value * (-quantile * e).exp()),
                    high: Some(value * (quantile * e).exp()),
                    determined: true,
                },
                None => bounds(problem, k, cost, variance),
            }
        })
        .collect()
}

/// The range of a coefficient over which the cost does not rise, the others held.
fn bounds(problem: &Problem<'_>, k: usize, cost: f64, variance: f64) -> Estimate {
    // A rise by twenty variances is beyond what chance does to one coefficient.
    let allowed = cost * 1.01 + 20.0 * variance;
    let value = problem.at[k].exp().clamp(RANGE[0], RANGE[1]);
    let scan = |factor: f64| {
        let mut x = value;
        let mut held = value;
        loop {
            x *= factor;
            if !(RANGE[0]..=RANGE[1]).contains(&x) {
                return None;
            }
            let mut at = problem.at.clone();
            at[k] = x.ln();
            if problem.cost(&at) > allowed {
                return Some(held);
            }
            held = x;
        }
    };
    let (low, high) = (scan(1.0 / 1.03), scan(1.03));
    // A cost with steps has no useful derivative, but may still have narrow walls.
    let determined = low.zip(high).is_some_and(|(low, high)| high / low < (2.0 * VAGUE).exp());
    Estimate { coefficient: problem.free[k], value, low, high, determined }
}
