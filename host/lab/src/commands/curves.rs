//! `stickslip-lab curves DATA...`: warnings in time against false alarms an hour, of several detectors.

use std::path::PathBuf;

use serde::Serialize;
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::warnings::{Figures, Share};
use stickslip_report::html;
use stickslip_report::plot::{Chart, Line, MEASURED, MODELS};
use stickslip_report::terminal::{Output, table};

use super::warnings::{rate, share};
use crate::curves::{DETECTORS, Learnt, Point, Scored, at_most, curve, lessons, predictor};
use crate::grasps;

/// Arguments of `stickslip-lab curves`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip-second-rig draw --family grasp-hard --seed 101 --out data/hard
  stickslip-second-rig draw --family grasp-wet --seed 361 --out data/wet
  stickslip-lab curves data/wet --learn-from data/hard --html out/curves.html")]
pub struct Args {
    /// Folders of the data sets, each with its key beside it
    #[arg(required = true)]
    pub data: Vec<PathBuf>,
    /// Folders of the data sets that the learnt detector is trained on: other ones
    #[arg(long, required = true, num_args = 1.., value_name = "DATA")]
    pub learn_from: Vec<PathBuf>,
    /// How often the object's pose is given
    #[arg(long, alias = "pose", value_enum, default_value = "every")]
    pub object_pose: ObjectPose,
    /// Write the curves as a page
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    predictor: Figures,
    predictor_up: Share,
    threshold: Vec<Point>,
    force_rate: Vec<Point>,
    learnt: Vec<Point>,
}

type Pick = fn(&Figures) -> &Share;
const WHAT: [(&str, Pick); 5] = [
    ("builds up: 100 ms ahead", |f| &f.builds_up),
    ("friction falls: within 40 ms", |f| &f.falls),
    ("sudden: within 20 ms", |f| &f.sudden_20),
    ("sudden: within 40 ms", |f| &f.sudden_40),
    ("drops: warned before", |f| &f.drops),
];

/// Trains, replays, prints and draws.
///
/// # Errors
/// Where a key, a model or the data cannot be read, or the page cannot be written.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let mut rows = Vec::new();
    for folder in &args.learn_from {
        rows.extend(
            grasps::each(folder, (None, None), |g| Ok(lessons(&g, args.object_pose)))?.into_iter().flatten(),
        );
    }
    output.note(format!("trees: {} samples to learn from", rows.len()));
    let learnt = Learnt::from(rows)?;
    let mut trials = Vec::new();
    for folder in &args.data {
        trials.extend(grasps::each(folder, (None, None), |g| Scored::of(&g, args.object_pose, &learnt))?);
    }
    let (ours, up) = predictor(&trials);
    let curves: [Vec<Point>; 3] = std::array::from_fn(|k| curve(&trials, k));
    let most = ours.all_false().rate().map_or(0.0, |r| r.per_hour);
    let share_up = up.found as f64 / f64::max(up.of as f64, 1.0);
    let mut t = table(["", "predictor", DETECTORS[0], DETECTORS[1], DETECTORS[2]]);
    for (name, what) in WHAT {
        let best = |c: &Vec<Point>| {
            at_most(c, (most, share_up), what).map_or("-".into(), |p| share(what(&p.figures)))
        };
        let [a, b, c] = curves.each_ref().map(best);
        t.add_row([name.to_owned(), share(what(&ours)), a, b, c]);
    }
    output.text(format_args!(
        "{} trials. Each detector at its best level with no more false slip alarms than the predictor ({}), up in no \
         more of the samples ({:.1} %):",
        trials.len(),
        rate(&ours.all_false()),
        100.0 * share_up
    ));
    output.table(&t);
    if let Some(path) = &args.html {
        output.page(path, page(&ours, &curves))?;
    }
    let [threshold, force_rate, learnt] = curves;
    output.document(&Report { predictor: ours, predictor_up: up, threshold, force_rate, learnt })
}

fn page(ours: &Figures, curves: &[Vec<Point>; 3]) -> String {
    // Less than one alarm an hour is drawn as one.
    let x = |f: &Figures| f.all_false().rate().map_or(0.0, |r| r.per_hour.max(1.0).log10());
    let y = |s: &Share| 100.0 * s.found as f64 / f64::max(s.of as f64, 1.0);
    let charts = WHAT.map(|(name, what)| {
        let line = |(c, colour): (&Vec<Point>, &_)| Line {
            points: c.iter().map(|p| (x(&p.figures), y(what(&p.figures)))).collect(),
            colour: *colour,
            width: 2,
        };
        let chart = Chart {
            size: (560, 320),
            x_label: "false slip alarms an hour".into(),
            y_label: "%".into(),
            x_decades: true,
            lines: curves.iter().zip(&MODELS).map(line).collect(),
            dots: vec![(x(ours), y(what(ours)), MEASURED)],
            ..Chart::default()
        };
        html::figure(name, "", name, &chart.svg())
    });
    let legend: Vec<(String, &str)> =
        DETECTORS.iter().enumerate().map(|(k, name)| (format!("line m{k}"), *name)).collect();
    let legend: Vec<(&str, &str)> = legend.iter().map(|(class, name)| (class.as_str(), *name)).collect();
    html::figures_page(
        "stickslip-lab curves",
        "Warnings in time against false alarms, each level of a detector a point; the dot is the predictor.",
        &legend,
        &charts,
    )
}
