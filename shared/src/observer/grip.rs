//! The grip command, and where it leads: a command that falls steadily runs out, one that steps to a new level
//! leads to that level and no further.

use crate::real::{Real, max, min};
use crate::tuning::tuned;

tuned! {
    /// What was chosen in it.
    pub struct GripParams<R> {
        /// The slowest jaw has followed a step of its command after this, s. Doubled: its gain is learnt that much later.
        settled_s: R = R::of(1.0), 0.01 to 100.0;
        /// A commanded fall shorter than this is a re-grasp, s: it is judged by its level, not by its slope. Doubled: a grip that
        /// decays is warned of 0.12 s later.
        regrasp_s: R = R::of(0.12), 0.0 to 10.0;
        /// A grip command that falls is extrapolated by this share of the time for which it has fallen. Doubled: ramps that stop
        /// short are warned of twice as early.
        goes_on: R = R::of(1.0), 0.0 to 100.0;
        /// Samples in which a falling command becomes a trend: 60 ms. Doubled: friction is learnt from loads under a grip that
        /// has fallen for 60 ms.
        falling_samples: u8 = 15, 1.0 to 250.0;
        /// Share with which a change of the command enters its trend: 27 ms. Doubled: steps of a command that falls in steps show
        /// in the time left.
        trend_share: R = R::of(0.15), 0.01 to 1.0;
        /// Smoothing of the normal force: three samples. Doubled: its noise is 1.6 times as large.
        smoothing: R = R::of(0.3), 0.01 to 1.0;
        /// A command that changes by less than this in a second stands, N/s. Doubled: slower decays are not seen.
        least_n_s: R = R::of(0.05), 0.0 to 1000.0;
    }
}

/// The grip command, and the normal force that it leads to.
#[derive(Clone, Debug)]
pub(super) struct Grip<R: Real> {
    params: GripParams<R>,
    command_n: R,
    trend_n_s: R,
    falling: u8,
    falls_s: R,
    /// Since the command last fell, and since it last changed, s.
    fell_s: R,
    changed_s: R,
    /// Normal force now, and over the command where that has settled.
    normal_n: R,
    gain: R,
}

impl<R: Real> Grip<R> {
    pub(super) fn new(params: GripParams<R>) -> Self {
        let (zero, long) = (R::zero(), R::of(10.0));
        Self {
            params,
            command_n: zero,
            trend_n_s: zero,
            falling: 0,
            falls_s: zero,
            fell_s: long,
            changed_s: long,
            normal_n: zero,
            // Two fingers.
            gain: R::of(2.0),
        }
    }

    /// The command has not fallen.
    pub(super) fn holds(&self) -> bool {
        self.falling == 0
    }

    /// One sample.
    pub(super) fn follow(&mut self, command_n: R, normal_n: Option<R>, dt_s: R) {
        self.fell_s += dt_s;
        self.changed_s += dt_s;
        if self.command_n > R::zero() {
            let rate = (command_n - self.command_n) / dt_s;
            self.trend_n_s += (rate - self.trend_n_s) * self.params.trend_share;
            let falls = rate < -self.params.least_n_s;
            self.falling =
                if falls { self.falling.saturating_add(1).min(self.params.falling_samples) } else { 0 };
            self.falls_s = if falls { self.falls_s + dt_s } else { R::zero() };
            if falls {
                self.fell_s = R::zero();
            }
            if rate.abs() > self.params.least_n_s {
                self.changed_s = R::zero();
            }
        }
        self.command_n = command_n;
        let Some(normal_n) = normal_n else { return };
        self.normal_n += (normal_n - self.normal_n) * self.params.smoothing;
        if self.changed_s > self.params.settled_s && command_n > R::of(0.05) {
            let gain = self.normal_n / command_n;
            let share = min(dt_s / self.params.settled_s, R::one());
            self.gain += (gain - self.gain) * share;
        }
    }

    /// The ratio that the command leads to, while the normal force is still on its way down to it.
    pub(super) fn comes_to(&self, ratio: R) -> Option<R> {
        let on_its_way = self.falls_s < self.params.regrasp_s && self.fell_s < self.params.settled_s;
        let settled_n = self.gain * self.command_n;
        (on_its_way && settled_n > R::of(0.02)).then(|| ratio * max(self.normal_n / settled_n, R::one()))
    }

    /// For how long the command has been falling steadily, s.
    pub(super) fn has_fallen_s(&self) -> Option<R> {
        (self.falls_s >= self.params.regrasp_s && self.trend_n_s < R::zero()).then_some(self.falls_s)
    }

    /// The ratio after so long, if a command that falls goes on.
    pub(super) fn ratio_in(&self, ratio: R, after_s: R) -> R {
        let left_n = max(self.command_n + self.trend_n_s * after_s, self.command_n * R::of(0.1));
        if left_n > R::zero() { ratio * self.command_n / left_n } else { ratio }
    }

    /// Time until a grip command that falls steadily is too little.
    pub(super) fn runs_out(&self, ratio: R, limit: R) -> Option<R> {
        let falls_s = self.has_fallen_s()?;
        let lasts = self.command_n / -min(self.trend_n_s, R::of(-1e-6));
        let left_s = max(lasts * (R::one() - ratio / limit), R::zero());
        // A fall that has lasted for so long may last as long again: a re-grasp ends sooner.
        (left_s < falls_s * self.params.goes_on).then_some(left_s)
    }
}
