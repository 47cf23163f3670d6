//! A recorded trial as a board is sent it: for `stream`, `board load` and `monitor`.

use std::path::Path;

use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::replay::{Feed, at_board_rate, feed, interpolated_poses};
use stickslip_device::package::Package;
use stickslip_report::terminal::Output;

use super::replay::every_so_many;

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
    let reader = stickslip_report::data::open(data, output)?;
    let (ordinal, info) = reader.find(trial)?;
    let (trial, every) = at_board_rate(reader.read_trial(info)?);
    if every > 1 {
        output.note(every_so_many(&info.trial, every));
    }
    if let Some(text) = interpolated_poses(&trial) {
        output.note(format_args!("trial {}: {text}", info.trial));
    }
    let model = model_or_default(model)?;
    let Feed { scene, plan, samples, .. } = feed(&reader.description, &trial)?;
    Ok((Package::new(scene, &model, plan, samples, ordinal), info.trial.clone()))
}
