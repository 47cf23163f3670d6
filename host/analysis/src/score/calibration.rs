//! Whether what is stated comes true: utilisation, time left until slip, grip that would hold.
//!
//! - Utilisation: of the ticks in which a held object sticks at a stated share of the
//!   friction limit, the share after which it slips within 0.1 s.
//! - Time left: at the ticks that state a slip ahead before an unexpected slip (the last
//!   half second), the time there really was.
//! - Grip: the grip at which a held object slipped as its grip fell, over the grip that was
//!   stated half a second before as just enough.

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::predictor::{Intent, Limits, Plan, Prediction};

use super::alarms::UNTRUSTED;
use super::truth::{Cause, Event, Kind, Truth};
use crate::evidence::statistics::quantiles;
use crate::run::replay::Feed;

/// Width of the bins of utilisation; the last holds what is above.
const SHARE_STEP: f64 = 0.1;
const SHARES: usize = 13;
/// Width of the bins of the time left, s.
const TIME_STEP_S: f64 = 0.05;
const TIMES: usize = 5;
/// A slip is looked for so far ahead of a tick.
const SOON_S: f64 = 0.1;
/// Time left is judged in so long before a slip, the grip stated so long before.
const BEFORE_S: f64 = 0.5;

/// What one method stated in one trial, or in all.
#[derive(Clone, Debug, Default)]
pub struct Stated {
    /// Ticks that stick, and those of them after which it slips soon, by utilisation.
    utilisation: [[usize; 2]; SHARES],
    /// Actual time left, by the time stated.
    time_left_s: [Vec<f64>; TIMES],
    grip: Vec<f64>,
}

/// One bin.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Bin {
    /// Mean of what is stated in this bin lies between.
    pub stated: [f64; 2],
    /// Ticks.
    pub ticks: usize,
    /// Utilisation: share of the ticks followed by slip. Time left: 5, 50, 95 % of the actual
    /// time left, s.
    pub actual: Vec<f64>,
}

/// For one method.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Calibration {
    /// Which.
    pub method: String,
    /// Share of the ticks that are followed by slip within 0.1 s, by stated utilisation.
    pub utilisation: Vec<Bin>,
    /// Actual time left by the time stated, s.
    pub time_left: Vec<Bin>,
    /// 5, 50, 95 % of the grip at which it slipped over that stated as just enough.
    pub grip: Option<[f64; 3]>,
    /// Slips that the last figure is of.
    pub grips: usize,
}

impl Stated {
    /// What was stated in one trial.
    pub fn in_trial(
        t_s: &[f64],
        predictions: &[Prediction],
        feed: &Feed,
        truth: &Truth,
        limits: &Limits,
    ) -> Self {
        let mut stated = Self::default();
        let slips = || truth.events.iter().filter(|e| e.kind == Kind::Slip && !e.intended);
        for (t, p) in t_s.iter().zip(predictions).take_while(|(t, _)| **t <= truth.until_s) {
            let slipping = |e: &&Event| (e.onset_s..=e.end_s + SOON_S).contains(t);
            if !holds(&feed.plan, *t) || p.validity & UNTRUSTED != 0 || slips().any(|e| slipping(&e)) {
                continue;
            }
            let used = p
                .finger
                .iter()
                .filter_map(|f| f.measured_utilisation.map(f64::from))
                .fold(f64::NAN, f64::max);
            let next = slips().map(|e| e.onset_s - t).filter(|left| *left > 0.0).reduce(f64::min);
            if let Some([ticks, slip]) =
                stated.utilisation.get_mut(((used / SHARE_STEP) as usize).min(SHARES - 1))
                && used.is_finite()
            {
                *ticks += 1;
                *slip += usize::from(next.is_some_and(|left| left <= SOON_S));
            }
            let ahead = p.finger.iter().filter_map(|f| f.slip.in_s()).map(f64::from).reduce(f64::min);
            if let (Some(left), Some(ahead)) =
                (next.filter(|left| *left <= BEFORE_S), ahead.filter(|t| *t > 0.0))
                && let Some(bin) = stated.time_left_s.get_mut((ahead / TIME_STEP_S) as usize)
            {
                bin.push(left);
            }
        }
        let grip = |at_s: f64| {
            let i = t_s.partition_point(|t| *t < at_s);
            feed.samples.get(i).zip(predictions.get(i))
        };
        for e in slips().filter(|e| e.cause == Cause::BuildsUp && e.onset_s > BEFORE_S) {
            let Some(((now, _), (_, before))) = grip(e.onset_s).zip(grip(e.onset_s - BEFORE_S)) else {
                continue;
            };
            let enough = before.holding_grip_n.map_or(0.0, |n| f64::from(n * limits.target_utilisation));
            if enough > 0.0 {
                stated.grip.push(f64::from(now.grip_cmd_n) / enough);
            }
        }
        stated
    }

    /// Both together.
    pub fn add(&mut self, other: &Self) {
        for (a, b) in self.utilisation.iter_mut().zip(&other.utilisation) {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        }
        for (a, b) in self.time_left_s.iter_mut().zip(&other.time_left_s) {
            a.extend(b);
        }
        self.grip.extend(&other.grip);
    }

    /// The figures; bins without a tick are left out.
    pub fn figures(mut self, method: &str) -> Calibration {
        let between = |i: usize, step: f64| [i as f64 * step, (i + 1) as f64 * step];
        let utilisation = self
            .utilisation
            .iter()
            .enumerate()
            .filter(|(_, b)| b[0] > 0)
            .map(|(i, [ticks, slip])| Bin {
                stated: between(i, SHARE_STEP),
                ticks: *ticks,
                actual: vec![*slip as f64 / *ticks as f64],
            })
            .collect();
        let time_left = self
            .time_left_s
            .iter_mut()
            .enumerate()
            .filter_map(|(i, left)| {
                left.sort_by(f64::total_cmp);
                let actual = quantiles(left)?.to_vec();
                Some(Bin { stated: between(i, TIME_STEP_S), ticks: left.len(), actual })
            })
            .collect();
        self.grip.sort_by(f64::total_cmp);
        let (grip, grips) = (quantiles(&self.grip), self.grip.len());
        Calibration { method: method.into(), utilisation, time_left, grip, grips }
    }
}

fn holds(plan: &Plan, t_s: f64) -> bool {
    plan.at(t_s as f32).is_none_or(|s| s.intent == Intent::Hold)
}
