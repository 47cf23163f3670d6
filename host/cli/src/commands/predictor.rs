//! `stickslip predictor`: the numbers of the predictor as a commented file, from their own descriptions.

use stickslip_analysis::tuning::{default_file, tables};
use stickslip_report::terminal::Output;

/// Command line of `stickslip predictor`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip predictor > predictor.toml
  stickslip replay data/demo --predictor predictor.toml
  stickslip --json predictor

A file for --predictor needs only the numbers that differ from the defaults. A board runs the defaults.")]
pub struct Args {}

/// Prints the file.
///
/// # Errors
/// Where it cannot be written as JSON.
pub fn run(_: &Args, output: &Output) -> anyhow::Result<()> {
    // Nothing else: what is printed is a file.
    output.text(default_file().trim_end());
    output.document(&tables())
}
