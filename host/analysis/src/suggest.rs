//! The experiments that would tell effects apart, and a plan of several.

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_data::Dataset;

use crate::diagnose::experiment::{Experiment, Plan};
use crate::diagnose::posterior::Weighed;
use crate::diagnose::{self, Telling};
use crate::fit::FitError;
use crate::left_out::LeftOut;
use crate::model::candidate::CandidateEffect;
use crate::model::file::ModelFile;
use crate::progress::Progress;

/// Between what.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The two effects to separate; empty: the credible ones.
    pub between: Vec<CandidateEffect>,
    /// Effects of the user that may be among them, beside the listed ones.
    pub own: Vec<CandidateEffect>,
    /// Trials of a plan.
    pub runs: Option<usize>,
}

impl Options {
    /// Whether they can be asked of `model`; needs no data.
    ///
    /// # Errors
    /// Not two effects, the same one twice, or one that the model has.
    pub fn check(&self, model: &ModelFile) -> Result<(), SuggestError> {
        if let Some(runs) = self.runs.filter(|runs| !(1..=MOST_RUNS).contains(runs)) {
            return Err(SuggestError::Runs(runs));
        }
        match self.between.as_slice() {
            [] => {}
            [a, b] if a.info.id == b.info.id => return Err(SuggestError::Twice(a.info.id)),
            [_, _] => {}
            other => return Err(SuggestError::NotTwo(other.len())),
        }
        let in_model = |c: &&CandidateEffect| model.effects.iter().any(|e| e.name() == c.info.id);
        if let Some(known) = self.between.iter().find(in_model) {
            return Err(SuggestError::InModel(known.info.id));
        }
        Ok(())
    }
}

/// Experiments proposed.
const MOST: usize = 8;
/// Most trials of a plan.
const MOST_RUNS: usize = 1000;

/// Effects and the experiments that separate them.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Report {
    /// Ids of the two likeliest, or of the two that were named.
    pub between: [&'static str; 2],
    /// All that are weighed, with their probabilities.
    pub sets: Vec<Weighed>,
    /// Best first: where one run gives most information.
    pub experiments: Vec<Experiment>,
    /// The trials that together give most information, where a number of them was asked for.
    pub plan: Option<Plan>,
    /// Trials that were used.
    pub trials: usize,
    /// Trials that were left out, and why.
    pub left_out: Vec<LeftOut>,
}

/// Why nothing can be suggested.
#[derive(Debug, thiserror::Error)]
pub enum SuggestError {
    /// One or more than two effects are named.
    #[error("{0} effect(s) to separate: name two different ones, or none")]
    NotTwo(usize),
    /// The same effect twice.
    #[error("{0} cannot be distinguished from itself: name two different effects")]
    Twice(&'static str),
    /// Part of the model.
    #[error("the model already has {0}: adding it cannot distinguish it from another")]
    InModel(&'static str),
    /// No plan, or one that nobody measures.
    #[error("a plan of {0} trials: between 1 and {MOST_RUNS}")]
    Runs(usize),
    /// Nothing changes the data.
    #[error(
        "there are no two candidates to separate: fewer than two effects change these data by more than noise"
    )]
    NoCandidates,
    /// No trial can be simulated.
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// Fits the effects to `data` and finds the trials that give most information about which of them is missing.
///
/// # Errors
/// See [`SuggestError`].
pub fn suggest(
    data: &Dataset,
    model: &ModelFile,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Report, SuggestError> {
    options.check(model)?;
    progress.begin("fitting", diagnose::steps() as usize);
    let of = (options.between.as_slice(), options.own.as_slice());
    let found = diagnose::suggest(data, model, of, (MOST, options.runs), &|| progress.step(1))?;
    let Telling { between, sets, experiments, plan, trials, left_out } =
        found.ok_or(SuggestError::NoCandidates)?;
    Ok(Report { between, sets, experiments, plan, trials, left_out })
}
