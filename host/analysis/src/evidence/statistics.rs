//! Tests: lack of fit against pure error, regression, and the correction for many looks.

use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};

/// Lack of fit of run means against the scatter of repetitions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LackOfFit {
    /// Mean square of the conditions' mean errors over that of the repetitions.
    pub f: f64,
    /// Degrees of freedom of the numerator.
    pub of_fit: f64,
    /// Degrees of freedom of the denominator.
    pub of_error: f64,
    /// Chance of a ratio as large where the model is right.
    pub p: f64,
    /// Standard deviation of a run's mean error around that of its repetitions.
    pub pure_error: f64,
}

/// F test that the mean errors of all conditions are zero. `conditions` holds the mean
/// errors of the runs of each, `repeated` what repetitions say about chance (the same errors,
/// or the measurement itself), condition by condition.
///
/// Parameters fitted to the same runs would lower the numerator: the test then rejects
/// less often than stated, never more. Where conditions scatter unequally the degrees of
/// freedom are reduced after Box (1954); the variance of each group enters with its own
/// weight. `None` without two repetitions of any condition, or without scatter.
pub fn lack_of_fit(conditions: &[Vec<f64>], repeated: &[Vec<f64>]) -> Option<LackOfFit> {
    let mut count = 0.0;
    let (mut fit, mut error, mut degrees) = (0.0, 0.0, 0.0);
    // Sums of the variances and of their squares, weighted as they enter each mean square.
    let (mut v_fit, mut v2_fit, mut v_error, mut v2_error, mut groups) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (errors, runs) in conditions.iter().zip(repeated).filter(|(e, r)| !e.is_empty() && e.len() == r.len())
    {
        let n = runs.len() as f64;
        let mean_of = |x: &[f64]| x.iter().sum::<f64>() / n;
        let (mean, centre) = (mean_of(errors), mean_of(runs));
        let squares = runs.iter().map(|x| (x - centre) * (x - centre)).sum::<f64>();
        count += 1.0;
        fit += n * mean * mean;
        error += squares;
        degrees += n - 1.0;
        if runs.len() > 1 {
            let variance = squares / (n - 1.0);
            // Unbiased for the square of the variance of a normal distribution.
            let square = variance * variance * (n - 1.0) / (n + 1.0);
            groups += 1.0;
            v_fit += variance;
            v2_fit += square;
            v_error += (n - 1.0) * variance;
            v2_error += (n - 1.0) * square;
        }
    }
    if !(degrees > 0.0 && error > 0.0) {
        return None;
    }
    let pure = error / degrees;
    let of_fit = (v_fit * v_fit / v2_fit * count / groups).clamp(1.0, count);
    let of_error = (v_error * v_error / v2_error).clamp(1.0, degrees);
    let f = fit / count / pure;
    let p = FisherSnedecor::new(of_fit, of_error).map_or(f64::NAN, |d| d.sf(f));
    Some(LackOfFit { f, of_fit, of_error, p, pure_error: pure.sqrt() })
}

/// The F ratio that chance exceeds with probability `p`; `None` without degrees of freedom.
#[must_use]
pub fn critical_f(of_fit: f64, of_error: f64, p: f64) -> Option<f64> {
    FisherSnedecor::new(of_fit, of_error).ok().map(|d| d.inverse_cdf(1.0 - p))
}

/// A straight line through points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Change of y with x.
    pub slope: f64,
    /// y at x = 0.
    pub intercept: f64,
    /// Chance of a slope as large where there is none.
    pub p: f64,
}

/// Least squares line; `estimated` is the number of parameters that the points have lost
/// (2 for a line through points as they are). `None` with no more points than that, or no
/// spread in x.
pub fn regression(points: &[(f64, f64)], estimated: usize) -> Option<Line> {
    let n = points.len() as f64;
    let degrees = points.len().checked_sub(estimated).filter(|d| *d > 0)? as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in points {
        xx += (x - mx) * (x - mx);
        xy += (x - mx) * (y - my);
        yy += (y - my) * (y - my);
    }
    if !(xx > 1e-24 * (1.0 + mx * mx)) {
        return None;
    }
    let slope = xy / xx;
    let left = (yy - slope * xy).max(0.0) / degrees;
    let p = if left > 0.0 {
        let t = slope / (left / xx).sqrt();
        StudentsT::new(0.0, 1.0, degrees).map_or(f64::NAN, |d| 2.0 * d.sf(t.abs()))
    } else if slope == 0.0 {
        1.0
    } else {
        0.0
    };
    Some(Line { slope, intercept: my - slope * mx, p })
}

/// p values corrected for their number (Holm 1979); NaN stays NaN and is not counted.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).filter(|i| p[*i].is_finite()).collect();
    order.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    let mut out = vec![f64::NAN; p.len()];
    let mut running = 0.0f64;
    for (rank, i) in order.iter().enumerate() {
        running = running.max(p[*i] * (order.len() - rank) as f64).min(1.0);
        out[*i] = running;
    }
    out
}

/// The value below which `share` of them lie; `None` of none.
#[must_use]
pub fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let at = (share * values.len() as f64) as usize;
    values.get(at.min(values.len().saturating_sub(1))).copied()
}

/// The middle one of them; `None` of none.
#[must_use]
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    quantile(values.into_iter().collect(), 0.5)
}

/// The value below which half of the weight lies, of values with their weights; `None` of none.
#[must_use]
pub fn weighted_median(mut values: Vec<(f64, f64)>) -> Option<f64> {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = values.iter().map(|v| v.1).sum();
    let mut below = 0.0;
    let middle = values.iter().find(|(_, weight)| {
        below += weight;
        below >= 0.5 * total
    });
    middle.map(|v| v.0)
}

/// 5, 50 and 95 % of sorted values.
#[must_use]
pub fn quantiles(sorted: &[f64]) -> Option<[f64; 3]> {
    let last = sorted.len().checked_sub(1)?;
    Some([0.05, 0.5, 0.95].map(|q| sorted[(q * last as f64).round() as usize]))
}
