//! `stickslip simulate DATA --model M --out PREDICTED`: what a model predicts, as a data set.

use std::path::PathBuf;

use super::arguments::PredictsWith;
use stickslip_analysis::simulate;
use stickslip_data::{Stage, TableFormat};
use stickslip_report::terminal::Output;

/// Arguments of `stickslip simulate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  stickslip simulate data/demo --model model.toml --out out/predicted")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    data: PathBuf,
    #[command(flatten)]
    with: PredictsWith,
    /// Folder to write the predicted data set into; new or empty
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Format of the tables
    #[arg(long, alias = "tables", value_enum, default_value_t)]
    format: TableFormat,
}

/// Simulates every trial and writes the result.
///
/// # Errors
/// Data or model that cannot be read, a folder that has content, no trial that can be simulated.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let index = stickslip_report::data::open(&args.data, output)?;
    let model = args.with.read()?;
    let stage = Stage::begin(&args.out)?;
    let report = simulate(&index, &model, stage.folder(), args.format, output)?;
    stage.finish()?;
    for why in &report.refused {
        output.refused(why);
    }
    output.text(format_args!(
        "{}: {} trials, {} samples; {} steps whose contact problem was not solved to its tolerance",
        args.out.display(),
        report.trials,
        report.samples,
        report.unsolved
    ));
    output.document(&report)
}
