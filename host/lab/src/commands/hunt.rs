//! `stickslip-lab hunt`: searches for the dearest and the least accurate problems.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use serde::Serialize;

use crate::hunt::problem::{honest, verdict};
use crate::hunt::run::{self, Case, Genes};
use crate::hunt::search::{Found, search};
use crate::hunt::{TARGETS, Target, problem};
use stickslip_device::package::Package;
use stickslip_lcp::files::{FactorSet, Factors, encode_factors};
use stickslip_report::terminal::{Output, table};

/// Stack of a thread that solves: the dense solver's memory is built on it.
const STACK_BYTES: usize = 64 << 20;

/// Command line of `stickslip-lab hunt`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip-lab hunt
  stickslip-lab hunt --target tick-work --budget 20000 --seed 7 --out worst/
  stickslip-lab cost --cases worst/*.json

Results depend on the seed alone. Contact problems are written as .fac files (`stickslip lcp`
reads them), runs of the predictor as .json (`stickslip-lab cost --cases` counts their instructions
on the emulated board). The cases in data/worst are repeated by a test.")]
pub struct Args {
    /// Quantity to maximise [default: all]
    #[arg(long, value_enum)]
    pub target: Vec<Target>,
    /// Number of candidates for each target
    #[arg(long, default_value_t = 4000)]
    pub budget: usize,
    /// Seed of the search
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for the worst cases found
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Number of cases to write for each target
    #[arg(long, default_value_t = 3)]
    pub keep: usize,
}

/// What a hunt found.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Target.
    pub target: Target,
    /// Candidates scored.
    pub scored: usize,
    /// Rounds of the search.
    pub rounds: usize,
    /// Largest value among candidates drawn at random.
    pub random: f64,
    /// Largest value found.
    pub worst: f64,
    /// How the solvers answer it.
    pub answer: String,
    /// No solution is claimed that is none.
    pub claims_hold: bool,
    /// Files written.
    pub files: Vec<PathBuf>,
}

/// # Errors
/// The folder cannot be written, or a claimed solution is none.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    ensure!(args.budget > 0, "--budget 0 searches nothing; give at least 1");
    let targets = if args.target.is_empty() { TARGETS.to_vec() } else { args.target.clone() };
    if let Some(folder) = &args.out {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let pool = rayon::ThreadPoolBuilder::new().stack_size(STACK_BYTES).build()?;
    let bar = output.progress((targets.len() * args.budget) as u64, "searching");
    let mut rows = Vec::new();
    for target in targets {
        let told = |more: usize| bar.inc(more as u64);
        let row = if target.is_run() {
            let found = pool.install(|| search(args.seed, args.budget, |g| run::score(target, g), told));
            runs(target, &found, args)?
        } else {
            let found = pool.install(|| search(args.seed, args.budget, |p| problem::score(target, p), told));
            pool.install(|| problems(target, &found, args))?
        };
        rows.push(row);
    }
    bar.finish_and_clear();
    let mut shown = table(["target", "candidates", "rounds", "worst at random", "worst found", "answer"]);
    for r in &rows {
        shown.add_row(vec![
            r.target.name(),
            r.scored.to_string(),
            r.rounds.to_string(),
            format!("{:.3e}", r.random),
            format!("{:.3e}", r.worst),
            r.answer.clone(),
        ]);
    }
    output.table(&shown);
    for file in rows.iter().flat_map(|r| &r.files) {
        output.text(format_args!("written: {}", file.display()));
    }
    output.document(&rows)?;
    if let Some(r) = rows.iter().find(|r| !r.claims_hold) {
        bail!("{}: a solution is claimed whose residual is above the tolerance", r.target.name());
    }
    Ok(())
}

fn row<C>(target: Target, found: &Found<C>, answer: String, files: Vec<PathBuf>) -> Row {
    Row {
        target,
        scored: found.scored,
        rounds: found.worst.len(),
        random: found.random_best,
        worst: found.worst.first().map_or(0.0, |w| w.0),
        answer,
        claims_hold: true,
        files,
    }
}

fn problems(target: Target, found: &Found<Factors>, args: &Args) -> anyhow::Result<Row> {
    let mut answer = String::from("none");
    if let Some((_, worst)) = found.worst.first()
        && let Some(v) = verdict(worst)
    {
        answer = format!("(b) {:?}, (a) {:?}", v.contact.report.status, v.dense.report.status);
    }
    let claims_hold =
        found.worst.iter().filter_map(|(_, p)| verdict(p)).all(|v| honest(&v.contact) && honest(&v.dense));
    let mut files = Vec::new();
    if let (Some(folder), Some((_, first))) = (&args.out, found.worst.first()) {
        let list: Vec<Factors> = found.worst.iter().take(args.keep).map(|(_, p)| p.clone()).collect();
        let (contacts, freedoms) = (first.friction.len(), first.inverse_mass.len());
        let set = FactorSet { contacts, freedoms, problems: list };
        files.push(write(folder, &format!("{}.fac", target.name()), &encode_factors(&set))?);
    }
    Ok(Row { claims_hold, ..row(target, found, answer, files) })
}

fn runs(target: Target, found: &Found<Genes>, args: &Args) -> anyhow::Result<Row> {
    let mut files = Vec::new();
    let mut answer = String::from("none");
    for (k, (value, genes)) in found.worst.iter().take(args.keep.max(1)).enumerate() {
        let (value, package) = shortest(target, *value, run::package(genes));
        if k == 0 {
            answer = format!("{} samples, {}", package.samples.len(), contents(&package));
        }
        if let Some(folder) = &args.out
            && k < args.keep
        {
            let case = serde_json::to_vec(&Case::new(target, value, package))?;
            files.push(write(folder, &format!("{}-{}.json", target.name(), k + 1), &case)?);
        }
    }
    Ok(row(target, found, answer, files))
}

/// The run up to the tick that is worst.
fn shortest(target: Target, value: f64, mut package: Package) -> (f64, Package) {
    let all = package.samples.clone();
    let enough = |count: usize| {
        let part = Package { samples: all[..count].to_vec(), ..package.clone() };
        run::worst(target, &part).is_some_and(|w| w >= value)
    };
    let count = (2..all.len()).find(|count| enough(*count)).unwrap_or(all.len());
    package.samples.truncate(count);
    (value, package)
}

fn contents(package: &Package) -> String {
    let (scene, model, _) = &package.model;
    let parts = [
        ("fingers", scene.fingers.is_some()),
        ("pusher", scene.pusher.is_some()),
        ("support", scene.support.is_some()),
    ];
    let named: Vec<&str> = parts.into_iter().filter(|p| p.1).map(|p| p.0).collect();
    format!("{}, {} effects", named.join(" + "), model.effects.len())
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> anyhow::Result<PathBuf> {
    let path = folder.join(name);
    std::fs::write(&path, bytes).with_context(|| path.display().to_string())?;
    Ok(path)
}
