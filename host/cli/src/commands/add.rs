//! `stickslip add DATA EFFECT`: the model with one more effect, fitted together with the rest.

use std::path::{Path, PathBuf};

use anyhow::{bail, ensure};

use crate::commands::fitted::{file_or_default, give, next_compare};
use stickslip_analysis::add;
use stickslip_analysis::model::candidate;
use stickslip_analysis::model::file::EffectEntry;
use stickslip_report::terminal::Output;

/// Arguments of `stickslip add`.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "stickslip add DATA EFFECT... [--model MODEL.toml] --out BETTER.toml",
    after_help = "Examples:
  stickslip add data/bench torsional_friction --model model.toml --out better.toml
  stickslip add data/bench my_hump --model model.toml --formula my_hump.toml --out better.toml

`stickslip effects` lists the effects."
)]
pub struct Args {
    /// Data set to fit all parameters to (its folder), then the effects to add: of the list, or formulas
    #[arg(required = true, value_names = ["DATA", "EFFECT"], num_args = 1..)]
    pub words: Vec<String>,
    /// Model to add it to; its formulas that were not fitted yet may be named as effects
    /// [default: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// More formulas that may be named as effects
    #[arg(long, value_name = "FILE.toml")]
    pub formula: Option<PathBuf>,
    /// Data set, where the words are effects only
    #[arg(long, value_name = "DATA")]
    pub fit: Option<PathBuf>,
    /// File of the new model
    #[arg(long, value_name = "BETTER.toml")]
    pub out: PathBuf,
}

impl Args {
    /// The data set, and the names of the effects.
    fn split(&self) -> anyhow::Result<(&Path, &[String])> {
        let (data, effects) = match (&self.fit, self.words.as_slice()) {
            (Some(fit), effects) => (fit.as_path(), effects),
            (None, [first, effects @ ..]) => (Path::new(first), effects),
            (None, []) => (Path::new(""), [].as_slice()),
        };
        if !data.exists() && candidate::named(&data.to_string_lossy(), &[]).is_ok() {
            bail!("the data set comes first: stickslip add DATA {} --out BETTER.toml", data.display());
        }
        ensure!(
            !effects.is_empty(),
            "name the effect to add after the data set; `stickslip effects` lists them"
        );
        Ok((data, effects))
    }
}

/// Fits and writes.
///
/// # Errors
/// Where an effect is unknown or already there, data or model cannot be read, or nothing can be fitted.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let (data, effects) = args.split()?;
    let whole = file_or_default(args.model.as_deref())?;
    let (before, formulas) = whole.proposals(args.formula.as_deref())?;
    // With those that the model has: `add` says so of them.
    let known: Vec<EffectEntry> = formulas.iter().chain(&before.effects).cloned().collect();
    let new = effects.iter().map(|name| candidate::named(name, &known)).collect::<Result<Vec<_>, _>>()?;
    for formula in whole.effects.iter().filter(|e| e.is_proposal()) {
        if !effects.iter().any(|name| name == formula.name()) {
            output.note(format_args!(
                "formula {} of the model file is not named: the new model does not have it",
                formula.name()
            ));
        }
    }
    let report = add(&stickslip_report::data::read(data, output)?, &before, &new, output)?;
    give(&before, &report, &args.out, output)?;
    next_compare(data, args.model.as_deref(), &args.out, output);
    Ok(())
}
