//! `stickslip-lab cost`: instructions of the tick and its parts on the emulated board.

use std::path::{Path, PathBuf};

use anyhow::Context;
use serde::Serialize;

use crate::cost::{self, Counts, Part, TICK_INSTRUCTIONS, TickCost};
use crate::held::{Held, NOISE_M};
use crate::hunt::run::Case;
use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::replay::{Feed, feed};
use stickslip_data::Index;
use stickslip_device::package::Package;
use stickslip_device::qemu::built;
use stickslip_lcp::files::Factors;
use stickslip_lcp::generate::{Family, contact_problem, neighbour};
use stickslip_report::terminal::{Output, table};
use stickslip_shared::model::{Formulation, Model};
use stickslip_shared::predictor::validity;

/// Command line of `stickslip-lab cost`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip-lab cost
  stickslip-lab cost data/demo --selftest 0
  stickslip-lab cost --cases data/worst/*.json
  stickslip --json cost --selftest 20000 > cost.json

Needs the program that `make cost` builds, and QEMU. Counts instructions, not cycles; the
counts are the same on every run.")]
pub struct Args {
    /// Folders of data sets whose trials are run
    #[arg(value_name = "DATA", default_value = "data/demo")]
    pub data: Vec<PathBuf>,
    /// Additional ticks of the self-test's varied trials
    #[arg(long, default_value_t = 3000, value_name = "TICKS")]
    pub selftest: u32,
    /// Seed of the self-test
    #[arg(long, default_value_t = 2)]
    pub seed: u32,
    /// Additional contact problems of the pyramid solver
    #[arg(long, default_value_t = 200, value_name = "PROBLEMS")]
    pub problems: u64,
    /// Contact model of the trials [default: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Additional runs found by `stickslip-lab hunt`
    #[arg(long, value_name = "CASE.json", num_args = 1..)]
    pub cases: Vec<PathBuf>,
    /// The program for the board [default: where `make cost` puts it]
    #[arg(long, value_name = "ELF")]
    pub program: Option<PathBuf>,
}

/// Nothing of the self-test.
const NO_SELF_TEST: cost::SelfTest = (Formulation::Cone, 0, 0, 0.0);
/// Samples of an object at rest.
const HELD_SAMPLES: u32 = 200;
/// How far a neighbour is moved, of the sizes of motion in a push.
const CHANGE: f64 = 1e-4;

#[derive(Serialize)]
struct Document<'a> {
    trials: &'a [Part],
    held: &'a [HeldCost],
    cases: &'a [CaseCost],
    selftest: &'a [Part],
    solves: &'a [Part],
    worst_tick: Option<TickCost>,
    /// Ticks in which pyramids were asked for and the cone was solved; of the recorded trials and of the self-test.
    cone_instead: [usize; 2],
    stack_bytes: u32,
    tick_instructions: f64,
}

/// An object at rest on the board.
#[derive(Serialize)]
struct HeldCost {
    points: usize,
    noise_m: f32,
    parts: Vec<Part>,
}

/// A run of the hunt on the board.
#[derive(Serialize)]
struct CaseCost {
    case: String,
    target: String,
    /// Instructions of its dearest tick.
    worst_tick: f64,
    /// Instructions of its dearest step from sample to sample.
    worst_step: f64,
    /// Ticks in which a solve hit its bound.
    marked: usize,
}

/// # Errors
/// Data or model cannot be read, or the board's program or QEMU is missing or fails.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let model = model_or_default(args.model.as_deref())?;
    let mut packages = Vec::new();
    for folder in &args.data {
        let reader = Index::open(folder)?;
        for (ordinal, info) in reader.trials.iter().enumerate() {
            let trial = reader.read_trial(info).with_context(|| info.trial.clone())?;
            packages.push({
                let Feed { scene, plan, samples, .. } = feed(&reader.description, &trial)?;
                Package::new(scene, &model, plan, samples, ordinal)
            });
        }
    }
    let program = args.program.clone().unwrap_or_else(|| built("STICKSLIP_COST", "cost"));
    let recorded = cost::count(&program, &packages, NO_SELF_TEST, &[])?;
    let varied = match args.selftest {
        0 => Counts::default(),
        ticks => cost::count(&program, &[], (model.formulation, args.seed, ticks, 0.1), &[])?,
    };
    let pairs: Vec<[Factors; 2]> = (0..args.problems)
        .map(|seed| {
            let first = contact_problem(Family::Force, cost::PROBLEM.0, seed);
            let second = neighbour(&first, CHANGE, seed);
            [first, second]
        })
        .collect();
    let solved = match pairs.as_slice() {
        [] => Counts::default(),
        pairs => cost::count(&program, &[], NO_SELF_TEST, pairs)?,
    };
    let held = count_held(&program, &model)?;
    let cases = count_cases(&program, &args.cases)?;
    let (trials, selftest) = (cost::summarise(&recorded), cost::summarise(&varied));
    output.text(format_args!("{} recorded trials", packages.len()));
    print(output, &trials);
    if args.selftest > 0 {
        output.text(format_args!("{} ticks of the self-test's trials", args.selftest));
        print(output, &selftest);
    }
    for h in &held {
        output.text(format_args!(
            "an object at rest with {} contact points, measured with noise up to {:.0} um",
            h.points,
            h.noise_m * 1e6
        ));
        print(output, &h.parts);
    }
    let solves = cost::summarise_solves(&solved);
    if !solved.solves.is_empty() {
        let at = |k: usize| solved.solves.iter().filter(|s| s.solved[k]).count();
        output.text(format_args!(
            "{} problems of {} contacts for the pyramid solver, single precision, and their neighbours at \
             {CHANGE:.0e}: solved {} cold, {} unchanged, {} moved",
            solved.solves.len(),
            cost::PROBLEM.0,
            at(0),
            at(1),
            at(2)
        ));
        print(output, &solves);
    }
    if !cases.is_empty() {
        output.text("cases of `stickslip-lab hunt`");
        let mut rows = table(["instructions", "target", "worst tick", "worst step", "ticks at the bound"]);
        for c in &cases {
            rows.add_row(vec![
                c.case.clone(),
                c.target.clone(),
                format!("{:.0}", c.worst_tick),
                format!("{:.0}", c.worst_step),
                c.marked.to_string(),
            ]);
        }
        output.table(&rows);
    }
    let worst =
        recorded.ticks.iter().chain(&varied.ticks).copied().max_by(|a, b| a.tick_all.total_cmp(&b.tick_all));
    if let Some(worst) = worst {
        let share = 100.0 * worst.tick_all / TICK_INSTRUCTIONS;
        output.text(format_args!(
            "worst tick: {:.0} instructions, {share:.0} % of 4 ms at 125 million a second ({} iterations, status {})",
            worst.tick_all, worst.iterations, worst.status
        ));
    }
    let marked = |c: &Counts| c.ticks.iter().filter(|t| t.status != 0).count();
    output.text(format_args!(
        "ticks in which a solve hit its bound: {} of {} recorded, {} of {} of the self-test",
        marked(&recorded),
        recorded.ticks.len(),
        marked(&varied),
        varied.ticks.len()
    ));
    let instead = |c: &Counts| c.ticks.iter().filter(|t| t.validity & validity::CONE_INSTEAD != 0).count();
    let cone_instead = [instead(&recorded), instead(&varied)];
    if model.formulation == Formulation::Lcp {
        output.text(format_args!(
            "ticks in which the cone was solved in place of pyramids: {} recorded, {} of the self-test",
            cone_instead[0], cone_instead[1]
        ));
    }
    output.text(format_args!("stack below the tick's caller: {} bytes", recorded.stack_bytes));
    output.document(&Document {
        trials: &trials,
        held: &held,
        cases: &cases,
        selftest: &selftest,
        solves: &solves,
        worst_tick: worst,
        cone_instead,
        stack_bytes: recorded.stack_bytes,
        tick_instructions: TICK_INSTRUCTIONS,
    })
}

/// Objects at rest: nothing changes, then only what noise changes.
fn count_held(program: &Path, model: &Model<f64>) -> anyhow::Result<Vec<HeldCost>> {
    let mut list = Vec::new();
    for (held, noise_m) in [Held::Prism, Held::Octagon, Held::Plate, Held::Bar]
        .into_iter()
        .flat_map(|held| [(held, 0.0), (held, NOISE_M)])
    {
        let package = held.package(model, HELD_SAMPLES, noise_m);
        let counts = cost::count(program, &[package], NO_SELF_TEST, &[])?;
        let parts = cost::summarise(&counts).into_iter().take(cost::STEP_PARTS).collect();
        list.push(HeldCost { points: held.points(), noise_m, parts });
    }
    Ok(list)
}

fn count_cases(program: &Path, files: &[PathBuf]) -> anyhow::Result<Vec<CaseCost>> {
    let mut list = Vec::new();
    for path in files {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).with_context(|| name.clone())?;
        let case: Case = serde_json::from_slice(&bytes).with_context(|| name.clone())?;
        let counts =
            cost::count(program, &[case.package()], NO_SELF_TEST, &[]).with_context(|| name.clone())?;
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        list.push(CaseCost {
            case: path.file_stem().map_or(name, |s| s.to_string_lossy().into_owned()),
            target: case.target,
            worst_tick: largest(&mut counts.ticks.iter().map(|t| t.tick_all)),
            worst_step: largest(&mut counts.steps.iter().filter(|s| s.place == 1).map(|s| s.step)),
            marked: counts.ticks.iter().filter(|t| t.status != 0).count(),
        });
    }
    Ok(list)
}

fn print(output: &Output, parts: &[Part]) {
    let mut rows = table(["instructions", "number", "median", "99 %", "worst"]);
    for p in parts.iter().filter(|p| p.number > 0) {
        let cell = |x: f64| format!("{x:.0}");
        rows.add_row(vec![
            p.part.to_owned(),
            p.number.to_string(),
            cell(p.median),
            cell(p.p99),
            cell(p.worst),
        ]);
    }
    output.table(&rows);
}
