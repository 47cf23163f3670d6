//! `stickslip-lab ceilings DATA...`: slips that the predictor sees in time beside those that the poses' noise lets anyone see.

use std::path::PathBuf;

use serde::Serialize;
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::alarms::{SLIPS, episodes};
use stickslip_analysis::score::warnings::{Class, Share, judge};
use stickslip_report::terminal::{Output, table};

use super::warnings::share;
use crate::ceilings::{From, Sight, found};
use crate::grasps;

/// Slips that begin without a sign of their own, and until when they shall be seen, s.
const JUDGED: [(&str, Class, f64); 2] =
    [("friction falls", Class::FrictionFalls, 0.04), ("sudden", Class::Sudden, 0.02)];
/// A slip that an oracle finds with this probability is a shortfall where it is missed.
const SURELY: f64 = 0.95;

/// Arguments of `stickslip-lab ceilings`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip-second-rig draw --family grasp-wet --seed 361 --out data/wet
  stickslip-lab ceilings data/wet --per-hour 3")]
pub struct Args {
    /// Folders of the data sets, each with its key beside it, as stickslip-second-rig draws them
    #[arg(required = true)]
    pub data: Vec<PathBuf>,
    /// False alarms an hour that the oracle may raise
    #[arg(long, value_name = "RATE", default_value_t = 3.0)]
    pub per_hour: f64,
}

/// Slips of a class in a data set.
#[derive(Clone, Debug, Default, Serialize)]
struct Row {
    data: String,
    class: String,
    within_s: f64,
    /// By the predictor.
    ours: Share,
    /// Slips that the oracle finds, expected: by the motion since the gross slip began, and since before.
    since_onset: f64,
    since_before: f64,
    /// Trials missed that the oracle finds surely by the motion since the gross slip began.
    shortfall: Vec<String>,
}

#[derive(Serialize)]
struct Report {
    per_hour: f64,
    rows: Vec<Row>,
}

/// Replays, compares, prints.
///
/// # Errors
/// Where a key, a model or the data cannot be read.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let mut report = Report { per_hour: args.per_hour, rows: Vec::new() };
    let mut t =
        table(["data", "slips", "seen in time", "oracle, since onset", "oracle, since before", "shortfall"]);
    for folder in &args.data {
        let sight = Sight::told(&grasps::key_of(folder))?;
        let one = |grasp: grasps::Grasp<'_>| -> anyhow::Result<_> {
            let raised = grasp.predictions(ObjectPose::Every, true)?;
            let up = episodes(&grasp.t_s, raised.iter().map(|p| p.flags & SLIPS != 0), grasp.until_s);
            let figures = judge(grasp.truth, &up, &[], grasp.until_s);
            let class = grasp.truth.class();
            let judged =
                JUDGED.iter().position(|(_, c, _)| *c == class).filter(|_| grasp.truth.slip_s().is_some());
            Ok(judged.and_then(|k| {
                let (_, _, within_s) = *JUDGED.get(k)?;
                let chance = |from| {
                    sight.stands_out(grasp.truth, within_s, from).map(|s| found(s, within_s, args.per_hour))
                };
                let ours = if k == 0 { figures.falls } else { figures.sudden_20 };
                Some((k, ours, chance(From::Onset)?, chance(From::Before)?, grasp.trial.to_owned()))
            }))
        };
        let trials = grasps::each(folder, (None, None), one)?;
        for (k, (name, _, within_s)) in JUDGED.iter().enumerate() {
            let mut row = Row {
                data: folder.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                class: format!("{name}, within {:.0} ms", within_s * 1e3),
                within_s: *within_s,
                ..Row::default()
            };
            for (_, ours, onset, before, trial) in trials.iter().flatten().filter(|(of, ..)| *of == k) {
                row.ours.join(ours);
                row.since_onset += onset;
                row.since_before += before;
                if ours.found == 0 && *onset > SURELY {
                    row.shortfall.push(trial.clone());
                }
            }
            t.add_row([
                row.data.clone(),
                row.class.clone(),
                share(&row.ours),
                format!("{:.1}", row.since_onset),
                format!("{:.1}", row.since_before),
                row.shortfall.join(" "),
            ]);
            report.rows.push(row);
        }
    }
    output.table(&t);
    output.document(&report)
}
