//! `stickslip simulate DATA --model M --out PREDICTED`: what a model predicts, as a data set.

use std::path::PathBuf;

use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::simulate;
use stickslip_data::{Stage, TableFormat};
use stickslip_report::terminal::Output;

/// Arguments of `stickslip simulate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  stickslip simulate data/demo --model model.toml --out out/predicted")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    data: PathBuf,
    /// Model to predict with [default: hard contact, friction 0.40 (fingers), 0.25 (pusher),
    /// 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// Folder to write the predicted data set into; new or empty
    #[arg(long)]
    out: PathBuf,
    /// How trials are stored
    #[arg(long, value_enum, default_value_t)]
    tables: TableFormat,
}

/// Simulates every trial and writes the result.
///
/// # Errors
/// Data or model that cannot be read, a folder that has content, no trial that can be simulated.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let index = stickslip_report::data::open(&args.data, output)?;
    let model = model_or_default(args.model.as_deref())?;
    let stage = Stage::begin(&args.out)?;
    let report = simulate(&index, &model, stage.folder(), args.tables, output)?;
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
