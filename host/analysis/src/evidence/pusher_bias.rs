//! Constant error of the pusher's force sensor, from what it shows before contact.
//!
//! Until something touches it a pusher bears nothing. What its sensor shows then, alike in all trials, is its error, or a force
//! that acts on the object from afar (a magnet, a cable from pusher to object), which the fingers bear: fingers, pusher and weight
//! then sum to zero, and of an error they sum to it. What is stated of the sensor counts as no error ([`most_error`]). No model of
//! contact enters.

use nalgebra::Vector3;
use statrs::distribution::{ContinuousCDF, StudentsT};
use stickslip_data::{Dataset, Trial, WrenchSensor};

use crate::evidence::sensors::most_error;
use crate::evidence::statistics::median;
use crate::evidence::{balance, offsets, stages};

/// Share of the error by which trials may scatter: what drifts, or differs from mounting to mounting, is no constant.
const SCATTER: f64 = 0.25;
/// Share of the pusher's force from which on the fingers bear it.
const BORNE: f64 = 0.5;
/// Fewer trials show no constant.
const FEWEST: usize = 4;
/// A normal distribution's standard deviation over its median absolute deviation.
const NORMAL: f64 = 1.4826;

/// Constant errors beyond what is stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bias {
    /// Of force (N) and torque (N m) along world axes; zero where it is within what is stated.
    pub of_channel: [f64; 6],
    /// Probability of the clearest by chance.
    pub by_chance: f64,
}

/// What the pusher's sensor shows before contact in one trial: force and torque along world axes, and the sum of all forces.
#[derive(Clone, Copy, Debug)]
pub struct AtRest {
    /// N and N m.
    pub pusher: [f64; 6],
    /// Of fingers, pusher and weight, N.
    pub sum_n: [f64; 3],
}

/// Of a trial; `None` where nothing is known before contact.
fn of_trial(dataset: &Dataset, trial: &Trial) -> Option<AtRest> {
    let stages = stages::stages(trial);
    let rest = offsets::at_rest(&dataset.description, trial, &stages)?;
    let turn = balance::gripper(trial.samples.get(stages.rest().start)?)?;
    let ([x, y, z], [tx, ty, tz]) = (rest.pusher_n?, rest.pusher_nm?);
    let sum_n = turn * Vector3::from(rest.fingers_sum_n) + Vector3::new(x, y, z);
    Some(AtRest { pusher: [x, y, z, tx, ty, tz], sum_n: sum_n.into() })
}

impl Bias {
    /// Of a data set; `None` where none is beyond what its `sensor` is stated to have.
    #[must_use]
    pub fn measured(dataset: &Dataset, sensor: &WrenchSensor) -> Option<Self> {
        let trials: Vec<AtRest> = dataset.trials.iter().filter_map(|t| of_trial(dataset, t)).collect();
        Self::over(&trials, sensor)
    }

    /// The same of what trials show.
    #[must_use]
    pub fn over(trials: &[AtRest], sensor: &WrenchSensor) -> Option<Self> {
        if trials.len() < FEWEST {
            return None;
        }
        let of = |value: &dyn Fn(&AtRest) -> f64| median(trials.iter().map(value));
        let mut out = Self { of_channel: [0.0; 6], by_chance: 1.0 };
        for k in 0..6 {
            let stated = most_error(sensor, k >= 3);
            let middle = of(&|t| t.pusher[k])?;
            let scatter = NORMAL * of(&|t| (t.pusher[k] - middle).abs())?;
            if middle.abs() <= stated || scatter > SCATTER * middle.abs() {
                continue;
            }
            if k < 3 && (of(&|t| t.sum_n[k])? / middle) < 1.0 - BORNE {
                return None;
            }
            let t = (middle.abs() - stated) * (trials.len() as f64).sqrt() / scatter.max(f64::MIN_POSITIVE);
            let chance = StudentsT::new(0.0, 1.0, trials.len() as f64 - 1.0).map_or(1.0, |of| 2.0 * of.sf(t));
            out.of_channel[k] = middle;
            out.by_chance = out.by_chance.min(chance);
        }
        out.of_channel.iter().any(|x| *x != 0.0).then_some(out)
    }
}
