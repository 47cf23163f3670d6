//! `stickslip stream DATA`: a recorded trial through the firmware, live.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use stickslip_shared::wire::{self, TelemetryReport};

use super::arguments::OneTrial;
use super::telemetry::{describe, live, told};
use crate::interrupt::Interrupt;
use stickslip_device::Device;
use stickslip_device::log::{self, Entry};
use stickslip_device::package::Package;
use stickslip_device::session::{self, Event, Outcome, Pace};
use stickslip_report::terminal::Output;

/// A run that takes so many times what its ticks take is not in real time.
const LATE: f64 = 1.05;

/// Command line of `stickslip stream`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip stream data/demo --trial linear_push-obj4-g20-v10-s0-r1 --device qemu
  stickslip stream data/demo --device serial:/dev/ttyACM0 --model model.toml
  stickslip stream data/demo --device serial:/dev/ttyACM0 --clock

The board takes one sample every 4 ms by its own clock. QEMU's clock counts instructions, 125
million a second, and is synchronised with this machine's. With --clock samples are
sent by this machine's clock, as by a host that measures, and the board is synchronised with it. Exit code 1 where the
board and the predictor on this host differ in a single bit, or (without --clock) the board did not process every sample.

A board runs the default numbers of the predictor (`stickslip predictor`): a file of `replay --predictor` does not reach it.")]
pub struct Args {
    #[command(flatten)]
    of: OneTrial,
    /// `qemu`, `qemu:FIRMWARE` or `serial:PORT`
    #[arg(long, default_value = "qemu", value_name = "DEVICE")]
    pub device: String,
    /// Record the run, as it happens; `stickslip replay --against FILE` compares it later
    #[arg(long, value_name = "FILE.mcap")]
    pub log: Option<PathBuf>,
    /// Send each sample when it is due by this machine's clock, and send the board the clock's offset and drift. Samples
    /// that come too late are counted, and not used as measurements
    #[arg(long, conflicts_with = "line_faults")]
    pub clock: bool,
    /// Damage the line on purpose: loss, repetition, reordering, garbage, drawn from this seed
    #[arg(long, value_name = "SEED")]
    pub line_faults: Option<u64>,
}

/// # Errors
/// Where data or model cannot be read, the device is not there, refuses, falls silent or
/// is cut off, or its predictions differ from this host's.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let (package, trial) = args.of.package(output)?;

    let mut device = Device::open(&args.device)?;
    output.text(describe(device.info()));
    if device.info().source != wire::SOURCE {
        output.note(
            "the firmware was built from other sources than this program: build both again (`make firmware`), \
             or their predictions may differ",
        );
    }
    output.text(format_args!("trial {trial}: {} samples", package.samples.len()));
    let mut log =
        args.log.as_deref().map(|path| start_log(path, &package, &trial, device.info())).transpose()?;
    // Without a log there is nothing to close.
    let interrupt =
        args.log.as_deref().map(|path| Interrupt::noted().map(|noted| (noted, path))).transpose()?;
    let began = Instant::now();
    let mut display = Display::new(output.progress(package.samples.len() as u64, "streaming"));
    let pace = if args.clock { Pace::Host } else { Pace::Board };
    let outcome = session::stream(&mut device, &package, pace, args.line_faults, &mut |event| {
        let now_ns = began.elapsed().as_nanos() as u64;
        interrupt.as_ref().map_or(Ok(()), |(noted, _)| noted.check())?;
        match event {
            Event::Report(report) => {
                display.show(report);
                keep(&mut log, now_ns, Entry::Telemetry(report))?;
            }
            Event::Sent(sample) => keep(&mut log, now_ns, Entry::Sample(sample))?,
        }
        Ok(())
    });
    display.bar.finish();
    let outcome = match interrupt {
        Some((noted, path)) => noted.explain(outcome, path)?,
        None => outcome?,
    };
    output.document(&outcome)?;
    report(output, &outcome);
    anyhow::ensure!(
        outcome.first_difference.is_none(),
        "board and host differ from sample {} on: firmware and host are not built from the same source",
        outcome.first_difference.unwrap_or_default()
    );
    anyhow::ensure!(
        args.clock || args.line_faults.is_some() || outcome.taken == outcome.samples,
        "the board processed {} of {} samples: the others were lost on the line or arrived too late",
        outcome.taken,
        outcome.samples
    );
    Ok(())
}

/// A log whose header holds what was sent to the board.
fn start_log(path: &Path, package: &Package, trial: &str, info: &wire::Info) -> anyhow::Result<log::Writer> {
    let (scene, model, _) = &package.model;
    let header = log::Header {
        scene: postcard::to_allocvec(scene)?,
        model: postcard::to_allocvec(model)?,
        meta: serde_json::json!({ "trial": trial, "device": "stream", "timer_hz": info.timer_hz }),
    };
    Ok(log::Writer::create(path, &header)?)
}

fn keep(log: &mut Option<log::Writer>, ns: u64, entry: Entry<'_>) -> std::io::Result<()> {
    log.as_mut().map_or(Ok(()), |writer| writer.record(ns, entry).map_err(std::io::Error::other))
}

/// Progress bar with the newest prediction below it.
struct Display {
    bar: ProgressBar,
    shown: Instant,
}

impl Display {
    /// Often enough for eyes, seldom enough for terminals.
    const INTERVAL: Duration = Duration::from_millis(80);

    fn new(bar: ProgressBar) -> Self {
        let style = ProgressStyle::with_template("[{bar:40}] {pos}/{len} samples {elapsed_precise}\n{msg}");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message("");
        Self { bar, shown: Instant::now() - Self::INTERVAL }
    }

    fn show(&mut self, report: &TelemetryReport) {
        let Some(seq) = report.sample_seq else { return };
        self.bar.set_position(u64::from(seq) + 1);
        if self.shown.elapsed() >= Self::INTERVAL && !self.bar.is_hidden() {
            self.shown = Instant::now();
            self.bar.set_message(live(report));
        }
    }
}

fn report(output: &Output, outcome: &Outcome) {
    let s = &outcome.statistics;
    let milliseconds = |cost: u32| f64::from(cost) / f64::from(outcome.timer_hz.max(1)) * 1e3;
    output.text(format_args!(
        "{} of {} samples processed; {:.2} s of the board's ticks in {:.2} s by this machine's clock",
        outcome.taken, outcome.samples, outcome.board_s, outcome.seconds
    ));
    if let Some(clock) = &outcome.clock {
        output.text(format_args!("clock sent to the board: {}", told(clock)));
        output
            .text(format_args!("{} samples came too late to be measurements of their tick", outcome.too_old));
        if outcome.too_old > 0 {
            output
                .note("`stickslip replay --against` the log of this run differs where samples were too late");
        }
    }
    output.text(format_args!("{} reports, {} lost on the line", outcome.reports, outcome.reports_lost));
    output.text(format_args!(
        "ticks missed {}, tick cost mean {:.3} ms, worst {:.3} ms; starved {}, samples lost {}, dropped {}, frames damaged {} on the board and {} on the host",
        outcome.ticks_missed,
        milliseconds(s.mean_cost),
        milliseconds(s.worst_cost),
        s.starved,
        s.samples_lost,
        s.samples_dropped,
        s.frames_damaged,
        outcome.frames_damaged
    ));
    if s.witnessed > 0 {
        output.text(format_args!(
            "the other formulation: {} steps solved by both, in {} of them a point sticks in one and slides in the other",
            s.witnessed, s.witness_apart
        ));
    }
    output.text(format_args!(
        "memory of the board: {} bytes, stack {} at the deepest",
        s.static_bytes, s.stack_bytes
    ));
    output.text(format_args!(
        "{} of {} predictions equal this host's bit for bit",
        outcome.equal, outcome.compared
    ));
    if outcome.ticks_missed > 0 {
        let period = f64::from(wire::TICK_US) * 1e-3;
        output.note(if milliseconds(s.worst_cost) > period {
            "the model is too expensive for this board: a tick took longer than its period"
        } else {
            "no tick took longer than its period, but some began late: another task delayed them"
        });
    }
    if outcome.seconds > outcome.board_s * LATE {
        output.note("not in real time: this machine is too busy or too slow for the emulated board");
    }
    if let Some(i) = &outcome.injected {
        output.text(format_args!(
            "faults injected: {} samples lost, {} damaged, {} repeated, {} reordered, {} bursts of garbage, {} reports lost",
            i.lost, i.damaged, i.repeated, i.overtaken, i.garbage, i.reports_lost
        ));
        output.text(format_args!(
            "the board counts: {} samples missing in order, {} late, {} repeated; {} frames damaged, {} too long",
            s.samples_lost, s.samples_reordered, s.samples_repeated, s.frames_damaged, s.frames_too_long
        ));
    }
    if let Some(seq) = outcome.unknown_from {
        output.note(format_args!(
            "from sample {seq} on samples and reports were lost together: nothing is compared there"
        ));
    }
}
