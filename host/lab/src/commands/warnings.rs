//! `stickslip-lab warnings DATA...`: warnings judged by what a simulator knows of slip and drop.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rayon::prelude::*;
use serde::Serialize;

use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::replay::feed;
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::alarms::{Episode, episodes};
use stickslip_analysis::score::warnings::{Events, Figures, Key, MISSED_S, Share, judge, missed_s, until_s};
use stickslip_data::Index;
use stickslip_report::terminal::{Output, table};
use stickslip_shared::predictor::{Limits, Plan, Predictor, flags};

use crate::degrade::Fault;

/// Arguments of `stickslip-lab warnings`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip-second-rig draw --family grasp-soft --seed 7 --out data/soft
  stickslip-lab warnings data/soft --pose start
  stickslip-lab warnings data/soft --degrade pose-frozen")]
pub struct Args {
    /// Folders of the data sets (each holds dataset.toml)
    #[arg(required = true)]
    pub data: Vec<PathBuf>,
    /// What is true of every trial [default: DATA.key.json, else key.json beside DATA]
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Model that is told [default: model.toml in DATA or beside it, else hard contact]
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// How often the object's pose is given
    #[arg(long, value_enum, default_value = "every")]
    pub pose: ObjectPose,
    /// Give the predictor no plan
    #[arg(long)]
    pub no_plan: bool,
    /// Spoil the samples, or the model, first
    #[arg(long, value_enum, value_name = "FAULT")]
    pub degrade: Option<Fault>,
    /// Share of the friction told at which the threshold to compare with warns
    #[arg(long, value_name = "SHARE", default_value_t = 0.8)]
    pub threshold: f64,
}

/// Samples whose forces the threshold averages.
const SMOOTHED: usize = 10;

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
        Method { name: format!("F_t/F_n > {} of the friction told", args.threshold), figures: threshold },
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

fn share(s: &Share) -> String {
    s.interval().map_or_else(
        || "-".into(),
        |[low, high]| {
            let percent = 100.0 * s.found as f64 / s.of as f64;
            format!("{} of {}, {percent:.0} % ({:.0} to {:.0})", s.found, s.of, 100.0 * low, 100.0 * high)
        },
    )
}

fn rate(events: &Events) -> String {
    events.rate().map_or_else(
        || "-".into(),
        |r| {
            let [low, high] = r.interval_per_hour;
            format!("{} in {:.2} h, {:.0} ({low:.0} to {high:.0})", r.count, r.hours, r.per_hour)
        },
    )
}

/// The key beside a data set.
fn key_of(folder: &Path) -> PathBuf {
    let mut name = folder.as_os_str().to_owned();
    name.push(".key.json");
    let own = PathBuf::from(name);
    if own.exists() { own } else { folder.join("../key.json") }
}

/// Figures of the predictor and of the threshold in each trial.
fn judge_set(args: &Args, folder: &Path) -> anyhow::Result<Vec<([Figures; 2], Doubts)>> {
    let path = args.key.clone().unwrap_or_else(|| key_of(folder));
    let text =
        std::fs::read(&path).with_context(|| format!("{}: cannot be read; state --key", path.display()))?;
    let key: Key = serde_json::from_slice(&text)
        .with_context(|| format!("{}: not a key of simulated grasps", path.display()))?;
    let index = Index::open(folder)?;
    let beside = [folder.join("model.toml"), folder.join("../model.toml")];
    let told = args.model.as_ref().or_else(|| beside.iter().find(|p| p.exists()));
    let model = model_or_default(told.map(PathBuf::as_path))?;
    index
        .trials
        .par_iter()
        .enumerate()
        .map(|(ordinal, info)| {
            let truth = key
                .trials
                .get(&info.trial)
                .with_context(|| format!("{}: no entry for trial '{}'", path.display(), info.trial))?;
            let trial = index.read_trial(info)?;
            let mut feed = feed(&index.description, &trial)?;
            let first = trial.samples.iter().find_map(|s| s.grip_cmd_n).or(info.grip_n).unwrap_or(0.0);
            // The plan tells the set-point at the start: that a grip decays is not in it.
            feed.plan.segments.iter_mut().for_each(|s| s.grip_n = first as f32);
            let mut model = model.clone();
            if let Some(fault) = args.degrade {
                fault.apply(&mut feed.samples, &mut model);
            }
            let mut predictor = Predictor::new(feed.scene.clone(), model.cast(), Limits::default())
                .map_err(|why| anyhow::anyhow!("trial {}: scene or model refused: {why:?}", info.trial))?;
            predictor.set_plan(if args.no_plan { Plan::default() } else { feed.plan.clone() });
            predictor.set_trial(ordinal as f32);
            let t_s: Vec<f64> = feed.samples.iter().map(|s| f64::from(s.t_us) * 1e-6).collect();
            let mut started = false;
            let raised: Vec<u32> = feed
                .samples
                .iter()
                .map(|s| {
                    let mut sample = *s;
                    if args.pose == ObjectPose::Start && started {
                        sample.object = None;
                    }
                    started |= s.object.is_some();
                    predictor.take(&sample).flags
                })
                .collect();
            let until = until_s(truth, &t_s);
            let up =
                |mask: u32| -> Vec<Episode> { episodes(&t_s, raised.iter().map(|f| f & mask != 0), until) };
            let slips = flags::SLIP_1 | flags::SLIP_2 | flags::SLIP_AHEAD_1 | flags::SLIP_AHEAD_2;
            let slip = up(slips);
            let ours = judge(truth, &slip, &up(flags::DROP), until);
            let ticks_in = |from_s: f64, to_s: f64| {
                t_s.iter().zip(&raised).filter(move |(t, _)| (from_s..=to_s).contains(*t))
            };
            let is_unsure = |raised: &u32| raised & flags::UNSURE != 0;
            let mut unsure = Doubts::default();
            ticks_in(0.0, until).for_each(|(_, raised)| unsure.ticks.count(is_unsure(raised)));
            if let Some(at) = missed_s(truth, &slip) {
                unsure
                    .missed
                    .count(ticks_in(at - MISSED_S, at + MISSED_S).any(|(_, raised)| is_unsure(raised)));
            }
            let limit = args.threshold * model.friction.finger;
            let over = episodes(&t_s, ratios(&feed.samples).map(|r| r > limit), until);
            Ok(([ours, judge(truth, &over, &over, until)], unsure))
        })
        .collect()
}

/// Tangential over normal force of both fingers, averaged.
fn ratios(samples: &[stickslip_shared::wire::Sample]) -> impl Iterator<Item = f64> + '_ {
    (0..samples.len()).map(|i| {
        let near = samples.get(i.saturating_sub(SMOOTHED - 1)..=i).unwrap_or(&[]);
        let sum = near.iter().fold([0.0f64; 3], |mut sum, s| {
            if let [Some(a), Some(b)] = s.finger {
                sum[0] += f64::from(a[0] + b[0]);
                sum[1] += f64::from(a[2] + b[2]);
                sum[2] += f64::from(a[1].abs() + b[1].abs());
            }
            sum
        });
        if sum[2] > 0.0 { sum[0].hypot(sum[1]) / sum[2] } else { 0.0 }
    })
}
