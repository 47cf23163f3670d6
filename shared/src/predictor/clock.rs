//! Time counted from an epoch: in `f32` seconds from the trial's beginning the sampling time would be lost within
//! an hour. The line's stamps have 32 bits of microseconds and wrap around every 71 minutes.

use crate::real::Real;

/// The epoch moves on after so long.
const EPOCH_US: u32 = 32_000_000;

/// Where time is counted from.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Clock {
    /// Since the trial's beginning.
    epoch_us: u64,
}

impl Clock {
    /// From the trial's beginning to the epoch, s.
    pub(super) fn epoch_s(&self) -> f32 {
        self.epoch_us as f32 * 1e-6
    }

    /// By how much the epoch must move on to a stamp, us; `None`: not yet. The first sample of a grasp sets it.
    pub(super) fn overdue_us(&self, stamp_us: u32, first: bool) -> Option<u32> {
        // The stamp's 32 bits are the lowest of the epoch's 64.
        let since_us = stamp_us.wrapping_sub(self.epoch_us as u32);
        (first || (EPOCH_US..=u32::MAX / 2).contains(&since_us)).then_some(since_us)
    }

    /// Moves the epoch on; what was counted from it is so much less now, s.
    pub(super) fn move_on(&mut self, by_us: u32) -> f32 {
        self.epoch_us = self.epoch_us.wrapping_add(u64::from(by_us));
        by_us as f32 * 1e-6
    }

    /// A stamp's time from the epoch, s.
    pub(super) fn time_s<R: Real>(&self, stamp_us: u32) -> R {
        // Beyond half the range it lies before the epoch.
        let since_us = stamp_us.wrapping_sub(self.epoch_us as u32).cast_signed();
        R::of(f64::from(since_us)) * R::of(1e-6)
    }
}
