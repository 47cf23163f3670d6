//! `stickslip suggest`: the experiment that would tell candidate effects apart.

use std::path::PathBuf;

use anyhow::bail;
use comfy_table::{Cell, CellAlignment};

use crate::commands::diagnose::read_data;
use stickslip_analysis::diagnose::{steps, suggest};
use stickslip_analysis::model::file::model_or_default;
use stickslip_report::terminal::{Output, table};

/// Arguments of `stickslip suggest`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip suggest data/demo --between grip_force_loss --between sensor_gain")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model that lacks the effect [default: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// The two effects to separate [default: the best two of the diagnosis]
    #[arg(long = "between", value_name = "EFFECT")]
    pub between: Vec<String>,
}

/// Fits both candidates and compares their predictions.
///
/// # Errors
/// Where data or model cannot be read, or there are no two candidates.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    if !matches!(args.between.len(), 0 | 2) {
        bail!("--between must be given twice, once for each effect");
    }
    let dataset = read_data(&args.data, output)?;
    let model = model_or_default(args.model.as_deref())?;
    let bar = output.progress(steps(), "fitting");
    let found = suggest(&dataset, &model, &args.between, 8, &|| bar.inc(1))?;
    bar.finish_and_clear();
    let Some((pair, experiments)) = found else {
        bail!(
            "there are no two candidates to separate: fewer than two effects change these data (check the identifiers)"
        );
    };
    output.text(format!("Between {} and {}:", pair[0], pair[1]));
    if let Some(best) = experiments.first() {
        output.text(&best.summary);
    }
    let mut t = table(["like trial", "grip N", "channel", "phase", "difference", "sd", "runs"]);
    for e in &experiments {
        let right = |s: String| Cell::new(s).set_alignment(CellAlignment::Right);
        t.add_row(vec![
            Cell::new(&e.like_trial),
            right(e.grip_n.map_or("-".into(), |g| format!("{g:.1}"))),
            Cell::new(&e.channel),
            Cell::new(e.phase),
            right(format!("{:.3} {}", e.difference, e.unit)),
            right(format!("{:.1}", e.standard_deviations)),
            right(e.runs.to_string()),
        ]);
    }
    output.table(&t);
    output.document(&serde_json::json!({ "between": pair, "experiments": experiments }))
}
