//! Each trial of a data set through every method tick by tick, beside what really happened.

use rayon::prelude::*;
use stickslip_shared::model::Model;
use stickslip_shared::predictor::{Checked, Limits, Prediction, flags};

use crate::progress::Progress;
use crate::run::replay::{Feed, ReplayError, at_board_rate, feed, intent_of, interpolated_poses, ready};
use crate::run::scene::{SceneError, scene};
use crate::score::alarms::{Episode, SLIPS, UNTRUSTED, episodes};
use crate::score::calibration::Stated;
use crate::score::truth::{self, Kind, Truth};
use stickslip_data::{Description, Index, Trial, TrialInfo, Warning, error::join_warnings};

/// The rate of the tangential force is taken over this many samples.
const RATE_SAMPLES: usize = 5;

/// How often the predictor is given the object's measured pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, schemars::JsonSchema, serde::Serialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum ObjectPose {
    /// Each sample, as recorded
    Every,
    /// Only at the start: a gripper without motion capture
    Start,
}

/// What is scored against the events.
#[derive(Clone, Debug)]
// A handful of them exist.
#[allow(clippy::large_enum_variant)]
pub enum Method {
    /// The predictor.
    Predictor {
        /// Shown.
        name: String,
        /// Contact law, friction, effects.
        model: Box<Model<f64>>,
        /// Its numbers.
        tuning: Box<Checked<f32>>,
        /// See [`ObjectPose`].
        pose: ObjectPose,
    },
    /// Tangential over normal force of both fingers above a threshold.
    Ratio(f64),
    /// Rate of the tangential force above a threshold, N/s.
    Rate(f64),
}

impl Method {
    /// As the table shows it.
    pub fn name(&self) -> String {
        match self {
            Method::Predictor { name, .. } => name.clone(),
            Method::Ratio(limit) => format!("F_t/F_n > {limit}"),
            Method::Rate(limit) => format!("|dF_t/dt| > {limit} N/s"),
        }
    }
}

/// A method's alarms in one trial.
#[derive(Clone, Debug, Default)]
pub struct Alarms {
    /// Slip, now or ahead; for [`Kind::Slip`].
    pub slip: Vec<Episode>,
    /// Sag or rotation beyond the limit, now or ahead.
    pub moved: Vec<Episode>,
    /// Loss of the grasp.
    pub drop: Vec<Episode>,
    /// Finger slips now.
    pub slipping: [Vec<Episode>; 2],
    /// Ticks with any doubt that withdraws the flags.
    pub doubtful: usize,
    /// Ticks scored.
    pub ticks: usize,
    /// The figures that it stated.
    pub stated: Stated,
}

impl Alarms {
    /// Episodes that speak of `kind`.
    pub fn of(&self, kind: Kind) -> &[Episode] {
        match kind {
            Kind::Slip => &self.slip,
            Kind::Moved => &self.moved,
            Kind::Drop => &self.drop,
        }
    }
}

/// One trial, judged.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Trial's name.
    pub trial: String,
    /// The plan holds the object throughout (no slip is meant).
    pub holds: bool,
    /// What happened.
    pub truth: Truth,
    /// In the order of the methods.
    pub alarms: Vec<Alarms>,
}

/// What a data set gave.
#[derive(Clone, Debug, Default)]
pub struct Scored {
    /// Trials with something to judge by.
    pub judged: Vec<Judged>,
    /// The others: name, and why they are passed over.
    pub passed_over: Vec<(String, &'static str)>,
    /// What could not be read of the data set, and why.
    pub refused: Vec<String>,
    /// What is worth knowing of the tables, equal remarks joined.
    pub warnings: Vec<Warning>,
}

/// Why a data set cannot be scored.
#[derive(Debug, thiserror::Error)]
pub enum ScoreError {
    /// No trial was left; the first reason.
    #[error("no trial can be scored: {0}")]
    Nothing(String),
}

/// Why a trial is refused.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub(super) enum Refused {
    Replay(#[from] ReplayError),
    Scene(#[from] SceneError),
}

/// Scores every trial that grasps something and shows where the object is; what cannot be read is
/// listed in the result. A step of `progress` is a trial.
pub fn judge(index: &Index, methods: &[Method], limits: Limits, progress: &dyn Progress) -> Scored {
    type One = (Option<Result<Judged, &'static str>>, Option<String>, Vec<Warning>);
    progress.begin("scoring", index.trials.len());
    let judged: Vec<One> = index
        .trials
        .par_iter()
        .enumerate()
        .map(|(ordinal, info)| {
            let reading = index.read_trial_lenient(info);
            let refusal = reading.refusal();
            let mut warnings = reading.warnings;
            if let Some(text) = reading.trial.as_ref().and_then(interpolated_poses) {
                warnings.push(Warning { file: index.folder.join(&info.file), files: 1, text });
            }
            let trial = reading.trial.map(|trial| at_board_rate(trial).0);
            let of = |trial| judge_trial(&index.description, trial, ordinal, methods, limits);
            let (judged, refusal) = match trial.as_ref().map(of).transpose() {
                Ok(judged) => (judged, refusal),
                Err(why) => (None, Some(why.to_string())),
            };
            progress.step(1);
            (judged, refusal, warnings)
        })
        .collect();
    let refused = index.errors.iter().map(ToString::to_string).collect();
    let mut scored = Scored { refused, ..Scored::default() };
    let mut warnings = index.warnings.clone();
    for ((judged, refusal, more), info) in judged.into_iter().zip(&index.trials) {
        warnings.extend(more);
        scored.refused.extend(refusal);
        match judged {
            Some(Ok(judged)) => scored.judged.push(judged),
            Some(Err(why)) => scored.passed_over.push((info.trial.clone(), why)),
            None => {}
        }
    }
    scored.warnings = join_warnings(warnings);
    scored
}

fn judge_trial(
    description: &Description,
    trial: &Trial,
    ordinal: usize,
    methods: &[Method],
    limits: Limits,
) -> Result<Result<Judged, &'static str>, Refused> {
    let info: &TrialInfo = &trial.info;
    let rig = scene(description, trial)?;
    if rig.fingers.is_none() {
        return Ok(Err(match description.fingers {
            Some(_) => "nothing is grasped: no sample has a whole gripper pose",
            None => "nothing is grasped: dataset.toml describes no fingers",
        }));
    }
    if !trial.samples.iter().any(|s| s.object.is_some() && s.gripper.is_some()) {
        return Ok(Err("no sample has complete poses of gripper and object, from which slip is found"));
    }
    let feed = fed(description, trial)?;
    let truth = truth::find(&rig, trial, &limits);
    let t_s = times(trial);
    let alarms = methods
        .iter()
        .map(|method| match method {
            Method::Predictor { model, tuning, pose, .. } => {
                predict(&feed, model, (limits, tuning), ordinal, *pose, &info.trial).map(|p| Alarms {
                    stated: Stated::in_trial(&t_s, &p, &feed, &truth, &limits),
                    ..predicted(&t_s, &p, &truth)
                })
            }
            Method::Ratio(limit) => Ok(threshold(&t_s, truth.ratio.iter().map(|r| r > limit), &truth)),
            Method::Rate(limit) => {
                let f = &truth.tangential_n;
                let rate = (0..f.len()).map(|i| {
                    let j = i.saturating_sub(RATE_SAMPLES);
                    let dt = t_s[i] - t_s[j];
                    dt > 0.0 && ((f[i] - f[j]) / dt).abs() > *limit
                });
                Ok(threshold(&t_s, rate, &truth))
            }
        })
        .collect::<Result<Vec<_>, Refused>>()?;
    let holds = intent_of(&info.primitive) == stickslip_shared::predictor::Intent::Hold;
    Ok(Ok(Judged { trial: info.trial.clone(), holds, truth, alarms }))
}

/// What goes to the board, with the grip's set-point at the start as its plan: that a grip decays is not in it.
pub(super) fn fed(description: &Description, trial: &Trial) -> Result<Feed, SceneError> {
    let mut feed = feed(description, trial)?;
    let first = trial.samples.iter().find_map(|s| s.grip_cmd_n);
    let set_point = first.or(trial.info.grip_n).unwrap_or(0.0) as f32;
    feed.plan.segments.iter_mut().for_each(|s| s.grip_n = set_point);
    Ok(feed)
}

/// Times of the samples from the first one on, s.
pub(super) fn times(trial: &Trial) -> Vec<f64> {
    let start = trial.samples.first().map_or(0.0, |s| s.t_s);
    trial.samples.iter().map(|s| s.t_s - start).collect()
}

/// Predictions at each sample.
pub(super) fn predict(
    feed: &Feed,
    model: &Model<f64>,
    (limits, tuning): (Limits, &Checked<f32>),
    ordinal: usize,
    pose: ObjectPose,
    trial: &str,
) -> Result<Vec<Prediction>, Refused> {
    let mut predictor = ready(feed.scene.clone(), feed.plan.clone(), model, limits, ordinal)
        .map_err(|why| ReplayError::Refused { trial: trial.to_owned(), why })?
        .with_tuning(tuning);
    let mut started = false;
    Ok(feed
        .samples
        .iter()
        .map(|s| {
            let mut sample = *s;
            if pose == ObjectPose::Start && started {
                sample.object = None;
            }
            started |= s.object.is_some();
            predictor.take(&sample)
        })
        .collect())
}

fn predicted(t_s: &[f64], predictions: &[Prediction], truth: &Truth) -> Alarms {
    let any = |mask: u32| predictions.iter().map(move |p| p.flags & mask != 0);
    let until = truth.until_s;
    let scored = || predictions.iter().zip(t_s).filter(move |(_, t)| **t <= until).map(|(p, _)| p);
    Alarms {
        slip: episodes(t_s, any(SLIPS), until),
        moved: episodes(t_s, any(flags::SAG | flags::ROTATION), until),
        drop: episodes(t_s, any(flags::DROP), until),
        slipping: [flags::SLIP_1, flags::SLIP_2].map(|f| episodes(t_s, any(f), until)),
        doubtful: scored().filter(|p| p.validity & UNTRUSTED != 0).count(),
        ticks: scored().count(),
        stated: Stated::default(),
    }
}

fn threshold(t_s: &[f64], up: impl IntoIterator<Item = bool>, truth: &Truth) -> Alarms {
    let slip = episodes(t_s, up, truth.until_s);
    Alarms {
        drop: slip.clone(),
        slip,
        ticks: t_s.iter().filter(|t| **t <= truth.until_s).count(),
        ..Alarms::default()
    }
}
