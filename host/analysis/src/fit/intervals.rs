//! Covariance and intervals of fitted parameters. Both take whole conditions as the unit, so that
//! they stay honest where the model is wrong.

use nalgebra::{DMatrix, DVector};
use rand::{Rng, SeedableRng};
use rand_distr::StandardNormal;
use schemars::JsonSchema;
use serde::Serialize;

use crate::fit::free::Free;
use crate::fit::gls::{self, Gram, Prior};
use crate::fit::noise;

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
