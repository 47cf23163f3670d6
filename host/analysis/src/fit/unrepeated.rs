//! What chance does where no condition was repeated: taken from what the model leaves.
//!
//! A run's residual is `B c + e`: known directions `B` (relative friction of each contact, and how the run
//! started, see [`crate::fit::placing`] and [`crate::fit::carried`]) with coefficients `c` of zero mean, and independent noise `e` of its
//! own size for each feature, with the heavy tails of Student's t from run to run. Sizes are those of greatest
//! likelihood over the runs (expectation and maximisation, Dempster, Laird and Rubin 1977; Lange, Little and
//! Taylor 1989). What the model misses is in them: noise is an upper bound,
//! shrinks when the model gets better, and can show that one model predicts better than another, never that
//! a model lacks nothing.

use nalgebra::{DMatrix, DVector};

use crate::fit::features::{FEATURES, Features};
use crate::fit::noise::{DEFAULT_FRICTION, Drift, Noise, pooled};

/// Fewest runs from which the noise is taken.
pub const FEWEST: usize = 12;
/// Rounds of the estimate; it gains less than a per cent a round after ten.
const ROUNDS: usize = 15;
/// Degrees of freedom of Student's t: the usual choice where it cannot be told (Lange, Little and Taylor). Doubled: a
/// push that slipped off counts twice as much. Halved: half of the runs hardly count.
const TAILS: f64 = 4.0;
/// Friction that differs by more from run to run is no friction coefficient (relative).
const MOST_FRICTION: f64 = 0.5;

/// A direction in which runs differ.
struct Direction<'a> {
    /// Of one run, for a coefficient of one.
    features: &'a Features,
    /// Standard deviation of the coefficient: at the start, or for good.
    sd: f64,
    /// Whether the runs tell it.
    estimated: bool,
}

/// The noise that the `residuals` of the runs leave room for, beside the `floor`. `friction` are each run's
/// sensitivities to the relative change of finger, pusher and support friction, `at_start` its directions of
/// one standard deviation of where the object was placed and of what the fingers carry.
#[must_use]
pub fn estimate(
    residuals: &[Features],
    friction: &[[Features; 3]],
    at_start: &[Vec<Features>],
    floor: &Features,
) -> Noise {
    let directions: Vec<Vec<Direction<'_>>> = friction
        .iter()
        .zip(at_start)
        .map(|(friction, at_start)| {
            let of_friction = friction.iter().map(|f| (f, DEFAULT_FRICTION, true));
            let of_start = at_start.iter().map(|f| (f, 1.0, false));
            let direction = |(features, sd, estimated)| Direction { features, sd, estimated };
            of_friction.chain(of_start).map(direction).collect()
        })
        .collect();
    let (spread, sd, weights) = from_misfit(residuals, &directions, floor);
    let of = |k: usize| sd.get(k).map_or(DEFAULT_FRICTION, |sd| sd.min(MOST_FRICTION));
    Noise {
        spread,
        floor: floor.clone(),
        directions: Vec::new(),
        friction: [of(0), of(1), of(2)],
        freedom: 0,
        drift: Drift::default(),
        of_misfit: Some(weights),
    }
}

/// Noise of each feature, the standard deviation of the coefficients of the `directions` (those that all runs have first),
/// and the runs' weights, from the `residuals` of the runs. Noise is at least a twentieth of the `floor`.
fn from_misfit(
    residuals: &[Features],
    directions: &[Vec<Direction<'_>>],
    floor: &Features,
) -> (Features, Vec<f64>, Vec<f64>) {
    let n = residuals.len();
    let mut spread = pooled(residuals, n, floor);
    let most: &[Direction<'_>] = directions.iter().max_by_key(|of| of.len()).map_or(&[], |of| of);
    let mut sd: Vec<f64> = most.iter().map(|d| d.sd).collect();
    let mut weights = vec![1.0; n];
    for _ in 0..ROUNDS {
        let mut left: Vec<Features> = Vec::with_capacity(n);
        let mut squares = vec![0.0; sd.len()];
        for ((residual, directions), weight) in residuals.iter().zip(directions).zip(&mut weights) {
            let seen: Vec<usize> = (0..FEATURES).filter(|f| residual[*f].is_finite()).collect();
            let scale = |f: usize| 1.0 / spread[f];
            let b = DMatrix::from_fn(seen.len(), sd.len(), |i, k| {
                let x = directions.get(k).map_or(0.0, |d| d.features[seen[i]]);
                if x.is_finite() { x * scale(seen[i]) } else { 0.0 }
            });
            let d = DVector::from_iterator(seen.len(), seen.iter().map(|f| residual[*f] * scale(*f)));
            let mut a = b.transpose() * &b;
            for (k, sd) in sd.iter().enumerate() {
                a[(k, k)] += 1.0 / (sd * sd).max(1e-12);
            }
            let Some(v) = a.cholesky().map(|c| c.inverse()) else { continue };
            let c = &v * (b.transpose() * &d);
            let rest = &d - &b * &c;
            // What the directions take counts by their own size.
            let distance2 = d.dot(&rest);
            *weight = (TAILS + seen.len() as f64) / (TAILS + distance2);
            let mut out = vec![f64::NAN; FEATURES];
            for (i, f) in seen.iter().enumerate() {
                let row = b.row(i);
                let unsure = (row * &v * row.transpose())[(0, 0)];
                out[*f] = (*weight * rest[i] * rest[i] + unsure).sqrt() / scale(*f);
            }
            left.push(out);
            for (k, s) in squares.iter_mut().enumerate() {
                *s += *weight * c[k] * c[k] + v[(k, k)];
            }
        }
        spread = pooled(&left, n, floor);
        for (k, sd) in sd.iter_mut().enumerate() {
            if most.get(k).is_some_and(|d| d.estimated) {
                *sd = (squares[k] / n as f64).sqrt();
            }
        }
    }
    (spread, sd, weights)
}

/// Logarithm of the density, but for a constant, of a run with `features` of them whose whitened misfit
/// has the square `loss`, whitening included its `weight`; `log_determinant` is that of the same whitening.
#[must_use]
pub fn log_density(loss: f64, features: usize, weight: f64, log_determinant: f64) -> f64 {
    let m = features as f64;
    let volume = log_determinant - 0.5 * m * weight.ln();
    volume - 0.5 * (TAILS + m) * (loss / weight / TAILS).ln_1p()
}
