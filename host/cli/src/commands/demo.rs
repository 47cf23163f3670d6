//! `stickslip demo`: the whole path, each step a command that a user can type.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, ensure};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::grip_loop::{self, Options, Trial};
use crate::moving;
use stickslip_report::html;
use stickslip_report::plot::{Chart, Line, MEASURED, MODELS};
use stickslip_report::terminal::{Output, Style};

/// Command line of `stickslip demo`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip demo --out out/demo

Streams a recorded push to the firmware in QEMU, replays it on this machine, compares model
and measurement; then finds the effect that is hidden in a second data set, adds it to the
model, and streams with the better model; and lifts objects with the planned grip and with the
one that the board's prediction advises. `make demo` builds what it needs first.")]
pub struct Args {
    /// Recorded trials
    #[arg(long, default_value = "data/demo", value_name = "DIR")]
    pub data: PathBuf,
    /// Folder of the results
    #[arg(long, default_value = "out/demo", value_name = "DIR")]
    pub out: PathBuf,
    /// Device to stream to
    #[arg(long, default_value = "qemu", value_name = "DEVICE")]
    pub device: String,
    /// Effect hidden in the second data set
    #[arg(long, default_value = "finger_friction_mismatch", value_name = "EFFECT")]
    pub hidden: String,
}

/// # Errors
/// Where a step fails.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    std::fs::create_dir_all(&args.out).with_context(|| format!("cannot make {}", args.out.display()))?;
    let mut steps = Steps { output, done: Vec::new() };
    let data = path(&args.data);
    let log = path(&args.out.join("run.mcap"));
    let page = path(&args.out.join("comparison.html"));
    // Logs are never overwritten; the demo's own may be.
    if Path::new(&log).exists() {
        std::fs::remove_file(&log).with_context(|| format!("cannot replace {log}"))?;
    }

    steps.title(
        "A recorded push through the firmware: 250 samples a second, by the board's clock and this machine's",
    );
    steps.step(&["stream", &data, "--device", &args.device, "--log", &log])?;
    steps.title("The same samples on this machine: must agree bit for bit");
    steps.step(&["replay", &data, "--against", &log])?;
    steps.title("Model against measurement");
    steps.step(&["compare", &data, "--html", &page])?;

    let bench = path(&args.out.join("bench"));
    let base = path(&args.out.join("base.toml"));
    let better = path(&args.out.join("better.toml"));
    let findings = path(&args.out.join("diagnosis.html"));
    let change = path(&args.out.join("before-after.html"));
    steps.title("A bench on which something is missing from the model");
    steps.step(&[
        "rig",
        "--force",
        "--out",
        &bench,
        "--plan",
        "push-small",
        "--seed",
        "11",
        "--hidden",
        &args.hidden,
    ])?;
    steps.step(&["calibrate", &bench, "--out", &base])?;
    steps.title("Diagnosis: what is missing?");
    let found = steps.step(&["diagnose", &bench, "--model", &base, "--html", &findings])?;
    let named = found.get("effects").and_then(|e| e.get(0)).and_then(Value::as_str).map(str::to_owned);
    match &named {
        None => output.text("No effect was named; the report says what can be concluded."),
        Some(effect) => {
            steps.title("Add the effect, fit the model, compare the error before and after");
            steps.step(&["add", &bench, effect, "--model", &base, "--out", &better])?;
            steps.step(&["compare", &bench, "--model", &base, "--model", &better, "--html", &change])?;
            steps.title("The better model on the board");
            steps.step(&["stream", &bench, "--device", &args.device, "--model", &better])?;
        }
    }
    steps.title("Drops prevented: lifts that go wrong, with the planned grip and with the advised one");
    let lifts = path(&args.out.join("lifts.html"));
    let kept = lift(output, Path::new(&lifts))?;
    for page in [&page, &findings, &change, &lifts] {
        if Path::new(page).exists() {
            output.text(format_args!("open {page}"));
        }
    }
    output.document(&Report { hidden: &args.hidden, named, steps: steps.done, lifts: kept })
}

fn path(p: &Path) -> String {
    p.display().to_string()
}

/// What the demonstration did.
#[derive(JsonSchema, Serialize)]
pub(super) struct Report<'a> {
    /// Effect that the rig hid.
    hidden: &'a str,
    /// First effect that the diagnosis named.
    named: Option<String>,
    /// Commands, in their order.
    steps: Vec<Done>,
    /// Lifts on the rig with the loop open and closed.
    lifts: Lifts,
}

/// What became of objects that were lifted twice from the same seed.
#[derive(JsonSchema, Serialize)]
struct Lifts {
    /// Lifts, each done twice.
    trials: usize,
    /// Objects kept with the planned grip.
    kept_planned: usize,
    /// Objects kept with the advised one.
    kept_advised: usize,
    /// Kept with the planned grip, lost with the advised one.
    made_worse: usize,
    /// Largest force of a finger over the planned grip, mean over the lifts with the advised one.
    peak_over_planned_mean: f64,
    /// The same of the lift where it is largest.
    peak_over_planned_most: f64,
}

/// One object of the rig, 18 lifts: steady ones and each way of losing it. The prediction is this machine's, bit for bit
/// the board's.
fn lift(output: &Output, page: &Path) -> anyhow::Result<Lifts> {
    let trials = grip_loop::run(&Options::demonstration())?;
    let count = |of: &dyn Fn(&Trial) -> bool| trials.iter().filter(|t| of(t)).count();
    let peaks: Vec<f64> = trials.iter().map(|t| t.pair.closed.peak_n / t.pair.planned_n).collect();
    let lifts = Lifts {
        trials: trials.len(),
        kept_planned: count(&|t| t.pair.open.kept),
        kept_advised: count(&|t| t.pair.closed.kept),
        made_worse: count(&|t| t.pair.open.kept && !t.pair.closed.kept),
        peak_over_planned_mean: peaks.iter().sum::<f64>() / peaks.len().max(1) as f64,
        peak_over_planned_most: peaks.iter().copied().fold(0.0, f64::max),
    };
    output.text(format_args!(
        "kept: {} of {} with the planned grip, {} with the advised one ({} made worse); peak grip {:.1} times the planned one in the mean, {:.1} at most",
        lifts.kept_planned,
        lifts.trials,
        lifts.kept_advised,
        lifts.made_worse,
        lifts.peak_over_planned_mean,
        lifts.peak_over_planned_most
    ));
    if let Some(saved) = trials.iter().find(|t| t.saved()) {
        output.page(page, picture(saved))?;
    }
    Ok(lifts)
}

/// Beyond this the object is off the pads, m: what follows is its fall.
const GONE_M: f64 = 0.03;

/// What is drawn of a lift.
type Course<'a> = &'a dyn Fn(&[stickslip_rig::Exact]) -> Vec<(f64, f64)>;

/// A lift with both grips: where the object is in the grasp, and the grip that is commanded.
fn picture(trial: &Trial) -> String {
    let colours = [MEASURED, MODELS[1]];
    let chart = |y_label: &str, of: Course| {
        let lines = trial.exact.iter().zip(colours);
        let drawn = Chart {
            size: (760, 240),
            x_label: "time, s".to_owned(),
            y_label: y_label.to_owned(),
            lines: lines.map(|(exact, colour)| Line { points: of(exact), colour, width: 2 }).collect(),
            ..Chart::default()
        };
        html::figure(y_label, "", &format!("{y_label} over time, with both grips"), &drawn.svg())
    };
    let place = chart("object in the grasp, mm", &|exact| {
        let held = |e: &stickslip_rig::Exact| e.object.0[2] - e.gripper.0[2];
        let first = exact.first().map_or(0.0, held);
        let moved = exact.iter().map(|e| (e.t_s, held(e) - first)).take_while(|(_, m)| m.abs() < GONE_M);
        moved.map(|(t_s, m)| (t_s, m * 1e3)).collect()
    });
    let grip = chart("grip commanded, N", &|exact| exact.iter().map(|e| (e.t_s, e.grip_n)).collect());
    let sentence = format!(
        "{} ({}), lifted twice from the same seed: one object is lost, the other kept. A line that ends: the object has \
         left the pads.",
        trial.pair.label, trial.pair.scenario
    );
    html::figures_page(
        "A drop prevented",
        &sentence,
        &[("line measured", "the planned grip"), ("line m1", "the grip that the prediction advises")],
        &[
            html::figure(
                "both lifts",
                "",
                "the object in the grasp, moving, with both grips",
                &moving::picture(trial),
            ),
            place,
            grip,
        ],
    )
}

/// One command.
#[derive(JsonSchema, Serialize)]
struct Done {
    /// Its line.
    command: String,
    /// Its document.
    result: Value,
}

struct Steps<'a> {
    output: &'a Output,
    done: Vec<Done>,
}

impl Steps<'_> {
    fn title(&self, what: &str) {
        self.output.text(format_args!("\n== {what}"));
    }

    /// Runs a command of this program. Its text goes to the terminal; its JSON document is
    /// returned where it is asked for or needed (`diagnose`).
    fn step(&mut self, words: &[&str]) -> anyhow::Result<Value> {
        let line = format!("stickslip {}", words.join(" "));
        self.output.text(format_args!("$ {line}"));
        let captured = self.output.style() == Style::Json || words.first() == Some(&"diagnose");
        let mut command = Command::new(std::env::current_exe()?);
        command.args(words).stdin(Stdio::null());
        if captured {
            command.arg("--json").stdout(Stdio::piped());
        }
        let result = command.spawn()?.wait_with_output()?;
        ensure!(result.status.success(), "`{line}` failed");
        let document = if captured {
            serde_json::from_slice(&result.stdout)
                .with_context(|| format!("`{line}` printed no JSON document"))?
        } else {
            Value::Null
        };
        if words.first() == Some(&"diagnose") {
            // As the command itself says it.
            if let Some(summary) = document.get("summary").and_then(Value::as_str) {
                self.output.text(summary);
            }
        }
        self.done.push(Done { command: line, result: document.clone() });
        Ok(document)
    }
}
