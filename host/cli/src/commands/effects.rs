//! `stickslip effects`: what a model can have, from the effects' own descriptions.

use std::path::PathBuf;

use comfy_table::{Cell, CellAlignment};
use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::effects::{Info, REGISTRY};

use stickslip_analysis::model::candidate;
use stickslip_analysis::model::file::{EffectEntry, ModelFile};
use stickslip_report::terminal::{Output, table};

/// Arguments of `stickslip effects`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip effects
  stickslip effects face_tilt")]
pub struct Args {
    /// Effect to show [default: list all]
    #[arg(value_name = "EFFECT")]
    pub id: Option<String>,
    /// Show the formulas of this file too
    #[arg(long, value_name = "FILE.toml")]
    pub formula: Option<PathBuf>,
}

/// An effect as JSON.
#[derive(JsonSchema, Serialize)]
/// An effect that a model can have.
pub(super) struct Effect {
    /// Its name in model files.
    id: &'static str,
    /// What it is.
    what: &'static str,
    /// What it looks like in data.
    in_data: &'static str,
    /// What it changes for a robot that grips.
    on_robot: &'static str,
    /// Where it is described.
    source: &'static str,
    /// Of a formula.
    #[serde(skip_serializing_if = "Option::is_none")]
    expression: Option<String>,
    /// Its parameters.
    parameters: Vec<Parameter>,
}

#[derive(JsonSchema, Serialize)]
/// A parameter of an effect.
pub(super) struct Parameter {
    /// Key in model files.
    name: &'static str,
    /// Unit of its value.
    unit: &'static str,
    /// What it is.
    what: &'static str,
    /// A size that is clearly visible in data.
    typical: f64,
    /// At it the parameter changes nothing.
    neutral: f64,
    /// Least value that is tried.
    low: f64,
    /// Greatest.
    high: f64,
}

impl Effect {
    fn of(info: &'static Info, formula: Option<&EffectEntry>) -> Self {
        let parameters = info.parameters.iter().map(|p| Parameter {
            name: p.name,
            unit: p.unit,
            what: p.what,
            typical: p.typical,
            neutral: p.neutral,
            low: p.low,
            high: p.high,
        });
        Effect {
            id: info.id,
            what: info.summary,
            in_data: info.signature,
            on_robot: info.on_robot,
            source: info.source,
            expression: formula.and_then(|e| e.formula.as_ref()).map(|f| f.expression.clone()),
            parameters: parameters.collect(),
        }
    }
}

/// Prints the list, or one effect.
///
/// # Errors
/// Where there is no such effect, or the file of formulas cannot be read.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let formulas = match &args.formula {
        Some(path) => ModelFile::read_formulas(path)?,
        None => Vec::new(),
    };
    let own = formulas.iter().filter_map(|f| Some(Effect::of(f.info()?, Some(f))));
    let mut effects: Vec<Effect> = REGISTRY.iter().map(|info| Effect::of(info, None)).chain(own).collect();
    let Some(id) = &args.id else {
        let mut t = table(["effect", "what it is"]);
        for e in &effects {
            t.add_row([e.id, e.what]);
        }
        output.table(&t);
        output.next(["effects", effects.first().map_or("EFFECT", |e| e.id)]);
        return output.document(&effects);
    };
    candidate::named(id, &formulas)?;
    effects.retain(|e| e.id == id);
    for effect in &effects {
        show(effect, output);
    }
    let formula = args.formula.as_ref().map(|f| f.display().to_string());
    let formula = formula.as_deref().map(|f| ["--formula", f]);
    let add = ["add", "DATA", id, "--model", "model.toml"];
    output.next(add.into_iter().chain(formula.into_iter().flatten()).chain(["--out", "better.toml"]));
    output.document(effects.first().ok_or_else(|| anyhow::anyhow!("{id}: not described"))?)
}

fn show(effect: &Effect, output: &Output) {
    output.text(format_args!("{}: {}", effect.id, effect.what));
    if let Some(expression) = &effect.expression {
        output.text(format_args!("expression: {expression}"));
    }
    output.text(format_args!("in data: {}", effect.in_data));
    output.text(format_args!("on the robot: {}", effect.on_robot));
    output.text(format_args!("source: {}\n", effect.source));
    let mut t = table(["parameter", "unit", "typical", "neutral", "bounds", "meaning"]);
    for p in &effect.parameters {
        let right = |x: f64| Cell::new(x).set_alignment(CellAlignment::Right);
        t.add_row(vec![
            Cell::new(p.name),
            Cell::new(p.unit),
            right(p.typical),
            right(p.neutral),
            Cell::new(format!("{} to {}", p.low, p.high)),
            Cell::new(p.what),
        ]);
    }
    output.table(&t);
    output.text("typical: a size that is clearly visible in data; neutral: changes nothing");
}
