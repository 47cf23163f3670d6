//! `stickslip-lab cost`: instructions of the tick and its parts on the emulated board.

use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use serde::Serialize;

use crate::cost::{self, BoardAnswer, Counts, Part, TICK_INSTRUCTIONS, TickCost};
use crate::held::{Held, NOISE_M};
use crate::hunt::run::Case;
use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::replay::{Feed, feed};
use stickslip_data::Index;
use stickslip_device::package::Package;
use stickslip_device::qemu::built;
use stickslip_lcp::files::{Factors, ProblemFile, read};
use stickslip_lcp::generate::{Family, contact_problem, neighbour};
use stickslip_lcp::solve::percentile;
use stickslip_report::terminal::{Output, table};
use stickslip_shared::lcp::{residual, tolerance};
use stickslip_shared::model::{Formulation, Model};
use stickslip_shared::predictor::validity;

/// Command line of `stickslip-lab cost`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip-lab cost
  stickslip-lab cost data/demo --selftest 0
  stickslip-lab cost --cases data/worst/*.json
  stickslip-lab cost --lcp ../shared/data/lcp/*.fac
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
    /// Only solve these problem files (.fac by the contact solver, .lcp by Lemke's method) on the board, in single
    /// precision, and judge each answer; exit code 1 where one is claimed falsely
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub lcp: Vec<PathBuf>,
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
    if !args.lcp.is_empty() {
        return solve_files(args, output);
    }
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
    let program = program(args);
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

fn program(args: &Args) -> PathBuf {
    args.program.clone().unwrap_or_else(|| built("STICKSLIP_COST", "cost"))
}

/// Problems of a file on the board.
#[derive(Serialize)]
struct Solved {
    file: String,
    problems: usize,
    /// Claimed, and a solution of what the board was given to 2e-5.
    solved: usize,
    /// Claimed, and none.
    falsely: usize,
    /// Not claimed; of them said to have no solution.
    marked: [usize; 2],
    /// Largest residual of a claim: of the problem rounded to single precision, as the board had it, and as it was.
    worst_residual: [f64; 2],
    /// Instructions: median and most.
    instructions: [f64; 2],
}

fn solve_files(args: &Args, output: &Output) -> anyhow::Result<()> {
    let program = program(args);
    let mut all = Vec::new();
    for path in &args.lcp {
        // As they are, and as the board has them.
        let (exact, given): (Vec<_>, Vec<_>);
        let answers = match read(path)? {
            ProblemFile::Factors(set) => {
                exact = set.problems.iter().map(Factors::dense).collect();
                given = set.problems.iter().map(|problem| rounded_factors(problem).dense()).collect();
                cost::answers(&program, &set.problems, &[])
            }
            ProblemFile::Dense(set) => {
                exact = set.problems;
                given = exact.iter().map(|(m, q)| (rounded(m), rounded(q))).collect();
                cost::answers(&program, &[], &exact)
            }
        };
        let answers = answers.with_context(|| path.display().to_string())?;
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        all.push(judge(file, [&exact, &given], &answers));
    }
    let sum = |of: &dyn Fn(&Solved) -> usize| all.iter().map(of).sum::<usize>();
    let mut rows = table([
        "problems",
        "number",
        "solved",
        "falsely",
        "marked",
        "'none'",
        "residual",
        "unrounded",
        "instructions",
        "most",
    ]);
    for s in &all {
        rows.add_row(vec![
            s.file.clone(),
            s.problems.to_string(),
            s.solved.to_string(),
            s.falsely.to_string(),
            s.marked[0].to_string(),
            s.marked[1].to_string(),
            format!("{:.1e}", s.worst_residual[0]),
            format!("{:.1e}", s.worst_residual[1]),
            format!("{:.0}", s.instructions[0]),
            format!("{:.0}", s.instructions[1]),
        ]);
    }
    output.table(&rows);
    let falsely = sum(&|s| s.falsely);
    output.text(format_args!(
        "on the board: {} of {} solved to {:.0e}, {} marked, {falsely} claimed falsely",
        sum(&|s| s.solved),
        sum(&|s| s.problems),
        tolerance::<f32>(),
        sum(&|s| s.marked[0]),
    ));
    output.document(&all)?;
    ensure!(falsely == 0, "{falsely} answers were claimed and are none");
    Ok(())
}

fn rounded(numbers: &[f64]) -> Vec<f64> {
    numbers.iter().map(|x| f64::from(*x as f32)).collect()
}

fn rounded_factors(problem: &Factors) -> Factors {
    Factors {
        jacobian: rounded(&problem.jacobian),
        inverse_mass: rounded(&problem.inverse_mass),
        compliance: rounded(&problem.compliance),
        friction: rounded(&problem.friction),
        constant: rounded(&problem.constant),
    }
}

fn judge(file: String, [exact, given]: [&[(Vec<f64>, Vec<f64>)]; 2], answers: &[BoardAnswer]) -> Solved {
    let (mut solved, mut falsely, mut worst_residual) = (0, 0, [0.0_f64; 2]);
    for ((exact, given), answer) in exact.iter().zip(given).zip(answers).filter(|(_, answer)| answer.claimed)
    {
        let z: Vec<f64> = answer.z.iter().map(|x| f64::from(*x)).collect();
        let residual = |(m, q): &(Vec<f64>, Vec<f64>)| {
            if z.len() == q.len() { residual::dense(m, q, &z).value() } else { f64::INFINITY }
        };
        let [of_given, of_exact] = [given, exact].map(residual);
        // Written so that a residual that is not a number counts as false.
        if of_given <= f64::from(tolerance::<f32>()) {
            solved += 1
        } else {
            falsely += 1
        }
        worst_residual = [worst_residual[0].max(of_given), worst_residual[1].max(of_exact)];
    }
    let mut instructions: Vec<f64> = answers.iter().map(|a| a.instructions).collect();
    instructions.sort_by(f64::total_cmp);
    let none = answers.iter().filter(|a| a.none).count();
    Solved {
        file,
        problems: answers.len(),
        solved,
        falsely,
        marked: [answers.iter().filter(|a| !a.claimed).count(), none],
        worst_residual,
        instructions: [percentile(&instructions, 50), percentile(&instructions, 100)],
    }
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
