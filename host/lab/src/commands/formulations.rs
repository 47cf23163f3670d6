//! `stickslip-lab formulations`: friction pyramids against the exact cone, step by step.

use stickslip_report::terminal::{Output, table};
use stickslip_shared::model::Formulation;

use super::steps::{self, Gathered};
use crate::formulations::{Pair, Summary, pair, summarise};

/// Command line of `stickslip-lab formulations`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip-lab formulations
  stickslip-lab formulations data/demo --random 20000 --seed 5

Each step that the board makes with friction pyramids is repeated with the exact cone from the same
state.")]
pub struct Args {
    /// Data, model and scenes
    #[command(flatten)]
    pub steps: steps::Args,
}

/// # Errors
/// Data or model cannot be read.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let Gathered { trials, random: varied } =
        steps::gather(&args.steps, Some(Formulation::Lcp), pair, output)?;
    let mut rows: Vec<Summary> = trials.iter().map(|(trial, own)| summarise(trial, own)).collect();
    let recorded: Vec<Pair> = trials.into_iter().flat_map(|(_, own)| own).collect();
    let all = [summarise("all recorded trials", &recorded), summarise("random scenes", &varied)];
    for s in rows.iter().chain(&all).filter(|s| s.number > 0) {
        output.text(format_args!(
            "{}: {} steps, cone in place of pyramids in {:.2} %; of {} compared, all points stick or slide alike in \
             {:.2} %, of the points {:.2} %",
            s.steps,
            s.number,
            100.0 * s.cone_instead_share,
            s.compared,
            100.0 * s.same_share,
            100.0 * s.same_points_share
        ));
    }
    for s in &all {
        print(s, output);
    }
    rows.extend(all);
    output.document(&rows)
}

fn print(s: &Summary, output: &Output) {
    output.text(&s.steps);
    let mut shown = table(["pyramids against the cone", "median", "99 %", "worst"]);
    for (name, x) in [
        ("force of a body, N", s.force_n),
        ("the same over the largest", s.relative),
        ("velocity, m/s", s.velocity_m_s),
        ("factorisations, pyramids", s.factorisations),
        ("evaluations and kinks, pyramids", s.evaluations),
        ("Newton steps, cone", s.cone_iterations),
        ("evaluations, cone", s.cone_evaluations),
    ] {
        let cell = |x: f64| if x.abs() < 1.0 { format!("{x:.1e}") } else { format!("{x:.1}") };
        shown.add_row(vec![name.to_owned(), cell(x.median), cell(x.p99), cell(x.worst)]);
    }
    output.table(&shown);
}
