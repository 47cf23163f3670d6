//! The tick: every 4 ms take commands, take a sample, predict, report. It waits for the
//! clock only, and it alone feeds the watchdog.

use embassy_time::{Duration, Instant, Timer};
use stickslip_shared::predictor::{HASH_START, Prediction, Predictor, flags, validity};
use stickslip_shared::wire::{Mode, Sample, Source, StartRequest, TICK_US, TelemetryReport};

use crate::board::Gauges;
use crate::board::current::{Watchdog, timer};
use crate::gauges::GaugeSource;
use crate::queues::{COMMANDS, Command, MODEL_CRC, REPORTS, SAMPLES, SPARE, set_mode};
use crate::slot::Slot;
use crate::source::{FingerSource, LinkSource, Next};
use crate::stats::COUNTERS;

/// Outside a run a report goes out every this many ticks: ten a second.
const IDLE_REPORT_TICKS: u32 = 25;

/// A run in progress.
struct Run {
    request: StartRequest,
    link: LinkSource,
}

/// State of the control task.
pub struct Control<G: Gauges> {
    predictor: &'static mut Option<Predictor<f32>>,
    gauges: GaugeSource<G>,
    run: Option<Run>,
    report: TelemetryReport,
}

impl<G: Gauges> Control<G> {
    /// In the safe state: no model, no run.
    pub fn new(predictor: &'static mut Option<Predictor<f32>>, gauges: G) -> Self {
        Self {
            predictor,
            gauges: GaugeSource::new(gauges),
            run: None,
            report: TelemetryReport { hash: HASH_START, prediction: nothing_yet(), ..Default::default() },
        }
    }

    /// Ticks for ever.
    pub async fn run(&mut self, mut watchdog: Watchdog) -> ! {
        let period = Duration::from_micros(u64::from(TICK_US));
        let mut due = Instant::now();
        loop {
            due = due.saturating_add(period);
            Timer::at(due).await;
            let began = timer();
            if Instant::now() >= due.saturating_add(period) {
                COUNTERS.ticks_missed.add(1);
                defmt::warn!("tick {=u32} began a period late", self.report.tick);
            }
            self.tick(began);
            watchdog.feed();
        }
    }

    /// One tick, begun at `began` on the board's timer.
    // A function of its own: `make no-panic` follows its calls.
    #[inline(never)]
    pub fn tick(&mut self, began: u32) {
        COUNTERS.ticks.add(1);
        self.obey();
        let running = self.run.is_some();
        let sample = self.sample();
        self.report.sample_seq = sample.as_ref().map(|sample| sample.seq);
        if let Some(sample) = &sample {
            self.predict(sample);
        }
        self.tell(running, began);
    }

    /// Applies the commands that wait.
    fn obey(&mut self) {
        while let Some(command) = COMMANDS.try_receive() {
            self.apply(command);
        }
    }

    /// Reports the tick that `began`, `running` at its beginning.
    fn tell(&mut self, running: bool, began: u32) {
        let mode = match (&self.run, &self.predictor) {
            (Some(_), _) => Mode::Running,
            (None, Some(_)) => Mode::Ready,
            (None, None) => Mode::Safe,
        };
        set_mode(mode);
        self.report.mode = mode;
        self.report.waiting = u8::try_from(SAMPLES.len()).unwrap_or(u8::MAX);
        self.report.cost = timer().wrapping_sub(began);
        if running || self.report.tick.is_multiple_of(IDLE_REPORT_TICKS) {
            if running {
                COUNTERS.book(self.report.cost);
            }
            if REPORTS.try_send(self.report).is_err() {
                COUNTERS.reports_dropped.add(1);
            }
            self.report.seq = self.report.seq.wrapping_add(1);
        }
        self.report.tick = self.report.tick.wrapping_add(1);
    }

    fn apply(&mut self, command: Command) {
        match command {
            Command::Install(slot) => {
                install(slot, self.predictor, self.run.is_some());
                MODEL_CRC.store(slot.crc, core::sync::atomic::Ordering::Relaxed);
                COUNTERS.model_swaps.add(1);
                // One slot, one place: there is always room.
                let _ = SPARE.try_send(slot);
            }
            Command::Plan(plan) => {
                if let Some(predictor) = self.predictor {
                    predictor.set_plan(plan);
                }
            }
            Command::Grip(force_n) => self.gauges.set_grip(force_n),
            Command::Calibration(calibration) => self.gauges.calibrate(&calibration),
            Command::Tare => self.gauges.tare(),
            Command::Start(request) => {
                if let Some(predictor) = self.predictor {
                    predictor.restart();
                    predictor.set_trial(request.trial);
                }
                self.gauges.restart();
                self.report.hash = HASH_START;
                self.report.taken = 0;
                self.report.prediction = nothing_yet();
                self.run = Some(Run { request, link: LinkSource::new(&request) });
            }
            Command::Stop => self.run = None,
        }
        self.report.commands = self.report.commands.wrapping_add(1);
    }

    fn sample(&mut self) -> Option<Sample> {
        let Some(run) = &mut self.run else {
            // Keeps a tare going.
            let _ = self.gauges.poll();
            return None;
        };
        let next = match run.request.source {
            Source::Link => run.link.next(),
            Source::Gauges => self.gauges.next(),
        };
        match next {
            Next::Sample(sample) => {
                COUNTERS.samples.add(1);
                self.report.taken = self.report.taken.wrapping_add(1);
                if run.request.length.is_some_and(|length| sample.seq.saturating_add(1) >= length) {
                    self.run = None;
                }
                Some(sample)
            }
            Next::Filling => None,
            Next::Starved => {
                COUNTERS.starved.add(1);
                None
            }
        }
    }

    fn predict(&mut self, sample: &Sample) {
        // A run starts with a model only, and none is ever taken away.
        let Some(predictor) = self.predictor else { return };
        let prediction = predict(predictor, sample);
        if prediction.validity & validity::SOLVER != 0 {
            COUNTERS.solver_marks.add(1);
        }
        if prediction.validity & (validity::SAMPLE | validity::WRENCH) != 0 {
            COUNTERS.sensor_marks.add(1);
        }
        let warnings = flags::UNEXPECTED | flags::DROP;
        if prediction.flags & !self.report.prediction.flags & warnings != 0 {
            defmt::warn!("sample {=u32}: flags {=u32:#b}", sample.seq, prediction.flags);
        }
        self.report.prediction = prediction;
        self.report.hash = prediction.hash(self.report.hash);
    }
}

/// Before the first sample: nothing is known, so that the flags, all down, cannot be relied on.
fn nothing_yet() -> Prediction {
    Prediction { flags: flags::UNSURE, validity: validity::WAITING, ..Prediction::default() }
}

/// A predictor of the model in the slot, in place of the one before. In a run it goes on: with the plan,
/// the friction learnt and the object.
fn install(slot: &mut Slot, place: &mut Option<Predictor<f32>>, running: bool) {
    let Some((scene, model, limits)) = slot.package.take() else { return };
    match place {
        Some(predictor) if running => predictor.swap(scene, model, limits),
        _ => *place = Some(Predictor::of_valid(scene, model, limits)),
    }
}

/// The predictor's tick.
// A function of its own: `make no-panic` follows its calls.
#[inline(never)]
fn predict(predictor: &mut Predictor<f32>, sample: &Sample) -> Prediction {
    predictor.take(sample)
}
