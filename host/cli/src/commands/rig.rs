//! `stickslip rig`: makes a data set with the synthetic reality.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use stickslip_data::{Stage, TableFormat, TrialInfo, Writer, write_file};
use stickslip_report::terminal::{Output, table};
use stickslip_rig::plan::{self, PlanName};
use stickslip_rig::{Condition, HiddenEffect, Kind, Nuisance, Reality, STEP_S, Setup, Truth, objects};

/// Command line of `stickslip rig`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip rig --out data/push --plan push-small
  stickslip rig --out data/grid --plan paper --format parquet
  stickslip rig --out data/blind --hidden static_friction=0.3 --seed 5 --key blind.json
  stickslip rig --list-effects")]
pub struct Args {
    /// Folder of the data set; created if it does not exist
    #[arg(long, value_name = "DIR", required_unless_present = "list_effects")]
    pub out: Option<PathBuf>,
    /// Replace a data set that is in the folder already
    #[arg(long)]
    pub force: bool,
    /// Which conditions
    #[arg(long, value_enum, default_value = "push-small")]
    pub plan: PlanName,
    /// Objects to use instead of the plan's (paper plan: a subset of its objects), as obj3,obj4
    #[arg(long, value_delimiter = ',', value_name = "ID")]
    pub objects: Vec<String>,
    /// Hidden effect [default strength: the typical one]; repeatable
    #[arg(long, value_name = "EFFECT[=STRENGTH]")]
    pub hidden: Vec<HiddenEffect>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Runs of each condition [default: 3; 1 for lift, slip-hours, decay and demo]
    #[arg(long, value_name = "N")]
    pub runs: Option<usize>,
    /// Friction of the fingers [default: drawn from 0.35 to 0.5]
    #[arg(long, value_name = "MU")]
    pub mu_finger: Option<f64>,
    /// Friction of the pusher [default: drawn from 0.2 to 0.3]
    #[arg(long, value_name = "MU")]
    pub mu_pusher: Option<f64>,
    /// Friction of the table [default: drawn from 0.2 to 0.35]
    #[arg(long, value_name = "MU")]
    pub mu_support: Option<f64>,
    /// Sensor noise as a multiple of the paper's
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    pub noise_scale: f64,
    /// Constant sensor errors as a share of the stated uncertainty
    #[arg(long, default_value_t = Nuisance::PAPER.bias, value_name = "SHARE")]
    pub bias_scale: f64,
    /// How far sensor errors drift in a minute of a trial, as a share of the stated uncertainty
    #[arg(long, default_value_t = 0.0, value_name = "SHARE")]
    pub drift: f64,
    /// Relative standard deviation of friction from run to run
    #[arg(long, default_value_t = Nuisance::PAPER.friction_run, value_name = "SHARE")]
    pub run_variation: f64,
    /// Relative standard deviation of friction from condition to condition
    #[arg(long, default_value_t = 0.0, value_name = "SHARE")]
    pub condition_variation: f64,
    /// Length of the slip-hours plan
    #[arg(long, default_value_t = 5.0, value_name = "HOURS")]
    pub hours: f64,
    /// Format of the tables
    #[arg(long, value_enum, default_value = "csv")]
    pub format: TableFormat,
    /// File of the true effects and parameters; must be outside the data set
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Name of the data set
    #[arg(long, default_value = "stickslip rig", value_name = "TEXT")]
    pub name: String,
    /// List the hidden effects with their units
    #[arg(long)]
    pub list_effects: bool,
}

/// What `--json` prints.
#[derive(Debug, JsonSchema, Serialize)]
/// A data set that was made.
pub(super) struct Report<'a> {
    /// Its folder.
    folder: &'a Path,
    /// Trials.
    trials: usize,
    /// Rows of all trials.
    samples: usize,
    /// Recorded time, s.
    data_s: f64,
}

/// The truth of a whole data set.
#[derive(Debug, Serialize)]
struct Key<'a> {
    seed: u64,
    reality: &'a Reality,
    trials: Vec<KeyTrial<'a>>,
}

#[derive(Debug, Serialize)]
struct KeyTrial<'a> {
    trial: &'a str,
    condition: &'a Condition,
    truth: &'a Truth,
}

#[derive(Debug, JsonSchema, Serialize)]
/// An effect that the rig can hide.
pub(super) struct EffectRow {
    /// Its name here.
    effect: &'static str,
    /// Of its strength.
    unit: &'static str,
    /// Clearly visible in data.
    typical_strength: f64,
    /// `diagnose` has it in its list.
    listed: bool,
    /// What it is.
    what: &'static str,
}

/// What stays of a trial whose table is written.
struct Made {
    info: TrialInfo,
    truth: Truth,
    samples: usize,
    last_s: f64,
}

/// Makes the data set.
///
/// # Errors
/// Values out of range, a plan that does not suit its objects, a key inside the data set,
/// files that cannot be written.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let Some(folder) = args.out.as_deref().filter(|_| !args.list_effects) else {
        return list_effects(output);
    };
    check(args, folder)?;
    let conditions = plan::conditions(args.plan, &args.objects, args.seed, args.hours);
    if conditions.is_empty() {
        bail!("plan {:?} has no condition with the objects {}", args.plan, args.objects.join(", "));
    }
    let trials = plan::trials(&conditions, args.runs.unwrap_or(args.plan.usual_runs()));
    let setup = setup(args, &conditions);
    let bar = output.progress(trials.len() as u64, "simulating");
    let stage = Stage::within(folder)?;
    let writer = Writer::begin(&setup.description, stage.folder(), args.format)
        .with_context(|| format!("writing the data set {}", folder.display()))?;
    let made = trials
        .par_iter()
        .map(|(condition, run)| {
            let outcome =
                stickslip_rig::run(&setup, condition, *run, args.seed).map_err(anyhow::Error::msg)?;
            writer.table(&outcome.trial).with_context(|| format!("writing the trial {}", condition.label))?;
            bar.inc(1);
            let samples = &outcome.trial.samples;
            let last_s = samples.last().map_or(0.0, |s| s.t_s);
            Ok(Made { samples: samples.len(), last_s, info: outcome.trial.info, truth: outcome.truth })
        })
        .collect::<anyhow::Result<Vec<Made>>>()?;
    bar.finish_and_clear();
    if let Some(path) = &args.key {
        write_key(path, args.seed, &setup.reality, &trials, &made)?;
    }
    let infos: Vec<&TrialInfo> = made.iter().map(|m| &m.info).collect();
    writer.finish(&infos).with_context(|| format!("writing the data set {}", folder.display()))?;
    clear(folder)?;
    stage.finish_with("dataset.toml")?;
    let report = Report {
        folder,
        trials: made.len(),
        samples: made.iter().map(|m| m.samples).sum(),
        data_s: made.iter().map(|m| m.last_s).sum(),
    };
    output.text(format_args!(
        "{}: {} trials, {} samples, {:.0} s of data",
        folder.display(),
        report.trials,
        report.samples,
        report.data_s
    ));
    output.document(&report)
}

fn check(args: &Args, folder: &Path) -> anyhow::Result<()> {
    let bounded = [
        ("--mu-finger", args.mu_finger.unwrap_or(0.4), 0.0, 10.0),
        ("--mu-pusher", args.mu_pusher.unwrap_or(0.25), 0.0, 10.0),
        ("--mu-support", args.mu_support.unwrap_or(0.3), 0.0, 10.0),
        ("--noise-scale", args.noise_scale, 0.0, 1e3),
        ("--bias-scale", args.bias_scale, 0.0, 100.0),
        ("--drift", args.drift, 0.0, 100.0),
        ("--run-variation", args.run_variation, 0.0, 0.3),
        ("--condition-variation", args.condition_variation, 0.0, 0.3),
        ("--hours", args.hours, 1e-3, 100.0),
    ];
    for (option, value, least, most) in bounded {
        if !(least..=most).contains(&value) {
            bail!("{option} is {value}; give a number from {least} to {most}");
        }
    }
    if args.runs == Some(0) {
        bail!("--runs is 0; give at least 1 (3 for a noise floor)");
    }
    if !args.force && (folder.join("dataset.toml").exists() || folder.join("trials.csv").exists()) {
        bail!(
            "--out {}: there is a data set already, and its list of trials would be replaced; choose another \
             folder, or give --force",
            folder.display()
        );
    }
    let known = objects::catalogue();
    if let Some(id) = args.objects.iter().find(|id| !known.iter().any(|o| o.id == **id)) {
        let ids: Vec<_> = known.iter().map(|o| o.id.as_str()).collect();
        bail!("--objects: no object '{id}'; the rig has {}", ids.join(", "));
    }
    if let Some(key) = &args.key
        && std::path::absolute(key)?.starts_with(std::path::absolute(folder)?)
    {
        bail!("--key {} is inside the data set; choose another folder", key.display());
    }
    Ok(())
}

/// Takes an old data set away, its description first: what is there until the new one comes is none. Tables that no list
/// names would stay in the folder.
fn clear(folder: &Path) -> anyhow::Result<()> {
    let index = stickslip_data::Index::open(folder);
    let lists = ["dataset.toml", "trials.csv"].map(|name| [folder.join(name)].to_vec());
    let tables = index
        .iter()
        .flat_map(|index| &index.trials)
        .map(|info| [folder.join(&info.file), folder.join(&info.file).with_extension("parquet")].to_vec());
    for files in lists.into_iter().chain(tables) {
        for table in files {
            if table.is_file() {
                std::fs::remove_file(&table).with_context(|| format!("removing {}", table.display()))?;
            }
        }
    }
    Ok(())
}

fn setup(args: &Args, conditions: &[Condition]) -> Setup {
    let primitives: Vec<_> = conditions.iter().map(|c| c.primitive.name()).collect();
    let used: Vec<_> = conditions.iter().map(|c| c.object.as_str()).collect();
    let description = objects::trimmed(objects::bench(&args.name), &primitives, &used);
    let nuisance = Nuisance {
        noise: args.noise_scale,
        bias: args.bias_scale,
        drift: args.drift,
        friction_run: args.run_variation,
        friction_condition: args.condition_variation,
        ..Nuisance::PAPER
    };
    let mut reality = Reality::draw(&description, nuisance, args.seed);
    reality.mu_finger = args.mu_finger.unwrap_or(reality.mu_finger);
    reality.mu_pusher = args.mu_pusher.unwrap_or(reality.mu_pusher);
    reality.mu_support = args.mu_support.unwrap_or(reality.mu_support);
    reality.effects.clone_from(&args.hidden);
    Setup { description, reality, step_s: STEP_S }
}

fn write_key(
    path: &Path,
    seed: u64,
    reality: &Reality,
    trials: &[(Condition, usize)],
    made: &[Made],
) -> anyhow::Result<()> {
    let key = Key {
        seed,
        reality,
        trials: trials
            .iter()
            .zip(made)
            .map(|((condition, _), made)| KeyTrial { trial: &made.info.trial, condition, truth: &made.truth })
            .collect(),
    };
    let text = serde_json::to_string_pretty(&key)?;
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent).with_context(|| format!("making {}", parent.display()))?;
    }
    write_file(path, text).with_context(|| format!("writing the key {}", path.display()))
}

fn list_effects(output: &Output) -> anyhow::Result<()> {
    let rows: Vec<_> = Kind::ALL
        .iter()
        .map(|kind| EffectRow {
            effect: kind.name(),
            unit: kind.unit(),
            typical_strength: kind.typical_strength(),
            listed: kind.is_listed(),
            what: kind.what(),
        })
        .collect();
    let mut shown = table(["effect", "unit", "typical", "what the rig does"]);
    for row in &rows {
        shown.add_row([row.effect, row.unit, &row.typical_strength.to_string(), row.what]);
    }
    output.table(&shown);
    output.document(&rows)
}
