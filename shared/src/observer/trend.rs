//! A straight line through the last 0.12 s of a noisy quantity, and whether its slope is proven.
//!
//! Samples are averaged in blocks; least squares through the block means give value and
//! slope. The slope's standard deviation comes from the larger of two figures: the noise
//! within the blocks, and how far the means lie off the line. What is no line (a step, a
//! knock) has means far off any line: the middle of a step reaches 3.7 standard deviations,
//! a knock less. A slope is proven at five, where both halves of the time show it.

use crate::real::{Real, max, min, sqrt};
use crate::tuning::tuned;
use crate::window::shift_in;

/// Blocks of the fit.
const BLOCKS: usize = 6;

/// Samples in a block of a short trend, and of one of slow ramps: 20 ms and 0.1 s at 250 Hz.
pub const SHORT: u8 = 5;
/// See [`SHORT`].
pub const LONG: u8 = 25;

tuned! {
    /// What was chosen in it.
    pub struct TrendParams<R> {
        /// Samples in a block: 20 ms at 250 Hz, half the shortest load of a hand-over. Doubled: slopes are
        /// proven twice as late, and slopes of a third of the size.
        per_block: u8 = SHORT, 2.0 to 200.0;
        /// Standard deviations that prove a slope: by chance once in some hundred hours. Doubled: ramps are
        /// proven at the limit only.
        proven_sigmas: R = R::of(5.0), 0.5 to 100.0;
        /// Standard deviations by which the slope may be less than it seems. Doubled: warnings of a barely
        /// proven slope come at half the lead.
        caution_sigmas: R = R::of(2.0), 0.0 to 100.0;
        /// Share of the slope that each half must show alone: a step shows it in one. Doubled: only what
        /// accelerates is proven.
        half_share: R = R::of(0.6), 0.0 to 1.5;
        /// Share with which the difference of two slopes enters their sway: a second of fits. Doubled: a sway is
        /// known, and forgotten, in half of it.
        sway_share: R = R::of(0.02), 1e-4 to 1.0;
        /// How much more than the sway so far one difference counts. Doubled: one ramp makes the next one
        /// harder to prove.
        sway_most: R = R::of(6.0), 1.0 to 1000.0;
        /// Share with which a block's noise enters the mean noise. Doubled: changes of noise are followed in
        /// 0.2 s.
        noise_share: R = R::of(0.05), 1e-4 to 1.0;
        /// How much more than the mean noise one block counts, in squares: a jump within it is no noise. Doubled: a jump delays the
        /// next proof.
        noise_most: R = R::of(9.0), 1.0 to 1000.0;
    }
}

/// See the module.
#[derive(Clone, Debug)]
pub struct Trend<R: Real> {
    /// Means of the full blocks, the oldest first, and the time of each.
    means: [[R; 2]; BLOCKS],
    full: usize,
    sum: R,
    squares: R,
    count: u8,
    /// Of the first sample of the block; what is summed counts from it.
    first: R,
    now_s: R,
    variance: R,
    line: Option<Line<R>>,
    proven_s: R,
    params: TrendParams<R>,
    persists: bool,
    /// Slopes of the last fits, the newest first, and how much they differ a window apart: square of the deviation.
    slopes: [R; BLOCKS + 1],
    sway: R,
    fits: u8,
}

/// What the last blocks show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<R: Real> {
    /// Value now.
    pub value: R,
    /// A slope that it surely has, in the direction of the measured one, 1/s.
    pub slope_s: R,
    /// The measured slope, 1/s.
    pub fitted_s: R,
}

impl<R: Real> Trend<R> {
    /// Knows nothing; `variance` is a first guess of the samples' noise.
    pub fn new(variance: R, params: TrendParams<R>) -> Self {
        let zero = R::zero();
        Self {
            means: [[zero; 2]; BLOCKS],
            full: 0,
            sum: zero,
            squares: zero,
            count: 0,
            first: zero,
            now_s: zero,
            variance,
            line: None,
            proven_s: zero,
            params,
            persists: false,
            slopes: [zero; BLOCKS + 1],
            sway: zero,
            fits: 0,
        }
    }

    /// Noise of a sample, standard deviation.
    pub fn noise(&self) -> R {
        sqrt(self.variance)
    }

    /// Begins anew: what was seen belongs to another state of affairs.
    pub fn forget(&mut self) {
        *self = Self { sway: self.sway, ..Self::new(self.variance, self.params) };
    }

    /// One sample, `dt_s` after the last.
    pub fn push(&mut self, x: R, dt_s: R) {
        self.now_s += dt_s;
        self.proven_s = if self.line.is_some() { self.proven_s + dt_s } else { R::zero() };
        if self.count == 0 {
            self.first = x;
        }
        let x = x - self.first;
        self.sum += x;
        self.squares += x * x;
        self.count += 1;
        if self.count < self.params.per_block {
            return;
        }
        let n = R::of(f64::from(self.params.per_block));
        let mean = self.sum / n;
        let spread = max(self.squares - self.sum * mean, R::zero()) / (n - R::one());
        // A jump within the block is not noise.
        let most = self.variance * self.params.noise_most;
        let spread = if spread > most { most } else { spread };
        self.variance += (spread - self.variance) * self.params.noise_share;
        // Times count from now, so that they stay small.
        let mut newer = [mean + self.first, R::zero()];
        for place in self.means.iter_mut().rev() {
            newer = core::mem::replace(place, newer);
        }
        for [_, at] in &mut self.means {
            *at -= self.now_s;
        }
        self.now_s = R::zero();
        self.full = (self.full + 1).min(BLOCKS);
        (self.sum, self.squares, self.count) = (R::zero(), R::zero(), 0);
        (self.line, self.persists) = if self.full == BLOCKS { self.fit() } else { (None, false) };
    }

    /// The line, where its slope is proven.
    pub fn proven(&self) -> Option<Line<R>> {
        self.line
    }

    /// For how long the line has been going on, its own length and the time for which it has been proven, s.
    pub fn lasts_s(&self) -> R {
        let [.., [_, oldest_s]] = self.means;
        self.now_s - oldest_s + self.proven_s
    }

    /// A rise that was proven has not ended: two standard deviations of it are left.
    pub fn persists(&self) -> bool {
        self.persists
    }

    fn fit(&mut self) -> (Option<Line<R>>, bool) {
        let n = R::of(BLOCKS as f64);
        let (mut mean, mut middle) = (R::zero(), R::zero());
        for [x, t] in &self.means {
            mean += *x;
            middle += *t;
        }
        mean /= n;
        middle /= n;
        let (mut tt, mut tx, mut xx) = (R::zero(), R::zero(), R::zero());
        for [x, t] in &self.means {
            let (x, t) = (*x - mean, *t - middle);
            tt += t * t;
            tx += t * x;
            xx += x * x;
        }
        if !(tt > R::zero()) {
            return (None, false);
        }
        let slope = tx / tt;
        let off = max(xx - slope * tx, R::zero()) / (n - R::of(2.0));
        let noise = self.variance / R::of(f64::from(self.params.per_block));
        let white = max(off, noise) / tt;
        shift_in(&mut self.slopes, slope);
        self.fits = self.fits.saturating_add(1);
        if self.fits as usize > BLOCKS {
            let [now, .., then] = self.slopes;
            let square = (now - then) * (now - then) * R::of(0.5);
            let most = max(self.sway, white) * self.params.sway_most;
            self.sway += (min(square, most) - self.sway) * self.params.sway_share;
        }
        let sigma = sqrt(max(white, self.sway));
        let persists = slope > sigma * self.params.caution_sigmas;
        if !(slope.abs() > sigma * self.params.proven_sigmas) {
            return (None, persists);
        }
        let half = |from: usize| {
            let (a, b) = (self.means.get(from), self.means.get(from + BLOCKS / 2 - 1));
            a.zip(b).is_some_and(|(a, b)| {
                let run = (b[1] - a[1]) * slope * self.params.half_share;
                (b[0] - a[0]) * slope.signum() >= run.abs()
            })
        };
        if !half(0) || !half(BLOCKS / 2) {
            return (None, persists);
        }
        let caution = sigma * self.params.caution_sigmas;
        let slope_s = if slope > R::zero() { slope - caution } else { slope + caution };
        // The newest block's middle lies half a block back.
        (Some(Line { value: mean - slope * middle, slope_s, fitted_s: slope }), persists)
    }
}
