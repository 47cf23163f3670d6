//! The grip force that a gripper's controller should command, never faster than the gripper can follow.
//!
//! While the object slips and is not meant to, it rises as fast as it may; where slip or drop is foreseen only, to
//! twice what it was. Without an alarm it goes to what holds: the predictor's `holding_grip_n`, the force that
//! keeps the share of friction that its limits allow. Down it goes so slowly that the predictor does not take its own
//! advice for a grip that fails. Where nothing is told to hold (the plan means to slide), it stays where it is. In
//! doubt it may rise and does not fall.

use stickslip_shared::predictor::{Prediction, flags};
use stickslip_shared::wire::GripLimits;

/// Without an alarm for so long the advice may fall, s: several times the span over which the predictor holds a
/// warning (0.15 s), so that one episode of slip is over.
const QUIET_S: f32 = 0.5;
/// A foreseen slip or drop raises the advice by this factor: it halves the share of friction in use.
const FORESEEN: f32 = 2.0;
/// Up to what holds it goes within this time, s: longer than the jaw's transients (0.1 s), in which what
/// holds is not yet known well.
const RISE_S: f32 = 0.25;
/// Down to what holds, s: four times as long as the predictor's trend of the load looks ahead for a drop (0.5 s). What holds
/// is more than what slips, so that by its trend the advice slips no sooner than after this time.
const FALL_S: f32 = 2.0;

/// The advised grip force.
#[derive(Clone, Debug)]
pub struct GripAdvice {
    limits: GripLimits,
    now_n: Option<f32>,
    /// What it was when the alarm began that lasts.
    alarmed_n: Option<f32>,
    quiet_s: f32,
}

impl GripAdvice {
    /// Within limits that passed `wire::check::grip_limits`.
    pub fn new(limits: GripLimits) -> Self {
        Self { limits, now_n: None, alarmed_n: None, quiet_s: 0.0 }
    }

    /// Other limits.
    pub fn set_limits(&mut self, limits: GripLimits) {
        self.limits = limits;
    }

    /// For one run.
    pub fn restart(&mut self) {
        (self.now_n, self.alarmed_n, self.quiet_s) = (None, None, 0.0);
    }

    /// The advice after a tick of `dt_s`, N for each finger. It begins at `commanded_n`; `None` as long as that is not
    /// known.
    pub fn follow(&mut self, prediction: &Prediction, commanded_n: f32, dt_s: f32) -> Option<f32> {
        let GripLimits { least_n, most_n, rise_n_s, fall_n_s } = self.limits;
        let known = commanded_n.is_finite().then_some(commanded_n.max(least_n).min(most_n));
        let before_n = self.now_n.or(known)?;
        let up = |bits| prediction.flags & bits != 0;
        let alarm = up(flags::UNEXPECTED | flags::SAG | flags::DROP);
        let slips = alarm && up(flags::SLIP_1 | flags::SLIP_2);
        let holding_n = prediction.holding_grip_n.filter(|x| x.is_finite()).unwrap_or(before_n);
        self.alarmed_n = alarm.then(|| self.alarmed_n.unwrap_or(before_n));
        let wanted_n = match self.alarmed_n {
            _ if slips => most_n,
            Some(alarmed_n) => holding_n.max(FORESEEN * alarmed_n).max(before_n),
            None => holding_n,
        };
        let wanted_n = wanted_n.max(least_n).min(most_n);
        self.quiet_s = if alarm || up(flags::UNSURE) { 0.0 } else { self.quiet_s + dt_s };
        let mut now_n = before_n;
        if wanted_n > before_n {
            let rate_n_s = if alarm { rise_n_s } else { rise_n_s.min((wanted_n - before_n) / RISE_S) };
            now_n = (before_n + rate_n_s * dt_s).min(wanted_n);
        } else if self.quiet_s > QUIET_S {
            let rate_n_s = fall_n_s.min((before_n - wanted_n) / FALL_S);
            now_n = (before_n - rate_n_s * dt_s).max(wanted_n);
        }
        self.now_n = Some(now_n);
        self.now_n
    }
}
