//! `stickslip score DATA`: how early slip and drop are predicted, and how many alarms are false.

use std::path::PathBuf;

use serde::Serialize;
use stickslip_shared::predictor::Limits;

use super::compare::read_model;
use crate::dataset::Index;
use crate::model_file::default_model;
use crate::output::{Output, table};
use crate::report;
use crate::score::calibration::{Calibration, Stated};
use crate::score::figures::{Class, Row, rows};
use crate::score::{Judged, Method, ObjectPose, Scored, judge};

/// Command line of `stickslip score`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip rig --plan slip-hours --hours 0.5 --out data/hours
  stickslip score data/hours
  stickslip score data/hours --model model.toml --object-pose start --html score.html")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model to predict with [default: hard contact, friction 0.40 (fingers), 0.25 (pusher),
    /// 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// How often the predictor is given the object's measured pose
    #[arg(long, value_enum, default_value = "every")]
    pub object_pose: ObjectPose,
    /// Threshold of the baseline on tangential over normal force
    #[arg(long, default_value_t = 0.3, value_name = "RATIO")]
    pub ratio: f64,
    /// Threshold of the baseline on the tangential force's rate, N/s
    #[arg(long, default_value_t = 20.0, value_name = "N/S")]
    pub rate: f64,
    /// Write a page with the table and plots
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// The JSON document `stickslip-score/1`.
#[derive(Clone, Debug, Serialize)]
pub struct Document {
    /// Always `stickslip-score/1`.
    pub schema: &'static str,
    /// Folder.
    pub data: PathBuf,
    /// Trials scored.
    pub trials: usize,
    /// Trials passed over: name, why.
    pub passed_over: Vec<(String, String)>,
    /// What is worth knowing of the tables.
    pub warnings: Vec<String>,
    /// Time scored, h.
    pub hours: f64,
    /// See [`ObjectPose`].
    pub object_pose: ObjectPose,
    /// Share of ticks at which the predictor does not trust its sample.
    pub doubtful_share: f64,
    /// One for each kind of event and method.
    pub rows: Vec<Row>,
    /// One for each predictor.
    pub calibration: Vec<Calibration>,
}

/// Scores and reports.
///
/// # Errors
/// Where data or model cannot be read.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    for (option, value) in [("--ratio", args.ratio), ("--rate", args.rate)] {
        anyhow::ensure!(value > 0.0 && value.is_finite(), "{option} is {value}; give a number above zero");
    }
    let index = Index::open(&args.data)?;
    let model = match &args.model {
        Some(path) => read_model(path)?.model,
        None => default_model(),
    };
    let pose = args.object_pose;
    let mut methods =
        vec![Method::Predictor { name: "stickslip".into(), model: Box::new(model.clone()), pose }];
    if !model.effects.is_empty() {
        let mut plain = model;
        plain.effects.clear();
        plain.formulas.clear();
        methods.push(Method::Predictor {
            name: "without added effects".into(),
            model: Box::new(plain),
            pose,
        });
    }
    methods.extend([Method::Ratio(args.ratio), Method::Rate(args.rate)]);
    let bar = output.progress(index.trials.len() as u64, "scoring");
    let Scored { judged, passed_over, warnings } = judge(&index, &methods, Limits::default(), || bar.inc(1))?;
    bar.finish_and_clear();
    if judged.is_empty() {
        let why = passed_over.first().map_or("the data set lists no trials", |(_, why)| *why);
        anyhow::bail!("{}: no trial can be scored: {why}", args.data.display());
    }
    let names: Vec<String> = methods.iter().map(Method::name).collect();
    let ticks: usize = judged.iter().map(|j| j.alarms[0].ticks).sum();
    let doubtful: usize = judged.iter().map(|j| j.alarms[0].doubtful).sum();
    let calibration = methods
        .iter()
        .enumerate()
        .filter(|(_, method)| matches!(method, Method::Predictor { .. }))
        .map(|(m, method)| {
            let mut all = Stated::default();
            judged.iter().filter_map(|j| j.alarms.get(m)).for_each(|a| all.add(&a.stated));
            all.figures(&method.name())
        })
        .collect();
    // Thresholds on forces say nothing of sag and rotation.
    let mut told = rows(&judged, &names);
    told.retain(|r| {
        let predicts = |m: &Method| m.name() == r.method && matches!(m, Method::Predictor { .. });
        r.class != Class::Moved || methods.iter().any(predicts)
    });
    let document = Document {
        schema: "stickslip-score/1",
        data: args.data.clone(),
        trials: judged.len(),
        passed_over: passed_over.into_iter().map(|(trial, why)| (trial, why.to_owned())).collect(),
        warnings: warnings.iter().map(ToString::to_string).collect(),
        hours: judged.iter().map(|j: &Judged| j.truth.until_s).sum::<f64>() / 3600.0,
        object_pose: pose,
        doubtful_share: doubtful as f64 / ticks.max(1) as f64,
        rows: told,
        calibration,
    };
    if let Some(path) = &args.html {
        output.page(path, report::score::page(&document))?;
    }
    print(&document, output);
    output.document(&document)
}

/// What the table's columns mean.
pub const LEGEND: &str = "found: an alarm was up at onset or began at most 0.1 s later; in time: slip that builds up 100 ms ahead, sudden or \
     intended slip at most 20 ms after its onset, sag and rotation and drop before they happen, a foreseeable drop \
     360 ms ahead; lead: onset minus the alarm's beginning, negative where it is late; false/h: alarms an hour \
     without an event of the kind (slip: in trials that are meant to hold); near/h: alarms with a smaller event (a motion short of a slip; for sag, a slip; for a \
     drop, a slip that ended in time)";

/// Trials passed over that are named.
const NAMED: usize = 3;

fn print(d: &Document, output: &Output) {
    for warning in &d.warnings {
        output.note(warning);
    }
    for (trial, why) in d.passed_over.iter().take(NAMED) {
        output.note(format_args!("trial {trial} not scored: {why}"));
    }
    if d.passed_over.len() > NAMED {
        output
            .note(format_args!("{} more trials not scored (--json lists all)", d.passed_over.len() - NAMED));
    }
    output.text(format_args!(
        "{}: {} trials, {:.2} h scored; sample unusable in {:.2} % of the ticks\n",
        d.data.display(),
        d.trials,
        d.hours,
        d.doubtful_share * 100.0
    ));
    let mut shown = table([
        "event",
        "method",
        "events",
        "found",
        "in time",
        "lead 5/50/95 %, ms",
        "false/h",
        "near/h",
        "onset error, ms",
    ]);
    for r in d.rows.iter().filter(|r| r.events > 0) {
        shown.add_row(cells(r));
    }
    output.table(&shown);
    output.text(format_args!("\n{LEGEND}"));
    for c in &d.calibration {
        output.text(format_args!("\n{}", c.method));
        let stated = [
            ("stated utilisation and slip within 0.1 s", utilisation(c)),
            ("stated time left and actual 5/50/95 %", time_left(c)),
        ];
        for (of, shown) in stated {
            if !shown.is_empty() {
                output.text(format_args!("  {of}: {}", shown.join("; ")));
            }
        }
        if let Some([low, middle, high]) = c.grip {
            output.text(format_args!(
                "  grip at which it slipped over the grip stated as just enough, 5/50/95 %: {low:.2} / {middle:.2} / \
                 {high:.2} ({} slips)",
                c.grips
            ));
        }
    }
}

/// Stated utilisation and how often slip followed within 0.1 s.
pub fn utilisation(c: &Calibration) -> Vec<String> {
    c.utilisation
        .iter()
        .map(|b| format!("{:.1}-{:.1} {:.2} %", b.stated[0], b.stated[1], 100.0 * b.actual[0]))
        .collect()
}

/// Stated time left and the actual one.
pub fn time_left(c: &Calibration) -> Vec<String> {
    let ms = |s: &f64| format!("{:.0}", s * 1e3);
    c.time_left
        .iter()
        .map(|b| {
            let actual: Vec<String> = b.actual.iter().map(ms).collect();
            format!("{}-{} ms stated, {} ms", ms(&b.stated[0]), ms(&b.stated[1]), actual.join("/"))
        })
        .collect()
}

/// A row as text.
pub fn cells(r: &Row) -> [String; 9] {
    let percent = |n: usize| format!("{:.1} %", 100.0 * n as f64 / r.events.max(1) as f64);
    let per_hour = |f: Option<f64>| f.map_or_else(|| "-".into(), |f| format!("{f:.1}"));
    let ms = |q: Option<[f64; 3]>| {
        q.map_or_else(|| "-".into(), |q| q.map(|x| format!("{:.0}", x * 1e3)).join(" / "))
    };
    [
        r.class.name().into(),
        r.method.clone(),
        r.events.to_string(),
        percent(r.found),
        percent(r.in_time),
        ms(r.lead_s),
        per_hour(r.false_alarms_per_hour),
        per_hour(r.near_alarms_per_hour),
        ms(r.onset_error_s),
    ]
}
