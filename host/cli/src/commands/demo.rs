//! `stickslip demo`: the whole path, each step a command that a user can type.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, ensure};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use stickslip_report::terminal::{Output, Style};

/// Command line of `stickslip demo`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip demo --out out/demo

Streams a recorded push to the firmware in QEMU, replays it on this machine, compares model
and measurement; then finds the effect that is hidden in a second data set, adds it to the
model, and streams with the better model. `make demo` builds what it needs first.")]
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
    for page in [&page, &findings, &change] {
        if Path::new(page).exists() {
            output.text(format_args!("open {page}"));
        }
    }
    output.document(&Report { hidden: &args.hidden, named, steps: steps.done })
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
            for key in ["verdict", "effects", "ambiguous_with", "error"] {
                if let Some(value) = document.get(key) {
                    self.output.text(format_args!("{key}: {value}"));
                }
            }
        }
        self.done.push(Done { command: line, result: document.clone() });
        Ok(document)
    }
}
