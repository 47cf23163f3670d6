//! `stickslip add EFFECT`: the model with one more effect, fitted together with the rest.

use std::path::PathBuf;

use anyhow::{Context, bail};
use comfy_table::{Cell, CellAlignment};
use stickslip_shared::effects::{REGISTRY, find};

use crate::commands::diagnose::read_data;
use stickslip_analysis::add::with_effects;
use stickslip_analysis::fit::campaign::Campaign;
use stickslip_analysis::model::file::{EffectEntry, ModelFile, default_model};
use stickslip_report::terminal::{Output, table};
use stickslip_report::words::short;

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
