//! How every command reads data: what is good is used, what was refused is listed
//! ([`Output::refused`]: the exit code is 1), and what makes results doubtful is said before them.

use std::path::Path;

use stickslip_analysis::evidence::sensors;
use stickslip_data::{Dataset, Index, Trial, TrialInfo, error::join_warnings};

use crate::terminal::Output;

/// Opens a data set; lists refused rows of trials.csv, warnings, and sensors about which nothing is
/// stated.
///
/// # Errors
/// Where dataset.toml or the header of trials.csv cannot be read.
pub fn open(folder: &Path, output: &Output) -> anyhow::Result<Index> {
    let index = Index::open(folder)?;
    for error in &index.errors {
        output.refused(error);
    }
    for warning in join_warnings(index.warnings.iter().cloned()) {
        output.note(warning);
    }
    if let Some(sentence) = sensors::unstated(&index.description).sentence() {
        output.note(format_args!("{}: {sentence}", folder.join("dataset.toml").display()));
    }
    Ok(index)
}

/// What is good of one trial; the rest is listed.
#[must_use]
pub fn trial(index: &Index, info: &TrialInfo, output: &Output) -> Option<Trial> {
    let reading = index.read_trial_lenient(info);
    if let Some(refusal) = reading.refusal() {
        output.refused(refusal);
    }
    reading.trial
}

/// A whole data set.
///
/// # Errors
/// As [`open`].
pub fn read(folder: &Path, output: &Output) -> anyhow::Result<Dataset> {
    let index = open(folder, output)?;
    let trials = index.trials.iter().filter_map(|info| trial(&index, info, output)).collect();
    Ok(Dataset { folder: folder.to_path_buf(), description: index.description, trials })
}
