//! Slip detected from the wrenches alone: a load that is clipped.
//!
//! Pads that slide carry `mu N`, whatever pulls at them: the needed ratio climbs to the
//! coefficient and stays there, flat within its noise. A knock that is held has a peak
//! instead. Five samples are flat if neither their slope nor their curvature is proven or a
//! tenth of the climb. Where the ratio *jumped* to its plateau, the load may have been far
//! more than what the pads carry, so the least friction that is likely is enough to call it
//! slip; where it rose slowly, it must have reached the friction there is. A load that has
//! been held for long is a load. So is one that first went higher: what the pads carried a
//! moment ago without sliding they carry still (but for the break-away that the model knows).
//! So is one under which the object has come to rest, as a push leaves it.
//! While the gripper gains speed, a held load is more than the weight by the acceleration; one
//! that stays as high when the gain ends is clipped, so the least likely friction waits for that.
//!
//! A short jump that is flat wherever it lies was clipped, most likely: where it ends within
//! a tenth of a second, its height is a ceiling of friction to be learnt from.

use crate::real::{Real, max, min, sqrt};
use crate::tuning::tuned;
use crate::window::shift_in;

/// Samples that must be flat.
const FLAT: usize = 5;

tuned! {
    /// What was chosen in it.
    pub struct PlateauParams<R> {
        /// Slope and curvature of a flat load over the window, as a share of the jump. Doubled: peaks of knocks pass
        /// for clipped.
        flat_share: R = R::of(0.12), 0.0 to 2.0;
        /// The same in standard deviations. Doubled: under noise, slow ramps pass for flat.
        flat_sigmas: R = R::of(2.0), 0.0 to 100.0;
        /// A jump is at least this share of the ratio. Doubled: clipped loads of less than a fifth more wait for the estimated friction.
        jump_share: R = R::of(0.1), 0.0 to 10.0;
        /// And so many standard deviations. Doubled: the same under noise.
        jump_sigmas: R = R::of(8.0), 0.0 to 100.0;
        /// A flat load is over its bar by so many deviations of such means. Doubled: slips without a pose are seen later.
        means_sigmas: R = R::of(2.0), 0.0 to 100.0;
        /// And so many above the slow mean of the load, where that is below the bar: by chance some 30 times an hour where
        /// the bar lies 1.6 of them above the load. Doubled: slips without a pose under a noise of
        /// a tenth of the load are not seen.
        level_sigmas: R = R::of(4.5), 0.0 to 100.0;
        /// Share with which a difference of means enters their variance: 0.4 s. Doubled: known, and forgotten, in half of it.
        spread_share: R = R::of(0.05), 0.001 to 1.0;
        /// How much more than the variance so far one difference counts. Doubled: knocks count as noise.
        spread_most: R = R::of(4.0), 1.0 to 1000.0;
        /// A plateau that follows a jump begins within so many samples of it: 60 ms. Doubled: ramps after a jump count as jumps.
        after_jump: u8 = 15, 1.0 to 250.0;
        /// A peak so far above the plateau, as a share of it, was carried. Doubled: friction that falls by so much with speed hides no slip.
        carried_share: R = R::of(0.02), 0.0 to 10.0;
        /// The same in standard deviations. Doubled: the same under noise.
        carried_sigmas: R = R::of(2.5), 0.0 to 100.0;
        /// The load that went higher has gone where the ratio falls below this share of its peak. Above 1, every sample forgets it.
        gone_share: R = R::of(0.8), 0.0 to 1.5;
        /// The plateau ends where the ratio falls below this share of it, ... Above 1, it never lasts.
        ended_share: R = R::of(0.95), 0.0 to 1.5;
        /// ... less so many standard deviations. Doubled: under noise it is seen to end later.
        ended_sigmas: R = R::of(2.0), 0.0 to 100.0;
        /// A knock that was clipped lasts so many samples at least: one that was not is narrower at half its height than at its
        /// foot. Doubled: knocks of less than 72 ms teach nothing.
        least_knock: u8 = 9, 5.0 to 250.0;
        /// And at most. Doubled: steps of the load of up to 0.2 s teach a ceiling.
        longest_knock: u8 = 25, 6.0 to 250.0;
        /// It adds so much to the load. Doubled: smaller ones teach nothing.
        knock_share: R = R::of(0.15), 0.0 to 10.0;
        /// Above its flat top by half of its height, or by so many standard deviations, it goes on rising. Doubled: under noise,
        /// knocks that are held teach a ceiling.
        rising_sigmas: R = R::of(4.0), 0.0 to 100.0;
    }
}

/// State.
#[derive(Clone, Debug)]
pub struct Plateau<R: Real> {
    params: PlateauParams<R>,
    /// Ratios, the newest first; how many there are.
    recent: [R; FLAT],
    count: u8,
    /// Samples since the ratio last jumped, and what it was before.
    since_jump: u8,
    before: R,
    /// Highest ratio of the present load.
    peak: R,
    /// Where it is clipped, and for how many samples it has been.
    at: R,
    clipped: u8,
    /// A flat top: its height, how long it has been there, and where the load was before.
    top: R,
    lasting: u8,
    base: R,
    /// Height of a knock that has just ended.
    ceiling: Option<R>,
    /// Variance of the mean about the level: noise that is not white shows there.
    spread: R,
    last_mean: R,
    since_mean: u8,
    /// Under this the object has come to rest, and it has not fallen much since; zero: none.
    borne: R,
}

/// What one sample is held against.
#[derive(Clone, Copy, Debug)]
pub struct Bars<R: Real> {
    /// The ratio, not smoothed.
    pub now: R,
    /// Slow mean of it.
    pub level: R,
    /// Noise of a sample, standard deviation.
    pub noise: R,
    /// Ratio that has been held for long.
    pub held: R,
    /// The planned motion is changing, and the load with it.
    pub steered: bool,
    /// The gripper gains or loses speed by the plan.
    pub accelerates: bool,
    /// Ratio that is slip where it was reached slowly.
    pub risen: R,
    /// The same for a jump.
    pub jumped: R,
    /// Friction while sliding over that at rest.
    pub sliding: R,
}

impl<R: Real> Default for Plateau<R> {
    fn default() -> Self {
        Self::new(PlateauParams::default())
    }
}

impl<R: Real> Plateau<R> {
    /// No load yet.
    pub fn new(params: PlateauParams<R>) -> Self {
        let zero = R::zero();
        Self {
            params,
            recent: [zero; FLAT],
            count: 0,
            since_jump: u8::MAX,
            before: zero,
            peak: zero,
            at: zero,
            clipped: 0,
            top: zero,
            lasting: 0,
            base: zero,
            ceiling: None,
            spread: zero,
            last_mean: zero,
            since_mean: 0,
            borne: zero,
        }
    }

    /// Takes one sample; for how many samples the load has been clipped, zero where it is not.
    pub fn clipped(&mut self, s: &Bars<R>) -> u8 {
        shift_in(&mut self.recent, s.now);
        self.count = self.count.saturating_add(1).min(FLAT as u8);
        self.follow(s);
        let flat = self.flat(s);
        self.knock(s, flat);
        if s.now < self.borne * self.params.gone_share {
            self.borne = R::zero();
        }
        let lasts = s.now > self.at * self.params.ended_share - s.noise * self.params.ended_sigmas
            && max(s.held, self.borne) < self.at * self.params.ended_share;
        self.note_mean(s);
        if self.clipped > 0 && lasts {
            self.clipped = self.clipped.saturating_add(1);
        } else {
            self.clipped = match flat {
                Some((mean, jumped)) if !self.carried_more(mean, s) && self.beyond(mean, jumped, s) => {
                    self.at = mean;
                    FLAT as u8
                }
                _ => 0,
            };
        }
        self.clipped
    }

    /// The object has come to rest under a load.
    pub fn bears(&mut self, ratio: R) {
        self.borne = ratio;
    }

    /// It slides by its pose.
    pub fn slides(&mut self) {
        self.borne = R::zero();
    }

    /// The flat load is over its bar: by more than the noise of its mean makes once in hours.
    fn beyond(&self, mean: R, jumped: bool, s: &Bars<R>) -> bool {
        let bar = if jumped && !s.accelerates { min(s.jumped, s.risen) } else { s.risen };
        let borne =
            self.borne * (R::one() + self.params.carried_share) + s.noise * self.params.carried_sigmas;
        let bar = if self.borne > R::zero() { max(bar, borne) } else { bar };
        let sigma = sqrt(self.spread);
        // The load that stays is over the bar, or what is over it is no noise of that load.
        let departs = s.level > bar || mean - s.level > sigma * self.params.level_sigmas;
        departs && mean > bar + sigma * self.params.means_sigmas
    }

    /// Variance of the mean of five samples, by what consecutive ones differ: noise that is not white shows there,
    /// a ramp does not.
    fn note_mean(&mut self, s: &Bars<R>) {
        self.since_mean += 1;
        if (self.since_mean as usize) < FLAT {
            return;
        }
        self.since_mean = 0;
        let [a, b, c, d, e] = self.recent;
        let mean = (a + b + c + d + e) * R::of(0.2);
        let change = mean - self.last_mean;
        self.last_mean = mean;
        let most = max(self.spread, s.noise * s.noise * R::of(0.2)) * self.params.spread_most;
        self.spread += (min(change * change * R::of(0.5), most) - self.spread) * self.params.spread_share;
    }

    /// Height at which a knock was clipped that has ended with this sample.
    pub fn ceiling(&self) -> Option<R> {
        self.ceiling
    }

    /// Follows jumps and the peak.
    fn follow(&mut self, s: &Bars<R>) {
        if !s.accelerates {
            self.since_jump = self.since_jump.saturating_add(1);
        }
        let [now, .., last] = self.recent;
        let jump = now - last;
        if self.count as usize == FLAT
            && jump > max(now * self.params.jump_share, s.noise * self.params.jump_sigmas)
        {
            if self.since_jump > self.params.after_jump {
                self.before = last;
            }
            self.since_jump = FLAT as u8 - 1;
        }
        let gone = now < self.peak * self.params.gone_share;
        self.peak = if gone { now } else { max(self.peak, now) };
    }

    /// The present load was more than `mean`, by more than noise and break-away explain.
    fn carried_more(&self, mean: R, s: &Bars<R>) -> bool {
        let share = (R::one() + self.params.carried_share) / min(max(s.sliding, R::of(0.1)), R::one());
        self.peak > mean * share + s.noise * self.params.carried_sigmas
    }

    fn knock(&mut self, s: &Bars<R>, flat: Option<(R, bool)>) {
        self.ceiling = None;
        if s.steered {
            self.lasting = 0;
            return;
        }
        if self.lasting == 0 {
            if let Some((mean, true)) = flat
                && mean > self.before * (R::one() + self.params.knock_share)
                && !self.carried_more(mean, s)
            {
                (self.top, self.base, self.lasting) = (mean, self.before, FLAT as u8);
            }
            return;
        }
        self.lasting = self.lasting.saturating_add(1);
        let height = self.top - self.base;
        if s.now > self.top + max(height * R::of(0.5), s.noise * self.params.rising_sigmas)
            || self.lasting > self.params.longest_knock
        {
            // It went on rising, or it stays: no knock.
            self.lasting =
                if self.lasting > self.params.longest_knock && s.now > self.base + height * R::of(0.5) {
                    self.params.longest_knock
                } else {
                    0
                };
        } else if s.now < self.base + height * R::of(0.5) {
            self.ceiling = (self.params.least_knock..self.params.longest_knock)
                .contains(&self.lasting)
                .then_some(self.top);
            self.lasting = 0;
        }
    }

    /// Mean of the last samples where they are flat, and whether they jumped there.
    fn flat(&self, s: &Bars<R>) -> Option<(R, bool)> {
        let [a, b, c, d, e] = self.recent;
        let mean = (a + b + c + d + e) * R::of(0.2);
        let jump = mean - s.level;
        let jumped = self.since_jump < self.params.after_jump;
        let slope = ((a + b) - (d + e)).abs() * R::of(0.5);
        let bend = ((b + c + d) * R::of(1.0 / 3.0) - (a + e) * R::of(0.5)).abs();
        let bound = max(jump.abs() * self.params.flat_share, s.noise * self.params.flat_sigmas);
        (self.count as usize == FLAT && slope < bound && bend < bound).then_some((mean, jumped))
    }
}
