//! `stickslip-lab warnings DATA...`: warnings judged by what a simulator knows of slip and drop.

use std::path::{Path, PathBuf};

use serde::Serialize;

use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::alarms::{Episode, SLIPS, episodes};
use stickslip_analysis::score::warnings::{Events, Figures, MISSED_S, Share, judge, missed_s};
use stickslip_analysis::tuning::tuning_or_default;
use stickslip_report::terminal::{Output, table};
use stickslip_shared::predictor::flags;

use crate::degrade::Fault;
use crate::grasps::{self, Grasp, Unit};

/// Arguments of `stickslip-lab warnings`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip-second-rig draw --family grasp-soft --seed 7 --out data/soft
  stickslip-lab warnings data/soft --object-pose start
  stickslip-lab warnings data/soft --degrade pose-frozen")]
pub struct Args {
    /// Folders of the data sets (each holds dataset.toml)
    #[arg(required = true)]
    pub data: Vec<PathBuf>,
    /// What is true of every trial [default: DATA.key.json, else key.json beside DATA]
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Model that the predictor gets [default: model.toml in DATA or beside it, else hard contact]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// How often the object's pose is given
    #[arg(long, alias = "pose", value_enum, default_value = "every")]
    pub object_pose: ObjectPose,
    /// Give the predictor no plan
    #[arg(long)]
    pub no_plan: bool,
    /// One unit takes the trials in turn, and keeps what it learns of friction
    #[arg(long)]
    pub stays_on: bool,
    /// Spoil the samples, or the model, first
    #[arg(long, value_enum, value_name = "FAULT")]
    pub degrade: Option<Fault>,
    /// Numbers of the predictor [default: those of `stickslip predictor`]
    #[arg(long, value_name = "PREDICTOR.toml")]
    pub predictor: Option<PathBuf>,
    /// Share of the stated friction at which the threshold to compare with warns
    #[arg(long, value_name = "SHARE", default_value_t = 0.8)]
    pub threshold: f64,
}

#[derive(Serialize)]
struct Method {
    name: String,
    figures: Figures,
}

/// What the predictor says of its own doubt.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Doubts {
    /// Ticks with `UNSURE`, of all until a drop.
    ticks: Share,
    /// Slips that were missed with `UNSURE` up within 0.1 s of them, of those that were missed.
    missed: Share,
}

#[derive(Serialize)]
struct Report {
    degrade: Option<Fault>,
    results: [Method; 2],
    unsure: Doubts,
}

/// Replays, judges, and prints the table.
///
/// # Errors
/// Where the key, the model or the data cannot be read.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let mut sums = [Figures::default(), Figures::default()];
    let mut unsure = Doubts::default();
    for folder in &args.data {
        for (pair, own) in judge_set(args, folder)? {
            sums.iter_mut().zip(&pair).for_each(|(sum, figures)| sum.join(figures));
            unsure.ticks.join(&own.ticks);
            unsure.missed.join(&own.missed);
        }
    }
    let [ours, threshold] = sums;
    let methods = [
        Method { name: "predictor".into(), figures: ours },
        Method { name: format!("F_t/F_n > {} of the stated friction", args.threshold), figures: threshold },
    ];
    let mut rows = table(["", &methods[0].name, &methods[1].name]);
    type Pick = fn(&Figures) -> &Share;
    let shares: [(&str, Pick); 7] = [
        ("builds up: 100 ms ahead", |f| &f.builds_up),
        ("friction falls: 100 ms ahead", |f| &f.falls_ahead),
        ("friction falls: within 40 ms", |f| &f.falls),
        ("sudden: within 20 ms", |f| &f.sudden_20),
        ("sudden: within 40 ms", |f| &f.sudden_40),
        ("drops: warned before", |f| &f.drops),
        ("drops that slip 360 ms before: 360 ms ahead", |f| &f.drops_ahead),
    ];
    for (name, pick) in shares {
        rows.add_row([name.into(), share(pick(&methods[0].figures)), share(pick(&methods[1].figures))]);
    }
    let all = methods.iter().map(|m| rate(&m.figures.all_false())).collect::<Vec<_>>();
    rows.add_row(["false slip alarms an hour, all".to_string(), all[0].clone(), all[1].clone()]);
    for scenario in methods[0].figures.false_slip.keys() {
        let of = |m: &Method| m.figures.false_slip.get(scenario).map_or_else(|| "-".into(), rate);
        rows.add_row([format!("  scenario {scenario}"), of(&methods[0]), of(&methods[1])]);
    }
    let drops = methods.iter().map(|m| rate(&m.figures.false_drop)).collect::<Vec<_>>();
    rows.add_row(["false drop alarms an hour".to_string(), drops[0].clone(), drops[1].clone()]);
    rows.add_row(["ticks with UNSURE".into(), share(&unsure.ticks), "-".into()]);
    rows.add_row(["slips missed with UNSURE up, of all missed".into(), share(&unsure.missed), "-".into()]);
    output.table(&rows);
    output.document(&Report { degrade: args.degrade, results: methods, unsure })
}

pub(super) fn share(s: &Share) -> String {
    s.interval().map_or_else(
        || "-".into(),
        |[low, high]| {
            let percent = 100.0 * s.found as f64 / s.of as f64;
            format!("{} of {}, {percent:.0} % ({:.0} to {:.0})", s.found, s.of, 100.0 * low, 100.0 * high)
        },
    )
}

pub(super) fn rate(events: &Events) -> String {
    events.rate().map_or_else(
        || "-".into(),
        |r| {
            let [low, high] = r.interval_per_hour;
            format!("{} in {:.2} h, {:.0} ({low:.0} to {high:.0})", r.count, r.hours, r.per_hour)
        },
    )
}

/// Figures of the predictor and of the threshold in each trial.
fn judge_set(args: &Args, folder: &Path) -> anyhow::Result<Vec<([Figures; 2], Doubts)>> {
    let told = (args.key.as_deref(), args.model.as_deref());
    let tuning = tuning_or_default(args.predictor.as_deref())?;
    if args.stays_on {
        let mut unit = Unit::tuned(tuning);
        return grasps::in_turn(folder, told, |grasp| judged(args, grasp, &mut unit));
    }
    grasps::each(folder, told, |grasp| judged(args, grasp, &mut Unit::tuned(tuning)))
}

fn judged(args: &Args, mut grasp: Grasp<'_>, unit: &mut Unit) -> anyhow::Result<([Figures; 2], Doubts)> {
    if let Some(fault) = args.degrade {
        grasp.spoil(fault);
    }
    let Grasp { truth, until_s: until, .. } = grasp;
    let raised: Vec<u32> =
        grasp.predictions_by(unit, args.object_pose, !args.no_plan)?.iter().map(|p| p.flags).collect();
    let t_s = &grasp.t_s;
    let up = |mask: u32| -> Vec<Episode> { episodes(t_s, raised.iter().map(|f| f & mask != 0), until) };
    let slip = up(SLIPS);
    let ours = judge(truth, &slip, &up(flags::DROP), until);
    let ticks_in =
        |from_s: f64, to_s: f64| t_s.iter().zip(&raised).filter(move |(t, _)| (from_s..=to_s).contains(*t));
    let is_unsure = |raised: &u32| raised & flags::UNSURE != 0;
    let mut unsure = Doubts::default();
    ticks_in(0.0, until).for_each(|(_, raised)| unsure.ticks.count(is_unsure(raised)));
    if let Some(at) = missed_s(truth, &slip) {
        let about = ticks_in(at - MISSED_S, at + MISSED_S);
        unsure.missed.count(about.into_iter().any(|(_, raised)| is_unsure(raised)));
    }
    let limit = args.threshold * grasp.model.friction.finger;
    let over = episodes(t_s, grasp.ratios().map(|r| r > limit), until);
    Ok(([ours, judge(truth, &over, &over, until)], unsure))
}
