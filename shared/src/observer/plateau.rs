//! Slip told from the wrenches alone: a load that is clipped.
//!
//! Pads that slide carry `mu N`, whatever pulls at them: the needed ratio climbs to the
//! coefficient and stays there, flat within its noise. A knock that is held has a peak
//! instead. Five samples are flat if neither their slope nor their curvature is proven or a
//! tenth of the climb. Where the ratio *jumped* to its plateau, the load may have been far
//! more than what the pads carry, so the least friction that is likely is enough to call it
//! slip; where it rose slowly, it must have reached the friction there is. A plateau that
//! lies below, or a load that has been held for long, is a load.

use crate::real::{Real, least};

/// Samples that must be flat.
const FLAT: usize = 5;
/// Slope and curvature over the window, as a share of the jump and in standard deviations.
const FLAT_SHARE: f64 = 0.12;
const FLAT_SIGMAS: f64 = 2.0;
/// A jump is at least this share of the bar, and so many standard deviations.
const JUMP_SHARE: f64 = 0.1;
const JUMP_SIGMAS: f64 = 8.0;
/// The plateau ends where the ratio falls below this share of it, less two standard deviations.
const ENDED_SHARE: f64 = 0.95;

/// State.
#[derive(Clone, Debug)]
pub struct Plateau<R: Real> {
    /// Ratios, the newest first; how many there are.
    recent: [R; FLAT],
    count: u8,
    /// Where it is clipped, and for how many samples it has been.
    at: R,
    clipped: u8,
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
    /// Ratio that is slip where it was reached slowly.
    pub risen: R,
    /// The same for a jump.
    pub jumped: R,
}

impl<R: Real> Default for Plateau<R> {
    fn default() -> Self {
        Self { recent: [R::zero(); FLAT], count: 0, at: R::zero(), clipped: 0 }
    }
}

impl<R: Real> Plateau<R> {
    /// Takes one sample; for how many samples the load has been clipped, zero where it is not.
    pub fn clipped(&mut self, s: &Bars<R>) -> u8 {
        self.recent.rotate_right(1);
        self.recent[0] = s.now;
        self.count = self.count.saturating_add(1).min(FLAT as u8);
        let lasts = s.now > self.at * R::of(ENDED_SHARE) - s.noise * R::of(2.0);
        if self.clipped > 0 && lasts {
            self.clipped = self.clipped.saturating_add(1);
        } else {
            self.clipped = if self.begins(s) { FLAT as u8 } else { 0 };
        }
        self.clipped
    }

    fn begins(&mut self, s: &Bars<R>) -> bool {
        let [a, b, c, d, e] = self.recent;
        let mean = (a + b + c + d + e) * R::of(0.2);
        let jump = mean - s.level;
        let jumped =
            jump > least(s.jumped, s.risen) * R::of(JUMP_SHARE) && jump > s.noise * R::of(JUMP_SIGMAS);
        let bar = if jumped { least(s.jumped, s.risen) } else { s.risen };
        let slope = ((a + b) - (d + e)).abs() * R::of(0.5);
        let bend = ((b + c + d) * R::of(1.0 / 3.0) - (a + e) * R::of(0.5)).abs();
        let share = jump.abs() * R::of(FLAT_SHARE);
        let sigmas = s.noise * R::of(FLAT_SIGMAS);
        let flat = |x: R| x < share || x < sigmas;
        self.at = mean;
        self.count as usize == FLAT && mean > bar && flat(slope) && flat(bend)
    }
}
