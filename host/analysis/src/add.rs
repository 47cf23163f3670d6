//! A model with more effects, or the one it is, with all its parameters fitted.

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_data::Dataset;
use stickslip_shared::effects::{Info, MAX_PARAMETERS};
use stickslip_shared::model::{MAX_EFFECTS, MAX_FORMULAS, Model};

use crate::calibrate::{self, name};
use crate::diagnose;
use crate::diagnose::beforehand::{self, Start};
use crate::diagnose::choice::other_ways;
use crate::diagnose::search::Search;
use crate::diagnose::select::{Candidate, Fitted, candidates, search_again};
use crate::fit::campaign::Campaign;
use crate::fit::{self, Estimate, Fit, FitError, Free, Options, intervals};
use crate::left_out::LeftOut;
use crate::model::candidate::CandidateEffect;
use crate::model::file::{EffectEntry, ModelFile};
use crate::progress::Progress;

/// A fitted model.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Report {
    /// With the fitted values and their intervals.
    #[serde(skip)]
    pub model: ModelFile,
    /// Trials that were used.
    pub trials: usize,
    /// Trials that were left out, and why.
    pub left_out: Vec<LeftOut>,
    /// One for each parameter that was fitted.
    pub parameters: Vec<Estimate>,
    /// What the data cannot distinguish or determine, in words.
    pub notes: Vec<String>,
    /// Of the parameters.
    pub covariance: Vec<Vec<f64>>,
}

/// Why an effect cannot be added.
#[derive(Debug, thiserror::Error)]
pub enum AddError {
    /// Part of the model.
    #[error("the model already has {0}; `stickslip refit` fits its parameters")]
    InModel(String),
    /// More than a board has room for.
    #[error("{0} effects; a model has at most {MAX_EFFECTS}")]
    Effects(usize),
    /// More than a board has room for.
    #[error("{0} formulas; a model has at most {MAX_FORMULAS}")]
    Formulas(usize),
    /// Nothing can be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// `model` with `effects`, all of it fitted to `data`; the new effects start from a screening of their
/// settings.
///
/// # Errors
/// See [`AddError`].
pub fn add(
    data: &Dataset,
    model: &ModelFile,
    effects: &[EffectEntry],
    progress: &dyn Progress,
) -> Result<Report, AddError> {
    let mut with = model.clone();
    for effect in effects {
        if with.effects.iter().any(|e| e.name() == effect.name()) {
            return Err(AddError::InModel(effect.name().to_owned()));
        }
        with.effects.push(effect.clone());
    }
    let formulas = with.effects.iter().filter(|e: &&EffectEntry| e.formula.is_some()).count();
    if formulas > MAX_FORMULAS {
        return Err(AddError::Formulas(formulas));
    }
    if with.effects.len() > MAX_EFFECTS {
        return Err(AddError::Effects(with.effects.len()));
    }
    Ok(fitted(data, with, effects.len(), progress)?)
}

/// `model` with friction and all effects fitted to `data`, from the values that it has.
///
/// # Errors
/// See [`FitError`].
pub fn refit(data: &Dataset, model: &ModelFile, progress: &dyn Progress) -> Result<Report, FitError> {
    fitted(data, model.clone(), 0, progress)
}

fn fitted(
    data: &Dataset,
    mut model: ModelFile,
    new: usize,
    progress: &dyn Progress,
) -> Result<Report, FitError> {
    progress.begin("fitting", new + 2);
    let old = model.effects.len() - new;
    let before = ModelFile { effects: model.effects[..old].to_vec(), ..model.clone() };
    let campaign = Campaign::new(data, &before.to_model());
    let start = (new > 0).then(|| start(&campaign, &before, &model.effects[old..])).flatten();
    let pads = start.as_ref().and_then(|s| entry(s.found.last()?));
    let mut notes = Vec::new();
    if let Some(pads) = pads {
        notes.push(format!(
            "{} is added with it, as in a diagnosis: compliant bodies keep their force when a motion ends, and this model \
             predicts better with it",
            pads.name()
        ));
        model.effects.insert(old, pads);
    }
    let found = start.and_then(|start| searched(&start, &model.effects[model.effects.len() - new..]));
    let joint = match found {
        Some((fit, free)) => {
            progress.step(1 + new);
            Joint::of(fit, free)
        }
        None => with_effects(&campaign, &model, new, progress)?,
    };
    let (settled, friction) = settle(data, &campaign, &model, &joint)?;
    progress.step(1);
    notes.extend(joint.notes);
    let mut parameters = Vec::new();
    let mut kept = Vec::new();
    for (k, mut e) in joint.estimates.into_iter().enumerate() {
        let Some(free) = joint.free.get(k) else { continue };
        let value = free.get(&settled);
        match (free.coefficient(), friction.iter().find(|f| free.coefficient() == Some(name(f.coefficient))))
        {
            (Some(_), None) => {
                notes.push(format!("{} is not determined by these data: it stays at {value:.3}", e.name));
                continue;
            }
            (_, Some(f)) => (e.low, e.high) = (f.low.unwrap_or(f64::NAN), f.high.unwrap_or(f64::NAN)),
            // As wide as with friction unknown.
            (None, None) => {
                let (low, high) = free.bounds();
                let moved = value - e.value;
                (e.low, e.high) = ((e.low + moved).clamp(low, high), (e.high + moved).clamp(low, high));
            }
        }
        e.value = value;
        kept.push(k);
        parameters.push(e);
    }
    let covariance = kept.iter().map(|i| kept.iter().map(|j| joint.covariance[*i][*j]).collect()).collect();
    model.set_values(&settled);
    model.set_intervals(parameters.iter().map(|e| (e.name.as_str(), [e.low, e.high])));
    Ok(Report { model, trials: joint.trials, left_out: joint.left_out, parameters, notes, covariance })
}

/// Where a diagnosis of `model` begins, with the pads, or the stiff contacts, that it puts into it before it looks for effects;
/// none where `new` has them, or where there is no room for them.
fn start<'a>(campaign: &'a Campaign, model: &ModelFile, new: &[EffectEntry]) -> Option<Start<'a>> {
    let room = model.effects.len() + new.len() < MAX_EFFECTS;
    if campaign.runs.is_empty() || !room || new.iter().any(EffectEntry::is_compliance) {
        return None;
    }
    Some(beforehand::start(campaign, &model.into()))
}

/// What was found before the search, as it stands in a model file.
fn entry(found: &Candidate) -> Option<EffectEntry> {
    let mut entry = EffectEntry::typical(found.info);
    let values = found.held.solution.model.effects.last()?.parameters;
    entry.values.iter_mut().zip(values).for_each(|(to, v)| *to = v);
    Some(entry)
}

/// The `new` effects on top of `start`, one after the other, each as a diagnosis searches it; `None` where one of them does not
/// show, or cannot stand beside the others.
fn searched(start: &Start, new: &[EffectEntry]) -> Option<(Fit, Vec<Free>)> {
    let mut held = start.held().clone();
    let given = diagnose::given(start.problem.campaign, &held);
    for effect in new {
        let others = other_ways(&start.problem, &held, start.others.iter().chain([&given]));
        let effect = [CandidateEffect::of(effect)?];
        let mut found = candidates(&start.problem, &held, &others, &effect, Fitted::most(1), &|| {}).0;
        search_again(&start.problem, &held, &others, &mut found, (1, Search::Grid), &|| {});
        held = found.pop()?.held;
    }
    let before = start.base.solution.loss.1;
    let home = Model { friction: given.friction, ..held.solution.model.clone() };
    let (solution, options) = (held.solution, Options::default());
    let fit = fit::of_solution(&start.problem, (solution, before), &home, &held.free, &options);
    Some((fit, held.free))
}

/// Rounds of friction and effects in turn.
const ROUNDS: usize = 6;
/// Relative change of friction below which effects stay as they are, and below which `calibrate` finds it again: where a
/// calibration begins has less than a thousandth of that left in where it ends.
const SETTLED: f64 = 1e-3;
const SAME: f64 = 2e-4;

/// The model with friction as [`calibrate`] finds it for the effects that the model has, and with the
/// effects as they fit best with that friction; and the coefficients that the data determine.
///
/// The joint fit weighs all features by what repetitions show. What the model lacks is in them too: on
/// synthetic pushes its friction is up to 5 % low, and its interval does not hold the truth. `calibrate`
/// weighs each signal by the error that is left in it. So the joint fit tells how much an effect has of
/// what friction could have as well, and `calibrate` has the last word on friction. What it does not
/// determine stays as `file` has it.
fn settle(
    data: &Dataset,
    campaign: &Campaign,
    file: &ModelFile,
    joint: &Joint,
) -> Result<(Model<f64>, Vec<calibrate::Estimate>), FitError> {
    let fitted = |f: &Free| f.coefficient().is_none() && !joint.unseen.contains(f);
    let effects: Vec<Free> = joint.free.iter().copied().filter(fitted).collect();
    let mut model = joint.model.clone();
    let given = file.to_model();
    let mut start = file.clone();
    let mut round = 0;
    loop {
        round += 1;
        start.set_values(&model);
        let options = calibrate::Options { pads: false, ..calibrate::Options::default() };
        let found = calibrate::calibrate(data, &start, &options, &())
            .map_err(|why| FitError::NoTrials(why.to_string()))?;
        let before = std::mem::replace(&mut model.friction, found.model.friction);
        let determined: Vec<calibrate::Estimate> = found.best().into_iter().cloned().collect();
        let known = |f: &Free| determined.iter().any(|e| f.coefficient() == Some(name(e.coefficient)));
        for f in fit::base_parameters(campaign).iter().filter(|f| !known(f)) {
            f.set(&mut model, f.get(&given));
        }
        let change = |a: f64, b: f64| (a / b - 1.0).abs();
        let moved = change(model.friction.finger, before.finger)
            .max(change(model.friction.pusher, before.pusher))
            .max(change(model.friction.support, before.support));
        if moved < SAME || round == ROUNDS {
            return Ok((model, determined));
        }
        if moved > SETTLED && !effects.is_empty() {
            let options = Options { resamples: 0, ..Options::default() };
            model = fit::calibrate(campaign, &model, &effects, &options)?.model;
        }
    }
}

/// The joint fit of friction and effects.
struct Joint {
    model: Model<f64>,
    free: Vec<Free>,
    estimates: Vec<Estimate>,
    covariance: Vec<Vec<f64>>,
    notes: Vec<String>,
    unseen: Vec<Free>,
    trials: usize,
    left_out: Vec<LeftOut>,
}

impl Joint {
    fn of(fit: Fit, free: Vec<Free>) -> Self {
        let Fit { model, estimates, covariance, notes, unseen, trials, left_out, .. } = fit;
        Self { model, free, estimates, covariance, notes, unseen, trials, left_out }
    }
}

/// Fits friction and all effects of `file`, whose last `new` effects start from a screening of
/// their settings (0: all start from their values).
fn with_effects(
    campaign: &Campaign,
    file: &ModelFile,
    new: usize,
    progress: &dyn Progress,
) -> Result<Joint, FitError> {
    let old = file.effects.len() - new;
    let (before, added) = file.effects.split_at(old);
    let model = ModelFile { effects: before.to_vec(), ..file.clone() }.to_model();
    let base = fit::base_parameters(campaign);
    let infos: Vec<&'static Info> = file.effects.iter().filter_map(EffectEntry::info).collect();
    let all = |count: usize| -> Vec<Free> {
        let of = infos.iter().enumerate().take(count).flat_map(|(slot, info)| Free::of_effect(info, slot));
        base.iter().copied().chain(of).collect()
    };
    let mut fitted = fit::calibrate(campaign, &model, &all(old), &Options::default())?;
    progress.step(1);
    for entry in added {
        let slot = fitted.model.effects.len();
        let Some(candidate) = CandidateEffect::of(entry) else { continue };
        let mut given = [0.0; MAX_PARAMETERS];
        given.iter_mut().zip(&entry.values).for_each(|(to, v)| *to = *v);
        // Each fit has its own noise: their losses do not compare, a common cost does.
        let mut best: Option<(f64, Fit)> = None;
        for with in fit::starts(campaign, &fitted.model, &all(slot), (&candidate, given)) {
            let fit = fit::calibrate(campaign, &with, &all(slot + 1), &Options::default())?;
            let cost = fit::robust_cost(campaign, &fit.model, fit::MANY);
            if best.as_ref().is_none_or(|b| cost < b.0) {
                best = Some((cost, fit));
            }
        }
        if let Some((_, best)) = best {
            fitted = best;
        }
        progress.step(1);
    }
    let free = all(fitted.model.effects.len());
    if new == 0 {
        fitted = nearer_to_none(campaign, fitted, &free)?;
    }
    Ok(Joint::of(fitted, free))
}

/// How much more a fit may cost that does as well.
const AS_WELL: f64 = 1.001;

/// `fitted`; where the data determine only a combination of two strengths of an effect, the fit from where the one that shows
/// less is neutral, if it does as well: a part that is not determined is no effect.
fn nearer_to_none(campaign: &Campaign, fitted: Fit, free: &[Free]) -> Result<Fit, FitError> {
    let Some(k) = combined(&fitted, free) else { return Ok(fitted) };
    let mut model = fitted.model.clone();
    if let Free::Effect { of, .. } = free[k] {
        free[k].set(&mut model, of.neutral);
    }
    let others: Vec<Free> = free.iter().filter(|f| **f != free[k]).copied().collect();
    let held = fit::calibrate(campaign, &model, &others, &Options { resamples: 0, ..Options::default() })?;
    let nearer = fit::calibrate(campaign, &held.model, free, &Options::default())?;
    let cost = |fit: &Fit| fit::robust_cost(campaign, &fit.model, fit::MANY);
    Ok(if cost(&nearer) <= AS_WELL * cost(&fitted) { nearer } else { fitted })
}

/// Of two strengths of an effect that the data do not separate the one that is fewer standard deviations from neutral.
fn combined(fit: &Fit, free: &[Free]) -> Option<usize> {
    let variance = |k: usize| fit.covariance[k][k];
    let owner = |k: usize| match free[k] {
        Free::Effect { slot, of, .. } if of.typical != of.neutral => Some(slot),
        _ => None,
    };
    let departs = |k: usize| match free[k] {
        Free::Effect { of, .. } => (free[k].get(&fit.model) - of.neutral).abs() / variance(k).sqrt(),
        _ => f64::INFINITY,
    };
    let pairs = (0..free.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let alike = |(i, j): &(usize, usize)| {
        owner(*i).is_some()
            && owner(*i) == owner(*j)
            && intervals::combined([variance(*i), variance(*j)], fit.covariance[*i][*j]).is_some()
    };
    let less = |(i, j): (usize, usize)| if departs(i) < departs(j) { i } else { j };
    pairs.filter(alike).map(less).find(|k| departs(*k) > 0.0)
}
