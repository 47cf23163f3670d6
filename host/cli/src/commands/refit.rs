//! `stickslip refit DATA`: all parameters of a model that has effects, fitted anew.

use std::path::PathBuf;

use crate::commands::fitted::{give, next_compare};
use stickslip_analysis::model::file::ModelFile;
use stickslip_analysis::refit;
use stickslip_report::terminal::Output;

/// Arguments of `stickslip refit`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip refit data/bench --model better.toml --out refitted.toml

`stickslip calibrate` fits friction alone, `stickslip add` adds an effect and fits.")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model whose friction, effects and formulas are fitted, from the values that it has
    #[arg(long, value_name = "MODEL.toml")]
    pub model: PathBuf,
    /// File of the fitted model
    #[arg(long, value_name = "FILE.toml")]
    pub out: PathBuf,
}

/// Fits and writes.
///
/// # Errors
/// Where data or model cannot be read, or nothing can be fitted.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let before = ModelFile::read(&args.model)?;
    let report = refit(&stickslip_report::data::read(&args.data, output)?, &before, output)?;
    give(&before, &report, &args.out, output)?;
    next_compare(&args.data, Some(&args.model), &args.out, output);
    Ok(())
}
