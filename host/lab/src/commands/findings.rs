//! `stickslip-lab findings`: the paper's statements, checked one by one.

use crate::findings::{Finding, findings, pyramids};
use stickslip_report::terminal::{Output, table};

/// Arguments of `stickslip-lab findings`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip-lab findings
  stickslip-lab findings --markdown > findings.md
  stickslip-lab findings --pyramids 0.15")]
pub struct Args {
    /// Print a Markdown table, as in docs/findings.md
    #[arg(long)]
    pub markdown: bool,
    /// Instead: the paper's push with fixed friction pyramids and the exact cone, at this
    /// finger friction
    #[arg(long, value_name = "MU", num_args = 0..=1, default_missing_value = "0.15")]
    pub pyramids: Option<f64>,
}

/// Runs rig and models and prints the table.
///
/// # Errors
/// Where the rig or a model cannot run a trial.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    if let Some(mu) = args.pyramids {
        return show_pyramids(mu, output);
    }
    let spinner = output.spinner("rig and models");
    let all = findings();
    spinner.finish_and_clear();
    let all = all?;
    if args.markdown {
        output.text(markdown(&all));
    } else {
        let mut rows =
            table(["about", "statement", "paper", "rig", "hard model", "soft model", "reproduced"]);
        for f in &all {
            rows.add_row([f.about, f.statement, &f.paper, &f.rig, &f.hard, &f.soft, f.outcome.word()]);
        }
        output.table(&rows);
        for f in all.iter().filter(|f| !f.reason.is_empty()) {
            output.text(format_args!("- {} ({}): {}", f.statement, f.outcome.word(), f.reason));
        }
    }
    output.document(&all)
}

fn show_pyramids(mu: f64, output: &Output) -> anyhow::Result<()> {
    anyhow::ensure!((0.0..=10.0).contains(&mu), "--pyramids {mu}: give a coefficient from 0 to 10");
    let spinner = output.spinner("pyramids");
    let rows = pyramids::table(mu);
    spinner.finish_and_clear();
    let mut shown = table(["friction", "push force N", "sag mm", "pitch deg", "unsolved steps"]);
    for r in &rows {
        shown.add_row([
            pyramids::words(r.friction),
            format!("{:.2}", r.push_n),
            format!("{:.2}", 1e3 * r.sag_m),
            format!("{:.1}", r.pitch_rad.to_degrees()),
            format!("{} of {}", r.unsolved, r.steps),
        ]);
    }
    output.table(&shown);
    output.document(&rows)
}

/// The table with reasons, as Markdown.
fn markdown(all: &[Finding]) -> String {
    let mut out = String::from(
        "| | statement | paper | rig | hard model | soft model | reproduced |\n|---|---|---|---|---|---|---|\n",
    );
    for f in all {
        out.push_str(&format!(
            "| {} | {} | {} | {} | {} | {} | {} |\n",
            f.about,
            f.statement,
            f.paper,
            f.rig,
            f.hard,
            f.soft,
            f.outcome.word()
        ));
    }
    out.push('\n');
    for f in all.iter().filter(|f| !f.reason.is_empty()) {
        out.push_str(&format!("- **{}** ({}). {}\n", f.statement, f.outcome.word(), f.reason));
    }
    out
}
