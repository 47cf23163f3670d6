//! `stickslip diagnose DATA`: which physical effect a model lacks.

use std::path::PathBuf;

use anyhow::Context;
use comfy_table::{Cell, CellAlignment};

use stickslip_analysis::diagnose::report::{Report, Verdict};
use stickslip_analysis::diagnose::{diagnose, steps};
use stickslip_analysis::model::file::{ModelFile, default_model};
use stickslip_data::{Dataset, Index};
use stickslip_report::terminal::{Output, table};
use stickslip_report::words::short;

/// Arguments of `stickslip diagnose`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip diagnose data/demo
  stickslip diagnose data/demo --model model.toml --html diagnosis.html")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model to diagnose; its friction is refitted, its formulas are tried as candidates
    /// [default: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Write a page with tables and plots; it needs no network
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// Diagnoses and reports.
///
/// # Errors
/// Where data or model cannot be read, no trial can be simulated, or the page not written.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let dataset = read_data(&args.data, output)?;
    let (model, own) = match &args.model {
        Some(path) => ModelFile::read(path)?.without_formulas(),
        None => (default_model(), Vec::new()),
    };
    let bar = output.progress(steps(), "diagnosing");
    let report = diagnose(&dataset, &model, &own, &|| bar.inc(1))?;
    bar.finish_and_clear();
    if let Some(path) = &args.html {
        std::fs::write(path, stickslip_report::diagnose::html(&report, &dataset.description.name))
            .with_context(|| format!("{}: cannot be written", path.display()))?;
    }
    print(&report, output);
    output.document(&report)
}

/// All trials of a data set that can be read; the others are noted.
///
/// # Errors
/// Where the data set cannot be opened.
pub fn read_data(folder: &std::path::Path, output: &Output) -> anyhow::Result<Dataset> {
    let index = Index::open(folder)?;
    for error in &index.errors {
        output.note(error);
    }
    let mut trials = Vec::with_capacity(index.trials.len());
    for info in &index.trials {
        let reading = index.read_trial_lenient(info);
        match (reading.trial, reading.error) {
            (Some(trial), _) => trials.push(trial),
            (None, Some(error)) => output.note(error),
            (None, None) => output.note(format!("trial {}: cannot be read", info.trial)),
        }
    }
    Ok(Dataset { folder: folder.to_path_buf(), description: index.description.clone(), trials })
}

fn print(report: &Report, output: &Output) {
    output.text(&report.summary);
    output.text(format!(
        "\n{} trials of {} conditions; error {:.2} run spreads before, {:.2} after (a perfect model: {:.2}); {:.1} s",
        report.trials,
        report.conditions,
        report.error.before,
        report.error.after,
        report.error.perfect_model,
        report.seconds
    ));
    if !report.candidates.is_empty() && report.verdict != Verdict::NothingMissing {
        let mut t = table(["effect", "explains", "held-out error", "p", "parameters"]);
        for c in &report.candidates {
            let parameters: Vec<String> = c
                .parameters
                .iter()
                .map(|(n, v)| format!("{n} = {} ({} to {})", short(v.value), short(v.low), short(v.high)))
                .collect();
            let right = |s: String| Cell::new(s).set_alignment(CellAlignment::Right);
            t.add_row(vec![
                Cell::new(c.id),
                right(format!("{:.0} %", 100.0 * c.explained)),
                right(format!("{:.2}", c.held_out_error)),
                right(format!("{:.1e}", c.p_value)),
                Cell::new(parameters.join("\n")),
            ]);
        }
        output.text("\nEffects tried (error in run spreads):");
        output.table(&t);
    }
    if !report.places.is_empty() {
        let mut t = table(["where", "phase", "before", "after"]);
        for p in report.places.iter().take(6) {
            let right = |x: f64| Cell::new(format!("{x:.1}")).set_alignment(CellAlignment::Right);
            t.add_row(vec![Cell::new(&p.channel), Cell::new(p.phase), right(p.before), right(p.after)]);
        }
        output.text("\nSystematic misfit (run spreads):");
        output.table(&t);
    }
    for u in &report.unexplained {
        let on: Vec<String> = u.depends_on.iter().map(|(q, s)| format!("{q} ({:.0} %)", 100.0 * s)).collect();
        let on = if on.is_empty() { "no named quantity".into() } else { on.join(", ") };
        output
            .text(format!("left: {} in {}, {:.1} run spreads, depends on {on}", u.channel, u.phase, u.size));
    }
    for limit in &report.limits {
        output.text(format!("limit: {limit}"));
    }
    if let Some(e) = &report.suggested_experiment {
        output.text(format!("next experiment: {}", e.summary));
    }
}
