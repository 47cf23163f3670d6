//! A model with more effects, or the one it is, with all its parameters fitted.

use stickslip_shared::effects::{Info, MAX_PARAMETERS};

use crate::fit::campaign::Campaign;
use crate::fit::{self, Fit, Free, Options};
use crate::model::candidate::CandidateEffect;
use crate::model::file::{EffectEntry, ModelFile};

/// Fits friction and all effects of `file`, whose last `new` effects start from a screening of
/// their settings (0: all start from their values); writes values and intervals into it.
///
/// # Errors
/// See [`fit::calibrate`].
pub fn with_effects(campaign: &Campaign, file: &mut ModelFile, new: usize) -> Result<Fit, fit::FitError> {
    let old = file.effects.len() - new.min(file.effects.len());
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
    }
    for f in kept {
        let (name, value) = (f.name(), f.get(&fitted.model));
        fitted.notes.push(format!(
            "{name} is not determined by the calibration: it is not fitted and stays at {value:.3}"
        ));
    }
    file.set_values(&fitted.model);
    let estimates = fitted.estimates.iter().map(|e| (e.name.as_str(), [e.low, e.high]));
    file.set_intervals(estimates);
    Ok(fitted)
}
