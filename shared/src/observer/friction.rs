//! The fingers' friction coefficient as a distribution, learnt while they work.
//!
//! Before anything is seen it lies about the model's value, with the spread of calibrations on other days. What the object
//! slides with is the coefficient, and only varies from slip to slip. What was held without slip is there: a load that
//! stays, or a knock that was withstood, where the pose shows that nothing moved. It cuts off what lies below. All of it
//! fades: the median goes back to the rig's and the spread to what a grasp has about it. The rig's comes from the model at first, and
//! then from the grasps that slid.
//!
//! The distribution is log-logistic (Fisk, Econometrica 29, 1961): more than `x` with the probability `S(x) = 1 / (1 + (x / m)^k)`, of
//! median `m`, and `k = pi / (sqrt(3) s)` with the standard deviation `s` of the logarithm. Its tails are heavier than those of
//! a normal one, and with what was held, `h`, both the probability `S(x) / S(h)` and the quantiles
//! `m (1 / (p S(h)) - 1)^(1 / k)` have closed forms.

use crate::real::{Real, clamp, max, min, sqrt};
use crate::tuning::tuned;

tuned! {
    /// What was chosen in it.
    pub struct FrictionParams<R> {
        /// Relative standard deviation of the model's friction: within 15 % on other days, and from grasp to grasp. Doubled:
        /// trends are warned of at half of the model's friction, and jumps of the load to 0.7 of it are slip without a pose.
        spread_told: R = R::of(0.12), 0.005 to 1.0;
        /// The same of friction that a slip has shown: what it varies by from slip to slip. Doubled: warnings that come
        /// 6 % below the limit come 12 % below.
        spread_learnt: R = R::of(0.026), 0.001 to 1.0;
        /// The same from grasp to grasp of a rig, about its own. Doubled: grasps teach next to nothing about the next ones.
        spread_grasp: R = R::of(0.08), 0.001 to 1.0;
        /// Degrees of freedom of one grasp's estimate of the rig's friction. Doubled: a wet patch moves the next grasps 1.7 times as far.
        freedom: R = R::of(4.0), 0.1 to 1000.0;
        /// Probability of the least friction: there is more with this one. Twice as near to 1: trends are warned of 3 % of the
        /// friction earlier.
        sure: R = R::of(0.9875), 0.5 to 0.9999;
        /// Probability of the likely friction, whatever was held. Twice as near to 1: jumps of the load to 0.8 of the
        /// model's friction are slip without a pose.
        likely: R = R::of(0.92), 0.5 to 0.9999;
        /// Least estimate over the model's coefficient. Doubled: friction that fell to a third is not learnt.
        least_share: R = R::of(0.2), 0.01 to 1.0;
        /// Largest estimate over the model's coefficient. Doubled: nothing, but for models that are far off.
        most_share: R = R::of(2.0), 1.0 to 100.0;
        /// What was learnt fades with this time constant, s. Doubled: what a wet patch taught lasts two minutes.
        fade_s: R = R::of(60.0), 1.0 to 1e6;
        /// Time constant of the slow mean of the ratio, s. Doubled: loads are known to stay that much later.
        level_s: R = R::of(0.5), 0.01 to 100.0;
        /// The ratio of a steady load stays within this share of its slow mean. Doubled: slow ramps pass for held.
        level_share: R = R::of(0.03), 0.0 to 1.0;
        /// And within so many standard deviations of its noise. Doubled: ramps under noise pass for held.
        level_sigmas: R = R::of(2.0), 0.0 to 100.0;
        /// A load that stays for so long proves friction, s. Doubled: it proves it that much later.
        steady_s: R = R::of(0.3), 0.01 to 100.0;
        /// A knock is over at this share of its peak. Above 1, every sample is one.
        over_share: R = R::of(0.8), 0.0 to 1.5;
        /// Share of a knock's peak that was held: the peak's noise is taken off. At 1, noise counts as friction.
        peak_share: R = R::of(0.97), 0.0 to 1.0;
        /// Friction is learnt from slip that is as old as this, s: two samples. Doubled: short slips teach nothing.
        slid_s: R = R::of(0.008), 0.0 to 1.0;
        /// And as fast as this, m/s: beyond the noise of the filtered velocity. Doubled: slow slips teach nothing.
        slid_m_s: R = R::of(0.005), 0.0 to 1.0;
        /// Share with which a sample of a slip enters the estimate: the mean of five. Doubled: 1.5 times the noise.
        slid_share: R = R::of(0.2), 0.001 to 1.0;
        /// The same where the spread is below half of `spread_told`: what is known well moves little. Doubled: pads that get wet
        /// in the midst of a grasp are followed in half of the time.
        known_share: R = R::of(0.05), 0.001 to 1.0;
        /// Pads that carry less than this share of what they carried in the slip do not slide. Above 1, no
        /// slip teaches.
        caught_share: R = R::of(0.9), 0.0 to 1.5;
        /// Slip as long as this settles the estimate, s. Doubled: short slips leave the spread as it was.
        learnt_s: R = R::of(0.04), 0.0 to 10.0;
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

/// What is known of the friction about which a rig's grasps lie.
#[derive(Clone, Copy, Debug)]
struct Rig<R: Real> {
    median: R,
    /// Of the logarithm of the median.
    variance: R,
    /// Relative standard deviation of the friction in a grasp.
    spread: R,
}

/// State.
#[derive(Clone, Debug)]
pub struct Friction<R: Real> {
    params: FrictionParams<R>,
    told: R,
    rig: Rig<R>,
    /// What the last slip of this grasp that was long enough has told.
    slid_at: Option<R>,
    /// Of the distribution, before what was held cuts it off.
    median: R,
    /// Relative standard deviation of it.
    spread: R,
    /// Held without slip: that much there is.
    proven: R,
    /// Needed now, where the pose shows that nothing moves.
    holds: R,
    level: R,
    steady_s: R,
    /// Highest need of the present knock, or of the present slip.
    peak: R,
}

impl<R: Real> Rig<R> {
    /// Knows of one grasp more, in which the object slid at a friction of `slid_at`: the posterior of a mean about which
    /// grasps are normal. One that is far off (a wet patch) counts less: as if of Student's distribution.
    fn told_by(&self, slid_at: R, params: &FrictionParams<R>) -> Self {
        if !(slid_at > R::zero() && self.median > R::zero()) {
            return *self;
        }
        let of_grasp = params.spread_grasp * params.spread_grasp;
        let seen = of_grasp + params.spread_learnt * params.spread_learnt;
        let off = (slid_at / self.median).ln();
        let freedom = params.freedom;
        let weight = (freedom + R::one()) / (freedom + off * off / (self.variance + seen));
        let gain = self.variance / (self.variance + seen / weight);
        let variance = self.variance - self.variance * gain;
        Self { median: self.median * (off * gain).exp(), variance, spread: sqrt(variance + of_grasp) }
    }
}

impl<R: Real> Friction<R> {
    /// Knows what the model says.
    pub fn new(told: R) -> Self {
        Self::with(told, FrictionParams::default())
    }

    /// The same with other tuning than the default.
    pub fn with(told: R, params: FrictionParams<R>) -> Self {
        let zero = R::zero();
        let of_rig = params.spread_told * params.spread_told - params.spread_grasp * params.spread_grasp;
        Self::of(Rig { median: told, variance: max(of_rig, zero), spread: params.spread_told }, told, params)
    }

    /// A grasp in which nothing was seen yet.
    fn of(rig: Rig<R>, told: R, params: FrictionParams<R>) -> Self {
        let zero = R::zero();
        Self {
            params,
            told,
            rig,
            slid_at: None,
            median: rig.median,
            spread: rig.spread,
            proven: zero,
            holds: zero,
            level: zero,
            steady_s: zero,
            peak: zero,
        }
    }

    /// Exponent of the distribution.
    fn steepness(&self) -> R {
        R::pi() / (R::of(1.732_050_8) * self.spread)
    }

    /// Median before `held` cuts it off: what told of less than was held was wrong.
    fn middle(&self, held: R) -> R {
        max(self.median, held)
    }

    /// Odds against more than `x` times the median.
    fn odds(&self, x: R) -> R {
        if x > R::zero() { x.powf(self.steepness()) } else { R::zero() }
    }

    /// There is more than this with the probability `p`, where so much is `held`.
    // Once in the program: it is asked for in a dozen places.
    #[inline(never)]
    fn quantile(&self, p: R, held: R) -> R {
        let middle = self.middle(held);
        if !(middle > R::zero()) {
            return R::zero();
        }
        let odds = (R::one() + self.odds(held / middle)) / p - R::one();
        middle * odds.powf(R::one() / self.steepness())
    }

    /// Probability that there is as much as `needed`.
    #[inline(never)]
    pub fn probability_of(&self, needed: R) -> R {
        let held = max(self.proven, self.holds);
        if !(needed > held) {
            return R::one();
        }
        let middle = self.middle(held);
        (R::one() + self.odds(held / middle)) / (R::one() + self.odds(needed / middle))
    }

    /// The coefficient: as likely more as less.
    pub fn estimate(&self) -> R {
        self.quantile(R::of(0.5), self.proven)
    }

    /// What the model is to reckon with: pads that hold a load do not slip under it, and not
    /// at the next tremor.
    pub fn assumed(&self) -> R {
        let held = max(self.proven, self.holds);
        self.quantile(R::of(0.5), min(held, self.told * self.params.most_share))
    }

    /// What was held without slip; zero where nothing was.
    pub fn proven(&self) -> R {
        self.proven
    }

    /// The least that it may be.
    pub fn least(&self) -> R {
        self.quantile(self.params.sure, self.proven)
    }

    /// The least that is likely, whatever was held.
    pub fn likely(&self) -> R {
        self.quantile(self.params.likely, R::zero())
    }

    /// Slow mean of what was needed.
    pub fn level(&self) -> R {
        self.level
    }

    /// Loads have been clipped at `needed`: there is no more than that. A flat top below the least friction there may be
    /// was held: far more loads happen to be flat than there is so much less friction.
    pub fn cap(&mut self, needed: R) {
        let bound = max(needed, self.told * self.params.least_share);
        if bound < self.median && needed > self.least() {
            (self.median, self.spread) = (bound, self.params.spread_learnt);
        }
    }

    /// Another grasp with the same fingers: friction varies from grasp to grasp about that of the rig, of which the slips
    /// of this one tell.
    pub fn regrasped(&self) -> Self {
        Self::of(
            self.slid_at.map_or(self.rig, |slid_at| self.rig.told_by(slid_at, &self.params)),
            self.told,
            self.params,
        )
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
                // What is known well moves little.
                let known = self.spread < self.params.spread_told * R::of(0.5);
                let gain = if known { self.params.known_share } else { self.params.slid_share };
                self.median = clamp(self.median + (seen.needed - self.median) * gain, low, high);
                if seen.slip_s.is_some_and(|s| s > self.params.learnt_s) {
                    self.spread = self.params.spread_learnt;
                    self.slid_at = Some(self.median);
                }
                self.proven = R::zero();
            }
            self.steady_s = R::zero();
            return;
        }
        let fade = dt_s / self.params.fade_s;
        self.median += (self.rig.median - self.median) * fade;
        self.spread += (self.rig.spread - self.spread) * fade;
        self.proven -= self.proven * fade;
        if seen.steered || !(self.level > R::zero()) {
            self.level = seen.needed;
        }
        self.level += (seen.needed - self.level) * min(dt_s / self.params.level_s, R::one());
        let near = (seen.needed - self.level).abs()
            < self.level * self.params.level_share + seen.noise * self.params.level_sigmas;
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
    }
}
