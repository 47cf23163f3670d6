//! `stickslip replay DATA --trial ID`: the predictor over a recorded trial, as the board runs it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use serde::Serialize;
use stickslip_shared::predictor::{Intent, Limits, Plan, Prediction, Slip};

use super::compare::read_model;
use crate::dataset::Index;
use crate::log;
use crate::model_file::default_model;
use crate::output::{Output, table};
use crate::replay::{
    Difference, FLAGS, PREDICTION_RECORD, Span, VALIDITY, feed, first_difference, hash, read_predictions,
    replay, spans,
};
use crate::report;

/// Arguments of `stickslip replay`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip replay data/demo --trial linear_push-obj4-g20-v10-s0-r1
  stickslip replay data/demo --trial linear_push-obj4-g20-v10-s0-r1 --against run.sslog
  stickslip replay data/demo --trial linear_push-obj4-g20-v10-s0-r1 --model model.toml --html replay.html")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Trial to replay [default: the first]
    #[arg(long, value_name = "ID")]
    pub trial: Option<String>,
    /// Model to predict with [default: hard contact, friction 0.40 (fingers), 0.25 (pusher),
    /// 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Write the predictions to a log
    #[arg(long, value_name = "FILE.sslog")]
    pub log: Option<PathBuf>,
    /// Compare with the predictions in this log bit for bit
    #[arg(long, value_name = "FILE.sslog")]
    pub against: Option<PathBuf>,
    /// Write a page with plots of the predictions
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// The JSON document `stickslip-replay/1`.
#[derive(Clone, Debug, Serialize)]
pub struct Document {
    /// Always `stickslip-replay/1`.
    pub schema: &'static str,
    /// Id.
    pub trial: String,
    /// Ticks run.
    pub ticks: usize,
    /// Hash of every output word, hexadecimal.
    pub hash: String,
    /// When each flag was up.
    pub flags: Vec<Span>,
    /// When each doubt was up.
    pub doubts: Vec<Span>,
    /// Largest values.
    pub prediction: Summary,
    /// How the solver fared.
    pub solver: Solver,
    /// Plan derived from the trial.
    pub plan: Vec<PlanRow>,
    /// Where `--against` was given.
    pub against: Option<Against>,
}

/// Largest predicted values.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// By the model, either finger, while measured or predicted.
    pub peak_utilisation: f32,
    /// By the measured wrenches; `null`: not measured.
    pub peak_measured_utilisation: Option<f32>,
    /// m/s
    pub peak_slip_m_s: f32,
    /// m
    pub peak_sag_m: f32,
    /// rad
    pub peak_rotation_rad: f32,
    /// First time at which a slip was announced before it came, s.
    pub first_warning_s: Option<f64>,
    /// First time at which a finger slips, s.
    pub first_slip_s: Option<f64>,
}

/// Ticks by the solver's status, and the cost.
#[derive(Clone, Debug, Serialize)]
pub struct Solver {
    /// By name of the status.
    pub ticks: BTreeMap<&'static str, usize>,
    /// Largest momentum error, N.
    pub worst_residual_n: f32,
    /// Newton steps, mean over the ticks.
    pub mean_iterations: f64,
    /// Newton steps, most in a tick.
    pub most_iterations: u16,
}

/// A segment of the plan.
#[derive(Clone, Debug, Serialize)]
pub struct PlanRow {
    /// s
    pub from_s: f32,
    /// s
    pub duration_s: f32,
    /// World axes.
    pub velocity_m_s: [f32; 3],
    /// World axes.
    pub angular_rad_s: [f32; 3],
    /// N
    pub grip_n: f32,
    /// `hold`, `slide`, `pivot`, `free`.
    pub intent: &'static str,
}

/// Agreement with a log.
#[derive(Clone, Debug, Serialize)]
pub struct Against {
    /// The log.
    pub file: String,
    /// Predictions in it.
    pub predictions: usize,
    /// Ticks of the replay for which the log has none.
    pub missing: usize,
    /// Hash over the logged predictions, hexadecimal.
    pub hash: String,
    /// Every logged prediction equals the replay's, bit for bit.
    pub equal: bool,
    /// The first that differs.
    pub first_difference: Option<Difference>,
    /// Damage of the log.
    pub lost: Option<String>,
}

/// Replays and reports.
///
/// # Errors
/// Where data, model or log cannot be read, or the log differs from the replay.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let index = Index::open(&args.data)?;
    let (at, info) = index.find(args.trial.as_deref())?;
    let trial = index.read_trial(info)?;
    let model = match &args.model {
        Some(path) => read_model(path)?.model,
        None => default_model(),
    };
    let feed = feed(&index.description, &trial)?;
    let replayed = replay(&index.description, &trial, &model, Limits::default(), at)?;
    if let Some(path) = &args.log {
        write_log(path, &feed.scene, &model, &info.trial, &feed.samples, &replayed.predictions)?;
    }
    let t_s: Vec<f64> = trial.samples.iter().map(|s| s.t_s).collect();
    let against = match &args.against {
        Some(path) => Some(against(path, &replayed.predictions)?),
        None => None,
    };
    let document = Document {
        schema: "stickslip-replay/1",
        trial: info.trial.clone(),
        ticks: replayed.predictions.len(),
        hash: format!("{:08x}", replayed.hash),
        flags: spans(&t_s, &replayed.predictions, &FLAGS, |p| p.flags),
        doubts: spans(&t_s, &replayed.predictions, &VALIDITY, |p| p.validity),
        prediction: summary(&t_s, &replayed.predictions),
        solver: solver(&replayed.predictions),
        plan: plan_rows(&feed.plan),
        against,
    };
    if let Some(path) = &args.html {
        output.page(path, report::replay::page(&document, &t_s, &replayed.predictions))?;
    }
    print(&document, output);
    output.document(&document)?;
    if let Some(a) = &document.against {
        anyhow::ensure!(a.equal, "{}: the log differs from the replay", a.file);
    }
    Ok(())
}

fn write_log(
    path: &Path,
    scene: &stickslip_shared::model::Scene<f32>,
    model: &stickslip_shared::model::Model<f64>,
    trial: &str,
    samples: &[stickslip_shared::wire::Sample],
    predictions: &[Prediction],
) -> anyhow::Result<()> {
    let header = log::Header {
        scene: postcard::to_allocvec(scene)?,
        model: postcard::to_allocvec(&model.cast::<f32>())?,
        meta: serde_json::json!({ "trial": trial, "device": "host replay" }),
    };
    let mut writer = log::Writer::create(path, &header)?;
    for (sample, prediction) in samples.iter().zip(predictions) {
        let ns = u64::from(sample.t_us) * 1000;
        writer.record(PREDICTION_RECORD, ns, &postcard::to_allocvec(prediction)?)?;
    }
    Ok(writer.sync()?)
}

fn against(path: &Path, predictions: &[Prediction]) -> anyhow::Result<Against> {
    let contents = log::read(path)?;
    let logged = read_predictions(&contents.records)
        .with_context(|| format!("{}: a prediction in it cannot be read", path.display()))?;
    anyhow::ensure!(!logged.is_empty(), "{}: the log holds no predictions", path.display());
    let first_difference = first_difference(&logged, predictions);
    Ok(Against {
        file: path.display().to_string(),
        predictions: logged.len(),
        missing: predictions.len().saturating_sub(logged.len()),
        hash: format!("{:08x}", hash(logged.iter().map(|(_, p)| p))),
        equal: first_difference.is_none(),
        first_difference,
        lost: contents.loss(),
    })
}

fn summary(t_s: &[f64], predictions: &[Prediction]) -> Summary {
    let fingers = || predictions.iter().flat_map(|p| p.finger.iter());
    let peak =
        |values: &mut dyn Iterator<Item = f32>| values.filter(|x| x.is_finite()).fold(0.0f32, f32::max);
    let measured =
        fingers().filter_map(|f| f.measured_utilisation).filter(|u| u.is_finite()).reduce(f32::max);
    let slips = |p: &Prediction| p.finger.iter().any(|f| f.slip == Slip::Now);
    let warns = |p: &Prediction| p.finger.iter().any(|f| matches!(f.slip, Slip::In(_)));
    let when = |test: &dyn Fn(&Prediction) -> bool| {
        t_s.iter().zip(predictions).find(|(_, p)| test(p)).map(|(t, _)| *t)
    };
    Summary {
        peak_utilisation: peak(&mut fingers().map(|f| f.peak_utilisation)),
        peak_measured_utilisation: measured,
        peak_slip_m_s: peak(&mut fingers().map(|f| f.slip_speed_m_s)),
        peak_sag_m: peak(&mut predictions.iter().map(|p| p.sag_m)),
        peak_rotation_rad: peak(&mut predictions.iter().map(|p| p.rotation_rad)),
        first_warning_s: when(&warns),
        first_slip_s: when(&slips),
    }
}

fn solver(predictions: &[Prediction]) -> Solver {
    let mut ticks = BTreeMap::new();
    for p in predictions {
        *ticks.entry(p.solver_status.name()).or_insert(0) += 1;
    }
    let sum: f64 = predictions.iter().map(|p| f64::from(p.solver_iterations)).sum();
    Solver {
        ticks,
        worst_residual_n: predictions.iter().map(|p| p.solver_residual_n).fold(0.0, f32::max),
        mean_iterations: sum / predictions.len().max(1) as f64,
        most_iterations: predictions.iter().map(|p| p.solver_iterations).max().unwrap_or(0),
    }
}

fn plan_rows(plan: &Plan) -> Vec<PlanRow> {
    let mut from_s = plan.start_s;
    plan.segments
        .iter()
        .map(|s| {
            let row = PlanRow {
                from_s,
                duration_s: s.duration_s,
                velocity_m_s: s.velocity_m_s,
                angular_rad_s: s.angular_rad_s,
                grip_n: s.grip_n,
                intent: match s.intent {
                    Intent::Hold => "hold",
                    Intent::Slide => "slide",
                    Intent::Pivot => "pivot",
                    Intent::Free => "free",
                },
            };
            from_s += s.duration_s;
            row
        })
        .collect()
}

fn print(d: &Document, output: &Output) {
    output.text(format_args!("trial {}: {} ticks, hash {}", d.trial, d.ticks, d.hash));
    let p = &d.prediction;
    let time = |t: Option<f64>| t.map_or_else(|| "never".to_owned(), |t| format!("at {t:.3} s"));
    let measured = p.peak_measured_utilisation.map_or_else(|| "not measured".into(), |u| format!("{u:.2}"));
    output.text(format_args!(
        "friction used: at most {:.2} by the model, {measured} by the sensors; slip announced {}, begins {}, up to \
         {:.1} mm/s; sag at most {:.2} mm, rotation {:.1} mrad",
        p.peak_utilisation,
        time(p.first_warning_s),
        time(p.first_slip_s),
        p.peak_slip_m_s * 1e3,
        p.peak_sag_m * 1e3,
        p.peak_rotation_rad * 1e3
    ));
    let ticks: Vec<String> =
        d.solver.ticks.iter().map(|(k, n)| format!("{} {n}", k.replace('_', " "))).collect();
    output.text(format_args!(
        "solver: {}; momentum error at most {:.1e} N; Newton steps {:.1} a tick, at most {}",
        ticks.join(", "),
        d.solver.worst_residual_n,
        d.solver.mean_iterations,
        d.solver.most_iterations
    ));
    let mut shown = table(["flag", "rises, s", "falls, s", "ticks"]);
    for s in d.flags.iter().chain(&d.doubts).take(40) {
        let falls = s.falls_s.map_or_else(|| "-".to_owned(), |t| format!("{t:.3}"));
        shown.add_row([s.flag.to_owned(), format!("{:.3}", s.rises_s), falls, s.ticks.to_string()]);
    }
    output.table(&shown);
    let all = d.flags.len() + d.doubts.len();
    if all > 40 {
        output.text(format_args!("{} more in the JSON document", all - 40));
    }
    if let Some(a) = &d.against {
        match &a.first_difference {
            None => output.text(format_args!(
                "{}: {} predictions, all equal bit for bit{}",
                a.file,
                a.predictions,
                if a.missing > 0 {
                    format!("; {} ticks are not in the log", a.missing)
                } else {
                    String::new()
                }
            )),
            Some(f) => output.text(format_args!(
                "{}: tick {} differs first, in output word {}: log {:08x}, replay {:08x}",
                a.file, f.tick, f.word, f.logged, f.replayed
            )),
        }
        if let Some(lost) = &a.lost {
            output.text(format_args!("{}: {lost}", a.file));
        }
    }
}
