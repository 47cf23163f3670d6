//! A model with one more effect, fitted together with the rest.

use stickslip_shared::effects::Effect;

use crate::fit::campaign::Campaign;
use crate::fit::{self, Fit, Free, Options};
use crate::model::file::{EffectEntry, ModelFile};

/// Fits friction and all effects of `file`, whose last `new` effects start from a screening of
/// their settings; writes values and intervals into it.
///
/// # Errors
/// See [`fit::calibrate`].
pub fn with_effects(campaign: &Campaign, file: &mut ModelFile, new: usize) -> Result<Fit, fit::FitError> {
    let whole = file.to_model();
    let mut model = whole.clone();
    model.effects.truncate(whole.effects.len() - new.min(whole.effects.len()));
    let mut base = fit::base_parameters(campaign);
    // What a calibration could not determine stays as it is: with an effect more it would take up
    // what else the model lacks.
    let mut kept = Vec::new();
    if !file.friction_intervals.is_empty() {
        let known = |f: &Free| f.coefficient().is_none_or(|name| file.friction_intervals.contains_key(name));
        (base, kept) = base.into_iter().partition(known);
    }
    let infos: Vec<_> = file.effects.iter().map(EffectEntry::info).collect();
    let described = |e: &Effect<f64>, slot: usize| infos.get(slot).copied().flatten().or_else(|| e.info());
    let all = |count: usize| -> Vec<Free> {
        let mut free = base.clone();
        for (slot, e) in whole.effects.iter().enumerate().take(count) {
            free.extend(described(e, slot).map(|i| Free::of_effect(i, slot)).unwrap_or_default());
        }
        free
    };
    let mut fitted = fit::calibrate(campaign, &model, &all(model.effects.len()), &Options::default())?;
    for _ in 0..new {
        let slot = fitted.model.effects.len();
        // Each fit has its own noise: their losses do not compare, a common cost does.
        let mut best: Option<(f64, Fit)> = None;
        for with in fit::starts(campaign, &fitted.model, &all(slot), whole.effects[slot]) {
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
        let (name, value) = (f.name(&model), f.get(&fitted.model));
        fitted.notes.push(format!(
            "{name} is not determined by the calibration: it is not fitted and stays at {value:.3}"
        ));
    }
    for f in base.iter() {
        let (name, value) = (f.name(&model), f.get(&fitted.model));
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
    file.friction_intervals.clear();
    for (free, e) in all(fitted.model.effects.len()).iter().zip(&fitted.estimates) {
        let range = [e.low, e.high];
        if let Free::Effect { slot, of: p, .. } = free
            && let Some(entry) = file.effects.get_mut(*slot)
        {
            entry.intervals.insert(p.name.into(), range);
        }
        if let Some(name) = free.coefficient() {
            file.friction_intervals.insert(name.into(), range);
        }
    }
    Ok(fitted)
}
