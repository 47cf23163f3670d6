//! What a comparison says: the JSON document `stickslip-compare/2`, and the traces that the
//! page draws.
//!
//! SI units. A residual is modelled minus measured as it is, noise included; an error is the part
//! of it beyond the tolerance.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::models::NamedModel;
use super::noise::Source;
use super::tare::Offsets;
use crate::channels::Signals;
use crate::evidence::conditions::Variable;
use crate::evidence::contact::Evidence;
use crate::evidence::force_bands::Band;
use crate::evidence::phases::{Phase, Phases};
use crate::left_out::LeftOut;
use crate::run::bench::Bench;

/// Name of the document's format.
pub const SCHEMA: &str = "stickslip-compare/2";

/// A comparison of one data set with one or more models.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Comparison {
    /// Command and version of this document.
    pub schema: &'static str,
    /// One sentence: does the model agree, and where does it fail worst?
    pub summary: String,
    /// What one should know to read the figures.
    pub notes: Vec<String>,
    /// What was compared.
    pub data: DataSummary,
    /// In the order given; the last is the one that the summary is about.
    pub models: Vec<ModelReport>,
    /// With two models or more: first against last, both within the tolerance of the first.
    pub changes: Vec<Change>,
    /// With two models or more: the changes counted, within the first model's tolerance and
    /// without any.
    pub tallies: Vec<Tally>,
    /// Trials that could not be compared.
    pub skipped: Vec<LeftOut>,
    /// What could not be read of the data set, and why; the rest was compared.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<String>,
    /// For the page.
    #[serde(skip)]
    pub traces: Vec<Trace>,
    /// The model that was compared where none was given.
    #[serde(skip)]
    pub calibrated: Option<NamedModel>,
}

/// What was compared.
#[derive(Clone, Debug, JsonSchema, Serialize)]
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
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct ModelReport {
    /// File name, or `base`.
    pub name: String,
    /// Where its parameters come from.
    pub origin: String,
    /// Coefficients of friction, by contact (`finger`), or primitive and contact (`pivot.finger`).
    pub friction: BTreeMap<String, f64>,
    /// Those of them that the data only bound: other values fit as well.
    pub only_bounded: Vec<String>,
    /// Ids of its effects.
    pub effects: Vec<String>,
    /// Mean width of the forces' intervals over all force distributions with the same motion while
    /// the object is pushed, N: what the model leaves open. `null` where it leaves nothing open or
    /// any deviation counts. The wider, the less a small error proves.
    pub open_force_n: Option<f64>,
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
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, JsonSchema, Serialize)]
pub struct Place {
    /// Primitive.
    pub primitive: String,
    /// Name of the channel.
    pub channel: &'static str,
    /// Phase.
    pub phase: Phase,
}

/// Size of residuals or errors over all samples of the trials.
#[derive(Clone, Copy, Debug, JsonSchema, Serialize)]
pub struct Size {
    /// Root mean square.
    pub rms: f64,
    /// Mean.
    pub mean: f64,
    /// Largest, without sign.
    pub largest: f64,
    /// RMS over noise floor; of a perfect model's residual 1.
    pub multiples: Option<f64>,
}

/// Residual and error of one channel in one phase.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct ErrorRow {
    /// Which.
    #[serde(flatten)]
    pub place: Place,
    /// SI unit of the errors.
    pub unit: &'static str,
    /// Trials in which it is known.
    pub trials: usize,
    /// Mean length of the phase, s.
    pub duration_s: f64,
    /// Modelled minus measured as it is, sensor offsets taken out.
    pub residual: Size,
    /// What of it is beyond the tolerance.
    pub error: Size,
    /// RMS of the residual without taking sensor offsets out.
    pub rms_with_offset: f64,
    /// Mean of the residual without taking sensor offsets out.
    pub bias_with_offset: f64,
    /// Where there are no repetitions: whether the mean error over phases of 0.1 s and longer is
    /// beyond the sensor's stated uncertainty. `null`: shorter, or no uncertainty is stated.
    pub sustained: Option<bool>,
    /// RMS that a perfect model would show; `null`: not known.
    pub noise_floor: Option<f64>,
    /// Where from.
    pub noise_source: Source,
    /// Lack of fit of the error against the repetitions; `null` without repetitions.
    pub lack_of_fit: Option<Test>,
    /// Whether lack of fit is significant after correction and the error above the floor.
    pub fails: bool,
    /// Channel number.
    #[serde(skip)]
    pub index: usize,
}

/// F test.
#[derive(Clone, Copy, Debug, JsonSchema, Serialize)]
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
#[derive(Clone, Debug, JsonSchema, Serialize)]
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
#[derive(Clone, Debug, JsonSchema, Serialize)]
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
#[derive(Clone, Debug, JsonSchema, Serialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// Failed, and does no more: a tenth smaller or more, and not significant.
    Gone,
    /// Significant in one of the two only, though its size is the same within a tenth.
    Unclear,
    /// Fails still, by less.
    Smaller,
    /// Fails still, neither by a tenth less nor by a tenth more.
    Remains,
    /// Fails still, by more.
    Larger,
    /// Fails only now.
    New,
    /// Failed in neither.
    Fits,
}

/// Before and after for one channel and phase.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Change {
    /// Which.
    #[serde(flatten)]
    pub place: Place,
    /// SI.
    pub unit: &'static str,
    /// Error of the first model.
    pub before: Size,
    /// Error of the last, within the tolerance of the first.
    pub after: Size,
    /// Residual of the first model.
    pub residual_before: Size,
    /// Residual of the last.
    pub residual_after: Size,
    /// What became of it.
    pub fate: Fate,
    /// Whether it fails before.
    #[serde(skip)]
    pub failed: bool,
}

/// Changes from the first model to the last, counted.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Tally {
    /// Whether what the first model leaves open counts as no error, for both models alike.
    pub within_tolerance: bool,
    /// Root mean square over the channels and phases where either fails (over all where neither
    /// does), in noise floors: first model.
    pub before: f64,
    /// Failures of the last model.
    pub after: f64,
    /// Failures of the first model.
    pub failures: usize,
    /// Failures of it that are gone.
    pub removed: usize,
    /// That are a tenth smaller or more, and still fail.
    pub smaller: usize,
    /// That are a tenth larger or more.
    pub larger: usize,
    /// New ones.
    pub new: usize,
}

/// Signals of one trial for drawing.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Id.
    pub trial: String,
    /// Why it is shown: `worst trial`, `median trial`, `chosen trial`, `worst of its condition`.
    pub role: &'static str,
    /// Its conditions in words.
    pub conditions: String,
    /// Primitive.
    pub primitive: String,
    /// Condition number, shared by repetitions; see [`TrialRow`].
    pub condition: usize,
    /// What was set, and the level of each as text in the unit of its label.
    pub levels: Vec<(Variable, String)>,
    /// Root mean square of the multiples of its channels and phases; see [`TrialRow`].
    pub multiples: Option<f64>,
    /// The bodies.
    pub bench: Bench,
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
