//! Streams a trial to a board, sample by sample at the board's pace.
//!
//! The board's clock rules: it takes one sample a tick, and the host keeps a few ahead of
//! what the telemetry says was taken. So neither side's clock drifts against the other's,
//! and the host's jitter (up to [`AHEAD`] ticks) does not reach the tick.
//!
//! By the host's clock ([`Pace::Host`]) a trial is streamed as a host that measures would: each sample when it is due, with
//! the time of its measurement, by a clock that the board was told.

use std::time::{Duration, Instant};

use serde::Serialize;
use stickslip_shared::predictor::{HASH_START, Predictor};
use stickslip_shared::wire::sequence::{Order, Sequence};
use stickslip_shared::wire::{self, Mode, Sample, Source, StartRequest, Statistics, TelemetryReport};
use stickslip_unit::host_clock::{MAX_AGE_US, WRENCH_AGE_US, as_measured};

use super::clock::{Clock, Exchange};
use super::faults::Injected;
use super::package::Package;
use super::{Device, DeviceError};

/// Samples kept ahead of the board.
pub const AHEAD: u32 = 24;
/// Without a report for this long the board counts as silent.
const SILENCE: Duration = Duration::from_secs(5);
/// Without a sample taken for this long, while none waits on the board, those on their way
/// count as lost: by this machine's clock and by the board's, either of which a busy machine may hold up.
const STARVED: Duration = Duration::from_millis(500);
const STARVED_TICKS: u32 = STARVED.as_micros() as u32 / wire::TICK_US;

/// Whose clock says when a sample goes out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// The board's: a sample is of the tick that takes it.
    #[default]
    Board,
    /// This machine's, which the board is told: a sample is of its own time, and none where that is too long ago.
    Host,
}

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
    /// The board's clock against the trial's times, as last sent to the board; null where only the board's own clock was used.
    pub clock: Option<Clock>,
    /// Samples, of those taken or left out by the board, that were too old to be a measurement of their tick.
    pub too_old: u32,
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
/// on this host over the same samples. With `faults`, a seed, the line is damaged on purpose. `pace` says whose clock rules.
///
/// # Errors
/// Where the board refuses, falls silent, restarts, or the line is cut. What happened
/// before was told to `watch`.
pub fn stream(
    device: &mut Device,
    package: &Package,
    pace: Pace,
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
        prefill: if pace == Pace::Board { AHEAD.min(count as u32) as u8 } else { 1 },
        length: Some(count as u32),
    };
    let before = device.statistics()?;
    let mut metronome = match pace {
        Pace::Board => None,
        Pace::Host => Some(Metronome::new(device)?),
    };
    device.command::<wire::Start>(&request)?;
    device.forget_reports();
    if let Some(metronome) = &mut metronome {
        // A start forgets the clock.
        metronome.begin(device)?;
    }
    if let Some(seed) = faults {
        device.damage_line(seed);
    }
    let mut run = Run::new(package, pace)?;
    let mut heard = Instant::now();
    loop {
        while let Some(sample) = run.to_send(metronome.as_ref()) {
            device.publish::<wire::Samples>(sample.seq, sample)?;
            watch(Event::Sent(sample))?;
            run.sent += 1;
        }
        let mut wait = Duration::from_millis(100);
        if let Some(metronome) = &mut metronome {
            metronome.go_on(device)?;
            wait = run.next().map_or(wait, |next| metronome.until(next).min(wait));
        }
        let Some(report) = device.report(wait)? else {
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
    // Reports that come after the run are not counted.
    let injected = device.injected();
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
        injected,
        clock: metronome.and_then(|metronome| metronome.told),
        too_old: statistics.readings_dropped.saturating_sub(before.readings_dropped),
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

/// Keeps the trial's time by this machine's clock, and the board told of it.
struct Metronome {
    /// Times of this machine count from here.
    began: Instant,
    /// The trial's time 0, s of them.
    zero_s: f64,
    exchanges: Vec<Exchange>,
    /// When times were last exchanged, and when the clock was last told.
    exchanged: Instant,
    told_at: Instant,
    told: Option<Clock>,
}

impl Metronome {
    /// Exchanges before the run.
    const FIRST: (usize, Duration) = (20, Duration::from_millis(5));
    /// Times are exchanged so often in it, ...
    const EXCHANGED: Duration = Duration::from_secs(1);
    /// ... and the clock is told so often: without a drift it is good for a minute.
    const TOLD: Duration = Duration::from_secs(10);
    /// From the start of the run to the trial's time 0, s.
    const LEAD_S: f64 = 0.02;

    fn new(device: &mut Device) -> Result<Self, DeviceError> {
        let began = Instant::now();
        let exchanges = device.exchange_clocks_since(began, Self::FIRST.0, Self::FIRST.1)?;
        let now = Instant::now();
        Ok(Self { began, zero_s: 0.0, exchanges, exchanged: now, told_at: now, told: None })
    }

    fn begin(&mut self, device: &mut Device) -> Result<(), DeviceError> {
        self.zero_s = self.began.elapsed().as_secs_f64() + Self::LEAD_S;
        self.tell(device)
    }

    fn tell(&mut self, device: &mut Device) -> Result<(), DeviceError> {
        let clock = Clock::of(&self.exchanges).map(|clock| clock.counted_from(self.zero_s));
        if let Some(clock) = &clock {
            device.tell_clock(clock)?;
        }
        (self.told, self.told_at) = (clock.or(self.told), Instant::now());
        Ok(())
    }

    fn go_on(&mut self, device: &mut Device) -> Result<(), DeviceError> {
        if self.exchanged.elapsed() >= Self::EXCHANGED {
            self.exchanges.extend(device.exchange_clocks_since(self.began, 1, Duration::ZERO)?);
            self.exchanged = Instant::now();
        }
        if self.told_at.elapsed() >= Self::TOLD { self.tell(device) } else { Ok(()) }
    }

    /// How long it is until a sample is due.
    fn until(&self, sample: &Sample) -> Duration {
        let due_s = self.zero_s + f64::from(sample.t_us) * 1e-6;
        Duration::try_from_secs_f64(due_s - self.began.elapsed().as_secs_f64()).unwrap_or_default()
    }
}

struct Run<'a> {
    package: &'a Package,
    pace: Pace,
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
    /// When the board last took a sample, and in which tick.
    fed: Instant,
    fed_tick: Option<u32>,
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
    fn new(package: &'a Package, pace: Pace) -> anyhow::Result<Self> {
        let (scene, model, limits) = package.model.clone();
        let mut predictor = Predictor::new(scene, model, limits)
            .map_err(|fault| anyhow::anyhow!("the predictor cannot run the model ({fault:?})"))?;
        predictor.set_trial(package.ordinal);
        predictor.set_plan(package.plan.clone());
        Ok(Self {
            package,
            pace,
            predictor,
            hash: HASH_START,
            next: 0,
            replayed: 0,
            sent: 0,
            done: 0,
            last: None,
            fed: Instant::now(),
            fed_tick: None,
            reports: None,
            spanned: None,
            answered: Vec::new(),
            newest: None,
            outcome: Outcome::default(),
            begun: false,
        })
    }

    fn next(&self) -> Option<&'a Sample> {
        self.package.samples.get(self.sent as usize)
    }

    fn to_send(&self, metronome: Option<&Metronome>) -> Option<&'a Sample> {
        self.next().filter(|next| match metronome {
            Some(metronome) => metronome.until(next).is_zero(),
            None => self.sent < self.done.saturating_add(AHEAD),
        })
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
        let fed_tick = *self.fed_tick.get_or_insert(report.tick);
        let Some(seq) = report.sample_seq else {
            let ticks = report.tick.wrapping_sub(fed_tick);
            if report.waiting == 0 && self.fed.elapsed() > STARVED && ticks >= STARVED_TICKS {
                self.done = self.sent;
                (self.fed, self.fed_tick) = (Instant::now(), Some(report.tick));
            }
            return;
        };
        (self.fed, self.fed_tick) = (Instant::now(), Some(report.tick));
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
        // Of a sample without a report it is not known either how old it was.
        if unreported > 0 && (from != self.next || self.pace == Pace::Host) {
            self.outcome.unknown_from = Some(self.next);
            return;
        }
        for sample in package.samples.iter().take(seq as usize + 1).skip(from as usize) {
            self.follow(sample, report.hash);
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

    /// The predictor here takes a sample, or of it what was young enough: of the three that is, the board's hash tells.
    fn follow(&mut self, sample: &Sample, told: u32) {
        if self.pace == Pace::Board {
            self.hash = self.predictor.take(sample).hash(self.hash);
            return;
        }
        let before = (self.predictor.clone(), self.hash);
        for age_us in [0, WRENCH_AGE_US + 1, MAX_AGE_US + 1] {
            (self.predictor, self.hash) = before.clone();
            self.hash = self.predictor.take(&as_measured(*sample, age_us)).hash(self.hash);
            if self.hash == told {
                break;
            }
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
