//! `stickslip lcp`: solves complementarity problems made elsewhere, or generated, and judges
//! every answer by its residual, computed apart from the solver.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use schemars::JsonSchema;
use serde::Serialize;

use stickslip_data::{Stage, write_file};
use stickslip_lcp::files::{self, DenseSet, FactorSet, Factors, ProblemFile};
use stickslip_lcp::generate::{FAMILIES, IMPOSSIBLE, contact_problem, neighbour};
use stickslip_lcp::solve::{Judged, Solver, Solvers, Summary, solve_file, summarise};
use stickslip_report::terminal::{Output, table};

/// Arguments of `stickslip lcp`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    stickslip lcp b_force_60.lcp --solver dense --out b_force_60.res\n  \
    stickslip lcp *.fac --solver contact\n  \
    stickslip lcp --generate 50000 --seed 1 --solver contact")]
pub struct Args {
    /// Problem files: .lcp (matrices) or .fac (factors of contact problems)
    #[arg(required_unless_present = "generate")]
    files: Vec<PathBuf>,
    /// Which solver: dense, contact (every problem cold), warm (from the answer before)
    #[arg(long, value_enum, default_value = "dense")]
    solver: Solver,
    /// Write the answers of the one FILE here, in the .res format
    #[arg(long)]
    out: Option<PathBuf>,
    /// Solve this many generated contact problems of all families instead of files
    #[arg(long, conflicts_with_all = ["files", "out"])]
    generate: Option<u64>,
    /// First seed of the generated problems
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Write the generated problems to this directory instead of solving them
    #[arg(long, requires = "generate", requires = "contacts")]
    save: Option<PathBuf>,
    /// Contacts of the generated problems; 2, 6, 9 and 10 in turns where not given
    #[arg(long)]
    contacts: Option<usize>,
}

#[derive(JsonSchema, Serialize)]
/// Solved sets of problems.
pub(super) struct Document {
    /// Which solver: dense, contact, warm.
    solver: String,
    /// By file or family.
    sets: Vec<Summary>,
    /// All of them.
    total: Summary,
}

/// Runs the command.
///
/// # Errors
/// A file cannot be read, is malformed (byte offset and reason) or does not fit the solver, or
/// the answers cannot be written.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    if let (Some(number), Some(directory), Some(contacts)) = (args.generate, &args.save, args.contacts) {
        return save(number, directory, contacts, args.seed, output);
    }
    // The working memory of the largest problems is built on the stack before it is boxed.
    let solved = std::thread::scope(|scope| {
        std::thread::Builder::new()
            .stack_size(256 << 20)
            .spawn_scoped(scope, || match (args.generate, &args.save) {
                (Some(number), None) => generated(args, number),
                _ => from_files(args),
            })
            .map(std::thread::ScopedJoinHandle::join)
    });
    let (sets, total) = match solved.context("a thread to solve in")? {
        Ok(result) => result?,
        Err(_) => bail!("the solver stopped; please report the problem file"),
    };
    let mut rows = table([
        "problems",
        "n",
        "number",
        "solved",
        "false",
        "no solution",
        "worst residual",
        "median us",
        "p99 us",
        "most pivots",
    ]);
    for summary in sets.iter().chain(std::iter::once(&total)) {
        rows.add_row(vec![
            summary.name.clone(),
            summary.n.to_string(),
            summary.problems.to_string(),
            summary.solved.to_string(),
            summary.false_claims.to_string(),
            summary.rays.to_string(),
            format!("{:.1e}", summary.worst_residual),
            format!("{:.2}", summary.median_us),
            format!("{:.2}", summary.p99_us),
            summary.most_pivots.to_string(),
        ]);
    }
    output.table(&rows);
    output.text(format!(
        "solved {}/{}  false {}  median {:.2} us  p99 {:.2} us",
        total.solved,
        total.problems - total.impossible,
        total.false_claims,
        total.median_us,
        total.p99_us
    ));
    if total.impossible > 0 {
        let rays: usize = sets.iter().filter(|s| s.impossible > 0).map(|s| s.rays).sum();
        output.text(format!(
            "without a solution {}: {rays} reported as such, the rest as not solved",
            total.impossible
        ));
    }
    output.document(&Document { solver: format!("{:?}", args.solver).to_lowercase(), sets, total })
}

type Sets = anyhow::Result<(Vec<Summary>, Summary)>;

fn from_files(args: &Args) -> Sets {
    if args.out.is_some() && args.files.len() != 1 {
        bail!("--out takes the answers of one file, {} were given", args.files.len());
    }
    let mut sets = Vec::new();
    let mut all: Vec<Judged> = Vec::new();
    let mut largest = 0;
    for path in &args.files {
        let file = files::read(path)?;
        let n = match &file {
            ProblemFile::Dense(set) => set.n,
            ProblemFile::Factors(set) => 6 * set.contacts,
        };
        let judged = solve_file(&file, args.solver).with_context(|| path.display().to_string())?;
        if let Some(out) = &args.out {
            let answers: Vec<_> = judged.iter().map(|j| j.answer.clone()).collect();
            write_file(out, files::encode_answers(n, &answers)).with_context(|| out.display().to_string())?;
        }
        let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        sets.push(summarise(&name, n, &judged));
        all.extend(judged);
        largest = largest.max(n);
    }
    let total = summarise("all", largest, &all);
    Ok((sets, total))
}

fn generated(args: &Args, number: u64) -> Sets {
    let mut solvers = Solvers::default();
    let mut sets = Vec::new();
    let mut all = Vec::new();
    let families = (FAMILIES.len() + IMPOSSIBLE.len()) as u64;
    for (k, family) in FAMILIES.into_iter().chain(IMPOSSIBLE).enumerate() {
        let mut judged = Vec::new();
        let share = number / families + u64::from((k as u64) < number % families);
        for i in 0..share {
            let contacts = args.contacts.unwrap_or([2, 6, 9, 10][(i % 4) as usize]);
            let seed = args.seed.wrapping_add(i);
            let problem = contact_problem(family, contacts, seed);
            if args.solver == Solver::Warm {
                // Solved first; what is judged is the step after it.
                solvers.judge_factors(&problem, Solver::Contact, 1)?;
                let next = neighbour(&problem, 1e-3, seed);
                judged.push(solvers.judge_factors(&next, args.solver, 3)?);
            } else {
                judged.push(solvers.judge_factors(&problem, args.solver, 1)?);
            }
        }
        // Times and residuals are kept, unknowns are not: a million problems fit in memory.
        for j in &mut judged {
            j.answer.z = Vec::new();
        }
        let n = 6 * args.contacts.unwrap_or(10);
        let mut set = summarise(&format!("{family:?}").to_lowercase(), n, &judged);
        if IMPOSSIBLE.contains(&family) {
            // Whatever the residual is, a claim is false.
            set.impossible = set.problems;
            set.false_claims += set.solved;
            set.false_above_1e4 += set.solved;
            set.solved = 0;
        }
        sets.push(set);
        all.extend(judged);
    }
    let mut total = summarise("all", 6 * args.contacts.unwrap_or(10), &all);
    let sum = |of: fn(&Summary) -> usize| sets.iter().map(of).sum::<usize>();
    total.impossible = sum(|s| s.impossible);
    total.solved = sum(|s| s.solved);
    total.false_claims = sum(|s| s.false_claims);
    total.false_above_1e4 = sum(|s| s.false_above_1e4);
    Ok((sets, total))
}

/// Writes `number` problems of each family, and as many steps of a push, as .fac and .lcp files.
fn save(number: u64, directory: &Path, contacts: usize, seed: u64, output: &Output) -> anyhow::Result<()> {
    let stage = Stage::within(directory)?;
    let mut lists: Vec<(String, Vec<Factors>)> = FAMILIES
        .into_iter()
        .map(|family| {
            let list = (0..number).map(|k| contact_problem(family, contacts, seed.wrapping_add(k)));
            (format!("{family:?}").to_lowercase(), list.collect())
        })
        .collect();
    // Steps of a push: each problem is a little different from the one before.
    let mut step = contact_problem(FAMILIES[0], contacts, seed);
    let mut steps = Vec::new();
    for k in 0..number {
        steps.push(step.clone());
        step = neighbour(&step, 1e-3, seed.wrapping_add(k));
    }
    lists.push(("sequence".to_owned(), steps));
    for (name, list) in lists {
        // A family may draw finger bodies or not: one file holds one number of freedoms.
        for freedoms in [6, 8] {
            let problems: Vec<Factors> =
                list.iter().filter(|p| p.inverse_mass.len() == freedoms).cloned().collect();
            if problems.is_empty() {
                continue;
            }
            let n = 6 * contacts;
            let dense = DenseSet {
                n,
                contacts,
                symmetric: false,
                problems: problems.iter().map(Factors::dense).collect(),
            };
            let factors = FactorSet { contacts, freedoms, problems };
            let stem = format!("{name}{freedoms}_{n}");
            for (extension, bytes) in
                [("lcp", files::encode_dense(&dense)), ("fac", files::encode_factors(&factors))]
            {
                let path = stage.folder().join(format!("{stem}.{extension}"));
                std::fs::write(&path, bytes).with_context(|| path.display().to_string())?;
            }
            output.text(format!("{stem}: {} problems", factors.problems.len()));
        }
    }
    Ok(stage.finish()?)
}
