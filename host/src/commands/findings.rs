//! `stickslip findings`: the paper's statements, checked one by one.

use crate::findings::{Finding, findings};
use crate::output::{Output, table};

/// Arguments of `stickslip findings`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip findings
  stickslip findings --markdown > findings.md")]
pub struct Args {
    /// Print a Markdown table, as in docs/findings.md
    #[arg(long)]
    pub markdown: bool,
}

/// Runs rig and models and prints the table.
///
/// # Errors
/// Where the rig or a model cannot run a trial.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let spinner = output.spinner("rig and models");
    let all = findings();
    spinner.finish_and_clear();
    let all = all?;
    if args.markdown {
        output.text(markdown(&all));
    } else {
        let mut rows = table(["about", "statement", "paper", "rig", "hard model", "soft model", "comes out"]);
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

/// The table with reasons, as Markdown.
fn markdown(all: &[Finding]) -> String {
    let mut out = String::from(
        "| | statement | paper | rig | hard model | soft model | comes out |\n|---|---|---|---|---|---|---|\n",
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
