//! Streams a trial to a board, sample by sample at the board's pace.
//!
//! The board's clock rules: it takes one sample a tick, and the host keeps a few ahead of
//! what the telemetry says was taken. So neither side's clock drifts against the other's,
//! and the host's jitter (up to [`AHEAD`] ticks) does not reach the tick.

use std::time::{Duration, Instant};

use serde::Serialize;
use stickslip_shared::predictor::{HASH_START, Predictor};
use stickslip_shared::wire::sequence::{Order, Sequence};
use stickslip_shared::wire::{self, Mode, Source, StartRequest, Statistics, TelemetryReport};

use super::faults::Injected;
use super::package::Package;
use super::{Device, DeviceError};

/// Samples kept ahead of the board.
pub const AHEAD: u32 = 24;
/// Without a report for this long the board counts as silent.
const SILENCE: Duration = Duration::from_secs(5);
/// Without a sample taken for this long, while none waits on the board, those on their way
/// count as lost.
const STARVED: Duration = Duration::from_millis(500);

/// What happens in a run, in order, for a log or a display.
pub enum Event<'a> {
    /// A sample went out.
    Sent(&'a wire::Sample),
    /// A report came in.
    Report(&'a TelemetryReport),
}

/// How a run went.
#[derive(Clone, Debug, Default, schemars::JsonSchema, Serialize)]
pub struct Outcome {
    /// Samples in the trial.
    pub samples: usize,
    /// Samples that the board says it took.
    pub taken: usize,
    /// Periods that the board's tick began late by, in this run.
    pub ticks_missed: u32,
    /// What was done to the line on purpose, where it was.
    pub injected: Option<Injected>,
    /// Reports received in the run.
    pub reports: usize,
    /// Reports that the board sent and the line lost.
    pub reports_lost: u32,
    /// Damaged frames received.
    pub frames_damaged: u64,
    /// Reports that could be compared with the same predictor on this host.
    pub compared: usize,
    /// From this sample on reports and samples were lost together, so that it is not known
    /// what the board took, and nothing is compared.
    pub unknown_from: Option<u32>,
    /// Reports whose hash equals that of the same predictor on this host.
    pub equal: usize,
    /// The first sample after which they differed.
    pub first_difference: Option<u32>,
    /// Duration of the run by this machine's clock.
    pub seconds: f64,
    /// The same by the board's ticks.
    pub board_s: f64,
    /// The board's counts since its reset.
    pub statistics: Statistics,
    /// Counts a second of the costs in `statistics`.
    pub timer_hz: u32,
}

/// Loads the model, streams every sample, and compares each report with the predictor run
/// on this host over the same samples. With `faults`, a seed, the line is damaged on purpose.
///
/// # Errors
/// Where the board refuses, falls silent, restarts, or the line is cut. What happened
/// before was told to `watch`.
pub fn stream(
    device: &mut Device,
    package: &Package,
    faults: Option<u64>,
    watch: &mut dyn FnMut(Event<'_>) -> std::io::Result<()>,
) -> anyhow::Result<Outcome> {
    let count = package.samples.len();
    device.load_model(&package.bytes()?)?;
    await_model(device)?;
    device.command::<wire::SetPlan>(&package.plan)?;
    let request = StartRequest {
        source: Source::Link,
        trial: package.ordinal,
        prefill: AHEAD.min(count as u32) as u8,
        length: Some(count as u32),
    };
    let before = device.statistics()?;
    device.command::<wire::Start>(&request)?;
    device.forget_reports();
    if let Some(seed) = faults {
        device.damage_line(seed);
    }
    let mut run = Run::new(package)?;
    let mut heard = Instant::now();
    loop {
        while let Some(sample) = run.to_send() {
            device.publish::<wire::Samples>(sample.seq, sample)?;
            watch(Event::Sent(sample))?;
            run.sent += 1;
        }
        let Some(report) = device.report(Duration::from_millis(100))? else {
            if heard.elapsed() > SILENCE {
                return Err(DeviceError::Silent { last: run.last, count }.into());
            }
            continue;
        };
        heard = Instant::now();
        if report.mode == Mode::Safe {
            return Err(DeviceError::Restarted { last: run.last }.into());
        }
        watch(Event::Report(&report))?;
        run.take(&report);
        if run.ended(&report, count) {
            break;
        }
    }
    if run.last.is_none_or(|last| (last as usize) + 1 < count) {
        device.command::<wire::Stop>(&())?;
    }
    let (seconds, board_s) = run.duration();
    // Only now: in the run it would hold up the samples.
    for (seq, report) in std::mem::take(&mut run.answered) {
        run.replay(seq, &report, package);
    }
    run.close();
    let statistics = device.statistics()?;
    let outcome = Outcome {
        samples: count,
        seconds,
        board_s,
        ticks_missed: statistics.ticks_missed.saturating_sub(before.ticks_missed),
        injected: device.injected(),
        statistics,
        timer_hz: device.info().timer_hz,
        frames_damaged: device.damaged_frames(),
        ..run.outcome
    };
    Ok(outcome)
}

/// Waits until the tick took the model over.
///
/// # Errors
/// Where it does not within half a second, or the line fails.
pub fn await_model(device: &mut Device) -> Result<(), DeviceError> {
    for _ in 0..100 {
        let info = device.patient::<wire::GetInfo>(&())?;
        if info.mode != Mode::Safe {
            return Ok(());
        }
        std::thread::sleep(Duration::from_millis(4));
    }
    Err(DeviceError::NoAnswer { request: "stickslip/model/commit" })
}

struct Run<'a> {
    package: &'a Package,
    predictor: Predictor<f32>,
    hash: u32,
    /// The next sample that the predictor on this host takes.
    next: u32,
    /// Samples that it took.
    replayed: u32,
    sent: u32,
    /// Samples before this one are done with: taken or lost.
    done: u32,
    last: Option<u32>,
    /// When the board last took a sample.
    fed: Instant,
    reports: Option<Sequence>,
    /// First and last report: when they arrived, and their ticks.
    spanned: Option<[(Instant, u32); 2]>,
    /// Reports on samples, to be compared after the run.
    answered: Vec<(u32, TelemetryReport)>,
    /// The newest report: its hash covers samples whose own reports were lost.
    newest: Option<TelemetryReport>,
    outcome: Outcome,
    begun: bool,
}

impl<'a> Run<'a> {
    fn new(package: &'a Package) -> anyhow::Result<Self> {
        let (scene, model, limits) = package.model.clone();
        let mut predictor = Predictor::new(scene, model, limits)
            .map_err(|fault| anyhow::anyhow!("the predictor cannot run the model ({fault:?})"))?;
        predictor.set_trial(package.ordinal);
        predictor.set_plan(package.plan.clone());
        Ok(Self {
            package,
            predictor,
            hash: HASH_START,
            next: 0,
            replayed: 0,
            sent: 0,
            done: 0,
            last: None,
            fed: Instant::now(),
            reports: None,
            spanned: None,
            answered: Vec::new(),
            newest: None,
            outcome: Outcome::default(),
            begun: false,
        })
    }

    fn to_send(&self) -> Option<&'a wire::Sample> {
        let room = self.sent < self.done.saturating_add(AHEAD);
        room.then(|| self.package.samples.get(self.sent as usize)).flatten()
    }

    fn take(&mut self, report: &TelemetryReport) {
        self.begun |= report.mode == Mode::Running || report.sample_seq.is_some();
        if !self.begun {
            return;
        }
        self.outcome.reports += 1;
        let now = (Instant::now(), report.tick);
        self.spanned = Some([self.spanned.map_or(now, |[first, _]| first), now]);
        self.outcome.taken = self.outcome.taken.max(report.taken as usize);
        if report.taken > 0 {
            self.newest = Some(*report);
        }
        let sequence = self.reports.get_or_insert_with(|| Sequence::starting_at(report.seq));
        if let Order::Next { lost } = sequence.judge(report.seq) {
            self.outcome.reports_lost += lost;
        }
        let Some(seq) = report.sample_seq else {
            if report.waiting == 0 && self.fed.elapsed() > STARVED {
                self.done = self.sent;
                self.fed = Instant::now();
            }
            return;
        };
        self.fed = Instant::now();
        self.done = self.done.max(seq.saturating_add(1));
        self.last = Some(seq);
        self.answered.push((seq, *report));
    }

    /// The predictor here takes the samples that the board took. Where reports were lost,
    /// their samples are known only if none of those in between was lost too.
    fn replay(&mut self, seq: u32, report: &TelemetryReport, package: &Package) {
        if self.outcome.unknown_from.is_some() {
            return;
        }
        let unreported = report.taken.wrapping_sub(self.replayed).wrapping_sub(1);
        let from = seq.saturating_sub(unreported);
        if unreported > 0 && from != self.next {
            self.outcome.unknown_from = Some(self.next);
            return;
        }
        for sample in package.samples.iter().take(seq as usize + 1).skip(from as usize) {
            let prediction = self.predictor.take(sample);
            self.hash = prediction.hash(self.hash);
        }
        self.next = seq.saturating_add(1);
        self.replayed = report.taken;
        self.outcome.compared += 1;
        if self.hash == report.hash {
            self.outcome.equal += 1;
        } else if self.outcome.first_difference.is_none() {
            self.outcome.first_difference = Some(seq);
        }
    }

    /// Where the reports on the last samples were lost, a later one still has the hash over
    /// all of them.
    fn close(&mut self) {
        let count = self.package.samples.len() as u32;
        if let Some(report) = self.newest
            && report.taken == count
            && self.next < count
        {
            self.replay(count - 1, &report, self.package);
        }
    }

    /// From the first report to the last, s: by this machine's clock and by the board's.
    fn duration(&self) -> (f64, f64) {
        let Some([first, last]) = self.spanned else { return (0.0, 0.0) };
        let ticks = last.1.wrapping_sub(first.1);
        ((last.0 - first.0).as_secs_f64(), f64::from(ticks) * f64::from(wire::TICK_US) * 1e-6)
    }

    fn ended(&self, report: &TelemetryReport, count: usize) -> bool {
        let all = self.done as usize >= count;
        (self.begun && report.mode != Mode::Running) || (all && self.sent as usize >= count)
    }
}
