//! What one trial tells, and the balance of forces over all of them.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::channels::COUNT;
use crate::check::physics::TrialPhysics;
use crate::evidence::balance::{NotChecked, StageBalance};
use crate::evidence::offsets::AtRest;

/// What one trial tells.
pub(super) struct TrialFacts {
    pub name: String,
    pub file: PathBuf,
    pub weight_n: [f64; 3],
    pub physics: TrialPhysics,
    pub samples: usize,
    pub measured: [usize; COUNT],
    pub white: [Option<f64>; COUNT],
    pub median_step_s: f64,
    pub gaps: usize,
    pub longest_gap_s: f64,
    pub balance: Result<Vec<StageBalance>, NotChecked>,
    pub offsets: Option<AtRest>,
}

/// The balance over the data set.
#[derive(Clone, Debug, Default, JsonSchema, Serialize)]
pub struct Balance {
    /// Trials in which it was formed.
    pub checked: usize,
    /// Trials in which it fails in any stage.
    pub failing: usize,
    /// Stages over the data set.
    pub stages: Vec<StageSummary>,
    /// Failing trials with their worst stage, worst first.
    pub worst: Vec<(String, StageBalance)>,
    /// Why it was not formed, and in how many trials.
    pub not_checked: Vec<(NotChecked, usize)>,
    /// Mean of the offsets found before contact, and their scatter between trials.
    pub tare: Option<TareSummary>,
}

/// One stage over the trials.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct StageSummary {
    /// Name.
    pub stage: &'static str,
    /// Trials.
    pub trials: usize,
    /// Mean of the trials' sums, world axes.
    pub mean_n: [f64; 3],
    /// Scatter of the trials' sums.
    pub scatter_n: [f64; 3],
    /// Greatest sum's component.
    pub worst_n: f64,
    /// Bound by the sensors' uncertainty.
    pub bound_n: f64,
}

/// Offsets over the trials.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct TareSummary {
    /// Trials in which they could be found.
    pub trials: usize,
    /// Fingers' sum, gripper axes: mean.
    pub fingers_sum_n: [f64; 3],
    /// Its scatter between trials.
    pub fingers_scatter_n: [f64; 3],
    /// Pusher force, world axes: mean.
    pub pusher_n: Option<[f64; 3]>,
}
