//! What the data can and cannot say about friction.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::model::Model;

use super::friction::Fit;
use super::problem::{Coefficient, Estimate};
use super::windows::Windowed;

/// Whether the object was seen to slide in the grasp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize)]
pub enum Slid {
    /// In at least one calibration trial.
    Yes,
    /// In none.
    No,
}

/// Something to know about a calibration.
#[derive(Clone, Debug, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Remark {
    /// A trial that the calibrated model misses altogether; it had hardly any say.
    Missed(String),
    /// No trial has a rest before its motion.
    NoRest,
    /// Nothing slides in the grasp; the largest measured share of tangential to normal force.
    NothingSlides {
        /// Friction is at least this; `None` where the fingers' forces were not measured.
        at_least: Option<f64>,
    },
    /// A coefficient that the data only bound.
    OnlyBounded(Coefficient),
    /// Grip force is known only from the command.
    GripNotMeasured,
    /// Measured over commanded grip, mean of the trials.
    GripRatio(f64),
    /// One level of grip only.
    OneGrip,
    /// Only this finger (1 or 2) was measured.
    OneFinger(usize),
    /// No trials are left to validate on.
    NoHeldOut,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missed(trial) => write!(
                f,
                "the calibrated model does not describe trial {trial} (grip lost, or dropped?): its weight in the fit is almost zero"
            ),
            Self::NoRest => write!(
                f,
                "no trial rests before it moves: sensor offsets could not be removed and count as force"
            ),
            Self::NothingSlides { at_least: Some(mu) } => write!(
                f,
                "nothing slides in the grasp: finger friction is only bounded, at least {mu:.3} (largest measured share of tangential to normal force). Push or pull until it slides to determine it"
            ),
            Self::NothingSlides { at_least: None } => write!(
                f,
                "nothing slides in the grasp, and the fingers' forces were not measured: finger friction is not determined"
            ),
            Self::OnlyBounded(c) => write!(
                f,
                "{} friction is not determined: the fit is equally good over the given range (its contact hardly slides, or the signals disagree)",
                name(*c)
            ),
            Self::GripNotMeasured => write!(
                f,
                "the fingers' normal forces were not measured: data show grip times friction only; the coefficient is correct only if the commanded grip is"
            ),
            Self::GripRatio(r) => write!(
                f,
                "measured grip is {r:.3} times the commanded: sliding forces show grip times friction only, so with the measured grip the finger coefficient would be that much {}",
                if *r > 1.0 { "lower" } else { "higher" }
            ),
            Self::OneGrip => write!(
                f,
                "one level of grip force only: the data do not separate an error of friction from a constant error of grip force or from adhesion"
            ),
            Self::OneFinger(k) => write!(
                f,
                "only finger {k} was measured: both fingers get one coefficient, and a difference between them would not be detected"
            ),
            Self::NoHeldOut => {
                write!(f, "every trial was needed for calibration: nothing is left to validate on")
            }
        }
    }
}

/// Name of a coefficient in text.
pub fn name(c: Coefficient) -> &'static str {
    match c {
        Coefficient::Finger => "finger",
        Coefficient::Pusher => "pusher",
        Coefficient::Support => "support",
    }
}

/// Whether the object moved in the grasp by more than pose noise.
fn slid(trials: &[&Windowed]) -> Slid {
    let moved = |w: &&Windowed| {
        let start = w.prepared.start.position_m;
        w.measured.iter().any(|row| {
            let across = (row[0] - start.x).hypot(row[2] - start.z);
            let turn = row[3].hypot(row[4]).hypot(row[5]);
            across > 2e-4 || turn > 0.01
        })
    };
    if trials.iter().any(moved) { Slid::Yes } else { Slid::No }
}

/// Where nothing slides in the grasp, forces bound friction only from below: whatever a fit
/// made of elastic details is withdrawn, and the base model's value stands where it bears what was borne.
pub fn withdraw(calibration: &[&Windowed], fit: &mut Fit, base: &Model<f64>) {
    if slid(calibration) != Slid::No {
        return;
    }
    fit.model.friction = base.friction;
    let at_least = largest_share(calibration);
    if let Some(mu) = at_least {
        fit.model.friction.finger = base.friction.finger.max(mu);
    }
    for e in &mut fit.estimates {
        e.determined = false;
        e.high = None;
        if e.coefficient == Coefficient::Finger {
            e.low = at_least;
        }
        e.value = match e.coefficient {
            Coefficient::Finger => fit.model.friction.finger,
            Coefficient::Pusher => fit.model.friction.pusher,
            Coefficient::Support => fit.model.friction.support,
        };
    }
}

/// Ratio of upper to lower end beyond which a coefficient counts as open.
const OPEN: f64 = 4.0;

/// Whether the data leave it open.
pub fn open(e: &Estimate) -> bool {
    e.low.zip(e.high).is_none_or(|(low, high)| high > OPEN * low)
}

/// What the data leave open stays what the base model says where that is within the bounds: the
/// least squares value on a plateau means nothing.
pub fn keep_base(fit: &mut Fit, base: &Model<f64>) {
    let mut base = base.clone();
    for e in fit.estimates.iter_mut().filter(|e| open(e)) {
        let known = *e.coefficient.of(&mut base);
        if e.low.is_none_or(|low| low <= known) && e.high.is_none_or(|high| known <= high) {
            e.value = known;
            *e.coefficient.of(&mut fit.model) = known;
        }
    }
}

/// Remarks on a fit, from what was measured and what moved.
pub fn remarks(calibration: &[&Windowed], held_out: &[&Windowed], fit: &Fit) -> Vec<Remark> {
    let mut out = Vec::new();
    let all = || calibration.iter().chain(held_out);
    let grasped = all().any(|w| w.prepared.scene.fingers.is_some());
    let seen = |k: usize| calibration.iter().any(|w| w.measured.iter().any(|row| row[k].is_finite()));
    if grasped {
        let fingers = [seen(7), seen(13)];
        if slid(calibration) == Slid::No {
            out.push(Remark::NothingSlides { at_least: largest_share(calibration) });
        }
        match fingers {
            [false, false] => out.push(Remark::GripNotMeasured),
            [true, false] => out.push(Remark::OneFinger(1)),
            [false, true] => out.push(Remark::OneFinger(2)),
            [true, true] => {}
        }
        if let Some(ratio) = grip_ratio(calibration).filter(|r| (r - 1.0).abs() > 0.02) {
            out.push(Remark::GripRatio(ratio));
        }
        let mut grips: Vec<f64> = calibration.iter().map(|w| w.prepared.grip_n()).collect();
        grips.sort_by(f64::total_cmp);
        if grips.first().zip(grips.last()).is_some_and(|(low, high)| high - low < 0.05 * high) {
            out.push(Remark::OneGrip);
        }
    }
    out.extend(fit.estimates.iter().filter(|e| !e.determined).map(|e| Remark::OnlyBounded(e.coefficient)));
    if held_out.is_empty() {
        out.push(Remark::NoHeldOut);
    }
    out
}

/// Largest share of tangential to normal force that a finger bore.
fn largest_share(trials: &[&Windowed]) -> Option<f64> {
    let shares = trials
        .iter()
        .flat_map(|w| &w.measured)
        .flat_map(|row| [6, 12].map(|k| row[k].hypot(row[k + 2]) / row[k + 1].abs()));
    shares.filter(|s| s.is_finite()).max_by(f64::total_cmp)
}

/// Mean of measured over commanded grip.
fn grip_ratio(trials: &[&Windowed]) -> Option<f64> {
    let mut sum = (0.0, 0.0);
    for w in trials {
        let grip = w.prepared.grip_n();
        for row in &w.measured {
            let mean = (row[13] - row[7]) * 0.5;
            if mean.is_finite() && grip > 0.0 {
                sum = (sum.0 + mean / grip, sum.1 + 1.0);
            }
        }
    }
    (sum.1 > 0.0).then(|| sum.0 / sum.1)
}
