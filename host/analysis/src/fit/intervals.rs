//! Covariance and intervals of fitted parameters. Both take whole conditions as the unit, so that
//! they stay honest where the model is wrong.

use nalgebra::{DMatrix, DVector};
use rand::{Rng, SeedableRng};
use rand_distr::StandardNormal;
use schemars::JsonSchema;
use serde::Serialize;

use crate::channels::COUNT;
use crate::evidence::draws::{self, RANGE};
use crate::fit::engine::Solution;
use crate::fit::features::Features;
use crate::fit::free::Free;
use crate::fit::gls::{self, Gram, Prior};
use crate::fit::noise;
use crate::fit::phases::BINS;
use crate::fit::problem::{Problem, take_off};

/// One fitted parameter.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Estimate {
    /// Owner and parameter, as in model files: `friction.finger`, `grip_force_loss.fraction`.
    pub name: String,
    /// Best value.
    pub value: f64,
    /// Lower end of the 95 % interval; `null` where the data do not bound it.
    #[schemars(with = "Option<f64>")]
    pub low: f64,
    /// Upper end; `null` where the data do not bound it.
    #[schemars(with = "Option<f64>")]
    pub high: f64,
    /// Unit.
    pub unit: &'static str,
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

/// 95 % interval of each coefficient's deviation from the best one, by resampling whole conditions, and what was known before
/// with them: a coefficient that the data do not see has the interval of its prior.
pub fn resample(grams: &[Gram], prior: &Prior, n: usize, (resamples, seed): (usize, u64)) -> Vec<[f64; 2]> {
    let conditions = grams.iter().map(|g| g.condition + 1).max().unwrap_or(0);
    if resamples < 20 || conditions < 3 {
        return Vec::new();
    }
    let Some(best) = gls::solve(grams.iter().map(|g| (1.0, g)), prior) else { return Vec::new() };
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut draws: Vec<Vec<f64>> = vec![Vec::with_capacity(resamples); n];
    for _ in 0..resamples {
        let mut weight = vec![0.0; conditions];
        for _ in 0..conditions {
            weight[rng.random_range(0..conditions)] += 1.0;
        }
        let known = |(precision, bound): (&f64, &f64)| match *precision > 0.0 {
            true => (rng.sample::<f64, _>(StandardNormal) / precision.sqrt()).clamp(-bound, *bound),
            false => 0.0,
        };
        let towards: Vec<f64> = prior.precision.iter().zip(&prior.bound).map(known).collect();
        let weighted = grams.iter().map(|g| (weight[g.condition], g));
        if let Some(x) = gls::solve_towards(weighted, prior, &towards) {
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

/// Costs at one value of a scan: what a prior costs, and the loss of each condition in each channel.
struct Costs {
    prior: f64,
    conditions: Vec<[f64; COUNT]>,
}

impl Costs {
    /// Losses of the conditions, each channel with its weight.
    fn losses(&self, weights: &[f64]) -> impl Iterator<Item = f64> {
        self.conditions.iter().map(move |of| of.iter().zip(weights).map(|(loss, weight)| loss * weight).sum())
    }
}

/// 95 % interval of the friction coefficient at place `k` of `free`, which ended in `solution`, as [`draws`] says: about an edge at
/// which a contact begins to slide the loss rises to one side only, and no quadratic says how far the other may be. All other
/// parameters and the sensors' errors follow to first order. Not a number on a side without a bound.
pub fn of_friction(problem: &Problem, solution: &Solution, free: &[Free], k: usize) -> [f64; 2] {
    let best = free[k].get(&solution.model).clamp(RANGE[0], RANGE[1]).ln();
    let scan = draws::scan(best);
    let models: Vec<_> = scan
        .iter()
        .map(|x| {
            let mut model = solution.model.clone();
            free[k].set(&mut model, x.exp());
            model
        })
        .collect();
    let predicted = problem.predict_each(&models);
    let costs: Vec<Costs> = predicted.iter().map(|p| following(problem, solution, free, k, p)).collect();
    let cost = |at: &Costs, draw: &draws::Draw| -> f64 {
        let weighted = at.losses(&draw.signal).zip(&draw.condition).map(|(loss, weight)| loss * weight);
        at.prior + weighted.sum::<f64>()
    };
    let set =
        |draw: &draws::Draw| draws::fitting(&costs.iter().map(|at| cost(at, draw)).collect::<Vec<f64>>());
    let sets: Vec<(usize, usize)> =
        draws::draws(problem.campaign.conditions, COUNT).iter().filter_map(set).collect();
    let by_condition: Vec<Vec<f64>> = costs.iter().map(|at| at.losses(&[1.0; COUNT]).collect()).collect();
    draws::ends(&scan, best, &sets, &by_condition).logs.map(|end| end.map_or(f64::NAN, f64::exp))
}

/// Costs of what is `predicted` with another value of parameter `k`, the others where they fit best beside it.
fn following(
    problem: &Problem,
    solution: &Solution,
    free: &[Free],
    k: usize,
    predicted: &[Features],
) -> Costs {
    let others: Vec<Free> = free.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, f)| *f).collect();
    let columns: Vec<_> =
        solution.columns.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, c)| c.clone()).collect();
    let residual = problem.residual(predicted);
    let grams = problem.grams(&residual, &columns);
    let prior = problem.priors(&others, 0);
    let home: Vec<f64> = others
        .iter()
        .map(|f| problem.prior(f).map_or(0.0, |(mean, _)| mean - f.get(&solution.model)))
        .collect();
    let towards = gls::solve_towards(grams.iter().map(|g| (1.0, g)), &prior, &home);
    let x = towards.unwrap_or_else(|| DVector::zeros(prior.len()));
    let n = others.len();
    let moved: Vec<f64> = others
        .iter()
        .zip(x.iter())
        .map(|(f, x)| {
            let (value, (low, high)) = (f.get(&solution.model), problem.bounds(f));
            (value + f.limited(&solution.model, *x)).clamp(low, high) - value
        })
        .collect();
    let mut left = problem.without_offsets(&residual, &x.as_slice()[n..]);
    for (i, left) in left.iter_mut().enumerate() {
        take_off(left, &columns, i, &moved);
    }
    let mut conditions = vec![[0.0; COUNT]; problem.campaign.conditions];
    for (g, left) in problem.groups.iter().zip(&left) {
        let whitener = &problem.whiteners[*g];
        let out = &mut conditions[problem.campaign.groups[*g].condition];
        for (feature, x) in whitener.active.iter().zip(whitener.apply(left).iter()) {
            out[feature / BINS] += x * x;
        }
    }
    let cost = |((x, home), precision): ((&f64, &f64), &f64)| precision * (x - home).powi(2);
    Costs { prior: moved.iter().zip(&home).zip(&prior.precision).map(cost).sum(), conditions }
}

/// Correlation beyond which only a combination of two parameters is determined.
const COMBINED: f64 = 0.97;

/// The correlation of two parameters of which only a combination is determined; `None` of two that the data separate.
pub fn combined(variance: [f64; 2], covariance: f64) -> Option<f64> {
    let r = covariance / (variance[0] * variance[1]).sqrt();
    (r.abs() > COMBINED).then_some(r)
}

/// What the data do not determine or separate, in words.
pub fn notes(estimates: &[Estimate], covariance: &DMatrix<f64>, free: &[Free]) -> Vec<String> {
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
            if let Some(r) = combined([covariance[(k, k)], covariance[(j, j)]], covariance[(k, j)]) {
                out.push(format!(
                    "these data do not separate {} and {} (correlation {r:.3}): only a combination of them is determined",
                    estimates[j].name, e.name
                ));
            }
        }
    }
    out
}
