//! A trial as the board needs it: scene, model and limits as bytes, samples, a plan.

use serde::Serialize;
use serde::de::DeserializeOwned;
use stickslip_shared::model::{Model, Scene};
use stickslip_shared::predictor::{Intent, Limits, MAX_SEGMENTS, Plan, Segment};
use stickslip_shared::wire::{self, ModelPackage};

use crate::dataset::{self, Trial};

/// Everything for one run.
#[derive(Clone, Debug)]
pub struct Package {
    /// In the board's precision.
    pub model: ModelPackage,
    /// What the gripper will do.
    pub plan: Plan,
    /// Place of the trial in its data set.
    pub ordinal: f32,
    /// One for each row, numbered from 0.
    pub samples: Vec<wire::Sample>,
}

impl Package {
    /// From a trial; `model` in `f64` as read from the user's file.
    ///
    /// # Errors
    /// Where a number of scene or model is not finite.
    pub fn new(
        scene: &Scene<f64>,
        model: &Model<f64>,
        trial: &Trial,
        ordinal: usize,
    ) -> Result<Self, serde_json::Error> {
        let grip = trial.info.grip_n.unwrap_or(0.0);
        let t0 = trial.samples.first().map_or(0.0, |s| s.t_s);
        let samples = trial
            .samples
            .iter()
            .enumerate()
            .map(|(index, sample)| self::sample(index, sample, t0, grip, trial.info.pusher.as_ref()))
            .collect();
        Ok(Self {
            model: (narrow(scene)?, narrow(model)?, Limits::default()),
            plan: plan(trial, t0, grip),
            ordinal: ordinal as f32,
            samples,
        })
    }

    /// Scene, model and limits as the board reads them.
    ///
    /// # Errors
    /// Never in practice: every part can be serialised.
    pub fn bytes(&self) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_stdvec(&self.model)
    }
}

/// The same structure in `f32`: through its own serialisation, field by field.
fn narrow<A: Serialize, B: DeserializeOwned>(wide: &A) -> Result<B, serde_json::Error> {
    serde_json::from_value(serde_json::to_value(wide)?)
}

fn pose(pose: &dataset::Pose) -> wire::Pose {
    wire::Pose {
        position_m: pose.position_m.map(|x| x as f32),
        quaternion: pose.quaternion.map(|x| x as f32),
    }
}

fn sample(
    index: usize,
    sample: &dataset::Sample,
    t0: f64,
    grip: f64,
    pusher: Option<&dataset::Pose>,
) -> wire::Sample {
    let finger = |wrench: &Option<dataset::Wrench>| {
        wrench.map(|w| {
            let ([fx, fy, fz], [tx, ty, tz]) = (w.force_n, w.torque_nm);
            [fx, fy, fz, tx, ty, tz].map(|x| x as f32)
        })
    };
    let [first, second] = &sample.finger;
    wire::Sample {
        seq: index as u32,
        t_us: ((sample.t_s - t0) * 1e6).round() as u32,
        grip_cmd_n: sample.grip_cmd_n.unwrap_or(grip) as f32,
        gripper: sample.gripper.as_ref().map(pose),
        object: sample.object.as_ref().map(pose),
        pusher: sample.pusher.as_ref().or(pusher).map(pose),
        finger: [finger(first), finger(second)],
    }
}

/// The recorded motion of the gripper as a plan: at most [`MAX_SEGMENTS`] pieces of equal
/// length, each with the mean velocity of its piece.
fn plan(trial: &Trial, t0: f64, grip: f64) -> Plan {
    let intent = match trial.info.primitive.as_str() {
        "linear_push" => Intent::Slide,
        "pivot" => Intent::Pivot,
        "roll" | "planar_push" => Intent::Free,
        _ => Intent::Hold,
    };
    let mut plan = Plan::default();
    let pieces = trial.samples.len().div_ceil(MAX_SEGMENTS).max(2);
    let mut from = 0;
    while from + 1 < trial.samples.len() && plan.segments.len() < MAX_SEGMENTS {
        let to = (from + pieces).min(trial.samples.len() - 1);
        let (a, b) = (&trial.samples[from], &trial.samples[to]);
        let dt = b.t_s - a.t_s;
        let (velocity, angular) = match (&a.gripper, &b.gripper) {
            (Some(a), Some(b)) => velocity(a, b, dt),
            _ => ([0.0; 3], [0.0; 3]),
        };
        let segment = Segment {
            duration_s: dt as f32,
            velocity_m_s: velocity.map(|x| x as f32),
            angular_rad_s: angular.map(|x| x as f32),
            grip_n: a.grip_cmd_n.unwrap_or(grip) as f32,
            intent,
        };
        if from == 0 {
            plan.start_s = (a.t_s - t0) as f32;
        }
        // The loop's bound keeps within the capacity.
        let _ = plan.segments.push(segment);
        from = to;
    }
    plan
}

fn velocity(a: &dataset::Pose, b: &dataset::Pose, dt: f64) -> ([f64; 3], [f64; 3]) {
    let (a, b) = (crate::channels::pose(a), crate::channels::pose(b));
    let linear = (b.position_m - a.position_m) / dt;
    let angular = (b.rotation * a.rotation.inverse()).scaled_axis() / dt;
    (linear.into(), angular.into())
}
