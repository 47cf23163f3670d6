//! `stickslip-lab precision`: single against double precision of the time step.

use serde::Serialize;
use stickslip_report::terminal::{Output, table};

use super::steps::{self, Gathered};
use crate::precision::{StepPair, compare};
use crate::steps::Spread;

/// Command line of `stickslip-lab precision`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip-lab precision
  stickslip-lab precision data/demo --random 20000 --seed 5
  stickslip-lab --json precision > precision.json

Each step that the board makes in single precision is repeated in double precision from the same
initial values.")]
pub struct Args {
    /// Data, model and scenes
    #[command(flatten)]
    pub steps: steps::Args,
}

/// Targets: contact forces to a millinewton, velocities to a micrometre a second.
pub const FORCE_N: f64 = 1e-3;
/// See [`FORCE_N`].
pub const VELOCITY_M_S: f64 = 1e-6;

/// Steps of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Which.
    pub steps: String,
    /// Compared: solved in both precisions.
    pub number: usize,
    /// Not solved in one of them: marked, and not compared.
    pub unsolved: usize,
    /// Steps with several solutions, of which the two precisions found different ones.
    pub several: usize,
    /// Force components at contact points, N.
    pub force_n: Spread,
    /// Relative to the largest force at a contact point (at least 1 N).
    pub relative: Spread,
    /// Forces of bodies, N.
    pub body_force_n: Spread,
    /// Object, m/s.
    pub velocity_m_s: Spread,
    /// Object, rad/s.
    pub turning_rad_s: Spread,
    /// Share of steps whose forces at contact points are within a millinewton.
    pub forces_within: f64,
    /// Share of steps whose velocity is within a micrometre a second.
    pub velocities_within: f64,
}

/// Summary of compared steps.
#[must_use]
pub fn summarise(steps: &str, pairs: &[StepPair]) -> Summary {
    let solved: Vec<StepPair> = pairs.iter().copied().filter(|p| p.solved).collect();
    let share = |good: &dyn Fn(&StepPair) -> bool| {
        solved.iter().filter(|p| good(p)).count() as f64 / solved.len().max(1) as f64
    };
    Summary {
        steps: steps.to_owned(),
        number: solved.len(),
        unsolved: pairs.len() - solved.len(),
        several: solved.iter().filter(|p| p.several).count(),
        force_n: Spread::of(solved.iter().map(|p| p.force_n)),
        relative: Spread::of(solved.iter().map(|p| p.force_n / p.load_n.max(1.0))),
        body_force_n: Spread::of(solved.iter().map(|p| p.body_force_n)),
        velocity_m_s: Spread::of(solved.iter().map(|p| p.velocity_m_s)),
        turning_rad_s: Spread::of(solved.iter().map(|p| p.turning_rad_s)),
        forces_within: share(&|p| p.force_n <= FORCE_N),
        velocities_within: share(&|p| p.velocity_m_s <= VELOCITY_M_S),
    }
}

/// # Errors
/// Data or model cannot be read.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let Gathered { trials, random: varied } = steps::gather(&args.steps, None, compare, output)?;
    let mut rows: Vec<Summary> = trials.iter().map(|(trial, own)| summarise(trial, own)).collect();
    let recorded: Vec<StepPair> = trials.into_iter().flat_map(|(_, own)| own).collect();
    let all = [summarise("all recorded trials", &recorded), summarise("random scenes", &varied)];
    for s in rows.iter().chain(&all).filter(|s| s.number > 0) {
        output.text(format_args!(
            "{}: {} steps compared, {} unsolved in one precision, {} with another solution in each; forces within 1 mN in {:.1} %, velocities within 1 um/s in {:.1} %",
            s.steps, s.number, s.unsolved, s.several, 100.0 * s.forces_within, 100.0 * s.velocities_within
        ));
    }
    for s in all.iter().filter(|s| s.number > 0) {
        output.text(&s.steps);
        let mut shown = table(["f32 against f64", "median", "99 %", "worst"]);
        for (name, x) in [
            ("force at a contact point, N", s.force_n),
            ("the same over the largest", s.relative),
            ("force of a body, N", s.body_force_n),
            ("velocity, m/s", s.velocity_m_s),
            ("angular velocity, rad/s", s.turning_rad_s),
        ] {
            let cell = |x: f64| format!("{x:.1e}");
            shown.add_row(vec![name.to_owned(), cell(x.median), cell(x.p99), cell(x.worst)]);
        }
        output.table(&shown);
    }
    rows.extend(all);
    output.document(&rows)
}
