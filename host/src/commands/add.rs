//! `stickslip add EFFECT`: the model with one more effect, fitted together with the rest.

use std::path::PathBuf;

use anyhow::{Context, bail};
use comfy_table::{Cell, CellAlignment};
use stickslip_shared::effects::{Effect, REGISTRY, find};

use crate::commands::diagnose::{read_data, short};
use crate::diagnose::campaign::Campaign;
use crate::fit::{self, Fit, Free, Options};
use crate::model_file::{EffectEntry, ModelFile, default_model};
use crate::output::{Output, table};

/// Arguments of `stickslip add`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip add torsional_friction --model model.toml --fit data/demo --out better.toml")]
pub struct Args {
    /// Identifiers of the effects to add
    #[arg(required = true, value_name = "EFFECT")]
    pub effects: Vec<String>,
    /// Model to add it to [default: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Data set to fit all parameters to
    #[arg(long, value_name = "DATA")]
    pub fit: PathBuf,
    /// File of the new model
    #[arg(long, value_name = "BETTER.toml")]
    pub out: PathBuf,
}

/// Fits and writes.
///
/// # Errors
/// Where an effect is unknown or already there, data or model cannot be read, or nothing can be fitted.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let mut file = match &args.model {
        Some(path) => ModelFile::read(path)?,
        None => {
            let base = default_model();
            ModelFile::new(base.base, base.friction)
        }
    };
    for id in &args.effects {
        let Some(info) = find(id) else {
            let known: Vec<&str> = REGISTRY.iter().map(|i| i.id).collect();
            bail!("unknown effect `{id}`; the known ones are {}", known.join(", "));
        };
        if file.effects.iter().any(|e| &e.id == id) {
            bail!("the model already has {id}; `stickslip calibrate` fits its parameters");
        }
        let values = info.parameters.iter().map(|p| p.typical).collect();
        file.effects.push(EffectEntry {
            id: id.clone(),
            values,
            intervals: Default::default(),
            formula: None,
        });
    }
    let dataset = read_data(&args.fit, output)?;
    let bar = output.spinner("fitting");
    let fit = with_effects(&Campaign::new(&dataset, &file.to_model()), &mut file, args.effects.len())?;
    bar.finish_and_clear();
    std::fs::write(&args.out, file.write())
        .with_context(|| format!("{}: cannot be written", args.out.display()))?;
    let mut t = table(["parameter", "value", "95 % interval", "unit"]);
    for e in &fit.estimates {
        t.add_row(vec![
            Cell::new(&e.name),
            Cell::new(short(e.value)).set_alignment(CellAlignment::Right),
            Cell::new(format!("{} to {}", short(e.low), short(e.high))),
            Cell::new(e.unit),
        ]);
    }
    output.table(&t);
    for note in &fit.notes {
        output.text(format!("note: {note}"));
    }
    output.text(format!("written to {}", args.out.display()));
    output.document(&serde_json::json!({
        "model": args.out, "parameters": fit.estimates, "notes": fit.notes, "covariance": fit.covariance,
    }))
}

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
    let infos: Vec<_> = file.effects.iter().map(crate::model_file::EffectEntry::info).collect();
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
        fitted
            .notes
            .push(format!("{name} is undetermined by the calibration: stays at {value:.3}, not fitted"));
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
