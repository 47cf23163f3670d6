//! What the studies of single steps have in common: recorded trials and random scenes, walked through.

use std::path::PathBuf;

use anyhow::{Context, ensure};
use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::replay::{Feed, feed};
use stickslip_data::Index;
use stickslip_device::package::Package;
use stickslip_lcp::generate::rng;
use stickslip_report::terminal::Output;
use stickslip_shared::model::Formulation;

use crate::hunt::run::{Genes, package};
use crate::hunt::search::Candidate;
use crate::steps::{Walked, walk};

/// Whose steps.
#[derive(Debug, clap::Args)]
#[group(skip)]
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

/// Steps as a study sees them.
pub struct Gathered<T> {
    /// Of each recorded trial.
    pub trials: Vec<(String, Vec<T>)>,
    /// Of random scenes.
    pub random: Vec<T>,
}

/// Walks through all; in the model's formulation, where `formulation` is none.
///
/// # Errors
/// Data or model cannot be read; no trial can be simulated.
pub fn gather<T>(
    args: &Args,
    formulation: Option<Formulation>,
    of: impl Fn(&Walked) -> T,
    output: &Output,
) -> anyhow::Result<Gathered<T>> {
    let mut model = model_or_default(args.model.as_deref())?;
    model.formulation = formulation.unwrap_or(model.formulation);
    let mut trials = Vec::new();
    let spinner = output.spinner("recorded trials");
    for folder in &args.data {
        let reader = Index::open(folder)?;
        for (ordinal, info) in reader.trials.iter().enumerate() {
            let trial = reader.read_trial(info).with_context(|| info.trial.clone())?;
            let Feed { scene, plan, samples, .. } = feed(&reader.description, &trial)?;
            let mut own = Vec::new();
            walk(&Package::new(scene, &model, plan, samples, ordinal), |walked| own.push(of(walked)));
            trials.push((info.trial.clone(), own));
        }
    }
    spinner.finish_and_clear();
    ensure!(trials.iter().any(|(_, own)| !own.is_empty()), "no trial of the data sets can be simulated");
    let bar = output.progress(args.random as u64, "random scenes");
    let random =
        random(args.random, args.seed, formulation.unwrap_or_default(), of, |more| bar.inc(more as u64));
    bar.finish_and_clear();
    Ok(Gathered { trials, random })
}

/// At least `steps` steps of random scenes, in `formulation`, each as `of` sees it; scenes that are refused
/// give none. `progress` is told how many more there are.
fn random<T>(
    steps: usize,
    seed: u64,
    formulation: Formulation,
    of: impl Fn(&Walked) -> T,
    mut progress: impl FnMut(usize),
) -> Vec<T> {
    let rng = &mut rng(seed);
    let mut seen = Vec::new();
    // A scene gives some forty steps; one in ten is refused.
    for _ in 0..steps {
        if seen.len() >= steps {
            break;
        }
        let mut package = package(&Genes::fresh(rng));
        package.model.1.formulation = formulation;
        if stickslip_shared::predictor::validate(&package.model.0, &package.model.1).is_ok() {
            let before = seen.len();
            walk(&package, |walked| seen.push(of(walked)));
            progress(seen.len() - before);
        }
    }
    seen
}
