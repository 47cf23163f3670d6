//! `stickslip-lab reliability DATA...`: stated probabilities against what came of them.

use std::path::PathBuf;

use serde::Serialize;
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::warnings::Share;
use stickslip_report::html;
use stickslip_report::plot::{Chart, Line, MEASURED, MODELS};
use stickslip_report::terminal::{Output, table};

use super::warnings::share;
use crate::grasps;
use crate::reliability::{EDGES, SOON_S, Stated};

type Pick = fn(&Stated) -> &Share;

/// Scenarios whose slips nothing announces.
const WITHOUT_SIGN: [&str; 2] = ["d", "e"];

/// Arguments of `stickslip-lab reliability`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip-second-rig draw --family grasp-soft --seed 7 --out data/soft
  stickslip-lab reliability data/soft --html out/reliability.html")]
pub struct Args {
    /// Folders of the data sets, each with its key beside it
    #[arg(required = true)]
    pub data: Vec<PathBuf>,
    /// How often the object's pose is given
    #[arg(long, alias = "pose", value_enum, default_value = "every")]
    pub object_pose: ObjectPose,
    /// Write the diagram as a page
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

#[derive(Default, Serialize)]
struct Report {
    /// Knocks and friction that falls left out: nothing announces them.
    announced: Stated,
    all: Stated,
}

/// Replays, counts, prints and draws.
///
/// # Errors
/// Where a key, a model or the data cannot be read, or the page cannot be written.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let mut report = Report::default();
    for folder in &args.data {
        let of = |grasp: grasps::Grasp<'_>| {
            let stated = Stated::of_grasp(&grasp, &grasp.predictions(args.object_pose, true)?);
            Ok((WITHOUT_SIGN.contains(&grasp.truth.scenario.as_str()), stated))
        };
        for (sudden, stated) in grasps::each(folder, (None, None), of)? {
            report.all.join(&stated);
            if !sudden {
                report.announced.join(&stated);
            }
        }
    }
    let mut t = table(["said to hold with", "mean", "held", "held, all scenarios", "ticks that held"]);
    for ((ends, some), all) in EDGES.windows(2).zip(&report.announced.holds).zip(&report.all.holds) {
        let mean = some.mean().map_or("-".into(), |m| format!("{m:.3}"));
        let between = format!("{} to {}", ends[0], ends[1]);
        t.add_row([between, mean, share(&some.trials), share(&all.trials), share(&all.ticks)]);
    }
    let of: [(&str, Pick); 2] = [
        ("true friction above the median stated", |s| &s.above_median),
        ("true friction above the least stated (0.9875)", |s| &s.above_least),
    ];
    for (name, pick) in of {
        let none = || "-".to_owned();
        t.add_row([name.into(), none(), share(pick(&report.announced)), share(pick(&report.all)), none()]);
    }
    output.text(format_args!(
        "Each trial counts once in a bin; held: no gross slip begins within {SOON_S} s. Knocks and friction that falls are \
         in 'all scenarios' only: nothing announces them."
    ));
    output.table(&t);
    if let Some(path) = &args.html {
        output.page(path, page(&report))?;
    }
    output.document(&report)
}

fn page(report: &Report) -> String {
    let points = |s: &Stated| -> Vec<(f64, f64)> {
        let of = |b: &crate::reliability::Bin| Some((b.mean()?, b.trials.found as f64 / b.trials.of as f64));
        s.holds.iter().filter_map(of).collect()
    };
    let [first, second, ..] = MODELS;
    let chart = Chart {
        size: (420, 420),
        x_label: "probability stated".into(),
        y_label: "share that held".into(),
        lines: vec![
            Line { points: vec![(0.0, 0.0), (1.0, 1.0)], colour: first, width: 1 },
            Line { points: points(&report.announced), colour: second, width: 2 },
        ],
        dots: points(&report.announced).into_iter().map(|(x, y)| (x, y, MEASURED)).collect(),
        ..Chart::default()
    };
    html::figures_page(
        "stickslip-lab reliability",
        "Probability that a grasp holds, as stated, against the share that held; the straight line is what shall be.",
        &[("line m0", "what shall be"), ("line m1", "what came")],
        &[html::figure("Reliability", "", "Reliability", &chart.svg())],
    )
}
