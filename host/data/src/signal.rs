//! A recorded signal by itself: its white noise, and when it leaves its rest.
//!
//! Import and `check` tell clocks apart by onsets, the same way.

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
    let rise = Rise::of(signal, over)?;
    let fits = rise.corners(rise.first_s(), &|since_s| since_s);
    let variance = least(&fits)? / rise.along.len().max(3) as f64 + f64::MIN_POSITIVE;
    likely(&fits, variance, rise.step_s)
}

/// A corner in a signal's time, s, and the sum of squares that the fit with it leaves.
pub type Corner = (f64, f64);

/// Least sum of squares of some corners.
#[must_use]
pub fn least(corners: &[Corner]) -> Option<f64> {
    corners.iter().map(|(_, squares)| *squares).reduce(f64::min)
}

/// Middle and half range of the corners whose sum of squares is within `variance` of the least, tried a quarter of
/// `step_s` apart.
#[must_use]
pub fn likely(corners: &[Corner], variance: f64, step_s: f64) -> Option<(f64, f64)> {
    let least = least(corners)?;
    let likely = || corners.iter().filter(|(_, squares)| *squares <= least + variance).map(|(at, _)| *at);
    let (low, high) = (likely().reduce(f64::min)?, likely().reduce(f64::max)?);
    Some((0.5 * (low + high), (0.5 * (high - low)).hypot(0.25 * step_s)))
}

/// A signal until it has clearly left its rest, as one channel: the way along which it leaves.
#[derive(Clone, Debug)]
pub struct Rise {
    along: Vec<(f64, f64)>,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Samples until it has left by more than noise.
    left: usize,
    base: [f64; 6],
    /// Of unit length.
    direction: [f64; 6],
}

impl Rise {
    /// Whether it has left is judged by means of `over` samples. `None`: no rest, or it never leaves it.
    #[must_use]
    pub fn of(signal: &[(f64, [f64; 6])], over: usize) -> Option<Self> {
        let (start_s, _) = signal.first()?;
        let early = signal.iter().take_while(|(t, _)| t - start_s <= BASELINE_S).count();
        let rest = signal.get(..early).filter(|rest| rest.len() >= 3)?;
        let base: [f64; 6] =
            std::array::from_fn(|k| rest.iter().map(|(_, x)| x[k]).sum::<f64>() / early as f64);
        let sigma: [f64; 6] =
            std::array::from_fn(|k| white_noise(signal.iter().map(|(_, x)| x[k])).unwrap_or(0.0));
        let total = sigma.iter().map(|s| s * s).sum::<f64>().sqrt();
        let away: Vec<[f64; 6]> =
            signal.iter().map(|(_, x)| std::array::from_fn(|k| x[k] - base[k])).collect();
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
        let direction: [f64; 6] = std::array::from_fn(|k| to[k] / scale);
        let along: Vec<(f64, f64)> = signal
            .iter()
            .zip(&away)
            .take(until)
            .map(|((t, _), x)| (*t, x.iter().zip(to).map(|(a, b)| a * b).sum::<f64>() / scale))
            .collect();
        let span_s = along.last()?.0 - along.first()?.0;
        let step_s = span_s / along.len().saturating_sub(1).max(1) as f64;
        Some(Self { along, step_s, left, base, direction })
    }

    /// Time of the first sample.
    #[must_use]
    pub fn first_s(&self) -> f64 {
        self.along.first().map_or(0.0, |(t, _)| *t)
    }

    /// Time of the last sample.
    #[must_use]
    pub fn last_s(&self) -> f64 {
        self.along.last().map_or(0.0, |(t, _)| *t)
    }

    /// How far a sample of the signal is from the rest, along the way on which it leaves.
    #[must_use]
    pub fn distance(&self, x: &[f64; 6]) -> f64 {
        (0..6).map(|k| (x[k] - self.base[k]) * self.direction[k]).sum()
    }

    /// How fast it is in the second half of the time since it has left its rest, 1/s.
    #[must_use]
    pub fn speed(&self) -> f64 {
        let moving = &self.along[self.left.min(self.along.len())..];
        let late = &moving[moving.len() / 2..];
        let count = late.len().max(1) as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| late.iter().map(of).sum::<f64>() / count;
        let (middle_s, middle) = (mean(|(t, _)| *t), mean(|(_, x)| *x));
        let (with, own) = late.iter().fold((0.0, 0.0), |(with, own), (t, x)| {
            (with + (t - middle_s) * (x - middle), own + (t - middle_s).powi(2))
        });
        if own > 0.0 { (with / own).max(0.0) } else { 0.0 }
    }

    /// Corners from `from_s` on: level before, a multiple of `shape` (of the time since) after.
    #[must_use]
    pub fn corners(&self, from_s: f64, shape: &dyn Fn(f64) -> f64) -> Vec<Corner> {
        let along = &self.along;
        let count = along.len() as f64;
        let (sum, squares) = along.iter().fold((0.0, 0.0), |(s, q), (_, x)| (s + x, q + x * x));
        let spread = squares - sum * sum / count;
        let corner = |at_s: f64| {
            let after = along.iter().rev().take_while(|(t, _)| *t > at_s);
            let (mut h, mut hh, mut hx) = (0.0, 0.0, 0.0);
            for (t, x) in after {
                let s = shape(t - at_s);
                (h, hh, hx) = (h + s, hh + s * s, hx + s * x);
            }
            // About the means: the level is found with it.
            let (own, with) = (hh - h * h / count, hx - h * sum / count);
            (own > 0.0).then(|| (spread - with * with / own).max(0.0))
        };
        let tried = (3..4 * along.len().saturating_sub(1))
            .map(|k| self.first_s() + 0.25 * self.step_s * k as f64)
            .filter(|at| *at >= from_s);
        tried.filter_map(|at| Some((at, corner(at)?))).collect()
    }

    /// How many samples are at rest, and the sums of the products of those so many samples apart, about their mean.
    fn products_at_rest(&self) -> (usize, impl Fn(usize) -> f64 + '_) {
        let rest = &self.along[..self.left.clamp(1, self.along.len())];
        let mean = rest.iter().map(|(_, x)| x).sum::<f64>() / rest.len() as f64;
        let product = move |lag: usize| -> f64 {
            rest.iter().zip(rest.iter().skip(lag)).map(|((_, a), (_, b))| (a - mean) * (b - mean)).sum()
        };
        (rest.len(), product)
    }

    /// Time over which the noise at rest is correlated, s, where that is more than one sample: what interpolation by a
    /// logger, or a filter, leaves. 0: it is not, there is too little rest to tell, or it swings (hum).
    #[must_use]
    pub fn blurred_s(&self) -> f64 {
        let (count, product) = self.products_at_rest();
        let all = product(0);
        // Three standard deviations of what white noise shows.
        let limit = 3.0 / (count as f64).sqrt();
        if !(all > 0.0 && limit < 0.3) {
            return 0.0;
        }
        let lags = (1..count / 4).take_while(|lag| product(*lag) > limit * all).count();
        let swings = (1..(8 * lags).min(count / 2)).any(|lag| product(lag) < -limit * all);
        if lags == 0 || swings { 0.0 } else { self.step_s * (lags + 1) as f64 }
    }

    /// Variance of what a fit leaves whose least sum of squares is given: of as many samples as are independent of each
    /// other, by the correlation of neighbours at rest (noise of one pole; what a filter makes of white noise).
    #[must_use]
    pub fn variance(&self, squares: f64) -> f64 {
        let (count, product) = self.products_at_rest();
        let all = product(0);
        let neighbours = if all > 0.0 { (product(1.min(count - 1)) / all).clamp(0.0, 0.95) } else { 0.0 };
        let free = self.along.len().saturating_sub(3).max(1) as f64;
        squares / free * (1.0 + neighbours) / (1.0 - neighbours) + f64::MIN_POSITIVE
    }
}
