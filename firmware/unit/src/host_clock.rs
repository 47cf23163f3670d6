//! The host's clock by the unit's: when a sample was measured that carries the host's time, and what of it is too old to be
//! a measurement of this tick.
//!
//! Host and unit exchange times (`ReadClock`), the host tells what it found ([`HostClock`]). Without that a sample
//! counts as measured when it is taken.

use stickslip_shared::wire::{HostClock, Sample, TICK_US};

/// Age beyond which a wrench of the host is none, us: two and a half of the unit's ticks. One is the host's own period, one
/// passes until a tick takes it, half of one is the line's.
pub const WRENCH_AGE_US: u32 = 2 * TICK_US + TICK_US / 2;
/// Age beyond which the host's poses of gripper and pusher, and its grip command, count as not known, us:
/// five ticks, more than the jitter of a USB serial line (1 to 16 ms), in which the fastest plan here moves
/// 0.5 mm (25 mm/s).
pub const MAX_AGE_US: u32 = 20_000;
/// A time to come by no more than this is now, us: an exchange over USB leaves as much open.
const AHEAD_US: u32 = 2_000;

/// A time of the host by the unit's clock, us; both may wrap around. Nearest to when the clock was told: beyond 35 minutes from
/// there it is a time long ago.
pub fn at_us(clock: &HostClock, host_us: u32) -> u32 {
    let since = host_us.wrapping_sub(clock.host_us).cast_signed();
    // A tenth of a second at most of half an hour: single precision is enough.
    let gained = (since as f32 * clock.drift) as i32;
    clock.board_us.wrapping_add_signed(since).wrapping_add_signed(gained)
}

/// How old a measurement of `at_us` is at `now_us`, us. One of a time to come is older than any: the clock was set.
pub fn age_us(at_us: u32, now_us: u32) -> u32 {
    if at_us.wrapping_sub(now_us) <= AHEAD_US { 0 } else { now_us.wrapping_sub(at_us) }
}

/// What of a host's sample is a measurement at such an age, us.
pub fn as_measured(sample: Sample, age_us: u32) -> Sample {
    let mut left = sample;
    if age_us > WRENCH_AGE_US {
        left.finger = [None; 2];
    }
    if age_us > MAX_AGE_US {
        (left.gripper, left.object, left.pusher, left.grip_cmd_n) = (None, None, None, f32::NAN);
    }
    left
}
