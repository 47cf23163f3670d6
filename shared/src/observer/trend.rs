//! A straight line through the last 0.12 s of a noisy quantity, and whether its slope is proven.
//!
//! Samples are averaged in blocks; least squares through the block means give value and
//! slope. The slope's standard deviation comes from the larger of two figures: the noise
//! within the blocks, and how far the means lie off the line. What is no line (a step, a
//! knock) has means far off any line: the middle of a step reaches 3.7 standard deviations,
//! a knock less. A slope is proven at five, where both halves of the time show it.

use crate::real::{Real, max, min, sqrt};

/// Blocks of the fit.
const BLOCKS: usize = 6;
/// Samples in a block: 20 ms at 250 Hz.
pub const SHORT: u8 = 5;
/// The same for slow ramps: 0.1 s.
pub const LONG: u8 = 25;
/// Standard deviations that prove a slope: by chance once in some hundred hours.
const PROVEN_SIGMAS: f64 = 5.0;
/// Standard deviations by which the slope may be less than it seems.
const CAUTION_SIGMAS: f64 = 2.0;
/// Share of the slope that each half must show alone.
const HALF_SHARE: f64 = 0.6;
/// The same for the sway of slopes, and how much more than it one difference counts.
const SWAY_SHARE: f64 = 0.02;
const SWAY_MOST: f64 = 6.0;
/// Share with which a block's noise enters the mean noise.
const NOISE_SHARE: f64 = 0.05;

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
    per_block: u8,
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
}

impl<R: Real> Trend<R> {
    /// Knows nothing; `variance` is a first guess of the samples' noise.
    pub fn new(variance: R, per_block: u8) -> Self {
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
            per_block,
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
        *self = Self { sway: self.sway, ..Self::new(self.variance, self.per_block) };
    }

    /// One sample, `dt_s` after the last.
    pub fn push(&mut self, x: R, dt_s: R) {
        self.now_s += dt_s;
        if self.count == 0 {
            self.first = x;
        }
        let x = x - self.first;
        self.sum += x;
        self.squares += x * x;
        self.count += 1;
        if self.count < self.per_block {
            return;
        }
        let n = R::of(f64::from(self.per_block));
        let mean = self.sum / n;
        let spread = max(self.squares - self.sum * mean, R::zero()) / (n - R::one());
        // A jump within the block is not noise.
        let spread = if spread > self.variance * R::of(9.0) { self.variance * R::of(9.0) } else { spread };
        self.variance += (spread - self.variance) * R::of(NOISE_SHARE);
        // Times count from now, so that they stay small.
        let mut newer = [mean + self.first, R::zero()];
        for place in self.means.iter_mut().rev() {
            core::mem::swap(place, &mut newer);
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
        let noise = self.variance / R::of(f64::from(self.per_block));
        let white = max(off, noise) / tt;
        let mut newer = slope;
        for place in &mut self.slopes {
            core::mem::swap(place, &mut newer);
        }
        self.fits = self.fits.saturating_add(1);
        if self.fits as usize > BLOCKS {
            let [now, .., then] = self.slopes;
            let square = (now - then) * (now - then) * R::of(0.5);
            let most = max(self.sway, white) * R::of(SWAY_MOST);
            self.sway += (min(square, most) - self.sway) * R::of(SWAY_SHARE);
        }
        let sigma = sqrt(max(white, self.sway));
        let persists = slope > sigma * R::of(CAUTION_SIGMAS);
        if !(slope.abs() > sigma * R::of(PROVEN_SIGMAS)) {
            return (None, persists);
        }
        let half = |from: usize| {
            let (a, b) = (self.means.get(from), self.means.get(from + BLOCKS / 2 - 1));
            a.zip(b).is_some_and(|(a, b)| {
                let run = (b[1] - a[1]) * slope * R::of(HALF_SHARE);
                (b[0] - a[0]) * slope.signum() >= run.abs()
            })
        };
        if !half(0) || !half(BLOCKS / 2) {
            return (None, persists);
        }
        let caution = sigma * R::of(CAUTION_SIGMAS);
        let slope_s = if slope > R::zero() { slope - caution } else { slope + caution };
        // The newest block's middle lies half a block back.
        (Some(Line { value: mean - slope * middle, slope_s }), persists)
    }
}
