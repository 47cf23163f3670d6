//! Warnings judged by a key: what a simulator knows of slip and drop, not what a pose shows of it.
//!
//! The key names each trial's scenario, its gross slips and its drop. The first gross slip longer
//! than [`SLIPPED_M`] of each trial is judged: what *builds up* (`b` grip decays, `f` mass is poured
//! in) must be warned of 100 ms before; where *friction falls* slowly (`e`, not sudden), within 40 ms
//! after; the *sudden* (`a` lift-off, `c` acceleration, `d` knock, quick `e`) within 20 and 40 ms. A drop
//! must be warned of before it happens. An alarm episode (pauses under 0.2 s bridged, as everywhere in
//! [`super::alarms`]) is false where within 0.5 s of it there is neither a gross slip nor an
//! irreversible partial slip of more than [`PARTIAL_M`].

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};

use super::alarms::Episode;
use super::rate::{CONFIDENCE, Rate};

/// Gross slip from which an episode of the key is judged, m.
pub const SLIPPED_M: f64 = 3e-4;
/// Irreversible partial slip that makes an alarm right, m.
pub const PARTIAL_M: f64 = 1.2e-4;
/// An alarm that ended so long before a slip still announced it, s.
const ANNOUNCED_S: f64 = 0.5;
/// A slip that was not warned of until so long after it began was missed, s.
pub const MISSED_S: f64 = 0.1;
/// A drop that follows its slip by this can be warned of that long ahead, s.
pub const DROP_AHEAD_S: f64 = 0.36;

/// What is true of a trial.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct TrialKey {
    /// Letter of the scenario.
    pub scenario: String,
    /// Which of its kind.
    pub sub: String,
    /// Class, as the simulator names it.
    pub cls: String,
    /// Gross slips: beginning, end, s; how far, m.
    pub episodes: Vec<[f64; 3]>,
    /// Slips of part of the patch: beginning, end, s; greatest share; irreversible displacement, m.
    #[serde(default)]
    pub partial: Vec<[f64; 4]>,
    /// When the grasp was lost, s.
    pub drop: Option<f64>,
    /// Friction coefficient that is told.
    #[serde(default)]
    pub told: Option<f64>,
    /// That at which it truly lets go, at the start.
    #[serde(default)]
    pub mu: Option<f64>,
    /// True place of the object in the gripper along X and Z about the beginning of each gross slip: time (s), m.
    #[serde(default)]
    pub about_slips: Vec<Vec<[f64; 3]>>,
}

/// A key: trials by name.
#[derive(Clone, Debug, Deserialize)]
pub struct Key {
    /// See [`TrialKey`].
    pub trials: BTreeMap<String, TrialKey>,
}

/// Classes of slips that are judged alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Grip decays, mass is poured in.
    BuildsUp,
    /// Friction falls slowly.
    FrictionFalls,
    /// Everything else.
    Sudden,
}

impl TrialKey {
    /// Class of the trial's slips.
    pub fn class(&self) -> Class {
        match self.scenario.as_str() {
            "b" | "f" => Class::BuildsUp,
            "e" if self.sub != "sudden" => Class::FrictionFalls,
            _ => Class::Sudden,
        }
    }

    /// The slip that is judged: beginning, s.
    pub fn slip_s(&self) -> Option<f64> {
        self.episodes.iter().find(|[.., m]| *m > SLIPPED_M).map(|[from, ..]| *from)
    }

    /// Times within which an alarm is right: from, to, s.
    fn reasons(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let gross = self.episodes.iter().filter(|[.., m]| *m > PARTIAL_M).map(|[a, b, _]| (*a, *b));
        let partial = self.partial.iter().filter(|[.., m]| *m > PARTIAL_M).map(|[a, b, ..]| (*a, *b));
        gross.chain(partial).chain(self.drop.map(|d| (d, d)))
    }
}

/// A count of all there were.
#[derive(Clone, Copy, Debug, Default, JsonSchema, Serialize)]
pub struct Share {
    /// Found in time.
    pub found: usize,
    /// All.
    pub of: usize,
}

impl Share {
    /// Counts one.
    pub fn count(&mut self, found: bool) {
        self.found += usize::from(found);
        self.of += 1;
    }

    /// Those of more trials.
    pub fn join(&mut self, other: &Self) {
        self.found += other.found;
        self.of += other.of;
    }

    /// Clopper-Pearson interval; `None` of nothing.
    pub fn interval(&self) -> Option<[f64; 2]> {
        if self.of == 0 {
            return None;
        }
        let (k, n, tail) = (self.found as f64, self.of as f64, 0.5 * (1.0 - CONFIDENCE));
        let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |d| d.inverse_cdf(p));
        let low = if self.found == 0 { 0.0 } else { quantile(k, n - k + 1.0, tail) };
        let high = if self.found == self.of { 1.0 } else { quantile(k + 1.0, n - k, 1.0 - tail) };
        Some([low, high])
    }
}

/// Events in some time.
#[derive(Clone, Copy, Debug, Default, JsonSchema, Serialize)]
pub struct Events {
    /// How many.
    pub count: usize,
    /// In how long.
    pub hours: f64,
}

impl Events {
    fn join(&mut self, other: &Self) {
        self.count += other.count;
        self.hours += other.hours;
    }

    /// Rate and its interval; `None` without any time.
    pub fn rate(&self) -> Option<Rate> {
        Rate::of(self.count, self.hours * 3600.0)
    }
}

/// Figures of a method.
#[derive(Clone, Debug, Default, JsonSchema, Serialize)]
pub struct Figures {
    /// Builds up: 100 ms ahead.
    pub builds_up: Share,
    /// Friction falls: 100 ms ahead.
    pub falls_ahead: Share,
    /// Friction falls: 40 ms after at the latest.
    pub falls: Share,
    /// Sudden: 20 ms after at the latest.
    pub sudden_20: Share,
    /// Sudden: 40 ms after at the latest.
    pub sudden_40: Share,
    /// Drops warned of before they happen.
    pub drops: Share,
    /// Drops whose slip began 360 ms before: warned that long ahead.
    pub drops_ahead: Share,
    /// False slip alarms by scenario.
    pub false_slip: BTreeMap<String, Events>,
    /// False drop alarms: no drop follows within 0.5 s of the alarm's end, and none came.
    pub false_drop: Events,
}

impl Figures {
    /// Those of more trials.
    pub fn join(&mut self, other: &Self) {
        self.builds_up.join(&other.builds_up);
        self.falls_ahead.join(&other.falls_ahead);
        self.falls.join(&other.falls);
        self.sudden_20.join(&other.sudden_20);
        self.sudden_40.join(&other.sudden_40);
        self.drops.join(&other.drops);
        self.drops_ahead.join(&other.drops_ahead);
        for (scenario, rate) in &other.false_slip {
            self.false_slip.entry(scenario.clone()).or_default().join(rate);
        }
        self.false_drop.join(&other.false_drop);
    }

    /// False slip alarms of all scenarios together.
    pub fn all_false(&self) -> Events {
        self.false_slip.values().fold(Events::default(), |mut sum, rate| {
            sum.join(rate);
            sum
        })
    }
}

/// Up to when a trial is judged, s.
pub fn until_s(key: &TrialKey, t_s: &[f64]) -> f64 {
    let end = t_s.last().copied().unwrap_or(0.0);
    key.drop.map_or(end, |d| d.min(end))
}

/// When the trial's first gross slip began, where no alarm for slip met it until [`MISSED_S`] after.
pub fn missed_s(key: &TrialKey, slip: &[Episode]) -> Option<f64> {
    let met = |at: f64| slip.iter().any(|a| a.from_s <= at + MISSED_S && a.to_s + ANNOUNCED_S >= at);
    key.slip_s().filter(|at| !met(*at))
}

/// One trial's figures: episodes of the alarms for slip and for drop.
pub fn judge(key: &TrialKey, slip: &[Episode], drop: &[Episode], until_s: f64) -> Figures {
    let mut figures = Figures::default();
    // Earliest alarm that is up at `at`, ended shortly before, or begins before `latest`.
    let lead = |alarms: &[Episode], at: f64, latest: f64| {
        alarms
            .iter()
            .filter(|a| a.from_s <= latest && a.to_s + ANNOUNCED_S >= at)
            .map(|a| at - a.from_s)
            .reduce(f64::max)
    };
    if let Some(at) = key.slip_s() {
        let lead = lead(slip, at, at + MISSED_S);
        let by = |s: f64| lead.is_some_and(|l| l >= s);
        match key.class() {
            Class::BuildsUp => figures.builds_up.count(by(0.1)),
            Class::FrictionFalls => {
                figures.falls_ahead.count(by(0.1));
                figures.falls.count(by(-0.04));
            }
            Class::Sudden => {
                figures.sudden_20.count(by(-0.02));
                figures.sudden_40.count(by(-0.04));
            }
        }
    }
    if let Some(at) = key.drop {
        let lead = lead(drop, at, at);
        figures.drops.count(lead.is_some_and(|l| l > 0.0));
        if key.slip_s().is_some_and(|s| at - s >= DROP_AHEAD_S) {
            figures.drops_ahead.count(lead.is_some_and(|l| l >= DROP_AHEAD_S));
        }
    }
    let hours = until_s / 3600.0;
    let wrong = slip.iter().filter(|a| {
        !key.reasons().any(|(from, to)| a.from_s <= to + ANNOUNCED_S && a.to_s + ANNOUNCED_S >= from)
    });
    figures.false_slip.insert(key.scenario.clone(), Events { count: wrong.count(), hours });
    let wrong = drop.iter().filter(|a| !key.drop.is_some_and(|d| a.to_s + ANNOUNCED_S >= d));
    figures.false_drop = Events { count: wrong.count(), hours };
    figures
}
