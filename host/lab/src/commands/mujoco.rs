//! `stickslip-lab mujoco DATA`: MuJoCo along recorded trials, beside the own model and the
//! measurement; the paper's two complaints looked for.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, bail};
use serde::Serialize;
use stickslip_shared::model::Model;

use crate::mujoco::engine::{self, Run};
use crate::mujoco::{Setting, mjcf::mjcf};
use stickslip_analysis::channels::{COUNT, Quantity, Signals, quantity};
use stickslip_analysis::compare::tare::Tare;
use stickslip_analysis::compare::{Forces, NamedModel, Options, compare};
use stickslip_analysis::evidence::conditions::HeldOut;
use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::simulate::{Prepared, Simulated, prepare};
use stickslip_report::data;
use stickslip_report::terminal::{Output, table};

/// Arguments of `stickslip-lab mujoco`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  make mujoco-setup
  stickslip-lab mujoco data/demo --html out/mujoco.html
  stickslip-lab mujoco data/demo --trial pivot-obj4-g20-w10-o15-r1 --export out/mjcf")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model whose friction both engines use [default: 0.4, 0.25, and 2.5 where trials roll]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Only these trials
    #[arg(long = "trial", value_name = "ID")]
    pub trials: Vec<String>,
    /// Settings of the engine [default: both]
    #[arg(long, value_enum)]
    pub setting: Option<Setting>,
    /// Only write each trial as MJCF to this folder
    #[arg(long, value_name = "DIR")]
    pub export: Option<PathBuf>,
    /// Write the page of `compare` with MuJoCo as further models
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// One engine on one primitive.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Primitive.
    pub primitive: String,
    /// `hard`, `mujoco-default`, `mujoco-tuned`.
    pub engine: String,
    /// Trials.
    pub trials: usize,
    /// Root mean square errors while the gripper moves: m, rad, N, N m.
    pub errors: [f64; 4],
    /// Time of one step, s.
    pub step_s: f64,
    /// Time for 4 ms of the trial, s.
    pub sample_s: f64,
    /// Sinking along gravity before the gripper moves, mean over the trials, m.
    pub sinks_m: f64,
    /// Rotation of the object in the grasp at the end, largest trial's, rad.
    pub turns_rad: f64,
    /// The same, measured.
    pub turned_rad: f64,
    /// Share of the samples, from first contact to the end of the motion, in which an edge
    /// bears on fewer than two points.
    pub line_lost: Option<f64>,
    /// Unstable states that the engine warned of.
    pub warnings: usize,
}

struct Loaded {
    id: String,
    primitive: String,
    prepared: Prepared,
}

/// Runs the engines and reports.
///
/// # Errors
/// Where data or model cannot be read, no trial can be exported, or the engine is not there.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let index = data::open(&args.data, output)?;
    let mut base = model_or_default(args.model.as_deref())?;
    if !base.effects.is_empty() {
        output.note("MuJoCo uses the model's friction only; effects act in the stickslip model alone");
    }
    let plain = base.clone();
    let model = |primitive: &str| -> Model<f64> {
        let mut model = plain.clone();
        if args.model.is_none() && primitive == "roll" {
            model.friction.support = 2.5;
        }
        model
    };
    if let Some(id) = args.trials.iter().find(|id| index.trials.iter().all(|t| t.trial != **id)) {
        bail!("{}: no trial is named `{id}`", args.data.display());
    }
    let mut loaded = Vec::new();
    for (at, info) in index.trials.iter().enumerate() {
        if !args.trials.is_empty() && !args.trials.contains(&info.trial) {
            continue;
        }
        let Some(trial) = data::trial(&index, info, output) else { continue };
        let prepared = prepare(&index.description, &trial, at)?;
        match mjcf(&prepared, &base.friction, Setting::Tuned) {
            Ok(_) => {
                loaded.push(Loaded { id: info.trial.clone(), primitive: info.primitive.clone(), prepared })
            }
            Err(why) => output.note(format_args!("left out: trial {}: {why}", info.trial)),
        }
    }
    if loaded.is_empty() {
        bail!("{}: no trial can be exported to MuJoCo", args.data.display());
    }
    if args.model.is_none() && loaded.iter().any(|l| l.primitive == "roll") {
        base.friction.support = model("roll").friction.support;
    }
    let settings = args.setting.map_or_else(|| Setting::ALL.to_vec(), |s| vec![s]);
    if let Some(folder) = &args.export {
        return export(folder, &loaded, &model, &settings, output);
    }
    let mut rows = Vec::new();
    let mut models = Vec::new();
    let start = Instant::now();
    let own: Vec<Simulated> = loaded.iter().map(|l| l.prepared.simulate(&model(&l.primitive))).collect();
    let own_s = start.elapsed().as_secs_f64();
    let samples: usize = loaded.iter().map(|l| l.prepared.t_s.len()).sum();
    let own_step = own_s / samples as f64;
    rows.extend(summary("hard", &loaded, &own, None, |_| (own_step, own_step)));
    models.push(named("hard", "stickslip, hard contact", &base, &loaded, own));
    let mut version = String::new();
    for setting in settings {
        let bar = output.progress(loaded.len() as u64, setting.name());
        let prepared: Vec<Prepared> = loaded.iter().map(|l| l.prepared.clone()).collect();
        let friction: Vec<_> = loaded.iter().map(|l| model(&l.primitive).friction).collect();
        let results = engine::run(&prepared, &friction, setting, &|| bar.inc(1))?;
        bar.finish_and_clear();
        let mut runs: Vec<Run> = Vec::new();
        for (l, result) in loaded.iter().zip(results) {
            runs.push(result.map_err(|why| anyhow::anyhow!("trial {}: {why}", l.id))?);
        }
        version = runs.first().map_or_else(String::new, |r| r.version.clone());
        let simulated: Vec<Simulated> = runs.iter().map(|r| r.simulated.clone()).collect();
        let time = |places: &[usize]| {
            let total: f64 = places.iter().map(|i| runs[*i].step_s).sum();
            let steps: usize = places.iter().map(|i| runs[*i].steps).sum();
            let samples: usize = places.iter().map(|i| loaded[*i].prepared.t_s.len()).sum();
            (total / steps as f64, total / samples as f64)
        };
        rows.extend(summary(setting.name(), &loaded, &simulated, Some(&runs), time));
        let origin = format!("MuJoCo {version}, {}", words(setting));
        models.push(named(setting.name(), &origin, &base, &loaded, simulated));
    }
    rows.sort_by(|a, b| a.primitive.cmp(&b.primitive));
    print(&rows, &version, output);
    if let Some(path) = &args.html {
        let options = Options {
            trial: None,
            held_out: match args.trials.as_slice() {
                [] => HeldOut::Nothing,
                _ => HeldOut::Trials(loaded.iter().map(|l| l.id.clone()).collect()),
            },
            tare: Tare::BeforeContact,
            // Recorded signals have no intervals of undetermined forces.
            forces: Forces::AsReturned,
            drawn: stickslip_report::compare::DRAWN,
        };
        let comparison = compare(&index, &models, &options, output)?;
        output.page(path, stickslip_report::compare::page(&comparison, ""))?;
    }
    output.document(&rows)
}

fn words(setting: Setting) -> &'static str {
    match setting {
        Setting::Default => "default contacts, 2 ms",
        Setting::Tuned => "elliptic cone, impratio 100, contacts of 5 ms, 1 ms",
    }
}

fn named(
    name: &str,
    origin: &str,
    base: &Model<f64>,
    loaded: &[Loaded],
    simulated: Vec<Simulated>,
) -> NamedModel {
    let recorded: BTreeMap<String, Simulated> = loaded.iter().map(|l| l.id.clone()).zip(simulated).collect();
    NamedModel { recorded: Some(Arc::new(recorded)), ..NamedModel::own(name, origin, base.clone()) }
}

fn export(
    folder: &std::path::Path,
    loaded: &[Loaded],
    model: &dyn Fn(&str) -> Model<f64>,
    settings: &[Setting],
    output: &Output,
) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let mut files = Vec::new();
    for l in loaded {
        for setting in settings {
            let text =
                mjcf(&l.prepared, &model(&l.primitive).friction, *setting).map_err(anyhow::Error::msg)?;
            let path = folder.join(format!("{}-{}.xml", l.id, setting.name()));
            std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
            output.text(path.display());
            files.push(path.display().to_string());
        }
    }
    output.document(&files)
}

/// One row for each primitive. `time` gives the time of a step and of a sample.
fn summary(
    engine: &str,
    loaded: &[Loaded],
    simulated: &[Simulated],
    runs: Option<&[Run]>,
    time: impl Fn(&[usize]) -> (f64, f64),
) -> Vec<Row> {
    let mut primitives: Vec<&str> = loaded.iter().map(|l| l.primitive.as_str()).collect();
    primitives.sort_unstable();
    primitives.dedup();
    let of = |primitive: &str| -> Vec<usize> {
        (0..loaded.len()).filter(|i| loaded[*i].primitive == primitive).collect()
    };
    primitives
        .into_iter()
        .map(|primitive| {
            let places = of(primitive);
            let mut squares = [[0.0; 2]; 4];
            let mut row = Row {
                primitive: primitive.into(),
                engine: engine.into(),
                trials: places.len(),
                errors: [0.0; 4],
                step_s: 0.0,
                sample_s: 0.0,
                sinks_m: 0.0,
                turns_rad: 0.0,
                turned_rad: 0.0,
                line_lost: None,
                warnings: 0,
            };
            (row.step_s, row.sample_s) = time(&places);
            let mut line = [0.0; 2];
            for i in &places {
                let (l, s) = (&loaded[*i].prepared, &simulated[*i]);
                let moving = moving(l);
                errors(l, &s.signals, moving.clone(), &mut squares);
                let down = Vector(l);
                row.sinks_m += down.sink(&s.signals, moving.start) / places.len() as f64;
                row.turns_rad = row.turns_rad.max(turn(&s.signals, moving.end));
                row.turned_rad = row.turned_rad.max(turn(&l.measured, moving.end));
                if let Some(run) = runs.and_then(|r| r.get(*i)) {
                    row.warnings += run.warnings;
                    let edge =
                        matches!(l.scene.pusher, Some(stickslip_shared::model::PusherContact::Line { .. }));
                    let first = run.pusher_points.iter().position(|n| *n > 0);
                    if let (true, Some(first)) = (edge, first) {
                        let after = &run.pusher_points[first..moving.end.max(first)];
                        line[0] += after.iter().filter(|n| **n < 2).count() as f64;
                        line[1] += after.len() as f64;
                    }
                }
            }
            row.errors = squares.map(|[sum, count]| (sum / count).sqrt());
            row.line_lost = (line[1] > 0.0).then(|| line[0] / line[1]);
            row
        })
        .collect()
}

/// Samples in which the gripper moves.
fn moving(prepared: &Prepared) -> std::ops::Range<usize> {
    let speed = prepared.drive_speed();
    let first = speed.iter().position(|s| *s > 1e-5).unwrap_or(0);
    let last = speed.iter().rposition(|s| *s > 1e-5).map_or(speed.len(), |l| l + 1);
    first..last
}

/// Adds the squares of the errors by quantity, each wrench channel less its mean error at rest.
fn errors(
    prepared: &Prepared,
    modelled: &[Signals],
    moving: std::ops::Range<usize>,
    squares: &mut [[f64; 2]; 4],
) {
    let rest = 0..moving.start.saturating_sub(5);
    for c in 0..COUNT {
        let error = |i: usize| modelled[i][c] - prepared.measured[i][c];
        let offset = match quantity(c) {
            Quantity::Force | Quantity::Torque if !rest.is_empty() => {
                rest.clone().map(error).sum::<f64>() / rest.len() as f64
            }
            _ => 0.0,
        };
        for e in moving.clone().map(|i| error(i) - offset).filter(|e| e.is_finite()) {
            let square = &mut squares[quantity(c) as usize];
            square[0] += e * e;
            square[1] += 1.0;
        }
    }
}

/// Downwards in the gripper's axes.
struct Vector<'a>(&'a Prepared);

impl Vector<'_> {
    /// How far the object has sunk in the grasp by sample `until`.
    fn sink(&self, signals: &[Signals], until: usize) -> f64 {
        let Some(pose) = self.0.poses().first() else { return 0.0 };
        let down = pose
            .carrier
            .rotation
            .inverse_transform_vector(&nalgebra::Vector3::from(self.0.scene.gravity_m_s2))
            .try_normalize(0.0)
            .unwrap_or_default();
        let at = signals.get(until.saturating_sub(1)).or(signals.last());
        at.map_or(0.0, |row| {
            (nalgebra::Vector3::new(row[0], row[1], row[2]) - self.0.start.position_m).dot(&down)
        })
    }
}

/// Rotation of the object in the grasp at the end of the motion.
fn turn(signals: &[Signals], end: usize) -> f64 {
    let row = signals.get(end.saturating_sub(1)).or(signals.last());
    row.map_or(0.0, |r| r[3].hypot(r[4]).hypot(r[5]))
}

fn print(rows: &[Row], version: &str, output: &Output) {
    output.text(format_args!("MuJoCo {version}; RMS errors while the gripper moves"));
    let mut shown = table([
        "primitive",
        "engine",
        "force N",
        "torque N mm",
        "position mm",
        "rotation mrad",
        "us a step",
        "us for 4 ms",
        "sinks before, mm",
        "turns in the grasp (measured), rad",
        "line contact lost",
    ]);
    for r in rows {
        shown.add_row([
            r.primitive.clone(),
            r.engine.clone(),
            format!("{:.2}", r.errors[2]),
            format!("{:.1}", 1e3 * r.errors[3]),
            format!("{:.3}", 1e3 * r.errors[0]),
            format!("{:.1}", 1e3 * r.errors[1]),
            format!("{:.1}", 1e6 * r.step_s),
            format!("{:.1}", 1e6 * r.sample_s),
            format!("{:.3}", 1e3 * r.sinks_m),
            format!("{:.3} ({:.3})", r.turns_rad, r.turned_rad),
            r.line_lost.map_or_else(|| "-".into(), |l| format!("{:.0} %", 100.0 * l)),
        ]);
    }
    output.table(&shown);
    for r in rows.iter().filter(|r| r.warnings > 0) {
        output.text(format_args!(
            "- {} on {}: {} warnings of unstable states",
            r.engine, r.primitive, r.warnings
        ));
    }
}
