//! The fingers' friction coefficient, learnt while they work: the model's until the rig
//! tells more.
//!
//! What the object slides with is all there is (a slip sets the estimate); what was held
//! without slip is there (a near slip raises the least there may be): a load that stays, or
//! a knock that was withstood, where the pose shows that nothing moved. Both within bounds,
//! and both fade.

use crate::real::{Real, clamp, max, min};

/// How much less friction there may be than the model's, or than was learnt from a slip; and how
/// much less is likely.
const SPREAD_TOLD: f64 = 0.25;
const LIKELY_TOLD: f64 = 0.15;
const SPREAD_LEARNT: f64 = 0.06;
/// Bounds of the estimate relative to the model's coefficient.
const LEAST_SHARE: f64 = 0.2;
const MOST_SHARE: f64 = 2.0;
/// What was learnt fades with this time constant.
const FADE_S: f64 = 60.0;
/// Slow mean of the ratio, and how near it the ratio of a steady load stays.
const LEVEL_S: f64 = 0.5;
const LEVEL_SHARE: f64 = 0.03;
/// How long a load stays that proves friction.
const STEADY_S: f64 = 0.3;
/// A knock is over at this share of its peak; the peak's noise is taken off.
const OVER_SHARE: f64 = 0.8;
const PEAK_SHARE: f64 = 0.97;
/// Friction is learnt from slip that is this old and this fast.
const SLID_S: f64 = 0.008;
const SLID_M_S: f64 = 0.005;
/// Pads that carry less than this share of what they carried in the slip do not slide.
const CAUGHT_SHARE: f64 = 0.9;
/// A load that is held leaves about so much friction.
const HELD_MARGIN: f64 = 1.08;
/// Slip this long settles the estimate.
const LEARNT_S: f64 = 0.04;

/// What a sample says of friction.
#[derive(Clone, Copy, Debug)]
pub struct Use<R: Real> {
    /// Coefficient needed, in terms of the model's (its effects taken off).
    pub needed: R,
    /// Noise of it, standard deviation.
    pub noise: R,
    /// Duration of the slip under way; `None`: nobody sees whether it slips.
    pub slip_s: Option<R>,
    /// Speed of it.
    pub speed_m_s: R,
    /// The grip is not falling.
    pub grip_holds: bool,
    /// The planned motion is changing: the load becomes another.
    pub steered: bool,
}

/// State.
#[derive(Clone, Debug)]
pub struct Friction<R: Real> {
    told: R,
    estimate: R,
    learnt: bool,
    /// Held without slip: that much there is.
    proven: R,
    /// Needed now, where the pose shows that nothing moves.
    holds: R,
    level: R,
    steady_s: R,
    /// Highest need of the present knock, or of the present slip.
    peak: R,
}

impl<R: Real> Friction<R> {
    /// Knows what the model says.
    pub fn new(told: R) -> Self {
        let zero = R::zero();
        Self {
            told,
            estimate: told,
            learnt: false,
            proven: zero,
            holds: zero,
            level: zero,
            steady_s: zero,
            peak: zero,
        }
    }

    /// The coefficient, estimated.
    pub fn estimate(&self) -> R {
        self.estimate
    }

    /// What the model is to reckon with: pads that hold a load do not slip under it, and not
    /// at the next tremor.
    pub fn assumed(&self) -> R {
        let held = max(self.proven, self.holds) * R::of(HELD_MARGIN);
        max(self.estimate, min(held, self.told * R::of(MOST_SHARE)))
    }

    /// What was held without slip; zero where nothing was.
    pub fn proven(&self) -> R {
        self.proven
    }

    /// The least that it may be.
    pub fn least(&self) -> R {
        let spread = if self.learnt { SPREAD_LEARNT } else { SPREAD_TOLD };
        max(self.estimate * R::of(1.0 - spread), self.proven)
    }

    /// The least that is likely, whatever was held.
    pub fn likely(&self) -> R {
        self.estimate * R::of(1.0 - if self.learnt { SPREAD_LEARNT } else { LIKELY_TOLD })
    }

    /// Slow mean of what was needed.
    pub fn level(&self) -> R {
        self.level
    }

    /// Loads have been clipped at `needed`: there is no more than that.
    pub fn cap(&mut self, needed: R) {
        let bound = max(needed, self.told * R::of(LEAST_SHARE));
        if bound < self.estimate {
            self.estimate = max(bound, self.proven);
            self.learnt = true;
        }
    }

    /// Another grasp of the same object: keeps what was learnt.
    pub fn regrasped(&self) -> Self {
        Self { estimate: self.estimate, learnt: self.learnt, ..Self::new(self.told) }
    }

    /// Forgets what was learnt.
    pub fn reset(&mut self) {
        *self = Self::new(self.told);
    }

    /// One sample.
    pub fn learn(&mut self, seen: &Use<R>, dt_s: R) {
        let still = seen.slip_s.is_some_and(|s| !(s > R::zero()));
        self.holds = if still { seen.needed } else { R::zero() };
        let (low, high) = (self.told * R::of(LEAST_SHARE), self.told * R::of(MOST_SHARE));
        if seen.slip_s.is_some_and(|s| s > R::zero()) {
            let slides = seen.slip_s.is_some_and(|s| s > R::of(SLID_S)) && seen.speed_m_s > R::of(SLID_M_S);
            self.peak = if slides { max(self.peak, seen.needed) } else { R::zero() };
            // Pads that have caught the object again carry less; the speed is seen to fall later.
            if slides && seen.needed > self.peak * R::of(CAUGHT_SHARE) {
                let gain = R::of(if self.learnt { 0.05 } else { 0.2 });
                self.estimate = clamp(self.estimate + (seen.needed - self.estimate) * gain, low, high);
                self.learnt |= seen.slip_s.is_some_and(|s| s > R::of(LEARNT_S));
                self.proven = R::zero();
            }
            self.steady_s = R::zero();
            return;
        }
        let fade = dt_s / R::of(FADE_S);
        self.estimate += (self.told - self.estimate) * fade;
        self.proven -= self.proven * fade;
        if seen.steered || !(self.level > R::zero()) {
            self.level = seen.needed;
        }
        self.level += (seen.needed - self.level) * min(dt_s / R::of(LEVEL_S), R::one());
        let near =
            (seen.needed - self.level).abs() < self.level * R::of(LEVEL_SHARE) + seen.noise * R::of(2.0);
        self.steady_s = if near && !seen.steered { self.steady_s + dt_s } else { R::zero() };
        self.peak = max(self.peak, seen.needed);
        let over = seen.needed < self.peak * R::of(OVER_SHARE);
        if over {
            if seen.slip_s.is_some() {
                self.proven = max(self.proven, min(self.peak * R::of(PEAK_SHARE), high));
            }
            self.peak = seen.needed;
        }
        if self.steady_s > R::of(STEADY_S) && seen.grip_holds {
            self.proven = max(self.proven, min(self.level, high));
            self.peak = seen.needed;
        }
        self.estimate = max(self.estimate, self.proven);
    }
}
