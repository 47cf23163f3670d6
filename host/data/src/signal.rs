//! A recorded signal by itself: its white noise, and when it leaves its rest.
//!
//! Import and `check` tell clocks apart by onsets, the same way.

use nalgebra::{SMatrix, SVector};

/// The rest at the start that gives the baseline, s.
const BASELINE_S: f64 = 0.05;
/// Beyond so many standard deviations a signal has left its baseline, in three samples in a row.
const LEAVES: f64 = 6.0;
/// The line of the motion is fitted up to so many of them.
const FITTED: f64 = 30.0;

/// Standard deviation of white noise, from the median of the differences of neighbouring
/// samples: motion and steps hardly enter it. `None` for fewer than eight differences.
#[must_use]
pub fn white_noise(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut last = f64::NAN;
    let mut differences: Vec<f64> = values
        .map(|x| {
            let d = (x - last).abs();
            last = x;
            d
        })
        .filter(|d| d.is_finite())
        .collect();
    if differences.len() < 8 {
        return None;
    }
    let middle = differences.len() / 2;
    let (_, median, _) = differences.select_nth_unstable_by(middle, f64::total_cmp);
    // The median of |d| is 0.6745 sqrt(2) sigma.
    Some(*median / (0.6745 * std::f64::consts::SQRT_2))
}

/// When a signal leaves its baseline: the corner of the broken line, level before and straight
/// after, that fits to it by least squares. Corners whose sum of squares is within one variance of
/// the least are as likely: their middle and half their range are the onset and its standard
/// deviation, both in the signal's time. Whether it has left is judged by means of `over` samples. `None`: no rest, or it
/// never leaves it.
#[must_use]
pub fn onset(signal: &[(f64, [f64; 6])], over: usize) -> Option<(f64, f64)> {
    let (start_s, _) = signal.first()?;
    let early = signal.iter().take_while(|(t, _)| t - start_s <= BASELINE_S).count();
    let rest = signal.get(..early).filter(|rest| rest.len() >= 3)?;
    let base: [f64; 6] = std::array::from_fn(|k| rest.iter().map(|(_, x)| x[k]).sum::<f64>() / early as f64);
    let sigma: [f64; 6] =
        std::array::from_fn(|k| white_noise(signal.iter().map(|(_, x)| x[k])).unwrap_or(0.0));
    let total = sigma.iter().map(|s| s * s).sum::<f64>().sqrt();
    let away: Vec<[f64; 6]> = signal.iter().map(|(_, x)| std::array::from_fn(|k| x[k] - base[k])).collect();
    let size = |x: &[f64; 6]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = away.iter().map(size).fold(0.0, f64::max);
    let means: Vec<f64> = away
        .windows(over)
        .map(|w| size(&std::array::from_fn(|k| w.iter().map(|x| x[k]).sum::<f64>() / over as f64)))
        .collect();
    let sigma = total / (over as f64).sqrt();
    let beyond = |limit: f64| means.windows(3).position(|three| three.iter().all(|x| *x > limit));
    let left = beyond((LEAVES * sigma).max(0.02 * largest))?;
    let until = beyond((FITTED * sigma).max(0.06 * largest)).unwrap_or(left).max(left) + over;
    // One channel: the way along which it leaves.
    let to = away.get(until.min(away.len() - 1))?;
    let scale = size(to);
    let along: Vec<(f64, f64)> = signal
        .iter()
        .zip(&away)
        .take(until)
        .map(|((t, _), x)| (*t, x.iter().zip(to).map(|(a, b)| a * b).sum::<f64>() / scale))
        .collect();
    let corner = |at_s: f64| {
        let (mut a, mut b) = (SMatrix::<f64, 2, 2>::zeros(), SVector::<f64, 2>::zeros());
        for (t, x) in &along {
            let h = SVector::<f64, 2>::new(1.0, (t - at_s).max(0.0));
            a += h * h.transpose();
            b += h * *x;
        }
        let solved = a.cholesky().map(|c| c.solve(&b))?;
        let left = |(t, x): &(f64, f64)| (x - solved[0] - solved[1] * (t - at_s).max(0.0)).powi(2);
        Some(along.iter().map(left).sum::<f64>())
    };
    let (first_s, last_s) = (along.first()?.0, along.last()?.0);
    let step_s = (last_s - first_s) / along.len().saturating_sub(1).max(1) as f64;
    let tried = (3..4 * along.len().saturating_sub(1)).map(|k| first_s + 0.25 * step_s * k as f64);
    let fits: Vec<(f64, f64)> = tried.filter_map(|at| Some((at, corner(at)?))).collect();
    let least = fits.iter().map(|(_, squares)| *squares).reduce(f64::min)?;
    let variance = least / along.len().max(3) as f64 + f64::MIN_POSITIVE;
    let likely = || fits.iter().filter(|(_, squares)| *squares <= least + variance).map(|(at, _)| *at);
    let (low, high) = (likely().reduce(f64::min)?, likely().reduce(f64::max)?);
    // The corners tried lie a quarter of a sample apart.
    Some((0.5 * (low + high), (0.5 * (high - low)).hypot(0.25 * step_s)))
}
