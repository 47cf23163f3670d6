//! The fingers' friction coefficient, learnt while they work: the model's until the rig
//! tells more.
//!
//! What the object slides with is all there is (a slip sets the estimate); what was held
//! without slip is there (a near slip raises the least there may be): a load that stays, or
//! a knock that was withstood, where the pose shows that nothing moved. Both within bounds,
//! and both fade.

use crate::real::{Real, clamp, max, min};

/// What was chosen in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionParams<R: Real> {
    /// How much less friction there may be than the model's: what calibrations on other days err by.
    /// Doubled: trends are warned of at half of the told friction.
    pub spread_told: R,
    /// How much less is likely. Doubled: jumps of the load to 0.7 of the told friction are slip without a pose.
    pub likely_told: R,
    /// Both where a slip has told: friction varies by so much from slip to slip. Doubled: warnings that come
    /// 6 % below the limit come 12 % below.
    pub spread_learnt: R,
    /// Least estimate over the told coefficient. Doubled: friction that fell to a third is not learnt.
    pub least_share: R,
    /// Largest estimate over the told coefficient. Doubled: nothing, but for models that are far off.
    pub most_share: R,
    /// What was learnt fades with this time constant, s. Doubled: what a wet patch taught lasts two minutes.
    pub fade_s: R,
    /// Time constant of the slow mean of the ratio, s. Doubled: loads are known to stay that much later.
    pub level_s: R,
    /// The ratio of a steady load stays within this share of its slow mean. Doubled: slow ramps pass for held.
    pub level_share: R,
    /// A load that stays for so long proves friction, s. Doubled: it proves it that much later.
    pub steady_s: R,
    /// A knock is over at this share of its peak. Above 1, every sample is one.
    pub over_share: R,
    /// Share of a knock's peak that was held: the peak's noise is taken off.
    pub peak_share: R,
    /// Friction is learnt from slip that is as old as this, s: two samples. Doubled: short slips teach nothing.
    pub slid_s: R,
    /// And as fast as this, m/s: beyond the noise of the filtered velocity. Doubled: slow slips teach nothing.
    pub slid_m_s: R,
    /// Pads that carry less than this share of what they carried in the slip do not slide. Above 1, no
    /// slip teaches.
    pub caught_share: R,
    /// What the model reckons with over what is held: pads do not slip at the next tremor. Twice the margin:
    /// the model foresees slip that much later.
    pub held_margin: R,
    /// Slip as long as this settles the estimate, s. Doubled: short slips leave the spread of the told one.
    pub learnt_s: R,
}

impl<R: Real> Default for FrictionParams<R> {
    fn default() -> Self {
        Self {
            spread_told: R::of(0.25),
            likely_told: R::of(0.15),
            spread_learnt: R::of(0.06),
            least_share: R::of(0.2),
            most_share: R::of(2.0),
            fade_s: R::of(60.0),
            level_s: R::of(0.5),
            level_share: R::of(0.03),
            steady_s: R::of(0.3),
            over_share: R::of(0.8),
            peak_share: R::of(0.97),
            slid_s: R::of(0.008),
            slid_m_s: R::of(0.005),
            caught_share: R::of(0.9),
            held_margin: R::of(1.08),
            learnt_s: R::of(0.04),
        }
    }
}

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
    params: FrictionParams<R>,
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
        Self::with(told, FrictionParams::default())
    }

    /// The same with other tuning than the default.
    pub fn with(told: R, params: FrictionParams<R>) -> Self {
        let zero = R::zero();
        Self {
            params,
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
        let held = max(self.proven, self.holds) * self.params.held_margin;
        max(self.estimate, min(held, self.told * self.params.most_share))
    }

    /// What was held without slip; zero where nothing was.
    pub fn proven(&self) -> R {
        self.proven
    }

    /// The least that it may be.
    pub fn least(&self) -> R {
        let spread = if self.learnt { self.params.spread_learnt } else { self.params.spread_told };
        max(self.estimate * (R::one() - spread), self.proven)
    }

    /// The least that is likely, whatever was held.
    pub fn likely(&self) -> R {
        self.estimate
            * (R::one() - if self.learnt { self.params.spread_learnt } else { self.params.likely_told })
    }

    /// Slow mean of what was needed.
    pub fn level(&self) -> R {
        self.level
    }

    /// Loads have been clipped at `needed`: there is no more than that. A flat top below the least friction there may be
    /// was held: far more loads happen to be flat than there is so much less friction.
    pub fn cap(&mut self, needed: R) {
        let bound = max(needed, self.told * self.params.least_share);
        if bound < self.estimate && needed > self.least() {
            self.estimate = max(bound, self.proven);
            self.learnt = true;
        }
    }

    /// Another grasp of the same object: keeps what was learnt.
    pub fn regrasped(&self) -> Self {
        Self { estimate: self.estimate, learnt: self.learnt, ..Self::with(self.told, self.params) }
    }

    /// Forgets what was learnt.
    pub fn reset(&mut self) {
        *self = Self::with(self.told, self.params);
    }

    /// One sample.
    pub fn learn(&mut self, seen: &Use<R>, dt_s: R) {
        let still = seen.slip_s.is_some_and(|s| !(s > R::zero()));
        self.holds = if still { seen.needed } else { R::zero() };
        let (low, high) = (self.told * self.params.least_share, self.told * self.params.most_share);
        if seen.slip_s.is_some_and(|s| s > R::zero()) {
            let slides =
                seen.slip_s.is_some_and(|s| s > self.params.slid_s) && seen.speed_m_s > self.params.slid_m_s;
            self.peak = if slides { max(self.peak, seen.needed) } else { R::zero() };
            // Pads that have caught the object again carry less; the speed is seen to fall later.
            if slides && seen.needed > self.peak * self.params.caught_share {
                let gain = R::of(if self.learnt { 0.05 } else { 0.2 });
                self.estimate = clamp(self.estimate + (seen.needed - self.estimate) * gain, low, high);
                self.learnt |= seen.slip_s.is_some_and(|s| s > self.params.learnt_s);
                self.proven = R::zero();
            }
            self.steady_s = R::zero();
            return;
        }
        let fade = dt_s / self.params.fade_s;
        self.estimate += (self.told - self.estimate) * fade;
        self.proven -= self.proven * fade;
        if seen.steered || !(self.level > R::zero()) {
            self.level = seen.needed;
        }
        self.level += (seen.needed - self.level) * min(dt_s / self.params.level_s, R::one());
        let near =
            (seen.needed - self.level).abs() < self.level * self.params.level_share + seen.noise * R::of(2.0);
        self.steady_s = if near && !seen.steered { self.steady_s + dt_s } else { R::zero() };
        self.peak = max(self.peak, seen.needed);
        let over = seen.needed < self.peak * self.params.over_share;
        if over {
            if seen.slip_s.is_some() {
                self.proven = max(self.proven, min(self.peak * self.params.peak_share, high));
            }
            self.peak = seen.needed;
        }
        if self.steady_s > self.params.steady_s && seen.grip_holds {
            self.proven = max(self.proven, min(self.level, high));
            self.peak = seen.needed;
        }
        self.estimate = max(self.estimate, self.proven);
    }
}
