//! `stickslip-lab formulations`: friction pyramids against the exact cone, step by step.

use std::path::PathBuf;

use anyhow::{Context, ensure};
use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::replay::{Feed, feed};
use stickslip_data::Index;
use stickslip_device::package::Package;
use stickslip_lcp::generate::rng;
use stickslip_report::terminal::{Output, table};
use stickslip_shared::model::Formulation;

use crate::formulations::{Pair, Summary, pair, summarise};
use crate::hunt::run::{Genes, package};
use crate::hunt::search::Candidate;
use crate::precision::walk;

/// Command line of `stickslip-lab formulations`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip-lab formulations
  stickslip-lab formulations data/demo --random 20000 --seed 5

Each step that the board makes with friction pyramids is repeated with the exact cone from the same
state.")]
pub struct Args {
    /// Folders of data sets whose trials are stepped
    #[arg(value_name = "DATA", default_value = "data/demo")]
    pub data: Vec<PathBuf>,
    /// Additional steps of random scenes
    #[arg(long, default_value_t = 10_000, value_name = "STEPS")]
    pub random: usize,
    /// Seed of the random scenes
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Contact model of the trials [default: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
}

/// At least `steps` steps of random scenes; those that are refused give none.
fn random(steps: usize, seed: u64, mut progress: impl FnMut(usize)) -> Vec<Pair> {
    let rng = &mut rng(seed);
    let mut pairs = Vec::new();
    // A scene gives some forty steps; one in ten is refused.
    for _ in 0..steps {
        if pairs.len() >= steps {
            break;
        }
        let mut package = package(&Genes::fresh(rng));
        package.model.1.formulation = Formulation::Lcp;
        if stickslip_shared::predictor::validate(&package.model.0, &package.model.1).is_ok() {
            let before = pairs.len();
            walk(&package, |walked| pairs.push(pair(walked)));
            progress(pairs.len() - before);
        }
    }
    pairs
}

/// # Errors
/// Data or model cannot be read.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let mut model = model_or_default(args.model.as_deref())?;
    model.formulation = Formulation::Lcp;
    let (mut rows, mut recorded) = (Vec::new(), Vec::new());
    let spinner = output.spinner("recorded trials");
    for folder in &args.data {
        let reader = Index::open(folder)?;
        for (ordinal, info) in reader.trials.iter().enumerate() {
            let trial = reader.read_trial(info).with_context(|| info.trial.clone())?;
            let Feed { scene, plan, samples, .. } = feed(&reader.description, &trial)?;
            let package = Package::new(scene, &model, plan, samples, ordinal);
            let mut own = Vec::new();
            walk(&package, |walked| own.push(pair(walked)));
            rows.push(summarise(&info.trial, &own));
            recorded.extend(own);
        }
    }
    spinner.finish_and_clear();
    ensure!(!recorded.is_empty(), "no trial of the data sets can be simulated");
    let bar = output.progress(args.random as u64, "random scenes");
    let varied = random(args.random, args.seed, |more| bar.inc(more as u64));
    bar.finish_and_clear();
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
