//! A recorded trial as a board is sent it: for `stream`, `board load`, `monitor` and `replay`.

use std::path::Path;

use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::replay::{self, Feed, feed, interpolated_poses};
use stickslip_data::{Index, Trial, TrialInfo};
use stickslip_device::package::Package;
use stickslip_report::terminal::Output;

use super::arguments::OneTrial;

impl OneTrial {
    /// What is sent, and the trial's name.
    ///
    /// # Errors
    /// As [`of_trial`].
    pub fn package(&self, output: &Output) -> anyhow::Result<(Package, String)> {
        of_trial(&self.data, self.trial.as_deref(), self.with.model.as_deref(), output)
    }
}

/// Trial `trial` of the data set at `data` (the first where none is named) with `model` (the default where none is
/// named), and the trial's name.
///
/// # Errors
/// Data or model that cannot be read, a trial that is not there or cannot be fed to the predictor.
pub fn of_trial(
    data: &Path,
    trial: Option<&str>,
    model: Option<&Path>,
    output: &Output,
) -> anyhow::Result<(Package, String)> {
    let index = stickslip_report::data::open(data, output)?;
    let (ordinal, info, trial) = at_board_rate(&index, trial, output)?;
    let model = model_or_default(model)?;
    let Feed { scene, plan, samples, .. } = feed(&index.description, &trial)?;
    Ok((Package::new(scene, &model, plan, samples, ordinal), info.trial.clone()))
}

/// Trial `trial` of a data set (the first where none is named) at the rate of a board, and its place in the list. Notes
/// say what the predictor does not use of it.
///
/// # Errors
/// A trial that is not there or cannot be read.
pub fn at_board_rate<'a>(
    index: &'a Index,
    trial: Option<&str>,
    output: &Output,
) -> anyhow::Result<(usize, &'a TrialInfo, Trial)> {
    let (ordinal, info) = index.find(trial)?;
    let bar = output.spinner("reading");
    let (trial, every) = replay::at_board_rate(index.read_trial(info)?);
    bar.finish_and_clear();
    if every > 1 {
        output.note(format_args!(
            "trial {}: the predictor takes a sample every 4 ms, as a board does: one in {every} of this record",
            info.trial
        ));
    }
    if let Some(text) = interpolated_poses(&trial) {
        output.note(format_args!("trial {}: {text}", info.trial));
    }
    Ok((ordinal, info, trial))
}
