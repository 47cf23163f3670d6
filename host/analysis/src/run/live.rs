//! The predictor over samples as they come: what a replay does with a record, one call a sample, the same bits.

use std::path::Path;

use serde::Deserialize;
use stickslip_data::error::{DatasetError, Problem};
use stickslip_data::{Description, Pose, Sample, TrialInfo};
use stickslip_shared::model::Model;
use stickslip_shared::predictor::{
    HASH_START, Intent, Limits, MAX_SEGMENTS, ModelError, Plan, Prediction, Predictor, Segment,
};
use stickslip_shared::wire::{Refusal, check};
use thiserror::Error;

use super::replay::{Converter, ready};
use super::scene::{SceneError, scene_of};

/// Why there is no predictor, or no prediction. What is refused changes nothing.
#[derive(Debug, Error)]
pub enum LiveError {
    /// The rig has no such object.
    #[error(transparent)]
    Object(#[from] DatasetError),
    /// No scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Scene, model or limits refused.
    #[error("the predictor refuses scene, model or limits: {0:?}")]
    Refused(ModelError),
    /// The sample cannot be one.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// The plan cannot be one.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Not the predictor's limits.
    #[error("limits: {0}")]
    Limits(String),
}

/// What a sample cannot be.
#[derive(Debug, Error, PartialEq)]
pub enum SampleError {
    /// NaN or infinity.
    #[error("{what} has a number that is not finite; give None for what was not measured")]
    NotFinite {
        /// Of the sample.
        what: &'static str,
    },
    /// The clock went back, or stood.
    #[error(
        "t_s is {t_s}, and the sample before was at {previous_s}: time does not rise; leave such a sample out, or \
         restart the predictor where the clock was set anew"
    )]
    TimeNotRising {
        /// s
        t_s: f64,
        /// s
        previous_s: f64,
    },
    /// A rotation that is none.
    #[error(
        "{what}: the quaternion's norm is {norm:.4}, off by more than 1 %; give qw, qx, qy, qz of a unit quaternion"
    )]
    QuaternionNorm {
        /// Of the sample.
        what: &'static str,
        /// Its norm.
        norm: f64,
    },
    /// A grip that pulls.
    #[error("grip_n is {0}; a grip force cannot be below zero")]
    NegativeGrip(f64),
}

/// What a plan cannot be.
#[derive(Debug, Error)]
pub enum PlanError {
    /// More than the predictor holds.
    #[error(
        "the plan has {0} segments; at most {MAX_SEGMENTS} fit: give the next ones, and the others later"
    )]
    TooLong(usize),
    /// Not segments.
    #[error("the plan: {0}")]
    NoSegments(String),
    /// A number that a board refuses too.
    #[error("the plan: {0}")]
    OutOfRange(String),
}

/// A segment of a plan as text: a row of the plan in the document of a replay.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    /// Of the first: when the plan begins. Segments follow one another, so of the others it says nothing.
    #[serde(default)]
    from_s: f32,
    duration_s: f32,
    #[serde(default)]
    velocity_m_s: [f32; 3],
    #[serde(default)]
    angular_rad_s: [f32; 3],
    grip_n: f32,
    #[serde(default)]
    intent: Word,
}

/// An intent by the name that it has in documents.
#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Word {
    #[default]
    Hold,
    Slide,
    Pivot,
    Free,
}

/// A plan from the JSON list of its segments, as a replay's document has it: `duration_s` and `grip_n` (N), and where they are
/// given `velocity_m_s`, `angular_rad_s` (rad/s; world axes, else zero), `intent` (else `hold`), and of the first `from_s`.
///
/// # Errors
/// Other keys or types, more segments than a plan holds, numbers that a board refuses.
pub fn plan_of_json(text: &str) -> Result<Plan, PlanError> {
    let rows: Vec<Row> =
        serde_json::from_str(text).map_err(|error| PlanError::NoSegments(error.to_string()))?;
    let mut plan = Plan { start_s: rows.first().map_or(0.0, |row| row.from_s), ..Plan::default() };
    for row in &rows {
        let segment = Segment {
            duration_s: row.duration_s,
            velocity_m_s: row.velocity_m_s,
            angular_rad_s: row.angular_rad_s,
            grip_n: row.grip_n,
            intent: match row.intent {
                Word::Hold => Intent::Hold,
                Word::Slide => Intent::Slide,
                Word::Pivot => Intent::Pivot,
                Word::Free => Intent::Free,
            },
        };
        plan.segments.push(segment).map_err(|_| PlanError::TooLong(rows.len()))?;
    }
    check::plan(&plan).map_err(|refusal| {
        PlanError::OutOfRange(match refusal {
            Refusal::OutOfRange { field, value, low, high } => {
                format!("{field:?} is {value}; give {low} to {high}")
            }
            other => format!("{other:?}"),
        })
    })?;
    Ok(plan)
}

/// The default limits but for those in a JSON object, by the names of [`Limits`].
///
/// # Errors
/// A name that is no limit's, or no number.
pub fn limits_of_json(text: &str) -> Result<Limits, LiveError> {
    let wrong = |error: serde_json::Error| LiveError::Limits(error.to_string());
    let given: serde_json::Map<String, serde_json::Value> = serde_json::from_str(text).map_err(wrong)?;
    let mut all = serde_json::to_value(Limits::default()).map_err(wrong)?;
    for (name, value) in given {
        match all.get_mut(&name) {
            Some(slot) => *slot = value,
            None => {
                let known: Vec<&str> =
                    all.as_object().into_iter().flatten().map(|(name, _)| name.as_str()).collect();
                return Err(LiveError::Limits(format!("no limit `{name}`; there are {}", known.join(", "))));
            }
        }
    }
    serde_json::from_value(all).map_err(wrong)
}

/// A predictor and where it is in time.
#[derive(Clone, Debug)]
pub struct Live {
    predictor: Predictor<f32>,
    convert: Converter,
    /// As it was given; its start counts from `plan_from_s`.
    plan: Plan,
    /// In the samples' time; `None`: from the first sample.
    plan_from_s: Option<f64>,
    /// Time of the newest sample; `None` before the first.
    last_s: Option<f64>,
    hash: u32,
}

/// After a pause as long the line's stamps, 32 bits of microseconds, no longer tell which way time went: it is counted anew.
const FORGOTTEN_S: f64 = 1000.0;

impl Live {
    /// Of a trial of `description` that begins: `info` has its object, primitive, and where they are known the first grip
    /// command and the pose of a fixed pusher. `plan` counts from the first sample; `ordinal` is the trial's place among
    /// others (wear goes with it).
    ///
    /// # Errors
    /// No such object, no scene, or the predictor refuses scene, model or limits.
    pub fn new(
        description: &Description,
        info: &TrialInfo,
        ordinal: usize,
        plan: Plan,
        model: &Model<f64>,
        limits: Limits,
    ) -> Result<Self, LiveError> {
        if !description.objects.iter().any(|object| object.id == info.object) {
            let known = description.objects.iter().map(|object| object.id.as_str()).collect::<Vec<_>>();
            let problem = Problem::UnknownObject { known: known.join(", ") };
            return Err(DatasetError::of_file(Path::new("dataset.toml"), problem)
                .column("objects.id")
                .value(info.object.clone())
                .into());
        }
        // Nobody asks for predictions of what is not grasped, but for a rig without fingers.
        let scene = scene_of(description, info, description.fingers.is_some())?;
        let predictor =
            ready(scene.cast(), plan.clone(), model, limits, ordinal).map_err(LiveError::Refused)?;
        Ok(Self {
            predictor,
            convert: Converter::since(0.0, info),
            plan,
            plan_from_s: None,
            last_s: None,
            hash: HASH_START,
        })
    }

    /// One sample, as every row of a trial's table; the prediction. Samples are 4 ms apart, as on a board.
    ///
    /// # Errors
    /// Numbers that are not finite, quaternions that are none, a negative grip, time that does not rise.
    pub fn step(&mut self, sample: &Sample) -> Result<Prediction, SampleError> {
        let sample = checked(sample)?;
        let t_s = sample.t_s;
        match self.last_s {
            Some(previous_s) if t_s <= previous_s => {
                return Err(SampleError::TimeNotRising { t_s, previous_s });
            }
            Some(previous_s) if t_s - previous_s < FORGOTTEN_S => {}
            Some(_) => {
                self.predictor.restart();
                self.begin(t_s);
            }
            None => self.begin(t_s),
        }
        self.last_s = Some(t_s);
        let prediction = self.predictor.take(&self.convert.sample(&sample));
        self.hash = prediction.hash(self.hash);
        Ok(prediction)
    }

    /// Counts time from `t_s` on.
    fn begin(&mut self, t_s: f64) {
        self.convert.restart(t_s);
        self.plan_from_s.get_or_insert(t_s);
        self.place_plan();
    }

    fn place_plan(&mut self) {
        let start_s = self.convert.start_s;
        let from_s = self.plan_from_s.unwrap_or(start_s) - start_s;
        let start_s = self.plan.start_s + from_s as f32;
        self.predictor.set_plan(Plan { start_s, ..self.plan.clone() });
    }

    /// Replaces the plan. It counts from `from_s` in the samples' time; `None`: from the newest sample, before the first one from
    /// that.
    pub fn set_plan(&mut self, plan: Plan, from_s: Option<f64>) {
        self.plan = plan;
        self.plan_from_s = from_s.or(self.last_s);
        if self.last_s.is_some() {
            self.place_plan();
        }
    }

    /// Forgets object, clock and plan: the next sample may have any time, and needs the object's pose. What was learnt of the
    /// friction stays.
    pub fn restart(&mut self) {
        self.predictor.restart();
        (self.plan, self.plan_from_s, self.last_s) = (Plan::default(), None, None);
        self.hash = HASH_START;
    }

    /// Forgets what was learnt of the friction: other pads, or another object of the same form.
    pub fn reset_friction(&mut self) {
        self.predictor.reset_friction();
    }

    /// Hash of every output word since the start or restart, as a replay has it.
    #[must_use]
    pub fn hash(&self) -> u32 {
        self.hash
    }
}

/// The sample, its quaternions normalised as those of a table are.
fn checked(sample: &Sample) -> Result<Sample, SampleError> {
    let finite = |what: &'static str, values: &[f64]| match values.iter().all(|x| x.is_finite()) {
        true => Ok(()),
        false => Err(SampleError::NotFinite { what }),
    };
    let pose = |what: &'static str, pose: Option<Pose>| {
        let Some(pose) = pose else { return Ok(None) };
        finite(what, &pose.position_m)?;
        finite(what, &pose.quaternion)?;
        pose.normalised().map(Some).map_err(|norm| SampleError::QuaternionNorm { what, norm })
    };
    finite("t_s", &[sample.t_s])?;
    if let Some(grip_n) = sample.grip_cmd_n {
        finite("grip_n", &[grip_n])?;
        if grip_n < 0.0 {
            return Err(SampleError::NegativeGrip(grip_n));
        }
    }
    for (what, wrench) in ["finger1", "finger2"].into_iter().zip(&sample.finger) {
        if let Some(wrench) = wrench {
            finite(what, &wrench.force_n)?;
            finite(what, &wrench.torque_nm)?;
        }
    }
    Ok(Sample {
        gripper: pose("gripper", sample.gripper)?,
        object: pose("object", sample.object)?,
        pusher: pose("pusher", sample.pusher)?,
        ..*sample
    })
}
