//! Balance of the measured forces: while the motion is slow, finger forces (turned to world
//! axes), pusher force and weight sum to zero. Where they do not, a sensor is wrong, and no
//! model may be blamed for it.
//!
//! The bound on the sum is what the sensors may be off by a constant, per axis: the
//! uncertainty of both fingers and of the pusher added up; beyond it and three standard errors
//! the balance fails. A constant offset of the sensors explains a failure that stays the same
//! in their axes: [`crate::evidence::offsets`].

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

use crate::evidence::stages::{STAGES, Stage, Stages};
use stickslip_data::{Description, Sample, Trial};

/// Inertia above this share of the weight is no slow motion.
const SLOW_SHARE: f64 = 0.02;
/// Inertia below this is slow for any object: it is at the noise of the accelerations.
const SLOW_LEAST_N: f64 = 0.05;
/// Accelerations are taken over twice this time: pose noise of 0.03 mm gives 0.02 m/s^2.
const HALF_WINDOW_S: f64 = 0.05;

/// Sum of forces over the slow part of one stage of a trial.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct StageBalance {
    /// Which part.
    pub stage: Stage,
    /// Mean of fingers + pusher + weight, world axes.
    pub sum_n: [f64; 3],
    /// Root mean square about that mean, for each axis.
    pub scatter_n: [f64; 3],
    /// Samples behind it.
    pub samples: usize,
    /// What the sensors' constant errors may add up to, for each axis.
    pub bound_n: f64,
    /// White noise of the mean.
    pub standard_error_n: f64,
    /// What the sum consists of.
    #[serde(skip)]
    pub parts: Parts,
}

/// Mean forces of finger 1, finger 2 and pusher, and what small errors of their sensors would do to the sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts {
    /// World axes.
    pub force_n: [Vector3<f64>; 3],
    /// Times a small rotation of the sensor (gripper axes; the pusher's: world axes): what that adds to the sum.
    pub turned_n: [Matrix3<f64>; 3],
    /// Turns gripper axes into the world's.
    pub gripper: Matrix3<f64>,
}

impl Parts {
    fn of(samples: &[&Sample]) -> Self {
        let mut parts = Self::default();
        let share = 1.0 / samples.len().max(1) as f64;
        for sample in samples {
            let turn =
                gripper(sample).map_or_else(Matrix3::identity, |turn| *turn.to_rotation_matrix().matrix());
            parts.gripper += turn * share;
            let [one, two] = sample.finger;
            let all = [(one, turn), (two, turn), (sample.pusher_wrench, Matrix3::identity())];
            for (k, (wrench, turn)) in all.into_iter().enumerate() {
                let force = wrench.map_or_else(Vector3::zeros, |wrench| Vector3::from(wrench.force_n));
                if force.iter().all(|component| component.is_finite()) {
                    parts.force_n[k] += turn * force * share;
                    parts.turned_n[k] -= turn * force.cross_matrix() * share;
                }
            }
        }
        parts
    }
}

impl StageBalance {
    /// Does the sum leave what the sensors may be off by?
    #[must_use]
    pub fn fails(&self) -> bool {
        let limit = self.bound_n + 3.0 * self.standard_error_n;
        self.sum_n.iter().any(|component| component.abs() > limit)
    }
}

/// Why a balance cannot be formed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NotChecked {
    /// Something touches the object whose force is not measured.
    PusherNotMeasured,
    /// The table carries the object, and its force is not measured.
    SupportNotMeasured,
    /// No finger force in all three axes with the gripper's pose.
    FingersNotMeasured,
    /// The motion is nowhere slow, or sensors miss in every slow sample.
    NothingSlow,
}

impl NotChecked {
    /// As people read it.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            NotChecked::PusherNotMeasured => "the pusher's force is not measured",
            NotChecked::SupportNotMeasured => "the support's force is not measured",
            NotChecked::FingersNotMeasured => {
                "finger forces in three axes and the gripper's pose are not measured"
            }
            NotChecked::NothingSlow => "no slow phase in which all forces are measured",
        }
    }
}

/// Balances of the stages of a trial in which it can be formed.
///
/// # Errors
/// Why it cannot be formed at all.
pub fn balance(
    description: &Description,
    trial: &Trial,
    stages: &Stages,
) -> Result<Vec<StageBalance>, NotChecked> {
    if description.supports.contains_key(&trial.info.primitive) {
        return Err(NotChecked::SupportNotMeasured);
    }
    let weight = weight_n(description, trial);
    if !trial.samples.iter().any(|sample| fingers_n(sample).is_some()) {
        return Err(NotChecked::FingersNotMeasured);
    }
    let pushed = description.pushers.contains_key(&trial.info.primitive);
    // Whether it touches the object already before it pushes cannot be known either.
    if pushed && !pusher_measured(trial) {
        return Err(NotChecked::PusherNotMeasured);
    }
    let sensors = &description.sensors;
    let slow = slow(&trial.samples, mass_kg(description, trial), weight.norm());
    let mut balances = Vec::new();
    for stage in STAGES {
        let range = stages.range(stage);
        let (used, sums): (Vec<&Sample>, Vec<Vector3<f64>>) = range
            .filter(|at| slow.get(*at).copied().unwrap_or(false))
            .filter_map(|at| trial.samples.get(at))
            .filter_map(|sample| {
                let pusher = match (pusher_n(sample), !pushed) {
                    (Some(force), _) => force,
                    (None, true) => Vector3::zeros(),
                    (None, false) => return None,
                };
                Some((sample, fingers_n(sample)? + pusher + weight))
            })
            .unzip();
        if sums.is_empty() {
            continue;
        }
        let count = sums.len() as f64;
        let mean = sums.iter().sum::<Vector3<f64>>() / count;
        let spread = sums.iter().map(|sum| (sum - mean).component_mul(&(sum - mean))).sum::<Vector3<f64>>();
        let measured_pusher = if pushed { 1.0 } else { 0.0 };
        let noise = 2.0 * sensors.finger.force_noise_n.powi(2)
            + measured_pusher * sensors.pusher.force_noise_n.powi(2);
        balances.push(StageBalance {
            stage,
            sum_n: mean.into(),
            scatter_n: (spread / count).map(f64::sqrt).into(),
            samples: sums.len(),
            bound_n: 2.0 * sensors.finger.force_uncertainty_n
                + measured_pusher * sensors.pusher.force_uncertainty_n,
            standard_error_n: (noise / count).sqrt(),
            parts: Parts::of(&used),
        });
    }
    if balances.is_empty() { Err(NotChecked::NothingSlow) } else { Ok(balances) }
}

pub(super) fn mass_kg(description: &Description, trial: &Trial) -> f64 {
    let object = description.objects.iter().find(|object| object.id == trial.info.object);
    object.map_or(0.0, |object| object.mass_kg)
}

pub(super) fn weight_n(description: &Description, trial: &Trial) -> Vector3<f64> {
    Vector3::from(description.gravity_m_s2) * mass_kg(description, trial)
}

pub(super) fn gripper(sample: &Sample) -> Option<UnitQuaternion<f64>> {
    sample.gripper.as_ref().map(|gripper| crate::channels::pose(gripper).rotation)
}

/// Both fingers' forces in world axes; `None` where a component is missing.
fn fingers_n(sample: &Sample) -> Option<Vector3<f64>> {
    let [finger1, finger2] = sample.finger;
    let sum = Vector3::from(finger1?.force_n) + Vector3::from(finger2?.force_n);
    sum.iter().all(|component| component.is_finite()).then_some(gripper(sample)? * sum)
}

fn pusher_n(sample: &Sample) -> Option<Vector3<f64>> {
    let force = Vector3::from(sample.pusher_wrench?.force_n);
    force.iter().all(|component| component.is_finite()).then_some(force)
}

pub(super) fn pusher_measured(trial: &Trial) -> bool {
    trial.samples.iter().any(|sample| pusher_n(sample).is_some())
}

/// Samples about which the inertia of the object (of the gripper where the object is not
/// measured) is small. Near the ends the window is cut: the nearest whole one decides.
pub(super) fn slow(samples: &[Sample], mass_kg: f64, weight_n: f64) -> Vec<bool> {
    let limit_n = (SLOW_SHARE * weight_n).max(SLOW_LEAST_N);
    let known: Vec<Option<bool>> =
        (0..samples.len()).map(|at| acceleration_m_s2(samples, at).map(|a| mass_kg * a <= limit_n)).collect();
    let first = known.iter().flatten().next().copied().unwrap_or(true);
    known
        .iter()
        .scan(first, |latest, known| {
            *latest = known.unwrap_or(*latest);
            Some(*latest)
        })
        .collect()
}

/// Central difference over a whole window; `None` where it is cut or a pose is missing.
fn acceleration_m_s2(samples: &[Sample], at: usize) -> Option<f64> {
    let position =
        |sample: &Sample| sample.object.or(sample.gripper).map(|pose| Vector3::from(pose.position_m));
    let here = samples.get(at)?;
    let before = samples.get(..at)?.iter().rev();
    let from = before.take_while(|sample| here.t_s - sample.t_s <= HALF_WINDOW_S).last()?;
    let after = samples.get(at..)?.iter();
    let to = after.take_while(|sample| sample.t_s - here.t_s <= HALF_WINDOW_S).last()?;
    let (left_s, right_s) = (here.t_s - from.t_s, to.t_s - here.t_s);
    if left_s.min(right_s) < 0.8 * HALF_WINDOW_S {
        return None;
    }
    let (a, b, c) = (position(from)?, position(here)?, position(to)?);
    Some((2.0 * ((c - b) / right_s - (b - a) / left_s) / (left_s + right_s)).norm())
}
