//! Pushing an object over a table: predicted final pose and force against measurement.
//!
//! Friction of table and pusher is calibrated on a share of the pushes; the rest is
//! predicted open loop from the first pose and the pusher's motion. Beside it the baseline
//! 'the object moves as the pusher pushes it': from first contact on it is carried along
//! with the pusher's displacement, without turning.

use rayon::prelude::*;
use serde::Serialize;

use stickslip_analysis::calibrate::Calibration;
use stickslip_analysis::channels::COUNT;
use stickslip_analysis::run::simulate::prepare;
use stickslip_data::{Description, Trial};

/// Errors of one push.
#[derive(Clone, Debug, Serialize)]
pub struct Push {
    /// Trial.
    pub trial: String,
    /// Distance between predicted and measured final position, m.
    pub position_m: f64,
    /// Angle between predicted and measured final orientation, rad.
    pub rotation_rad: f64,
    /// The same of the baseline.
    pub baseline_position_m: f64,
    /// The same of the baseline: how far the object really turned.
    pub baseline_rotation_rad: f64,
    /// How far the object really moved, m.
    pub moved_m: f64,
    /// Mean force while pushing, predicted and measured, N.
    pub force_n: [f64; 2],
    /// Root mean square error of the force vector over the push, N.
    pub force_error_n: f64,
}

/// Errors over the held-out pushes.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the figure.
    pub what: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Of the model: median and root mean square.
    pub model: [f64; 2],
    /// Of the baseline, NaN where it says nothing.
    pub baseline: [f64; 2],
    /// Size of the measured quantity: median and root mean square.
    pub measured: [f64; 2],
}

/// Predicts the pushes that `calibration` did not use.
pub fn evaluate(
    description: &Description,
    trials: &[(usize, Trial)],
    calibration: &Calibration,
) -> Vec<Push> {
    trials
        .par_iter()
        .filter(|(_, t)| !calibration.calibration_trials.contains(&t.info.trial))
        .filter_map(|(at, trial)| {
            let prepared = prepare(description, trial, *at).ok()?;
            let mut pushed = vec![false; prepared.t_s.len()];
            let simulated = prepared.simulate(&calibration.model);
            for (p, n) in pushed.iter_mut().zip(&simulated.normal_n) {
                *p = n[2] > 0.0;
            }
            let end = prepared.measured.iter().rposition(|row| row[0].is_finite())?;
            let truth = prepared.world_pose(end, &prepared.measured[end]);
            let start = prepared.carrier.to_world(&prepared.start);
            let predicted = prepared.world_pose(end, simulated.signals.get(end)?);
            let poses = prepared.poses();
            let touch = pushed.iter().position(|p| *p)?;
            let carried = poses.get(end)?.pusher?.position_m - poses.get(touch)?.pusher?.position_m;
            let flat = |v: nalgebra::Vector3<f64>| v.x.hypot(v.y);
            let (mut sums, mut count, mut error) = ([0.0; 2], 0.0, 0.0);
            for ((model, seen), on) in simulated.signals.iter().zip(&prepared.measured).zip(&pushed) {
                let offset = |c: usize| seen[c] - calibration.offsets.get(c).copied().unwrap_or(0.0);
                let (m, s) = ([model[18], model[19]], [offset(18), offset(19)]);
                if *on && s.iter().chain(&m).all(|x| x.is_finite()) {
                    sums = [sums[0] + m[0].hypot(m[1]), sums[1] + s[0].hypot(s[1])];
                    error += (m[0] - s[0]).powi(2) + (m[1] - s[1]).powi(2);
                    count += 1.0;
                }
            }
            const { assert!(COUNT > 19) };
            Some(Push {
                trial: trial.info.trial.clone(),
                position_m: flat(predicted.position_m - truth.position_m),
                rotation_rad: predicted.rotation.angle_to(&truth.rotation),
                baseline_position_m: flat(start.position_m + carried - truth.position_m),
                baseline_rotation_rad: start.rotation.angle_to(&truth.rotation),
                moved_m: flat(truth.position_m - start.position_m),
                force_n: sums.map(|s| s / count),
                force_error_n: f64::sqrt(error / count),
            })
        })
        .collect()
}

/// Median and root mean square of what is finite.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut all: Vec<f64> = values.filter(|x| x.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    let median = all.get(all.len() / 2).copied().unwrap_or(f64::NAN);
    [median, (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt()]
}

/// The figures of the table.
pub fn summaries(pushes: &[Push]) -> Vec<Summary> {
    let of = |f: &dyn Fn(&Push) -> f64| spread(pushes.iter().map(f));
    let none = [f64::NAN; 2];
    vec![
        Summary {
            what: "final position",
            unit: "m",
            model: of(&|p| p.position_m),
            baseline: of(&|p| p.baseline_position_m),
            measured: of(&|p| p.moved_m),
        },
        Summary {
            what: "final orientation",
            unit: "rad",
            model: of(&|p| p.rotation_rad),
            baseline: of(&|p| p.baseline_rotation_rad),
            measured: of(&|p| p.baseline_rotation_rad),
        },
        Summary {
            what: "mean push force",
            unit: "N",
            model: of(&|p| (p.force_n[0] - p.force_n[1]).abs()),
            baseline: none,
            measured: of(&|p| p.force_n[1]),
        },
        Summary {
            what: "push force, each sample",
            unit: "N",
            model: of(&|p| p.force_error_n),
            baseline: none,
            measured: of(&|p| p.force_n[1]),
        },
    ]
}
