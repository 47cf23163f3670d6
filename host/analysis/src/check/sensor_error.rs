//! Which sensor's error would make the measured forces balance: one that is mounted turned, or reads too much or too little.
//!
//! A sensor that is turned by a small `r` adds `r x F` of its own force `F` to the sum of all forces, one that reads too much
//! by a share `g` adds `g F`. Least squares over all stages of all trials give `r` or `g` of each suspect, beside constant
//! offsets of the fingers' sum and of the pusher within what the sensors may be off by. A suspect explains the sums if it
//! leaves little of them, and the forces balance without its part. Two fingers that share the load alike, or pusher and
//! fingers, explain each other's errors: all that fit about as well are told. Where a wrong mass does, nobody is suspected.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

use crate::evidence::balance::StageBalance;
use stickslip_data::{Description, Sensors};

/// Scatter of the sums from trial to trial that is nobody's error, N.
const SCATTER_N: f64 = 0.05;
/// A suspect leaves no more than this share of the sums' root mean square.
const LEAVES: f64 = 0.35;
/// Of the trials, at most this share does not balance without its part.
const STILL_FAILING: f64 = 0.1;
/// The others leave no more than this multiple of what the best leaves.
const AS_GOOD: f64 = 1.3;
/// A turn that is worth telling, and the largest that the small-angle form describes, rad.
const TURN_RAD: [f64; 2] = [0.01, 0.5];
/// The same of a gain.
const GAIN: [f64; 2] = [0.01, 1.0];

/// What is wrong with a sensor.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// It stands turned by this rotation vector, rad: gripper axes, the pusher's world axes.
    Turned([f64; 3]),
    /// It reads too much by this share.
    Gain(f64),
}

/// A sensor, or two alike, whose error explains why the forces do not balance.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Suspect {
    /// As people call it.
    pub sensor: &'static str,
    /// What is wrong.
    pub fault: Fault,
    /// Effect by which `diagnose` fits it.
    pub effect: &'static str,
    /// Root mean square of the sums, before and without its part, N.
    pub sums_n: [f64; 2],
}

impl std::fmt::Display for Suspect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.fault {
            Fault::Turned(rad) => {
                let least = TURN_RAD[0].min(0.2 * Vector3::from(rad).norm());
                let about: Vec<String> = rad
                    .iter()
                    .zip(["X", "Y", "Z"])
                    .filter(|(rad, _)| rad.abs() >= least)
                    .map(|(rad, axis)| format!("{:.1} deg about {axis}", rad.to_degrees()))
                    .collect();
                write!(f, "{} turned by {}", self.sensor, about.join(" and "))
            }
            Fault::Gain(share) => {
                let much = if share > 0.0 { "much" } else { "little" };
                write!(f, "{} reading {:.1} % too {much}", self.sensor, 100.0 * share.abs())
            }
        }
    }
}

/// Suspects in the order of what they leave; none where no error of a single kind explains the sums.
#[must_use]
pub fn suspects(trials: &[&[StageBalance]], description: &Description) -> Vec<Suspect> {
    let sensors = &description.sensors;
    let stages: Vec<&StageBalance> = trials.iter().flat_map(|trial| trial.iter()).collect();
    let Some(before_n) = fit(&stages, sensors, &|_| DMatrix::zeros(3, 0)).map(|(_, left)| left) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for (sensor, of) in
        [("finger 1", &[0][..]), ("finger 2", &[1]), ("both fingers", &[0, 1]), ("the pusher", &[2])]
    {
        let turned = |stage: &StageBalance| of.iter().map(|k| stage.parts.turned_n[*k]).sum::<Matrix3<f64>>();
        let force = |stage: &StageBalance| of.iter().map(|k| stage.parts.force_n[*k]).sum::<Vector3<f64>>();
        let turn =
            fit(&stages, sensors, &|stage| DMatrix::from_iterator(3, 3, turned(stage).iter().copied()));
        let gain = fit(&stages, sensors, &|stage| DMatrix::from_iterator(3, 1, force(stage).iter().copied()));
        let mut judge = |fault, effect, size: f64, [least, most]: [f64; 2], left_n: f64, part: &Part| {
            let fails = |trial: &&&[StageBalance]| {
                trial.iter().any(|stage| {
                    let sum_n = (Vector3::from(stage.sum_n) - part(stage)).into();
                    StageBalance { sum_n, ..*stage }.fails()
                })
            };
            let failing = trials.iter().filter(fails).count();
            let explains =
                left_n <= LEAVES * before_n && failing as f64 <= STILL_FAILING * trials.len() as f64;
            if explains && (least..=most).contains(&size) {
                found.push(Suspect { sensor, fault, effect, sums_n: [before_n, left_n] });
            }
        };
        if let Some((x, left_n)) = turn {
            let r = Vector3::new(x[0], x[1], x[2]);
            let part = |stage: &StageBalance| turned(stage) * r;
            judge(Fault::Turned(r.into()), "sensor_misalignment", r.norm(), TURN_RAD, left_n, &part);
        }
        if let Some((x, left_n)) = gain {
            let part = |stage: &StageBalance| force(stage) * x[0];
            judge(Fault::Gain(x[0]), "sensor_gain", x[0].abs(), GAIN, left_n, &part);
        }
    }
    found.sort_by(|a: &Suspect, b| a.sums_n[1].total_cmp(&b.sums_n[1]));
    let best_n = found.first().map_or(0.0, |best| best.sums_n[1]);
    // The same force along gravity in every stage: a mass.
    let gravity = description.gravity_m_s2;
    let mass = fit(&stages, sensors, &|_| DMatrix::from_column_slice(3, 1, &gravity));
    if mass.is_none_or(|(_, left_n)| left_n <= AS_GOOD * best_n) {
        return Vec::new();
    }
    found.retain(|suspect| suspect.sums_n[1] <= AS_GOOD * best_n);
    found
}

/// What a suspect adds to the sum of a stage, N.
type Part<'a> = dyn Fn(&StageBalance) -> Vector3<f64> + 'a;

/// Least squares over `stages` of the columns that `of` gives for each, beside the offsets; the suspect's numbers, and the
/// root mean square that is left.
fn fit(
    stages: &[&StageBalance],
    sensors: &Sensors,
    of: &dyn Fn(&StageBalance) -> DMatrix<f64>,
) -> Option<(Vec<f64>, f64)> {
    let own = of(stages.first()?).ncols();
    let count = own + 6;
    let (mut normal, mut right) = (DMatrix::<f64>::zeros(count, count), DVector::<f64>::zeros(count));
    let row = |stage: &StageBalance| {
        let mut row = DMatrix::zeros(3, count);
        row.view_mut((0, 0), (3, own)).copy_from(&of(stage));
        row.view_mut((0, own), (3, 3)).copy_from(&stage.parts.gripper);
        row.view_mut((0, own + 3), (3, 3)).copy_from(&Matrix3::<f64>::identity());
        row
    };
    let sum = |stage: &StageBalance| DVector::from_column_slice(&stage.sum_n);
    for stage in stages {
        let row = row(stage);
        normal += row.tr_mul(&row);
        right += row.tr_mul(&sum(stage));
    }
    // Offsets of the fingers' sum and of the pusher are within what is stated.
    for k in 0..6 {
        let uncertain =
            if k < 3 { 2.0 * sensors.finger.force_uncertainty_n } else { sensors.pusher.force_uncertainty_n };
        normal[(own + k, own + k)] += (SCATTER_N / uncertain.max(1e-3)).powi(2);
    }
    let x = normal.cholesky()?.solve(&right);
    let left: f64 = stages.iter().map(|stage| (sum(stage) - row(stage) * &x).norm_squared()).sum();
    Some((x.iter().take(own).copied().collect(), (left / (3 * stages.len()) as f64).sqrt()))
}
