//! A model with more effects, or the one it is, with all its parameters fitted.

use serde::Serialize;
use stickslip_data::Dataset;
use stickslip_shared::effects::{Info, MAX_PARAMETERS};
use stickslip_shared::model::{MAX_EFFECTS, MAX_FORMULAS};

use crate::fit::campaign::Campaign;
use crate::fit::{self, Estimate, Fit, FitError, Free, Options};
use crate::model::candidate::CandidateEffect;
use crate::model::file::{EffectEntry, ModelFile};
use crate::progress::Progress;

/// A fitted model.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// With the fitted values and their intervals.
    #[serde(skip)]
    pub model: ModelFile,
    /// One for each parameter that was fitted.
    pub parameters: Vec<Estimate>,
    /// What cannot be told apart or seen, in words.
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
    progress.begin("fitting", new + 1);
    let old = model.effects.len() - new;
    let before = ModelFile { effects: model.effects[..old].to_vec(), ..model.clone() }.to_model();
    let fit = with_effects(&Campaign::new(data, &before), &mut model, new, progress)?;
    Ok(Report { model, parameters: fit.estimates, notes: fit.notes, covariance: fit.covariance })
}

/// Fits friction and all effects of `file`, whose last `new` effects start from a screening of
/// their settings (0: all start from their values); writes values and intervals into it.
fn with_effects(
    campaign: &Campaign,
    file: &mut ModelFile,
    new: usize,
    progress: &dyn Progress,
) -> Result<Fit, FitError> {
    let old = file.effects.len() - new;
    let (before, added) = file.effects.split_at(old);
    let model = ModelFile { effects: before.to_vec(), ..file.clone() }.to_model();
    let mut base = fit::base_parameters(campaign);
    // What a calibration could not determine stays as it is: with an effect more it would take up
    // what else the model lacks.
    let mut kept = Vec::new();
    if !file.friction_intervals.is_empty() {
        let known = |f: &Free| f.coefficient().is_none_or(|name| file.friction_intervals.contains_key(name));
        (base, kept) = base.into_iter().partition(known);
    }
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
            let cost = fit::robust_cost(campaign, &fit.model);
            if best.as_ref().is_none_or(|b| cost < b.0) {
                best = Some((cost, fit));
            }
        }
        if let Some((_, best)) = best {
            fitted = best;
        }
        progress.step(1);
    }
    for f in kept {
        let (name, value) = (f.name(), f.get(&fitted.model));
        fitted.notes.push(format!(
            "{name} is not determined by the calibration: it is not fitted and stays at {value:.3}"
        ));
    }
    for f in base.iter() {
        let (name, value) = (f.name(), f.get(&fitted.model));
        let before = f.coefficient().and_then(|c| file.friction_intervals.get(c));
        if let Some([low, high]) = before.filter(|[low, high]| !(*low..=*high).contains(&value)) {
            fitted.notes.push(format!(
                "{name} is {value:.3} here and {low:.3} to {high:.3} by the calibration: two estimates, one with the \
                 effect and from all features, one without it and from windows of the motion. `stickslip \
                 calibrate` on the new model fits friction alone"
            ));
        }
    }
    file.set_values(&fitted.model);
    let estimates = fitted.estimates.iter().map(|e| (e.name.as_str(), [e.low, e.high]));
    file.set_intervals(estimates);
    Ok(fitted)
}
