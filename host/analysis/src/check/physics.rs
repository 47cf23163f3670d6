//! What physics does not allow, whatever the object and whatever the contact: each check is one
//! inequality on one trial (or on the description), and says what most likely caused a breach
//! of it.
//!
//! The bounds are wide. They are to find a wrong unit, sign, column or clock, never a sensor that
//! is off by some per cent: that is the balance's part (`crate::evidence::balance`).

mod breach;
mod clock;
mod frames;
mod missing;
mod signs;
mod units;

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_data::{Description, Index, Trial};

use crate::evidence::balance::{NotChecked, StageBalance};
use crate::evidence::pose_clock::{self, Delay};
use crate::evidence::stages::Stages;

pub use breach::{Breach, Cause};
pub use clock::{Clock, Clocks, Means, Unknown};

/// A breach, with the trials that show it.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Finding {
    /// Likely cause.
    pub cause: Cause,
    /// File where it shows first.
    pub file: PathBuf,
    /// Columns or keys to look at.
    pub columns: String,
    /// What, of the first such trial.
    pub text: String,
    /// Trials that show it; zero where it is about the description.
    pub trials: usize,
    /// Trials read.
    pub of: usize,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}: {}", self.file.display(), self.columns, self.text)?;
        if self.trials > 0 { write!(f, " ({} of {} trials)", self.trials, self.of) } else { Ok(()) }
    }
}

/// What the checks make of one trial.
#[derive(Clone, Debug)]
pub struct TrialPhysics {
    /// Breaches, one for each cause and column.
    pub breaches: Vec<Breach>,
    /// What is suspicious without being impossible.
    pub remarks: Vec<String>,
    /// What the trial does.
    pub primitive: String,
    /// Onsets of force and motion, or why there are none.
    pub clock: Result<Clock, Unknown>,
    /// How late the object's pose is behind the gripper's.
    pub delay: Option<pose_clock::OfTrial>,
}

/// All checks of one trial.
#[must_use]
pub fn of_trial(
    description: &Description,
    trial: &Trial,
    stages: &Stages,
    balance: &Result<Vec<StageBalance>, NotChecked>,
) -> TrialPhysics {
    let mut breaches = Vec::new();
    breaches.extend(units::time_step(description, trial));
    // With time in another unit every speed is wrong too: one cause, one sentence.
    let timed = breaches.is_empty();
    breaches.extend(units::reach(description, trial));
    breaches.extend(units::speed(trial).filter(|_| timed));
    breaches.extend(units::rotation_speed(trial).filter(|_| timed));
    breaches.extend(units::slope(trial));
    breaches.extend(units::grip(trial));
    breaches.extend(units::finger_torques(description, trial));
    breaches.extend(units::pusher_torques(description, trial));
    breaches.extend(signs::fingers(trial, balance, description));
    breaches.extend(missing::finger_columns(trial));
    breaches.extend(missing::gripper(description, trial));
    breaches.extend(missing::grip(description, trial));
    // Places in another unit or turned forces break the tests of rotations too, and a turned pusher
    // seems to pull: the first cause is the one that is named.
    let sound = !breaches
        .iter()
        .any(|b| matches!(b.cause, Cause::LengthUnit | Cause::SignsTurned | Cause::FingersSwapped));
    let order =
        if sound { frames::quaternions(description, trial, stages) } else { frames::Frames::default() };
    let turned = order.breaches.iter().any(|b| matches!(b.cause, Cause::QuaternionOrder | Cause::Frame));
    breaches.extend(order.breaches);
    breaches.extend(signs::pusher(trial).filter(|_| !turned));
    breaches.extend(signs::weight(description, trial, balance).filter(|_| !turned));
    // A motion that jumps by metres or stands still has no onset.
    let pushed = description.pushers.contains_key(&trial.info.primitive);
    let delay = if breaches.is_empty() { pose_clock::of_trial(trial) } else { None };
    let clock =
        if breaches.is_empty() { clock::clock(trial, pushed, delay.as_ref()) } else { Err(Unknown::Unsound) };
    TrialPhysics { breaches, remarks: order.remarks, primitive: trial.info.primitive.clone(), clock, delay }
}

/// Findings over the data set: those of the description, then those of the trials in the order
/// of [`Cause`], each once with the number of trials that show it.
#[must_use]
pub fn findings(index: &Index, trials: &[(PathBuf, &TrialPhysics)]) -> Vec<Finding> {
    let finding = |file: &PathBuf, breach: Breach, trials: usize, of: usize| Finding {
        cause: breach.cause,
        file: file.clone(),
        columns: breach.columns,
        text: breach.text,
        trials,
        of,
    };
    let toml = index.folder.join("dataset.toml");
    let mut found: Vec<Finding> =
        units::objects(&index.description).into_iter().map(|breach| finding(&toml, breach, 0, 0)).collect();
    for (file, physics) in trials {
        for breach in &physics.breaches {
            let same =
                |f: &&mut Finding| f.cause == breach.cause && f.columns == breach.columns && f.trials > 0;
            match found.iter_mut().find(same) {
                Some(known) => known.trials += 1,
                None => found.push(finding(file, breach.clone(), 1, trials.len())),
            }
        }
    }
    if found.is_empty() {
        let of = delay(trials.iter().map(|(_, physics)| *physics));
        let late = of.and_then(|of| Some((clock::late(&of)?, of.trials)));
        if let (Some((breach, shown)), Some((file, _))) = (late, trials.first()) {
            found.push(finding(file, breach, shown, trials.len()));
        }
        for of in by_primitive(trials.iter().map(|(file, physics)| (file, *physics))).values() {
            let clocks: Vec<Clock> = of.iter().filter_map(|(_, physics)| physics.clock.ok()).collect();
            if let (Some(breach), Some((file, _))) = (clock::offset(&clocks), of.first()) {
                found.push(finding(file, breach, clocks.len(), trials.len()));
            }
        }
    }
    found.sort_by_key(|f| f.cause);
    found
}

/// How late the object's poses are behind the gripper's, over all trials.
#[must_use]
pub fn delay<'t>(trials: impl Iterator<Item = &'t TrialPhysics>) -> Option<Delay> {
    Delay::over(&trials.filter_map(|physics| physics.delay).collect::<Vec<_>>())
}

/// Whether poses and forces go by one clock, for each primitive.
#[must_use]
pub fn clocks<'t>(trials: impl Iterator<Item = &'t TrialPhysics>) -> Vec<Clocks> {
    let of = |(primitive, trials): (&&str, &Vec<((), &TrialPhysics)>)| {
        clock::clocks(primitive, &trials.iter().map(|(_, physics)| physics.clock).collect::<Vec<_>>())
    };
    by_primitive(trials.map(|physics| ((), physics))).iter().map(of).collect()
}

fn by_primitive<'t, T>(
    trials: impl Iterator<Item = (T, &'t TrialPhysics)>,
) -> BTreeMap<&'t str, Vec<(T, &'t TrialPhysics)>> {
    let mut out: BTreeMap<&str, Vec<(T, &TrialPhysics)>> = BTreeMap::new();
    for (with, physics) in trials {
        out.entry(&physics.primitive).or_default().push((with, physics));
    }
    out
}
