//! The predictor and simple thresholds over a whole data set, in one document.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_data::Index;
use stickslip_shared::model::Model;
use stickslip_shared::predictor::{Checked, Limits};

use super::calibration::{Calibration, Stated};
use super::figures::{Class, Row, rows};
use super::judge::{Judged, Method, ObjectPose, ScoreError, Scored, judge};
use crate::progress::Progress;
use crate::tuning::{Changed, changed};

/// The JSON document `stickslip-score/1`.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Document {
    /// Always `stickslip-score/1`.
    pub schema: &'static str,
    /// Folder.
    pub data: PathBuf,
    /// Trials scored.
    pub trials: usize,
    /// Trials passed over: name, why.
    pub passed_over: Vec<(String, String)>,
    /// What could not be read of the data set, and why; the rest was scored.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<String>,
    /// What is worth knowing of the tables.
    pub warnings: Vec<String>,
    /// Time scored, h.
    pub hours: f64,
    /// Which object poses the predictor was given.
    pub object_pose: ObjectPose,
    /// Share of ticks at which the predictor does not trust its sample.
    pub doubtful_share: f64,
    /// Numbers of the predictor that are not the defaults, as the file of `--predictor` sets them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tuned: Vec<Changed>,
    /// One for each kind of event and method.
    pub rows: Vec<Row>,
    /// One for each predictor.
    pub calibration: Vec<Calibration>,
}

impl Document {
    /// Whether `row` is the predictor's, and not that of the same without effects or of a baseline.
    pub fn is_own(&self, row: &Row) -> bool {
        self.rows.first().is_some_and(|first| first.method == row.method)
    }
}

/// What is scored, and against what.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// How often the predictor is given the object's measured pose.
    pub object_pose: ObjectPose,
    /// Baseline: tangential over normal force at which a finger is said to slip.
    pub ratio: f64,
    /// Baseline: rate of the tangential force at which a finger is said to slip, N/s.
    pub rate_n_s: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { object_pose: ObjectPose::Every, ratio: 0.3, rate_n_s: 20.0 }
    }
}

/// Scores the predictor with `model`, the same without its effects, and the baselines.
///
/// # Errors
/// Where no trial can be scored.
pub fn score(
    index: &Index,
    model: &Model<f64>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Document, ScoreError> {
    score_tuned(index, model, &Checked::default(), options, progress)
}

/// [`score`] of a predictor with other numbers than the default ones.
///
/// # Errors
/// Where no trial can be scored.
pub fn score_tuned(
    index: &Index,
    model: &Model<f64>,
    tuning: &Checked<f32>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Document, ScoreError> {
    let predictor = |name: &str, model: Model<f64>| Method::Predictor {
        name: name.to_owned(),
        model: Box::new(model),
        tuning: Box::new(*tuning),
        pose: options.object_pose,
    };
    let mut methods = vec![predictor("stickslip", model.clone())];
    if !model.effects.is_empty() {
        let mut plain = model.clone();
        plain.effects.clear();
        plain.formulas.clear();
        methods.push(predictor("without added effects", plain));
    }
    methods.extend([Method::Ratio(options.ratio), Method::Rate(options.rate_n_s)]);
    let Scored { judged, passed_over, refused, warnings } =
        judge(index, &methods, Limits::default(), progress);
    if judged.is_empty() {
        let passed = passed_over.first().map(|(_, why)| (*why).to_owned());
        let why = passed.or(refused.into_iter().next());
        return Err(ScoreError::Nothing(why.unwrap_or_else(|| "the data set lists no trials".into())));
    }
    let names: Vec<String> = methods.iter().map(Method::name).collect();
    let ticks: usize = judged.iter().map(|j| j.alarms[0].ticks).sum();
    let doubtful: usize = judged.iter().map(|j| j.alarms[0].doubtful).sum();
    let calibration = methods
        .iter()
        .enumerate()
        .filter(|(_, method)| matches!(method, Method::Predictor { .. }))
        .map(|(m, method)| {
            let mut all = Stated::default();
            judged.iter().filter_map(|j| j.alarms.get(m)).for_each(|a| all.add(&a.stated));
            all.figures(&method.name())
        })
        .collect();
    // Thresholds on forces say nothing of sag and rotation.
    let mut shown = rows(&judged, &names);
    shown.retain(|r| {
        let predicts = |m: &Method| m.name() == r.method && matches!(m, Method::Predictor { .. });
        r.class != Class::Moved || methods.iter().any(predicts)
    });
    Ok(Document {
        schema: "stickslip-score/1",
        data: index.folder.clone(),
        trials: judged.len(),
        passed_over: passed_over.into_iter().map(|(trial, why)| (trial, why.to_owned())).collect(),
        refused,
        warnings: warnings.iter().map(ToString::to_string).collect(),
        hours: judged.iter().map(|j: &Judged| j.truth.until_s).sum::<f64>() / 3600.0,
        object_pose: options.object_pose,
        doubtful_share: doubtful as f64 / ticks.max(1) as f64,
        tuned: changed(tuning),
        rows: shown,
        calibration,
    })
}
