//! `stickslip board`: what is done with a unit beside streaming a trial to it.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, bail, ensure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::arguments::OneTrial;
use super::board_set::SetArgs;
use super::monitor;
use super::telemetry::{describe, told as in_words};
use crate::interrupt::Interrupt;
use stickslip_analysis::Progress;
use stickslip_device::clock::Clock;
use stickslip_device::error::reason;
use stickslip_device::{Device, log};
use stickslip_live::words::flag_names;
use stickslip_report::terminal::Output;
use stickslip_shared::wire::{
    self, Calibration, Port, Recalled, Sensor, Sensors, Source, StartRequest, TelemetryReport, check,
};

/// Command line of `stickslip board`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip board info --device serial:/dev/ttyACM0
  stickslip board load data/demo --model model.toml --store --device serial:/dev/ttyACM0
  stickslip board sensors --finger1 ft300 --finger2 ati:5 --device serial:/dev/ttyACM0
  stickslip board selftest

A board in QEMU starts afresh with each command.")]
pub struct Args {
    /// `qemu`, `qemu:FIRMWARE` or `serial:PORT`
    #[arg(long, global = true, default_value = "qemu", value_name = "DEVICE")]
    pub device: String,
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// What it is, what it remembers, how it last ended, what was lost, and its clock
    #[command(after_help = "Example:\n  stickslip board info --device serial:/dev/ttyACM0")]
    Info,
    /// Load scene and model of a trial's data set
    #[command(
        after_help = "Example:\n  stickslip board load data/demo --model model.toml --store --device serial:/dev/ttyACM0"
    )]
    Load(Load),
    /// Say which sensor measures which finger: gauges, ft300, ati:BASE or can
    #[command(
        after_help = "Example:\n  stickslip board sensors --finger1 ft300 --finger2 ati:5 --device serial:/dev/ttyACM0"
    )]
    Sensors(SensorArgs),
    /// Set its number, grip and its limits, and poses without a host
    #[command(
        after_help = "Example:\n  stickslip board set --unit 7 --grip-most 40 --grasp grasp.toml --store --device serial:/dev/ttyACM0"
    )]
    Set(SetArgs),
    /// Tare: the sensors' mean over the next half second becomes zero load
    #[command(after_help = "Example:\n  stickslip board tare --device serial:/dev/ttyACM0")]
    Tare,
    /// Send the matrices of a file: `[[finger]]` with `number` and `matrix`
    #[command(
        after_help = "Example:\n  stickslip board calibrate matrices.toml --device serial:/dev/ttyACM0"
    )]
    Calibrate {
        /// File of the matrices
        #[arg(value_name = "FILE.toml")]
        file: PathBuf,
    },
    /// Watch what it predicts: as `stickslip monitor` on this device, for a stated time
    #[command(after_help = "Example:\n  stickslip board monitor --seconds 60 --device serial:/dev/ttyACM0")]
    Monitor(Span),
    /// Check the line, the clock, the tick and that bad commands are refused
    #[command(after_help = "Example:\n  stickslip board selftest --device serial:/dev/ttyACM0")]
    Selftest,
    /// Record its telemetry
    #[command(
        after_help = "Example:\n  stickslip board log unit.mcap --seconds 600 --device serial:/dev/ttyACM0"
    )]
    Log {
        /// File to write
        #[arg(value_name = "FILE.mcap")]
        file: PathBuf,
        #[command(flatten)]
        span: Span,
    },
    /// Store what was set; with --start the unit begins a run on its own sensors after each start
    #[command(after_help = "Example:\n  stickslip board store --start --device serial:/dev/ttyACM0")]
    Store {
        /// Begin a run by itself
        #[arg(long)]
        start: bool,
    },
    /// Forget what was stored
    #[command(after_help = "Example:\n  stickslip board forget --device serial:/dev/ttyACM0")]
    Forget,
}

#[derive(Debug, clap::Args)]
struct Load {
    #[command(flatten)]
    of: OneTrial,
    /// Store it
    #[arg(long)]
    store: bool,
}

#[derive(Debug, clap::Args)]
struct SensorArgs {
    /// Of finger 1 (+Y side)
    #[arg(long, value_name = "SENSOR", value_parser = port)]
    finger1: Option<Port>,
    /// Of finger 2 (-Y side)
    #[arg(long, value_name = "SENSOR", value_parser = port)]
    finger2: Option<Port>,
}

#[derive(Debug, clap::Args)]
struct Span {
    /// Duration
    #[arg(long, value_name = "S", default_value_t = 10.0)]
    seconds: f64,
}

impl Span {
    fn check(&self) -> anyhow::Result<Duration> {
        ensure!((0.0..=86_400.0).contains(&self.seconds), "--seconds is {}; give 0 to 86400", self.seconds);
        Ok(Duration::from_secs_f64(self.seconds))
    }
}

fn port(text: &str) -> Result<Port, String> {
    match text.split_once(':') {
        None if text == "gauges" => Ok(Port::Gauges),
        None if text == "ft300" => Ok(Port::Ft300),
        None if text == "can" => Ok(Port::Can),
        Some(("ati", base)) => match base.parse() {
            Ok(base @ 0..=127) => Ok(Port::Ati { base }),
            _ => Err(format!("'{base}' is no base identifier: give 0 to 127")),
        },
        _ => Err(format!("'{text}' is no sensor: gauges, ft300, ati:BASE or can")),
    }
}

/// A file of matrices.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Matrices {
    finger: Vec<Matrix>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Matrix {
    /// 1 or 2.
    number: u8,
    /// N and N m a number of the sensor, row by column.
    matrix: [[f32; 6]; 6],
}

/// # Errors
/// Where files cannot be read, the device is not there, refuses or falls silent, or the self-test fails.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    if let What::Monitor(span) = &args.what {
        return monitor::run(&monitor::Args::watching(&args.device, span.seconds), output);
    }
    // Files first: a mistake in one needs no board.
    let matrices = match &args.what {
        What::Calibrate { file } => read_matrices(file)?,
        _ => Vec::new(),
    };
    let set = match &args.what {
        What::Set(set) => Some(set.checked()?),
        _ => None,
    };
    let package = match &args.what {
        What::Load(load) => Some(load.of.package(output)?.0),
        _ => None,
    };
    let mut device = Device::open(&args.device)?;
    output.text(describe(device.info()));
    match &args.what {
        // Watched above.
        What::Monitor(_) => Ok(()),
        What::Info => info(&mut device, output),
        What::Load(load) => {
            let Some(package) = package else { return Ok(()) };
            let bytes = package.bytes()?;
            output.begin("loading", bytes.len());
            device.load_model_watched(&bytes, &mut |sent| output.step(sent))?;
            output.text(format_args!("model of {} bytes loaded", bytes.len()));
            if load.store {
                stickslip_device::session::await_model(&mut device)?;
                device.command::<wire::Store>(&None)?;
                output.text("stored");
            }
            output.document(&Done { bytes: Some(bytes.len()), stored: Some(load.store), ..Done::default() })
        }
        What::Sensors(sensors) => {
            let of = [sensors.finger1, sensors.finger2].into_iter().zip(0..);
            let list: Sensors =
                of.filter_map(|(port, finger)| port.map(|port| Sensor { port, finger })).collect();
            device.command::<wire::SetSensors>(&list)?;
            output.text("sensors assigned: each needs its matrix (`stickslip board calibrate`), then a tare");
            output.document(&Done { sensors: Some(list.len()), ..Done::default() })
        }
        What::Set(_) => {
            let Some(set) = set else { return Ok(()) };
            let done = set.send(&mut device)?;
            output.text(done.join("; "));
            output.document(&Done { set: Some(done), stored: Some(set.store), ..Done::default() })
        }
        What::Tare => {
            let offsets = tare(&mut device, output)?;
            output.document(&Done { tared: Some(true), offsets: Some(offsets), ..Done::default() })
        }
        What::Calibrate { .. } => {
            output.begin("calibrating", matrices.len());
            for matrix in &matrices {
                device.command::<wire::SetCalibration>(matrix)?;
                output.step(1);
            }
            output.text(format_args!("{} matrices sent", matrices.len()));
            output.document(&Done { matrices: Some(matrices.len()), ..Done::default() })
        }
        What::Log { file, span } => {
            let for_s = span.check()?;
            let info = device.info();
            let meta =
                json!({ "device": args.device, "board": info.board.as_str(), "timer_hz": info.timer_hz });
            let mut writer = log::Writer::create(file, &log::Header { scene: vec![], model: vec![], meta })?;
            let interrupt = Interrupt::noted()?;
            let began = Instant::now();
            let reports = watch(&mut device, for_s, output, "recording (ms)", |report| {
                interrupt.check()?;
                Ok(writer.record(began.elapsed().as_nanos() as u64, log::Entry::Telemetry(report))?)
            });
            let reports = interrupt.explain(reports, file)?;
            output.text(format_args!("{reports} reports in {}", file.display()));
            output.document(&Done { reports: Some(reports), file: Some(file.clone()), ..Done::default() })
        }
        What::Selftest => selftest(&mut device, output),
        What::Store { start } => {
            let request = StartRequest { source: Source::Unit, trial: 0.0, prefill: 0, length: None };
            device.command::<wire::Store>(&start.then_some(request))?;
            output.text("stored");
            output.document(&Done { stored: Some(true), starts: Some(*start), ..Done::default() })
        }
        What::Forget => {
            device.command::<wire::Forget>(&())?;
            output.text("stored settings erased");
            output.document(&Done { stored: Some(false), ..Done::default() })
        }
    }
}

fn read_matrices(file: &std::path::Path) -> anyhow::Result<Vec<Calibration>> {
    let named = || file.display().to_string();
    let text = std::fs::read_to_string(file).with_context(named)?;
    let matrices: Matrices = toml::from_str(&text).with_context(named)?;
    let mut all = Vec::new();
    for Matrix { number, matrix } in matrices.finger {
        let Some(finger @ 0..=1) = number.checked_sub(1) else {
            bail!("{}: finger number {number}; there are 1 and 2", named());
        };
        let calibration = Calibration { finger, matrix };
        if let Err(refusal) = check::calibration(&calibration) {
            bail!("{}: finger {number}: {}", named(), reason(&refusal));
        }
        all.push(calibration);
    }
    ensure!(!all.is_empty(), "{}: no [[finger]] in it", named());
    Ok(all)
}

/// What was done on a board.
#[derive(Default, JsonSchema, Serialize)]
pub(super) struct Done {
    /// Length of the model that was loaded.
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes: Option<usize>,
    /// Whether settings are stored in the board's memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    stored: Option<bool>,
    /// Whether it predicts after a reset without a host.
    #[serde(skip_serializing_if = "Option::is_none")]
    starts: Option<bool>,
    /// What was set, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    set: Option<Vec<String>>,
    /// Sensors that were assigned.
    #[serde(skip_serializing_if = "Option::is_none")]
    sensors: Option<usize>,
    /// Whether the tare ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    tared: Option<bool>,
    /// Zero load of each finger in its sensor's numbers (converter counts, or N and N m).
    #[serde(skip_serializing_if = "Option::is_none")]
    offsets: Option<[[f32; 6]; 2]>,
    /// Calibration matrices that were sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    matrices: Option<usize>,
    /// Reports received.
    #[serde(skip_serializing_if = "Option::is_none")]
    reports: Option<usize>,
    /// Log that was written.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<PathBuf>,
}

/// What a board is.
#[derive(JsonSchema, Serialize)]
pub(super) struct About {
    /// Firmware, protocol, model and how it last started.
    info: wire::Info,
    /// Its counts since reset.
    statistics: wire::Statistics,
    /// Its clock against this machine's; null where no exchange was answered.
    clock: Option<Clock>,
}

/// What a board must do whatever is connected to it.
#[derive(JsonSchema, Serialize)]
pub(super) struct Checks {
    /// Each check and its result.
    checks: Vec<Check>,
    /// Number of checks that failed.
    failed: usize,
}

/// A check.
#[derive(JsonSchema, Serialize)]
struct Check {
    /// What must hold.
    check: &'static str,
    /// Whether it holds.
    holds: bool,
}

/// Exchanges of clocks for `info`, and the time between two.
const EXCHANGES: (usize, Duration) = (20, Duration::from_millis(20));

fn info(device: &mut Device, output: &Output) -> anyhow::Result<()> {
    let clock = Clock::of(&device.exchange_clocks(EXCHANGES.0, EXCHANGES.1)?);
    let about =
        About { info: device.request::<wire::GetInfo>(&())?, statistics: device.statistics()?, clock };
    let i = &about.info;
    output.text(format_args!("unit {}, mode {:?}, protocol {}", i.unit, i.mode, i.protocol));
    output.text(match i.recalled {
        Recalled::NoMemory => "it has no memory for settings".to_owned(),
        Recalled::Empty => "nothing is stored".to_owned(),
        Recalled::Done => "settings were taken from its memory".to_owned(),
        Recalled::OtherVersion { found } => {
            format!(
                "the stored settings are of version {found}, not {}: set and store them again",
                wire::PROTOCOL
            )
        }
        Recalled::Unusable => "the stored settings cannot be used: set and store them again".to_owned(),
        Recalled::WithoutModel => {
            "settings were taken from its memory, the model stored with them cannot be used: \
                                   load it and store again"
                .to_owned()
        }
    });
    if let Some(p) = &i.post_mortem {
        let line = if p.line > 0 { format!(", line {} of its source", p.line) } else { String::new() };
        output.text(format_args!(
            "before its last start: {:?} at {:#010x}, from {:#010x}{line}",
            p.ending, p.pc, p.lr
        ));
        for note in p.last.iter().filter(|note| note.tick > 0) {
            let end = if note.cost == 0 { "did not end".to_owned() } else { format!("cost {}", note.cost) };
            output.text(format_args!("  tick {}: flags {}, {end}", note.tick, flag_names(note.flags)));
        }
    }
    if let Some(clock) = &about.clock {
        output.text(format_args!("its clock: {}", in_words(clock)));
    }
    let s = &about.statistics;
    output.text(format_args!(
        "{} ticks, {} missed; lost: {} samples, {} reports, {} bytes; damaged: {} frames, {} readings; {} readings lost, {} dropped; {} frames not sent on the bus",
        s.ticks, s.ticks_missed, s.samples_lost, s.reports_dropped, s.bytes_lost, s.frames_damaged, s.readings_damaged,
        s.readings_lost, s.readings_dropped, s.frames_unsent
    ));
    output.document(&about)
}

/// How long a tare may take: the half second that it averages, that of a sensor which was just connected, and the line.
const TARE: Duration = Duration::from_secs(3);
/// Between two questions whether it has ended.
const TARE_ASKED: Duration = Duration::from_millis(50);

/// Has the sensors' readings of half a second taken for no load, and waits until the board says what they were.
fn tare(device: &mut Device, output: &Output) -> anyhow::Result<[[f32; 6]; 2]> {
    let before = device.request::<wire::GetTare>(&())?.ended;
    device.command::<wire::Tare>(&())?;
    let spinner = output.spinner("half a second of readings");
    let began = Instant::now();
    let state = loop {
        std::thread::sleep(TARE_ASKED);
        let state = device.request::<wire::GetTare>(&())?;
        if state.ended != before || began.elapsed() > TARE {
            break state;
        }
    };
    spinner.finish_and_clear();
    let ended = state.ended != before;
    for ((offset, waits), finger) in state.offsets.iter().zip(state.waits).zip(1..) {
        if !waits {
            let numbers = offset.map(|number| number.to_string()).join(" ");
            output.text(format_args!("finger {finger}: no load is {numbers}"));
        }
    }
    let silent: Vec<_> = state
        .waits
        .iter()
        .zip(1..)
        .filter(|(waits, _)| **waits)
        .map(|(_, f)| format!("finger {f}"))
        .collect();
    ensure!(
        ended,
        "no half second of readings within {} s from the sensor of {}: is it connected, and within its range \
         (`stickslip board info`: readings damaged, dropped)? The board goes on waiting for them",
        TARE.as_secs(),
        silent.join(" and ")
    );
    Ok(state.offsets)
}

/// Hands on every report for so long; how many there were.
fn watch(
    device: &mut Device,
    for_s: Duration,
    output: &Output,
    stage: &'static str,
    mut show: impl FnMut(&TelemetryReport) -> anyhow::Result<()>,
) -> anyhow::Result<usize> {
    let began = Instant::now();
    let (mut count, mut shown) = (0, 0);
    output.begin(stage, for_s.as_millis() as usize);
    while began.elapsed() < for_s {
        let now = began.elapsed().as_millis() as usize;
        output.step(now - shown);
        shown = now;
        if let Some(report) = device.report(Duration::from_millis(200))? {
            show(&report)?;
            count += 1;
        }
    }
    Ok(count)
}

/// What a board must do whatever is connected to it.
fn selftest(device: &mut Device, output: &Output) -> anyhow::Result<()> {
    let before = device.statistics()?;
    let mut checks: Vec<(&'static str, bool)> = Vec::new();
    let refused = device.command::<wire::SetGrip>(&f32::NAN).is_err();
    checks.push(("a grip force that is no number is refused", refused));
    let singular = Calibration { finger: 0, matrix: [[1.0; 6]; 6] };
    checks.push(("a singular matrix is refused", device.command::<wire::SetCalibration>(&singular).is_err()));
    let twice: Sensors = [Sensor { port: Port::Gauges, finger: 0 }; 2].into_iter().collect();
    checks.push((
        "two sensors for one finger are refused",
        device.command::<wire::SetSensors>(&twice).is_err(),
    ));
    let clock = Clock::of(&device.exchange_clocks(EXCHANGES.0, EXCHANGES.1)?);
    checks.push(("its clock answers", clock.is_some_and(|c| c.uncertainty_s < 0.1)));
    let reports = watch(device, Duration::from_secs(1), output, "watching (ms)", |_| Ok(()))?;
    checks.push(("it reports ten times a second or every tick", reports >= 8));
    let after = device.statistics()?;
    checks.push(("it ticks", after.ticks.saturating_sub(before.ticks) >= 200));
    checks.push(("no tick was missed", after.ticks_missed == before.ticks_missed));
    checks.push(("what was refused is counted", after.commands_refused == before.commands_refused + 3));
    checks.push((
        "nothing was lost on the line",
        after.bytes_lost == before.bytes_lost && after.frames_damaged == before.frames_damaged,
    ));
    for (what, holds) in &checks {
        output.text(format_args!("{} {what}", if *holds { "ok  " } else { "FAIL" }));
    }
    let failed = checks.iter().filter(|(_, holds)| !holds).count();
    let number = checks.len();
    let list = checks.into_iter().map(|(check, holds)| Check { check, holds }).collect();
    output.document(&Checks { checks: list, failed })?;
    ensure!(failed == 0, "{failed} of {} checks failed", number);
    Ok(())
}
