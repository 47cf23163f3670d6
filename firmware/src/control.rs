//! The tick: every 4 ms take commands, take a sample, predict, report. It waits for the
//! clock only, and it alone feeds the watchdog.

use embassy_time::{Duration, Instant, Timer};
use stickslip_shared::on_board;
use stickslip_shared::predictor::{HASH_START, Prediction, Predictor, flags, validity};
use stickslip_shared::wire::{
    GripLimits, HostClock, Mode, Port, Recalled, Sample, Source, StartRequest, TICK_US, TareState,
    TelemetryReport, TickNote,
};
use stickslip_unit::alarm::Alarms;
use stickslip_unit::bus::State;
use stickslip_unit::fingers::Fingers;
use stickslip_unit::grip::GripAdvice;
use stickslip_unit::host_clock::{self, WRENCH_AGE_US};
use stickslip_unit::memory::Settings;
use stickslip_unit::post_mortem::Recorder;
use stickslip_unit::source::{WrenchSource, gauges};

use crate::board::current::{AlarmLines, Watchdog, timer};
use crate::board::{Gauges, SetAlarms};
use crate::queues::{COMMANDS, Command, MODEL_CRC, READINGS, REPORTS, SAMPLES, SPARE, TARED, set_mode};
use crate::slot::Slot;
use crate::source::{LinkSource, Next};
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
    gauges: G,
    channels: [gauges::Gauges; 2],
    fingers: Fingers,
    grip: GripAdvice,
    lines: AlarmLines,
    recorder: Recorder<'static>,
    taring: bool,
    tares: u32,
    /// Told for the run that goes on.
    clock: Option<HostClock>,
    run: Option<Run>,
    report: TelemetryReport,
}

impl<G: Gauges> Control<G> {
    /// In the safe state: no model, no run.
    pub fn new(
        predictor: &'static mut Option<Predictor<f32>>,
        gauges: G,
        lines: AlarmLines,
        recorder: Recorder<'static>,
    ) -> Self {
        Self {
            predictor,
            gauges,
            channels: [gauges::Gauges::new(0), gauges::Gauges::new(1)],
            fingers: Fingers::new(),
            grip: GripAdvice::new(GripLimits::default()),
            lines,
            recorder,
            taring: false,
            tares: 0,
            clock: None,
            run: None,
            report: TelemetryReport { hash: HASH_START, prediction: nothing_yet(), ..Default::default() },
        }
    }

    /// Takes over what was stored, and begins the run that begins by itself: after a reset in mid-grasp the unit
    /// predicts again within some ticks. Before the first tick.
    pub fn recall(&mut self, settings: &Settings, slot: &'static mut Slot, recalled: Recalled) {
        // They passed the checks when they were read.
        let _ = self.fingers.assign(&settings.sensors);
        for (matrix, finger) in settings.matrix.iter().zip(0..) {
            if let Some(matrix) = matrix {
                self.fingers.calibrate(&stickslip_shared::wire::Calibration { finger, matrix: *matrix });
            }
        }
        if recalled == Recalled::Done {
            self.fingers.set_offsets(settings.offsets);
        }
        self.publish();
        if let Some(force_n) = settings.grip_cmd_n {
            self.fingers.set_grip(force_n);
        }
        self.fingers.set_grasp(settings.grasp);
        self.grip.set_limits(settings.grip.unwrap_or_default());
        if slot.package.is_some() {
            self.apply(Command::Install(slot));
            set_mode(Mode::Ready);
            let ready =
                |request: &StartRequest| request.source == Source::Link || settings.check_ready().is_ok();
            if let Some(request) = settings.start.filter(ready) {
                self.apply(Command::Start(request));
            }
        } else {
            let _ = SPARE.try_send(slot);
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
        self.recorder.tick_begins(self.report.tick);
        self.obey();
        let running = self.run.is_some();
        let sample = self.sample();
        self.report.sample_seq = sample.as_ref().map(|sample| sample.seq);
        if let Some(sample) = &sample {
            self.predict(sample);
        }
        self.act(sample.as_ref(), running);
        self.tell(running, began);
    }

    /// Sets the alarm lines and the advised grip. Without a sample in a run what was predicted last is in doubt.
    fn act(&mut self, sample: Option<&Sample>, running: bool) {
        let prediction = &self.report.prediction;
        let alarms = match sample {
            Some(_) => Alarms::of(prediction),
            None => Alarms { sure: false, ..Alarms::of(prediction) },
        };
        let alarms = if running { alarms } else { Alarms::default() };
        if self.lines.set_alarms(alarms).is_err() {
            defmt::error!("an alarm line cannot be set");
        }
        if let Some(sample) = sample {
            let tick_s = TICK_US as f32 * 1e-6;
            self.report.advised_grip_n = self.grip.follow(prediction, sample.grip_cmd_n, tick_s);
        } else if !running {
            self.report.advised_grip_n = None;
        }
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
            if crate::board::current::HAS_CAN {
                crate::sensors::tell(State::of(&self.report));
            }
            if REPORTS.try_send(self.report).is_err() {
                COUNTERS.reports_dropped.add(1);
            }
            self.report.seq = self.report.seq.wrapping_add(1);
        }
        let TelemetryReport { tick, prediction, cost, .. } = self.report;
        self.recorder.tick_ends(TickNote { tick, flags: prediction.flags, cost });
        self.report.tick = tick.wrapping_add(1);
    }

    fn apply(&mut self, command: Command) {
        match command {
            Command::Install(slot) => {
                if let Some(package) = slot.package.take() {
                    on_board::install(package, self.predictor, self.run.is_some());
                }
                MODEL_CRC.store(slot.crc, core::sync::atomic::Ordering::Relaxed);
                COUNTERS.model_swaps.add(1);
                // One slot, one place: there is always room.
                let _ = SPARE.try_send(slot);
            }
            Command::Plan(plan) => {
                if let Some(predictor) = self.predictor {
                    on_board::set_plan(predictor, plan);
                }
            }
            Command::Grip(force_n) => self.fingers.set_grip(force_n),
            Command::Calibration(calibration) => self.fingers.calibrate(&calibration),
            Command::Tare => {
                self.fingers.tare();
                self.taring = true;
                self.publish();
            }
            Command::Sensors(sensors) => {
                // Checked where it came in.
                let _ = self.fingers.assign(&sensors);
                self.publish();
            }
            Command::Grasp(grasp) => self.fingers.set_grasp(grasp),
            Command::GripLimits(limits) => self.grip.set_limits(limits),
            Command::Start(request) => {
                if let Some(predictor) = self.predictor {
                    on_board::begin(predictor, request.trial);
                }
                self.clock = None;
                self.fingers.restart();
                self.grip.restart();
                self.report.hash = HASH_START;
                self.report.taken = 0;
                self.report.prediction = nothing_yet();
                self.run = Some(Run { request, link: LinkSource::new(&request) });
            }
            Command::Clock(clock) => self.clock = Some(clock),
            Command::Stop => self.run = None,
        }
        self.report.commands = self.report.commands.wrapping_add(1);
    }

    fn sample(&mut self) -> Option<Sample> {
        // The low 32 bits of the clock, as on the line.
        let now_us = Instant::now().as_micros() as u32;
        self.read_sensors(now_us);
        let clock = self.clock;
        let measured = |sample: &Sample| clock.map_or(now_us, |clock| host_clock::at_us(&clock, sample.t_us));
        let run = self.run.as_mut()?;
        self.report.at_us = now_us;
        let next = match run.request.source {
            Source::Link => {
                let mut next = run.link.take();
                while let Next::Sample(sample) = next {
                    self.report.at_us = measured(&sample);
                    let age_us = host_clock::age_us(self.report.at_us, now_us);
                    let late = age_us > WRENCH_AGE_US;
                    if late {
                        COUNTERS.readings_dropped.add(1);
                    }
                    if late && !SAMPLES.is_empty() {
                        // One sample a tick would never make up for a host whose clock is the faster one.
                        next = run.link.take();
                        continue;
                    }
                    next = Next::Sample(host_clock::as_measured(sample, age_us));
                    break;
                }
                next
            }
            Source::Unit => {
                while let Some(sample) = SAMPLES.try_receive() {
                    self.fingers.told(sample, measured(&sample));
                }
                let sample = self.fingers.sample(now_us);
                self.report.alone = self.fingers.is_alone();
                if sample.finger.iter().any(Option::is_none) {
                    COUNTERS.starved.add(1);
                }
                Next::Sample(sample)
            }
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

    /// Takes what the sensors measured since the last tick; goes on with a tare.
    fn read_sensors(&mut self, now_us: u32) {
        if self.fingers.sensors().any(|s| s.port == Port::Gauges) {
            match self.gauges.read() {
                Some(counts) => self.take_gauges(&counts, now_us),
                None => COUNTERS.readings_damaged.add(1),
            }
        }
        while let Some((port, finger, reading)) = READINGS.try_receive() {
            if !self.fingers.take(port, finger, reading) {
                COUNTERS.readings_dropped.add(1);
            }
        }
        if self.taring {
            if !self.fingers.is_taring() {
                self.taring = false;
                self.tares = self.tares.wrapping_add(1);
            }
            self.publish();
        }
    }

    /// Hands the link what counts as no load, for the memory and for who asks.
    fn publish(&self) {
        let state =
            TareState { ended: self.tares, waits: self.fingers.taring(), offsets: self.fingers.offsets() };
        critical_section::with(|cs| TARED.borrow(cs).set(state));
    }

    fn take_gauges(&mut self, counts: &[u16; gauges::CHANNELS], now_us: u32) {
        let wired = |fingers: &Fingers, finger: u8| {
            fingers.sensors().any(|s| s.finger == finger && s.port == Port::Gauges)
        };
        for (channels, finger) in self.channels.iter_mut().zip(0..) {
            if !wired(&self.fingers, finger) {
                continue;
            }
            match channels.take(counts, now_us) {
                Some(reading) => {
                    self.fingers.take(Port::Gauges, finger, reading);
                }
                // At the end of its range.
                None => COUNTERS.readings_dropped.add(1),
            }
        }
    }

    fn predict(&mut self, sample: &Sample) {
        // A run starts with a model only, and none is ever taken away.
        let Some(predictor) = self.predictor else { return };
        let prediction = predict(predictor, sample);
        let said = predictor.testimony();
        COUNTERS.witnessed.set(said.compared);
        COUNTERS.witness_apart.set(said.compared - said.alike);
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

/// The predictor's tick.
// A function of its own: `make no-panic` follows its calls.
#[inline(never)]
fn predict(predictor: &mut Predictor<f32>, sample: &Sample) -> Prediction {
    on_board::take(predictor, sample)
}
