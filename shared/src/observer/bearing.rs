//! Fingers that bear less than the weight that they bore let the object fall (Newton).
//!
//! The force that bears the object, over what the model expects, is held against its own
//! slow mean by a cumulative sum (Page 1954): `S = max(0, S + (mean - share) / sigma - k)`,
//! an alarm at `S > h`. Deficits below a twentieth of the weight never add up. It is told
//! only where the told weight has proven right, and while the planned motion stays.

use crate::real::{Real, clamp, max, min, sqrt};

/// Deficit that is none, as a share of the weight, and in standard deviations.
const ALLOWED_SHARE: f64 = 0.05;
const ALLOWED_SIGMAS: f64 = 0.9;
/// By chance once in a hundred hours, `exp(2 k h) / (2 k^2)` samples apart (Siegmund 1985).
const CHANCE: f64 = 19.0;
/// After so many samples it does not fall but rests elsewhere, or has been dropped.
const FALLEN_SAMPLES: u8 = 100;
/// The told weight is right if it is borne for a while within this share.
const WEIGHT_SHARE: f64 = 0.15;
/// Time constants of the mean and of the noise; first guess of the noise.
const BORNE_S: f64 = 0.3;
const NOISE_S: f64 = 0.2;
const NOISE: f64 = 0.03;
/// The same of noise that has just begun.
const SUDDEN_S: f64 = 0.04;
/// A sample counts up to so many standard deviations in mean and noise: a knock is neither.
const COUNTED_SIGMAS: f64 = 2.5;
/// A sample counts up to so many in the deficit: three of them are a fall.
const FALLS_SIGMAS: f64 = 5.0;
/// Less than this bears nothing, N.
const LEAST_N: f64 = 0.2;

/// Share of the alarm's bar from which the object may be falling.
const SUSPECT_SHARE: f64 = 0.4;

/// State.
#[derive(Clone, Debug)]
pub struct Bearing<R: Real> {
    /// Mean of the force that bears the object, over the model's; variance of a sample.
    mean: R,
    variance: R,
    /// Of the last differences, and the last share: noise that has just begun counts at once.
    sudden: R,
    last: R,
    deficit: R,
    suspect: bool,
    fallen: u8,
    /// Samples so far: the first count more.
    age: u8,
}

impl<R: Real> Default for Bearing<R> {
    fn default() -> Self {
        let variance = R::of(NOISE * NOISE);
        Self {
            mean: R::zero(),
            variance,
            sudden: variance,
            last: R::zero(),
            deficit: R::zero(),
            suspect: false,
            fallen: 0,
            age: 0,
        }
    }
}

impl<R: Real> Bearing<R> {
    /// The object may be falling.
    pub fn suspect(&self) -> bool {
        self.suspect
    }

    /// One sample: the force that bears the object, measured and by the model, N. For how many
    /// samples it has been falling; zero where it is borne.
    pub fn falls(&mut self, bearing_n: Option<[R; 2]>, steered: bool, dt_s: R) -> u8 {
        let Some([measured, model]) = bearing_n.filter(|[_, model]| *model > R::of(LEAST_N)) else {
            *self = Self { variance: self.variance, ..Self::default() };
            return 0;
        };
        let share = measured / model;
        let change = share - self.last;
        self.last = share;
        // A fall is a few large differences, noise many.
        let square = min(change * change * R::of(0.5), self.sudden * R::of(4.0));
        self.sudden += (square - self.sudden) * min(dt_s / R::of(SUDDEN_S), R::one());
        let sigma = max(sqrt(max(self.variance, self.sudden)), R::of(1e-3));
        let allowed = max(R::of(ALLOWED_SHARE) / sigma, R::of(ALLOWED_SIGMAS));
        let enough = R::of(CHANCE * 0.5) / allowed;
        let right = (self.mean - R::one()).abs() < R::of(WEIGHT_SHARE);
        if self.fallen >= FALLEN_SAMPLES {
            *self = Self { variance: self.variance, ..Self::default() };
        } else if right && !steered {
            let most = R::of(FALLS_SIGMAS);
            let gain = clamp((min(self.mean, R::one()) - share) / sigma, -most, most) - allowed;
            self.deficit = clamp(self.deficit + gain, R::zero(), enough * R::of(2.0));
        } else {
            self.deficit = R::zero();
        }
        self.suspect = self.deficit > enough * R::of(SUSPECT_SHARE);
        if self.deficit > enough {
            self.fallen = self.fallen.saturating_add(1);
            return self.fallen;
        }
        self.fallen = 0;
        self.age = self.age.saturating_add(1);
        let first = R::one() / R::of(f64::from(self.age));
        let counted = if self.age < u8::MAX && !right {
            share - self.mean
        } else {
            clamp(share - self.mean, -sigma * R::of(COUNTED_SIGMAS), sigma * R::of(COUNTED_SIGMAS))
        };
        self.mean += counted * max(min(dt_s / R::of(BORNE_S), R::one()), first);
        if right {
            let slow = min(dt_s / R::of(NOISE_S), R::one()) * R::of(0.1);
            self.variance += (counted * counted - self.variance) * slow;
        }
        0
    }
}
