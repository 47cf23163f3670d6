//! What a model predicts along recorded trials, as a data set of the same format: for plots and programs of
//! others.
//!
//! Object pose and wrenches are the model's, without sensor noise; gripper, pusher and grip command are those
//! that drove it (interpolated and without noise, as the model had them).

use std::path::Path;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use stickslip_data::{
    Dataset, DatasetError, Index, Pose, Sample, TableFormat, Trial, TrialInfo, Wrench, Writer,
};
use stickslip_shared::model::Model;
use stickslip_shared::track;
use thiserror::Error;

use crate::evidence::carried;
use crate::progress::Progress;
use crate::run::simulate::{Prepared, Simulated, prepare};

/// What was written.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Report {
    /// Trials written.
    pub trials: usize,
    /// Their samples.
    pub samples: usize,
    /// Steps whose solve did not reach its tolerance.
    pub unsolved: usize,
    /// Trials and rows that were left out, with the reason.
    pub refused: Vec<String>,
}

/// Why nothing was written.
#[derive(Debug, Error)]
pub enum SimulateError {
    /// Writing.
    #[error(transparent)]
    Data(#[from] DatasetError),
    /// No trial is left.
    #[error("no trial could be simulated; the first: {0}")]
    NoTrials(String),
}

/// Runs `model` (f64) along every trial of `index` and writes the result into `folder`.
///
/// # Errors
/// What the file system answers, and where no trial can be simulated. A trial that fails alone is in
/// [`Report::refused`].
pub fn simulate(
    index: &Index,
    model: &Model<f64>,
    folder: &Path,
    tables: TableFormat,
    progress: &dyn Progress,
) -> Result<Report, SimulateError> {
    let writer = Writer::begin(&index.description, folder, tables)?;
    let table = |trial: Trial| writer.table(&trial).map(|()| trial.info);
    let (report, infos) = each(index, model, &table, progress)?;
    writer.finish(&infos.iter().collect::<Vec<_>>())?;
    Ok(report)
}

/// The same into memory.
///
/// # Errors
/// Where no trial can be simulated.
pub fn in_memory(
    index: &Index,
    model: &Model<f64>,
    progress: &dyn Progress,
) -> Result<(Report, Dataset), SimulateError> {
    let (report, trials) = each(index, model, &Ok, progress)?;
    let (folder, description) = (index.folder.clone(), index.description.clone());
    Ok((report, Dataset { folder, description, trials }))
}

/// Hands every predicted trial to `keep`; what that makes of them, in order.
fn each<T: Send>(
    index: &Index,
    model: &Model<f64>,
    keep: &(dyn Fn(Trial) -> Result<T, DatasetError> + Sync),
    progress: &dyn Progress,
) -> Result<(Report, Vec<T>), SimulateError> {
    progress.begin("simulating", index.trials.len());
    let one = |(ordinal, info): (usize, &TrialInfo)| -> Result<Result<Made<T>, String>, DatasetError> {
        let read = index.read_trial_lenient(info);
        let refusal = read.refusal();
        let result = match read.trial {
            None => Err(refusal.unwrap_or_default()),
            Some(trial) => match prepare(&index.description, &trial, ordinal) {
                Err(error) => Err(error.to_string()),
                Ok(prepared) => {
                    let prepared = carried::at_an_edge(prepared);
                    let simulated = prepared.simulate(model);
                    let trial = predicted(&prepared, &trial, &simulated);
                    let (samples, unsolved) = (trial.samples.len(), simulated.unsolved);
                    Ok(Made { kept: keep(trial)?, samples, unsolved, refusal })
                }
            },
        };
        progress.step(1);
        Ok(result)
    };
    let results: Vec<_> = index
        .trials
        .par_iter()
        .enumerate()
        .map(one)
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Result<_, _>>()?;
    let mut report = Report {
        trials: 0,
        samples: 0,
        unsolved: 0,
        refused: index.errors.iter().map(ToString::to_string).collect(),
    };
    let mut kept = Vec::new();
    for result in results {
        match result {
            Err(why) => report.refused.push(why),
            Ok(made) => {
                report.trials += 1;
                report.samples += made.samples;
                report.unsolved += made.unsolved;
                report.refused.extend(made.refusal);
                kept.push(made.kept);
            }
        }
    }
    if kept.is_empty() {
        return Err(SimulateError::NoTrials(report.refused.first().cloned().unwrap_or_default()));
    }
    Ok((report, kept))
}

/// A trial that was simulated.
struct Made<T> {
    kept: T,
    samples: usize,
    unsolved: usize,
    refusal: Option<String>,
}

/// `trial` as the model would have recorded it.
#[must_use]
pub fn predicted(prepared: &Prepared, trial: &Trial, simulated: &Simulated) -> Trial {
    let grasped = prepared.scene.fingers.is_some();
    let moves = trial.samples.iter().any(|sample| sample.pusher.is_some());
    let samples = simulated.signals.iter().zip(prepared.poses()).zip(prepared.grips_n()).enumerate();
    let samples = samples.map(|(at, ((row, poses), grip_n))| {
        let wrench = |from: usize| {
            let of = |k: usize| row[from + k];
            let wrench = Wrench { force_n: [of(0), of(1), of(2)], torque_nm: [of(3), of(4), of(5)] };
            row[from..from + 6].iter().any(|component| !component.is_nan()).then_some(wrench)
        };
        Sample {
            t_s: poses.t_s,
            grip_cmd_n: grasped.then_some(*grip_n),
            gripper: grasped.then(|| written(&poses.carrier)),
            object: Some(written(&prepared.world_pose(at, row))),
            pusher: poses.pusher.as_ref().filter(|_| moves).map(written),
            finger: [wrench(6), wrench(12)],
            pusher_wrench: wrench(18),
        }
    });
    Trial { info: trial.info.clone(), samples: samples.collect() }
}

fn written(pose: &track::Pose<f64>) -> Pose {
    Pose::of(&pose.position_m, &pose.rotation)
}
