//! `stickslip suggest`: the experiments that would tell candidate effects apart, and a plan of several.

use std::path::PathBuf;

use comfy_table::{Cell, CellAlignment};

use crate::commands::fitted::file_or_default;
use stickslip_analysis::channels::channel_words;
use stickslip_analysis::compare::verdict::readable;
use stickslip_analysis::diagnose::posterior::Weighed;
use stickslip_analysis::model::candidate::{self, CandidateEffect};
use stickslip_analysis::suggest::{Options, Report, suggest};
use stickslip_report::terminal::{Output, table};

/// Arguments of `stickslip suggest`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip suggest data/demo --between finger_friction_mismatch --between sensor_crosstalk
  stickslip suggest data/demo --runs 6")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model that lacks the effect [default: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// More formulas that may be named, or be among the best two
    #[arg(long, value_name = "FILE.toml")]
    pub formula: Option<PathBuf>,
    /// The two effects to separate [default: all that are credible]
    #[arg(long = "between", value_name = "EFFECT")]
    pub between: Vec<String>,
    /// Plan this many trials that together give the most information
    #[arg(long, value_name = "N")]
    pub runs: Option<usize>,
}

/// Fits the candidates and compares their predictions.
///
/// # Errors
/// Where data or model cannot be read, an effect is not known, or there are no two candidates.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let whole = file_or_default(args.model.as_deref())?;
    let (file, formulas) = whole.proposals(args.formula.as_deref())?;
    let mut between = Vec::new();
    for name in &args.between {
        between.extend(CandidateEffect::of(&candidate::named(name, &formulas)?));
    }
    let own = formulas.iter().filter_map(CandidateEffect::of).collect();
    let options = Options { between, own, runs: args.runs };
    options.check(&file)?;
    let report = suggest(&stickslip_report::data::read(&args.data, output)?, &file, &options, output)?;
    let Report { sets, experiments, plan, trials, left_out, .. } = &report;
    let of = |s: &Weighed| format!("{} ({:.0} %)", s.effects.join(" + "), 100.0 * s.probability);
    output.text(format_args!("Between {}:", sets.iter().map(of).collect::<Vec<_>>().join(", ")));
    output.left_out(left_out, trials + left_out.len(), "all: --json");
    if let Some(best) = experiments.first() {
        output.text(&best.summary);
    }
    let mut t = table(["like trial", "grip N", "channel", "phase", "difference", "sd", "runs", "bits"]);
    for e in experiments {
        let right = |s: String| Cell::new(s).set_alignment(CellAlignment::Right);
        t.add_row(vec![
            Cell::new(&e.like_trial),
            right(e.grip_n.map_or("-".into(), |g| format!("{g:.1}"))),
            Cell::new(channel_words(&e.channel)),
            Cell::new(e.phase),
            right(readable(e.difference, e.unit)),
            right(format!("{:.1}", e.standard_deviations)),
            right(e.runs.to_string()),
            right(format!("{:.2}", e.information_bits)),
        ]);
    }
    output.table(&t);
    if let Some(plan) = plan {
        output.text(format_args!(
            "\nA plan of {} trials. Undecided: {:.2} bits; expected from the plan: at least {:.2} of them.",
            plan.trials.len(),
            plan.open_bits,
            plan.information_bits
        ));
        let mut t = table(["", "like trial", "grip N", "bits up to here"]);
        for (k, p) in plan.trials.iter().enumerate() {
            let right = |s: String| Cell::new(s).set_alignment(CellAlignment::Right);
            t.add_row(vec![
                right((k + 1).to_string()),
                Cell::new(&p.like_trial),
                right(p.grip_n.map_or("-".into(), |g| format!("{g:.1}"))),
                right(format!("{:.2}", p.information_bits)),
            ]);
        }
        output.table(&t);
    }
    let data = args.data.display().to_string();
    let model = args.model.as_ref().map(|m| m.display().to_string());
    let mut next = vec!["diagnose", &data];
    if let Some(model) = &model {
        next.extend(["--model", model]);
    }
    output.text("\nOnce these runs are in the data set:");
    output.next(next);
    output.document(&report)
}
