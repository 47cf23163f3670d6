//! `stickslip-lab planar DATA`: planar pushes predicted from friction found on a few of them.

use std::path::PathBuf;

use anyhow::{Context, bail};
use serde::Serialize;

use crate::planar::{Push, Summary, evaluate, summaries};
use stickslip_analysis::calibrate::{Calibration, Share, of_primitive};
use stickslip_analysis::model::file::model_or_default;
use stickslip_data::Trial;
use stickslip_report::terminal::{Output, table};

/// Arguments of `stickslip-lab planar`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip import cmu-push patch__exp_08_18_1435_50.txt --out data/cmu_patch
  stickslip-lab planar data/cmu_patch")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model to start from [default: hard contact, no effects]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Share of the pushes that friction is fitted to
    #[arg(long, value_name = "SHARE", default_value_t = 0.1)]
    pub share: f64,
}

#[derive(Serialize)]
struct Document {
    calibration: Calibration,
    summary: Vec<Summary>,
    pushes: Vec<Push>,
}

/// Calibrates, predicts, and prints the table.
///
/// # Errors
/// Where the data cannot be read or hold no planar pushes.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let base = model_or_default(args.model.as_deref())?;
    let data = stickslip_report::data::read(&args.data, output)?;
    let trials: Vec<(usize, Trial)> =
        data.trials.into_iter().enumerate().filter(|(_, t)| t.info.primitive == "planar_push").collect();
    if trials.is_empty() {
        bail!("{}: no trial of primitive planar_push", args.data.display());
    }
    let share = Share { share: args.share, fewest: 3 };
    let calibration = of_primitive(&data.description, "planar_push", &trials, &base, share)
        .with_context(|| args.data.display().to_string())?;
    let pushes = evaluate(&data.description, &trials, &calibration);
    let summary = summaries(&pushes);
    for e in &calibration.estimates {
        let bound = |b: Option<f64>| b.map_or_else(|| "-".into(), |b| format!("{b:.3}"));
        output.text(format_args!(
            "{} friction {:.3}, {} to {}{}",
            stickslip_analysis::calibrate::name(e.coefficient),
            e.value,
            bound(e.low),
            bound(e.high),
            if e.determined { "" } else { " (only bounded)" }
        ));
    }
    output.text(format_args!(
        "from {} pushes; errors of {} others, median and root mean square:",
        calibration.calibration_trials.len(),
        pushes.len()
    ));
    let mut rows = table(["error of", "unit", "model", "moved with the pusher", "measured size"]);
    for s in &summary {
        let pair = |p: &[f64; 2]| {
            if p[0].is_finite() { format!("{:.4}, {:.4}", p[0], p[1]) } else { "-".into() }
        };
        rows.add_row([s.what.into(), s.unit.into(), pair(&s.model), pair(&s.baseline), pair(&s.measured)]);
    }
    output.table(&rows);
    for remark in &calibration.remarks {
        output.text(format_args!("- {remark}"));
    }
    output.document(&Document { calibration, summary, pushes })
}
