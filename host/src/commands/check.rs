//! `stickslip check DATA`: what a data set holds and whether it can be trusted.

use std::path::PathBuf;

use crate::output::Output;

/// Arguments of `stickslip check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  stickslip check data/demo")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
}

/// Reads the data set leniently and reports.
///
/// # Errors
/// Where the data set cannot be read or holds errors.
pub fn run(args: &Args, _output: &Output) -> anyhow::Result<()> {
    anyhow::bail!("{}: not readable", args.data.display())
}
