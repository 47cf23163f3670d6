//! What a comparison says: the JSON document `stickslip-compare/1`, and the traces that the
//! page draws.
//!
//! Errors are modelled minus measured, SI units.

use std::collections::BTreeMap;

use serde::Serialize;

use super::noise::Source;
use super::tare::Offsets;
use crate::channels::Signals;
use crate::evidence::conditions::Variable;
use crate::evidence::force_bands::Band;
use crate::evidence::phases::{Evidence, Phase, Phases};

/// Name of the document's format.
pub const SCHEMA: &str = "stickslip-compare/1";

/// A comparison of one data set with one or more models.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Always [`SCHEMA`].
    pub schema: &'static str,
    /// One sentence: does the model agree, and where does it fail worst?
    pub summary: String,
    /// What one should know to read the figures.
    pub notes: Vec<String>,
    /// What was compared.
    pub data: DataSummary,
    /// In the order given; the last is the one that the summary is about.
    pub models: Vec<ModelReport>,
    /// With two models or more: first against last.
    pub changes: Vec<Change>,
    /// Trials that could not be compared.
    pub skipped: Vec<Skipped>,
    /// For the page.
    #[serde(skip)]
    pub traces: Vec<Trace>,
}

/// What was compared.
#[derive(Clone, Debug, Serialize)]
pub struct DataSummary {
    /// From dataset.toml.
    pub name: String,
    /// Trials compared.
    pub trials: usize,
    /// Conditions among them.
    pub conditions: usize,
    /// Conditions run more than once.
    pub repeated_conditions: usize,
    /// Whether these were held out from calibration.
    pub held_out: bool,
    /// Where the noise floor comes from.
    pub noise_floor: Source,
    /// Family-wise chance of a false alarm among the tests.
    pub significance: f64,
}

/// One model's errors.
#[derive(Clone, Debug, Serialize)]
pub struct ModelReport {
    /// File name, or `base`.
    pub name: String,
    /// Where its parameters come from.
    pub origin: String,
    /// Coefficients of friction, by contact (`finger`), or primitive and contact (`pivot.finger`).
    pub friction: BTreeMap<String, f64>,
    /// Ids of its effects.
    pub effects: Vec<String>,
    /// Sensor offsets found with it.
    pub offsets: Offsets,
    /// One for each primitive, channel and phase, worst first.
    pub errors: Vec<ErrorRow>,
    /// Errors over pairs of conditions for the worst rows.
    pub regions: Vec<Region>,
    /// Mean errors that change with a condition, strongest evidence first.
    pub trends: Vec<Trend>,
    /// Trends looked at.
    pub trends_tested: usize,
    /// One for each trial.
    pub trials: Vec<TrialRow>,
    /// Steps whose solve did not reach its tolerance.
    pub unsolved_steps: usize,
}

/// Names what an error belongs to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Place {
    /// Primitive.
    pub primitive: String,
    /// Name of the channel.
    pub channel: &'static str,
    /// Phase.
    pub phase: Phase,
}

/// Error of one channel in one phase.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorRow {
    /// Which.
    #[serde(flatten)]
    pub place: Place,
    /// SI unit of the errors.
    pub unit: &'static str,
    /// Trials in which it is known.
    pub trials: usize,
    /// Root mean square error over all samples.
    pub rms: f64,
    /// Mean error.
    pub bias: f64,
    /// Largest error, without sign.
    pub max: f64,
    /// RMS without taking sensor offsets out.
    pub rms_with_offset: f64,
    /// Mean without taking sensor offsets out.
    pub bias_with_offset: f64,
    /// RMS that a perfect model would show; `null`: not known.
    pub noise_floor: Option<f64>,
    /// Where from.
    pub noise_source: Source,
    /// RMS over noise floor.
    pub multiples: Option<f64>,
    /// Lack of fit against the repetitions; `null` without repetitions.
    pub lack_of_fit: Option<Test>,
    /// Whether lack of fit is significant after correction and the error above the floor.
    pub fails: bool,
    /// Channel number.
    #[serde(skip)]
    pub index: usize,
}

/// F test.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Test {
    /// Ratio of mean squares.
    pub f: f64,
    /// Degrees of freedom, numerator.
    pub df_fit: f64,
    /// Degrees of freedom, denominator.
    pub df_error: f64,
    /// Of this test alone.
    pub p: f64,
    /// Corrected for all tests of the model (Holm).
    pub p_corrected: f64,
    /// Standard deviation of a run's mean error among its repetitions.
    pub pure_error: f64,
}

/// Error over two conditions.
#[derive(Clone, Debug, Serialize)]
pub struct Region {
    /// Which error.
    #[serde(flatten)]
    pub place: Place,
    /// Across.
    pub x: Variable,
    /// Up.
    pub y: Variable,
    /// Levels of `x`, in the unit of its label.
    pub x_levels: Vec<String>,
    /// Levels of `y`.
    pub y_levels: Vec<String>,
    /// Error in multiples of the noise floor, row by row (`y`); `null`: no such trial.
    pub multiples: Vec<Vec<Option<f64>>>,
}

/// Change of the mean error with a condition.
#[derive(Clone, Debug, Serialize)]
pub struct Trend {
    /// Which error.
    #[serde(flatten)]
    pub place: Place,
    /// Against what.
    pub variable: Variable,
    /// Mean error (SI) a unit of the variable (SI).
    pub slope: f64,
    /// Mean error at zero of the variable.
    pub intercept: f64,
    /// Unit of the slope.
    pub unit: String,
    /// Change of the mean error over the range of the variable, in multiples of the noise floor.
    pub span_multiples: Option<f64>,
    /// Of this test alone.
    pub p: f64,
    /// Corrected for all trends of the model (Holm).
    pub p_corrected: f64,
    /// Variable and mean error, SI; one for each condition (`order`: for each run).
    #[serde(skip)]
    pub points: Vec<(f64, f64)>,
}

/// One trial.
#[derive(Clone, Debug, Serialize)]
pub struct TrialRow {
    /// Id.
    pub trial: String,
    /// Condition number, shared by repetitions.
    pub condition: usize,
    /// Root mean square of the multiples of its channels and phases.
    pub multiples: Option<f64>,
    /// Where it is worst.
    pub worst: Option<Place>,
    /// Begin and end of each phase, s.
    pub phases: BTreeMap<&'static str, [f64; 2]>,
    /// What contact was found from.
    pub contact_from: Evidence,
    /// What motion was found from.
    pub motion_from: Evidence,
    /// Steps whose solve did not reach its tolerance.
    pub unsolved_steps: usize,
}

/// Fate of a failure from the first model to the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// Failed, and does no more.
    Gone,
    /// Fails still, by less.
    Smaller,
    /// Fails still, not by less.
    Remains,
    /// Fails only now.
    New,
    /// Failed in neither.
    Fits,
}

/// Before and after for one channel and phase.
#[derive(Clone, Debug, Serialize)]
pub struct Change {
    /// Which.
    #[serde(flatten)]
    pub place: Place,
    /// SI.
    pub unit: &'static str,
    /// RMS with the first model.
    pub rms_before: f64,
    /// RMS with the last.
    pub rms_after: f64,
    /// In noise floors.
    pub multiples_before: Option<f64>,
    /// In noise floors.
    pub multiples_after: Option<f64>,
    /// What became of it.
    pub fate: Fate,
}

/// A trial that could not be compared.
#[derive(Clone, Debug, Serialize)]
pub struct Skipped {
    /// Id.
    pub trial: String,
    /// Why.
    pub reason: String,
}

/// Signals of one trial for drawing.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Id.
    pub trial: String,
    /// Why it is shown: `worst trial`, `median trial`, `chosen trial`.
    pub role: &'static str,
    /// Its conditions in words.
    pub conditions: String,
    /// Time stamps.
    pub t_s: Vec<f64>,
    /// Measured, sensor offsets taken out as in the errors.
    pub measured: Vec<Signals>,
    /// By model.
    pub modelled: Vec<Vec<Signals>>,
    /// Phases.
    pub phases: Phases,
    /// Half width of the noise band of each channel and phase; NaN where not known.
    pub band: Vec<[f64; 5]>,
    /// Time and interval of each force over all force distributions that the last model
    /// allows; empty where it determines them.
    pub force_bands: Vec<(f64, Band)>,
}
