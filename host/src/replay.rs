//! A recorded trial through the predictor, tick by tick in `f32`, as the board does it.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use stickslip_shared::model::{
    Base, FingerContact, Friction, Model, Object, PusherContact, Scene, Shape, SupportContact,
};
use stickslip_shared::predictor::{
    HASH_START, Intent, Limits, MAX_SEGMENTS, ModelError, Plan, Prediction, Predictor, Sample, Segment,
};
use stickslip_shared::track::Pose;
use thiserror::Error;

use crate::channels;
use crate::dataset::{self, Description, Trial};
use crate::simulate::{SceneError, scene};

/// Why a trial cannot be replayed.
#[derive(Debug, Error)]
pub enum ReplayError {
    /// No scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Scene or model refused.
    #[error("trial {trial}: the predictor refuses scene or model: {why:?}")]
    Refused {
        /// Trial.
        trial: String,
        /// Why.
        why: ModelError,
    },
}

/// A trial as it goes to the board: scene, plan and samples.
#[derive(Clone, Debug)]
pub struct Feed {
    /// Rig and object.
    pub scene: Scene<f32>,
    /// Derived from the gripper's measured motion.
    pub plan: Plan,
    /// One for each recorded sample.
    pub samples: Vec<Sample<f32>>,
}

/// What a replay gave.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// One for each sample.
    pub predictions: Vec<Prediction>,
    /// Hash of every output word.
    pub hash: u32,
}

/// Scene, plan and samples of a trial.
///
/// # Errors
/// See [`scene`].
pub fn feed(description: &Description, trial: &Trial) -> Result<Feed, SceneError> {
    let scene = scene(description, trial)?;
    let mut convert = Converter::new(trial, &scene);
    let samples = trial.samples.iter().map(|s| convert.sample(s)).collect();
    Ok(Feed { scene: narrow_scene(&scene), plan: plan_for(trial), samples })
}

/// Runs the predictor over a trial; `ordinal` is the trial's place in its data set.
///
/// # Errors
/// No scene, or the predictor refuses scene or model.
pub fn replay(
    description: &Description,
    trial: &Trial,
    model: &Model<f64>,
    limits: Limits,
    ordinal: usize,
) -> Result<Replayed, ReplayError> {
    let feed = feed(description, trial)?;
    let mut predictor = Predictor::new(feed.scene, narrow_model(model), limits)
        .map_err(|why| ReplayError::Refused { trial: trial.info.trial.clone(), why })?;
    predictor.set_plan(feed.plan);
    predictor.set_trial(ordinal as f32);
    let predictions: Vec<Prediction> = feed.samples.iter().map(|s| predictor.tick(s)).collect();
    let hash = hash(&predictions);
    Ok(Replayed { predictions, hash })
}

/// Hash of every output word of a run.
pub fn hash<'a>(predictions: impl IntoIterator<Item = &'a Prediction>) -> u32 {
    predictions.into_iter().fold(HASH_START, |h, p| p.hash(h))
}

/// Turns recorded samples into the predictor's, one after the other: what is commanded
/// (grip) or fixed (pusher) holds until it is given anew; what is measured does not.
#[derive(Clone, Debug)]
pub struct Converter {
    grip_n: f32,
    pusher: Option<Pose<f32>>,
    has_pusher: bool,
}

impl Converter {
    /// For the samples of `trial`.
    pub fn new(trial: &Trial, scene: &Scene<f64>) -> Self {
        Self {
            grip_n: trial.info.grip_n.unwrap_or(0.0) as f32,
            pusher: trial.info.pusher.as_ref().map(narrow_pose),
            has_pusher: scene.pusher.is_some(),
        }
    }

    /// The next sample. Only the first needs the object's pose.
    pub fn sample(&mut self, s: &dataset::Sample) -> Sample<f32> {
        self.grip_n = s.grip_cmd_n.map_or(self.grip_n, |g| g as f32);
        self.pusher = s.pusher.as_ref().map(narrow_pose).or(self.pusher);
        Sample {
            t_s: s.t_s as f32,
            grip_cmd_n: self.grip_n,
            gripper: s.gripper.as_ref().map(narrow_pose),
            object: s.object.as_ref().map(narrow_pose),
            pusher: self.pusher.filter(|_| self.has_pusher),
            finger: s.finger.map(|w| {
                w.map(|w| {
                    let [fx, fy, fz] = w.force_n;
                    let [tx, ty, tz] = w.torque_nm;
                    [fx, fy, fz, tx, ty, tz].map(|x| x as f32)
                })
            }),
        }
    }
}

fn narrow_pose(pose: &dataset::Pose) -> Pose<f32> {
    let p = channels::pose(pose);
    let q = p.rotation.quaternion();
    Pose {
        position_m: p.position_m.map(|x| x as f32),
        // Rounded, not normalised again: the board gets these very numbers.
        rotation: UnitQuaternion::new_unchecked(Quaternion::new(
            q.w as f32, q.i as f32, q.j as f32, q.k as f32,
        )),
    }
}

/// The plan that a trial followed, as far as the gripper's measured motion tells: up to
/// eight segments of nearly constant velocity, with the intent of the primitive.
pub fn plan_for(trial: &Trial) -> Plan {
    let intent = match trial.info.primitive.as_str() {
        "linear_push" => Intent::Slide,
        "pivot" => Intent::Pivot,
        "lift" => Intent::Hold,
        _ => Intent::Free,
    };
    let moments: Vec<Moment> = {
        let mut grip_n = trial.info.grip_n.unwrap_or(0.0);
        trial
            .samples
            .iter()
            .filter_map(|s| {
                grip_n = s.grip_cmd_n.unwrap_or(grip_n);
                s.gripper.as_ref().map(|g| Moment { t_s: s.t_s, pose: channels::pose(g), grip_n })
            })
            .collect()
    };
    let mut plan =
        Plan { start_s: trial.samples.first().map_or(0.0, |s| s.t_s as f32), segments: Default::default() };
    for (from, to) in pieces(&moments) {
        let (a, b) = (&moments[from], &moments[to]);
        let v = velocity(a, b);
        let grips = &moments[from..=to];
        let segment = Segment {
            duration_s: (b.t_s - a.t_s) as f32,
            velocity_m_s: [v[0], v[1], v[2]].map(|x| x as f32),
            angular_rad_s: [v[3], v[4], v[5]].map(|x| x as f32),
            grip_n: (grips.iter().map(|m| m.grip_n).sum::<f64>() / grips.len() as f64) as f32,
            intent,
        };
        // `pieces` gives no more than fit.
        let _ = plan.segments.push(segment);
    }
    plan
}

struct Moment {
    t_s: f64,
    pose: Pose<f64>,
    grip_n: f64,
}

/// Mean velocity (m/s) and angular velocity (rad/s) between two moments, world axes.
fn velocity(a: &Moment, b: &Moment) -> [f64; 6] {
    let dt = b.t_s - a.t_s;
    let v: Vector3<f64> = (b.pose.position_m - a.pose.position_m) / dt;
    let w: Vector3<f64> = (b.pose.rotation * a.pose.rotation.inverse()).scaled_axis() / dt;
    [v.x, v.y, v.z, w.x, w.y, w.z]
}

/// Cuts the motion into at most [`MAX_SEGMENTS`] pieces: starting from slices of 40 ms,
/// the two neighbours whose velocities differ least (by path over the shorter) are joined
/// until what is left differs by more than a tenth of the largest speed and the pieces fit.
fn pieces(moments: &[Moment]) -> Vec<(usize, usize)> {
    const SLICE_S: f64 = 0.04;
    // A rotation moves the object's ends, 50 mm away.
    const ARM_M: f64 = 0.05;
    let mut cuts = vec![0];
    for (i, m) in moments.iter().enumerate() {
        if m.t_s - moments[cuts[cuts.len() - 1]].t_s >= SLICE_S {
            cuts.push(i);
        }
    }
    if cuts.len() > 1
        && let Some(last) = cuts.last_mut()
    {
        *last = moments.len() - 1;
    }
    let mut pieces: Vec<(usize, usize)> = cuts.windows(2).map(|w| (w[0], w[1])).collect();
    let speed = |v: &[f64; 6]| {
        let n = |a: &[f64]| a.iter().map(|x| x * x).sum::<f64>().sqrt();
        n(&v[..3]) + ARM_M * n(&v[3..])
    };
    let of = |p: &(usize, usize)| velocity(&moments[p.0], &moments[p.1]);
    let largest = pieces.iter().map(|p| speed(&of(p))).fold(0.0, f64::max);
    while pieces.len() > 1 {
        let difference = |k: usize| {
            let (a, b) = (of(&pieces[k]), of(&pieces[k + 1]));
            speed(&std::array::from_fn(|i| a[i] - b[i]))
        };
        let length = |k: usize| moments[pieces[k].1].t_s - moments[pieces[k].0].t_s;
        // Short pieces go first: a brief deviation matters less than a long one.
        let cost = |k: &usize| difference(*k) * length(*k).min(length(*k + 1));
        let Some(k) = (0..pieces.len() - 1).min_by(|a, b| cost(a).total_cmp(&cost(b))) else { break };
        let brief = length(k).min(length(k + 1)) < 2.0 * SLICE_S;
        let alike = difference(k) < 0.1 * largest || brief && difference(k) < 0.3 * largest;
        if pieces.len() <= MAX_SEGMENTS && !alike {
            break;
        }
        let end = pieces.remove(k + 1).1;
        pieces[k].1 = end;
    }
    pieces
}

/// A scene rounded to what the board computes with.
pub fn narrow_scene(s: &Scene<f64>) -> Scene<f32> {
    let shape = match &s.object.shape {
        Shape::Prism { length_m, side_m } => {
            Shape::Prism { length_m: *length_m as f32, side_m: *side_m as f32 }
        }
        Shape::Cylinder { length_m, diameter_m, across_flats_m } => Shape::Cylinder {
            length_m: *length_m as f32,
            diameter_m: *diameter_m as f32,
            across_flats_m: *across_flats_m as f32,
        },
        Shape::Polygon { vertices_m, height_m } => Shape::Polygon {
            vertices_m: vertices_m.iter().map(|v| v.map(|x| x as f32)).collect(),
            height_m: *height_m as f32,
        },
    };
    Scene {
        gravity_m_s2: s.gravity_m_s2.map(|x| x as f32),
        object: Object {
            shape,
            mass_kg: s.object.mass_kg as f32,
            inertia_kg_m2: s.object.inertia_kg_m2.map(|r| r.map(|x| x as f32)),
        },
        fingers: s.fingers.map(|f| match f {
            FingerContact::Point => FingerContact::Point,
            FingerContact::Line { length_m } => FingerContact::Line { length_m: length_m as f32 },
            FingerContact::Disc { diameter_m } => FingerContact::Disc { diameter_m: diameter_m as f32 },
        }),
        pusher: s.pusher.map(|p| match p {
            PusherContact::Plane => PusherContact::Plane,
            PusherContact::Line { length_m } => PusherContact::Line { length_m: length_m as f32 },
            PusherContact::Point { tip_radius_m } => {
                PusherContact::Point { tip_radius_m: tip_radius_m as f32 }
            }
        }),
        support: s.support.as_ref().map(|s| match s {
            SupportContact::Patch => SupportContact::Patch,
            SupportContact::Points(p) => {
                SupportContact::Points(p.iter().map(|v| v.map(|x| x as f32)).collect())
            }
        }),
    }
}

/// A model rounded to what the board computes with.
pub fn narrow_model(m: &Model<f64>) -> Model<f32> {
    Model {
        base: match m.base {
            Base::Hard => Base::Hard,
            Base::Soft { normal_n_m, tangential_n_m, damping_s } => Base::Soft {
                normal_n_m: normal_n_m as f32,
                tangential_n_m: tangential_n_m as f32,
                damping_s: damping_s as f32,
            },
        },
        friction: Friction {
            finger: m.friction.finger as f32,
            pusher: m.friction.pusher as f32,
            support: m.friction.support as f32,
        },
        effects: m
            .effects
            .iter()
            .map(|e| stickslip_shared::effects::Effect {
                code: e.code,
                parameters: e.parameters.map(|p| p as f32),
            })
            .collect(),
        formulas: Default::default(),
    }
}
