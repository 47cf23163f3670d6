//! `stickslip-lab blind`: blind test of the diagnosis on synthetic data.

use std::path::{Path, PathBuf};

use comfy_table::Cell;
use rayon::prelude::*;
use serde_json::json;

use crate::blind;
use crate::blind::generate::{Class, Plan, Wanted};
use crate::blind::score::{Opened, figures, text};
use stickslip_analysis::model::candidate::CandidateEffect;
use stickslip_analysis::model::file::ModelFile;
use stickslip_analysis::score::warnings::Share;
use stickslip_report::terminal::{Output, table};
use stickslip_rig::{HiddenEffect, Kind};

/// Arguments of `stickslip-lab blind`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip-lab blind --runs 60 --seed 1
  stickslip-second-rig draw --family bench-wide --seed 1 --count 30 --out data/blind
  stickslip-lab blind --data data/blind")]
pub struct Args {
    /// Data sets to make and diagnose
    #[arg(long, default_value_t = 20)]
    pub runs: usize,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Largest number of conditions of a plan; each is run two or three times
    #[arg(long, default_value_t = 12)]
    pub conditions: usize,
    /// Hide this effect instead of a random one [default strength: the typical one]; repeatable
    #[arg(long, value_name = "EFFECT[=STRENGTH]")]
    pub hide: Vec<HiddenEffect>,
    /// Hide each effect of the list in turn, each in all runs
    #[arg(long, conflicts_with = "hide")]
    pub each: bool,
    /// Kind and number of the hidden effects
    #[arg(long, value_enum)]
    pub class: Option<Class>,
    /// Plan of all runs
    #[arg(long, value_enum)]
    pub plan: Option<Plan>,
    /// Repeat only these numbers of the series
    #[arg(long, value_name = "NUMBER", value_delimiter = ',')]
    pub only: Vec<usize>,
    /// Multiple of the typical strength of all effects [default: drawn from 0.8 to 2]
    #[arg(long, value_name = "FACTOR")]
    pub strength: Option<f64>,
    /// Diagnose the data sets of this folder in place of drawn ones
    #[arg(long, value_name = "DIR", conflicts_with_all = ["hide", "each", "class", "plan", "only", "strength", "formula"])]
    pub data: Option<PathBuf>,
    /// Folder of their keys, NAME.json each [default: FOLDER.keys]
    #[arg(long, value_name = "DIR", requires = "data")]
    pub keys: Option<PathBuf>,
    /// Try the formulas of this file beside the listed effects; one stands for the hidden effect
    /// whose name it bears
    #[arg(long, value_name = "FILE.toml")]
    pub formula: Option<PathBuf>,
}

/// Makes, diagnoses, opens the key, sums up.
///
/// # Errors
/// Where the rig or the diagnosis fails.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let opened = match &args.data {
        Some(folder) => of_others(folder, args.keys.as_deref(), output)?,
        None => drawn(args, output)?,
    };
    let f = figures(&opened);
    let mut t = table(["figure", "share", "aim"]);
    for (what, share, aim) in [
        ("single strong effect, alone or in a set of at most three", f.strong_named, "98 %"),
        ("single strong effect, alone", f.strong_alone, "85 %"),
        ("single effect of any strength, so named", f.single_named, "-"),
        ("single effect of any strength, wrongly named", f.single_wrong, "-"),
        ("nothing missing, said so", f.nothing_right, "99 %"),
        ("unknown effect, not given a name", f.unknown_not_named, "90 %"),
        ("two effects, both named", f.both_named, "80 %"),
        ("two effects, each strong alone, both named", f.both_strong_named, "-"),
        ("two effects, none wrongly named", f.one_of_two, "-"),
        ("rightly named, error after within 1.3 run spreads", f.error_fell, "95 %"),
        ("most probable with 95 % or more: right", f.sure_right, "93 %"),
        ("credible sets hold what was hidden", f.credible_holds, "93 %"),
    ] {
        t.add_row(vec![Cell::new(what), Cell::new(text(&share)), Cell::new(aim)]);
    }
    output.table(&t);
    output.text(format!(
        "mean size of ambiguous sets {:.1}; expected calibration error {:.2}; slowest diagnosis {:.1} s\n",
        f.mean_set, f.calibration_error, f.slowest_s
    ));
    if args.data.is_some() {
        let share = |s: &Share| s.found as f64 / s.of as f64;
        let mut worst_first: Vec<_> = f.families.iter().collect();
        worst_first.sort_by(|a, b| share(a.1).total_cmp(&share(b.1)));
        let mut t = table(["family", "single strong effect, alone or in a set of at most three"]);
        for (family, share) in worst_first {
            t.add_row([family.clone(), text(share)]);
        }
        output.table(&t);
    }
    let mut c = table(["hidden", "named", "runs"]);
    for (hidden, answers) in &f.confusion {
        for (answer, count) in answers {
            c.add_row(vec![Cell::new(hidden), Cell::new(answer), Cell::new(count)]);
        }
    }
    output.table(&c);
    output.document(&json!({ "figures": f, "runs": opened }))
}

/// Data sets that others made.
fn of_others(folder: &Path, keys: Option<&Path>, output: &Output) -> anyhow::Result<Vec<Opened>> {
    let keys = keys.map_or_else(|| folder.with_added_extension("keys"), Path::to_owned);
    let names = blind::keys::names(folder)?;
    let bar = output.progress(names.len() as u64, "blind test");
    let opened = names
        .par_iter()
        .map(|name| {
            let o = blind::keys::run(folder, &keys, name)?;
            bar.suspend(|| output.note(line(name, &o)));
            bar.inc(1);
            Ok(o)
        })
        .collect::<anyhow::Result<_>>()?;
    bar.finish_and_clear();
    Ok(opened)
}

/// Data sets of the own rig.
fn drawn(args: &Args, output: &Output) -> anyhow::Result<Vec<Opened>> {
    let own = match &args.formula {
        Some(path) => ModelFile::read_formulas(path)?.iter().filter_map(CandidateEffect::of).collect(),
        None => Vec::new(),
    };
    let hidden: Vec<Vec<HiddenEffect>> = match args.each {
        true => Kind::ALL
            .iter()
            .map(|kind| {
                let strength = kind.typical_strength() * args.strength.unwrap_or(1.0);
                vec![HiddenEffect { kind: *kind, strength }]
            })
            .collect(),
        false => vec![args.hide.clone()],
    };
    let cases: Vec<(usize, Wanted)> = hidden
        .into_iter()
        .flat_map(|effects| {
            let wanted = Wanted { effects, class: args.class, plan: args.plan, strength: args.strength };
            let chosen = |number: &usize| args.only.is_empty() || args.only.contains(number);
            (0..args.runs).filter(chosen).map(move |number| (number, wanted.clone()))
        })
        .collect();
    let bar = output.progress(cases.len() as u64, "blind test");
    let opened = cases
        .par_iter()
        .map(|(number, wanted)| {
            let o = blind::run(args.seed, *number, args.conditions, (wanted, &own))?;
            bar.suspend(|| output.note(line(&number.to_string(), &o)));
            bar.inc(1);
            Ok(o)
        })
        .collect::<anyhow::Result<_>>()?;
    bar.finish_and_clear();
    Ok(opened)
}

fn line(name: &str, o: &Opened) -> String {
    let tried: Vec<String> = o
        .candidates
        .iter()
        .map(|c| {
            let left = c.worst.as_ref().map_or(String::new(), |(c, p, x)| format!(", left {x:.1} {c} {p}"));
            let share = 100.0 * c.explained;
            format!("{} {share:.0} % p {:.1e} to {:.2}{left}", c.id, c.p_value, c.held_out_error)
        })
        .collect();
    let probable: Vec<String> = o
        .credible_sets
        .iter()
        .take(3)
        .map(|s| format!("{} {:.2}", s.effects.join("+"), s.probability))
        .collect();
    format!(
        "{name}: {} {} trials, hidden [{}]: {:?} {:?} ~ {:?}; probable [{}], none {:.2}; error {:.2} -> {:.2} (floor {:.2}), worst {:.1} -> {:.1} ({}); tried {}; {:.1} s",
        o.truth.family,
        o.truth.trials,
        o.truth.strengths.join(", "),
        o.verdict,
        o.named,
        o.ambiguous_with,
        probable.join(", "),
        o.unlisted,
        o.error[0],
        o.error[1],
        o.error[2],
        o.worst,
        o.worst_after,
        o.worst_place,
        tried.join("; "),
        o.seconds
    )
}
