//! The tick: every 4 ms take commands, take a sample, predict, report.

use core::marker::PhantomData;

use crate::alarm::Alarms;
use crate::bus::State;
use crate::fingers::Fingers;
use crate::grip::GripAdvice;
use crate::host_clock::{self, WRENCH_AGE_US};
use crate::memory::Settings;
use crate::post_mortem::Recorder;
use crate::source::{WrenchSource, gauges};
use stickslip_shared::on_board;
use stickslip_shared::predictor::{HASH_START, Prediction, Predictor, flags, validity};
use stickslip_shared::wire::{
    GripLimits, HostClock, Mode, Port, Recalled, Sample, Source, StartRequest, TICK_US, TareState,
    TelemetryReport, TickNote,
};

use crate::between::{Between, Command};
use crate::board::{Board, Channels, SetAlarms};
use crate::link_source::{LinkSource, Next};
use crate::slot::Slot;

/// Outside a run a report goes out every this many ticks: ten a second.
const IDLE_REPORT_TICKS: u32 = 25;

/// A run in progress.
struct Run {
    request: StartRequest,
    link: LinkSource,
}

/// State of the control task.
pub struct Control<B: Board> {
    between: &'static Between,
    predictor: &'static mut Option<Predictor<f32>>,
    gauges: B::Channels,
    channels: [gauges::Gauges; 2],
    fingers: Fingers,
    grip: GripAdvice,
    lines: B::Lines,
    recorder: Recorder<'static>,
    taring: bool,
    tares: u32,
    /// Told for the run that goes on.
    clock: Option<HostClock>,
    run: Option<Run>,
    report: TelemetryReport,
    board: PhantomData<B>,
}

impl<B: Board> Control<B> {
    /// In the safe state: no model, no run.
    pub fn new(
        between: &'static Between,
        predictor: &'static mut Option<Predictor<f32>>,
        gauges: B::Channels,
        lines: B::Lines,
        recorder: Recorder<'static>,
    ) -> Self {
        Self {
            between,
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
            board: PhantomData,
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
            self.between.set_mode(Mode::Ready);
            let ready =
                |request: &StartRequest| request.source == Source::Link || settings.check_ready().is_ok();
            if let Some(request) = settings.start.filter(ready) {
                self.apply(Command::Start(request));
            }
        } else {
            let _ = self.between.spare.try_send(slot);
        }
    }

    /// One tick, begun at `began` on the board's timer, at `now_us` by its clock: of that its low 32 bits, as on the line.
    // A function of its own: `make no-panic` follows its calls.
    #[inline(never)]
    pub fn tick(&mut self, began: u32, now_us: u32) {
        self.between.counters.ticks.add(1);
        self.recorder.tick_begins(self.report.tick);
        self.obey();
        let running = self.run.is_some();
        let sample = self.sample(now_us);
        self.report.sample_seq = sample.as_ref().map(|sample| sample.seq);
        if let Some(sample) = &sample {
            self.predict(sample);
        }
        self.act(sample.as_ref(), running);
        self.tell(running, began);
    }

    /// Sets the alarm lines and the advised grip. Without a sample in a run what was predicted last is in doubt; without a
    /// run nothing is predicted.
    fn act(&mut self, sample: Option<&Sample>, running: bool) {
        let report = &mut self.report;
        if let Some(sample) = sample {
            let tick_s = TICK_US as f32 * 1e-6;
            report.advised_grip_n = self.grip.follow(&report.prediction, sample.grip_cmd_n, tick_s);
        } else if !running {
            (report.prediction, report.advised_grip_n) = (nothing_yet(), None);
        } else if report.taken > 0 {
            report.prediction.flags |= flags::UNSURE;
            report.prediction.validity |= validity::SAMPLE;
        }
        let alarms = if running { Alarms::of(&report.prediction) } else { Alarms::default() };
        // Where one cannot be set, that for 'sure' is down.
        let _ = self.lines.set_alarms(alarms);
    }

    /// Applies the commands that wait.
    fn obey(&mut self) {
        while let Some(command) = self.between.commands.try_receive() {
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
        self.between.set_mode(mode);
        self.report.mode = mode;
        self.report.waiting = u8::try_from(self.between.samples.len()).unwrap_or(u8::MAX);
        self.report.cost = B::timer().wrapping_sub(began);
        if running || self.report.tick.is_multiple_of(IDLE_REPORT_TICKS) {
            if running {
                self.between.counters.book(self.report.cost);
            }
            if B::HAS_CAN {
                self.between.tell(State::of(&self.report));
            }
            if self.between.reports.try_send(self.report).is_err() {
                self.between.counters.reports_dropped.add(1);
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
                self.between.set_model_crc(slot.crc);
                self.between.counters.model_swaps.add(1);
                // One slot, one place: there is always room.
                let _ = self.between.spare.try_send(slot);
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

    fn sample(&mut self, now_us: u32) -> Option<Sample> {
        let between = self.between;
        self.read_sensors(now_us);
        let clock = self.clock;
        let measured = |sample: &Sample| clock.map_or(now_us, |clock| host_clock::at_us(&clock, sample.t_us));
        let run = self.run.as_mut()?;
        // Told with a sample only: without one that of the last stands.
        let mut at_us = now_us;
        let next = match run.request.source {
            Source::Link => {
                let mut next = run.link.take(&between.samples);
                while let Next::Sample(sample) = next {
                    at_us = measured(&sample);
                    let age_us = host_clock::age_us(at_us, now_us);
                    let late = age_us > WRENCH_AGE_US;
                    if late {
                        between.counters.readings_dropped.add(1);
                    }
                    if late && !between.samples.is_empty() {
                        // One sample a tick would never make up for a host whose clock is the faster one.
                        next = run.link.take(&between.samples);
                        continue;
                    }
                    next = Next::Sample(host_clock::as_measured(sample, age_us));
                    break;
                }
                next
            }
            Source::Unit => {
                while let Some(sample) = between.samples.try_receive() {
                    self.fingers.told(sample, measured(&sample));
                }
                let sample = self.fingers.sample(now_us);
                at_us = self.fingers.measured_us();
                self.report.alone = self.fingers.is_alone();
                if sample.finger.iter().any(Option::is_none) {
                    between.counters.starved.add(1);
                }
                Next::Sample(sample)
            }
        };
        match next {
            Next::Sample(sample) => {
                between.counters.samples.add(1);
                self.report.taken = self.report.taken.wrapping_add(1);
                self.report.at_us = at_us;
                if run.request.length.is_some_and(|length| sample.seq.saturating_add(1) >= length) {
                    self.run = None;
                }
                Some(sample)
            }
            Next::Filling => None,
            Next::Starved => {
                between.counters.starved.add(1);
                None
            }
        }
    }

    /// Takes what the sensors measured since the last tick; goes on with a tare.
    fn read_sensors(&mut self, now_us: u32) {
        if self.fingers.sensors().any(|s| s.port == Port::Gauges) {
            match self.gauges.read() {
                Some(counts) => self.take_gauges(&counts, now_us),
                None => self.between.counters.readings_damaged.add(1),
            }
        }
        while let Some((port, finger, reading)) = self.between.readings.try_receive() {
            if !self.fingers.take(port, finger, reading) {
                self.between.counters.readings_dropped.add(1);
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
        self.between.set_tared(state);
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
                None => self.between.counters.readings_dropped.add(1),
            }
        }
    }

    fn predict(&mut self, sample: &Sample) {
        // A run starts with a model only, and none is ever taken away.
        let Some(predictor) = self.predictor else { return };
        let prediction = predict(predictor, sample);
        let said = predictor.testimony();
        self.between.counters.witnessed.set(said.compared);
        self.between.counters.witness_apart.set(said.compared - said.alike);
        if prediction.validity & validity::SOLVER != 0 {
            self.between.counters.solver_marks.add(1);
        }
        if prediction.validity & (validity::SAMPLE | validity::WRENCH) != 0 {
            self.between.counters.sensor_marks.add(1);
        }
        self.report.prediction = prediction;
        self.report.hash = prediction.hash(self.report.hash);
    }
}

/// Before the first sample and without a run: nothing is known, so that the flags, all down, cannot be relied on.
// A function of its own: three places ask for it.
#[inline(never)]
fn nothing_yet() -> Prediction {
    Prediction { flags: flags::UNSURE, validity: validity::WAITING, ..Prediction::default() }
}

/// The predictor's tick.
// A function of its own: `make no-panic` follows its calls.
#[inline(never)]
fn predict(predictor: &mut Predictor<f32>, sample: &Sample) -> Prediction {
    on_board::take(predictor, sample)
}
