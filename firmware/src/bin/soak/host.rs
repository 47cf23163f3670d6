//! The host's side of the line: what it sends, what is done to it on the way, and when it stops reading.

use core::convert::Infallible;
use core::sync::atomic::Ordering;

use embassy_time::{Duration, Instant, Timer};
use embedded_io_async::{ErrorType, Read, Write};
use heapless::Vec;
use postcard_rpc::{Endpoint, Topic};
use static_cell::StaticCell;
use stickslip_selftest::push;
use stickslip_shared::model::{Formulation, Model};
use stickslip_shared::predictor::{Intent, Plan, Segment};
use stickslip_shared::wire::frame::{FrameReader, MAX_LINE, crc32, encode};
use stickslip_shared::wire::sequence::{Order, Sequence};
use stickslip_shared::wire::{
    self, CHUNK, ModelChunk, ModelCommit, Port, Pose, Sample, Sensor, Source, StartRequest, TICK_US,
    TelemetryReport,
};

use crate::done::{DONE, Draw, ON_SENSORS, STEP, TOLD_US, count, value};
use crate::sensors::{self, Kind};

/// Samples of one run: rest, push, rest.
const RUN_SAMPLES: u32 = 750;
/// Samples of a run on the unit's sensors, and the step from which the host tells no poses any more.
pub const UNIT_SAMPLES: u32 = 735;
const TOLD_STEPS: u32 = 700;
/// Behind its time by so much the host was blocked.
const BLOCKED: Duration = Duration::from_millis(20);
/// Steps of a run in which the host may stop reading. What follows between two runs finds the line free: each command in
/// its tick, as the board takes them.
const STALLS: core::ops::Range<u32> = 50..450;
/// Room for what goes out at once: a few frames and a burst of garbage.
const ROOM: usize = 4096;

fn plan() -> Plan {
    let mut segments = Vec::new();
    for (duration_s, speed) in [(0.4, 0.0), (1.5, -0.01), (5.0, 0.0)] {
        let _ = segments.push(Segment {
            duration_s,
            velocity_m_s: [speed, 0.0, 0.0],
            angular_rad_s: [0.0; 3],
            grip_n: 20.0,
            intent: Intent::Slide,
        });
    }
    Plan { start_s: 0.0, segments }
}

/// A serialised model.
pub type Bytes = Vec<u8, { wire::MAX_MODEL_BYTES }>;

/// Of two frictions, one with the cone and one with pyramids, each with the other as its witness: what a tick can be asked
/// for at most. Made once, before anything runs: on the host's stack they would be on the board's.
#[inline(never)]
pub fn models() -> &'static [Bytes; 2] {
    static MODELS: StaticCell<[Bytes; 2]> = StaticCell::new();
    let models = MODELS.init([const { Vec::new() }; 2]);
    for (bytes, (friction, formulation)) in
        models.iter_mut().zip([(0.15, Formulation::Cone), (0.3, Formulation::Lcp)])
    {
        let _ = bytes.resize_default(wire::MAX_MODEL_BYTES);
        let (scene, model, limits) = push(0.2, friction);
        let model = Model { formulation, witness: true, ..model };
        let length = postcard::to_slice(&(scene, model, limits), bytes).map_or(0, |used| used.len());
        bytes.truncate(length);
    }
    models
}

/// The host's side of the line, sending: what the receiving task reads.
pub struct Host {
    draw: Draw,
    models: &'static [Bytes; 2],
    out: Vec<u8, ROOM>,
    at: usize,
    due: Instant,
    /// Sample of the run; beyond the run: the ticks between two runs.
    step: u32,
    run: u32,
    request: u32,
    held: Option<Vec<u8, MAX_LINE>>,
    wrench: [[f32; 6]; 2],
    /// Samples for which the sensor fault goes on, and which it is.
    fault: (u32, u32),
    /// Of the sample; beside the steps where the host is silent.
    seq: u32,
    silent: u32,
    /// What its clock is wrong by, us.
    clock_us: u32,
}

impl Host {
    pub fn new(seed: u32, models: &'static [Bytes; 2]) -> Self {
        Self {
            draw: Draw(seed),
            models,
            out: Vec::new(),
            at: 0,
            due: Instant::now(),
            step: RUN_SAMPLES,
            run: 0,
            request: 0,
            held: None,
            wrench: [[0.0; 6]; 2],
            fault: (0, 0),
            seq: 0,
            silent: 0,
            clock_us: 0,
        }
    }

    fn request<E: Endpoint>(&mut self, body: &E::Request)
    where
        E::Request: serde::Serialize,
    {
        let mut line = [0; MAX_LINE];
        self.request = self.request.wrapping_add(1);
        if let Some(bytes) = encode(E::REQ_KEY, self.request, body, &mut line) {
            let _ = self.out.extend_from_slice(bytes);
            count(&DONE.requests);
        }
    }

    fn model(&mut self) {
        let [first, second] = self.models;
        let bytes = if self.draw.once_in(2) { first } else { second };
        let mut offset = 0;
        for piece in bytes.chunks(CHUNK) {
            let chunk = ModelChunk { offset, bytes: Vec::from_slice(piece).unwrap_or_default() };
            self.request::<wire::LoadModelChunk>(&chunk);
            offset += piece.len() as u16;
        }
        let commit = ModelCommit { length: bytes.len() as u16, crc: crc32(bytes) };
        self.request::<wire::CommitModel>(&commit);
        count(&DONE.models);
    }

    /// What the host sends in this period.
    fn next(&mut self) {
        self.out.clear();
        self.at = 0;
        STEP.store(self.step, Ordering::Relaxed);
        // Of the run that goes on; between two, of the next one.
        let kind = Kind::of(if self.step < RUN_SAMPLES { self.run } else { self.run + 1 });
        match self.step {
            step if step < RUN_SAMPLES => self.moment(step, kind),
            // Between two runs, some ticks apart: the board takes commands at its tick.
            750 => {
                if ON_SENSORS.load(Ordering::Relaxed) {
                    count(&DONE.unit_runs);
                }
                ON_SENSORS.store(false, Ordering::Relaxed);
                sensors::connect(Kind::Host);
                self.request::<wire::Stop>(&());
            }
            752 => self.request::<wire::SetSensors>(&kind.sensors()),
            753 => self.model(),
            755 if kind != Kind::Host => {
                for finger in 0..2 {
                    self.request::<wire::SetCalibration>(&kind.calibration(finger));
                }
                sensors::connect(kind);
            }
            757 => self.request::<wire::Store>(&None),
            760 => self.request::<wire::SetPlan>(&plan()),
            763 => {
                let (source, length) = match kind {
                    Kind::Host => (Source::Link, RUN_SAMPLES),
                    _ => (Source::Unit, UNIT_SAMPLES),
                };
                let trial = (self.run % 1000) as f32;
                let start = StartRequest { source, trial, prefill: 8, length: Some(length) };
                self.request::<wire::Start>(&start);
            }
            766 => {
                self.run += 1;
                (self.step, self.seq, self.silent, self.clock_us) = (0, 0, 0, 0);
                ON_SENSORS.store(kind != Kind::Host, Ordering::Relaxed);
                return;
            }
            _ => {}
        }
        self.step += 1;
    }

    /// A sample's time of a run.
    fn moment(&mut self, step: u32, kind: Kind) {
        if kind == Kind::Host {
            if self.draw.once_in(600) {
                // Forward by up to 4 s, or back by one.
                let by_us = (self.draw.next() % 5_000_000).wrapping_sub(1_000_000);
                self.clock_us = self.clock_us.wrapping_add(by_us);
                count(&DONE.clock_steps);
            }
            return self.sample(self.seq, RUN_SAMPLES);
        }
        self.truth(step);
        sensors::measure(self.wrench);
        // Poses that come late are not told: the line was blocked by a host that does not read.
        if step >= TOLD_STEPS || Instant::now() > self.due + BLOCKED {
            return;
        }
        if self.silent > 0 {
            self.silent -= 1;
        } else if self.seq > 2 && step + 300 < TOLD_STEPS && self.held.is_none() && self.draw.once_in(150) {
            // Camera or host stall: no pose for a while.
            self.silent = 3 + self.draw.next() % 200;
            count(&DONE.silences);
        } else {
            self.sample(self.seq, u32::MAX);
        }
    }

    /// Sends the run's next sample; of the last ones nothing is lost where `length` is the run's.
    fn sample(&mut self, seq: u32, length: u32) {
        self.seq += 1;
        if self.draw.once_in(400) {
            self.bad_command();
        }
        if self.draw.once_in(300) {
            self.garbage();
        }
        // A model swap in the middle of a run: it goes on with plan, friction and, in the same scene, object.
        if self.step == 300 && self.run.is_multiple_of(7) {
            self.model();
        }
        let sample = self.measure(seq);
        let mut line = [0; MAX_LINE];
        let Some(bytes) = encode(wire::Samples::TOPIC_KEY, seq, &sample, &mut line) else { return };
        // The ends of a run stay whole: a loss shows by its successor.
        let last = self.step + 3 > if length == RUN_SAMPLES { RUN_SAMPLES } else { TOLD_STEPS };
        let end = seq < 2 || last;
        let late = self.held.take();
        let fault = if end || late.is_some() { u32::MAX } else { self.draw.next() % 200 };
        match fault {
            0..=2 => count(&DONE.lost),
            3..=4 => {
                let mut bytes: Vec<u8, MAX_LINE> = Vec::from_slice(bytes).unwrap_or_default();
                let at = self.draw.next() as usize % bytes.len().saturating_sub(1).max(1);
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = if *byte == 0x55 { 0x0f } else { *byte ^ 0x55 };
                }
                let _ = self.out.extend_from_slice(&bytes);
                count(&DONE.damaged);
            }
            5..=6 => {
                let _ = self.out.extend_from_slice(bytes);
                let _ = self.out.extend_from_slice(bytes);
                self.went_out();
                count(&DONE.repeated);
            }
            7..=8 => self.held = Vec::from_slice(bytes).ok(),
            _ => {
                let _ = self.out.extend_from_slice(bytes);
                self.went_out();
            }
        }
        if let Some(late) = late {
            let _ = self.out.extend_from_slice(&late);
            count(&DONE.overtaken);
        }
    }

    /// A sample did, whole and in order.
    fn went_out(&mut self) {
        if ON_SENSORS.load(Ordering::Relaxed) {
            count(&DONE.told);
            TOLD_US.store(sensors::now_us(), Ordering::Relaxed);
        } else {
            count(&DONE.sound);
        }
    }

    fn garbage(&mut self) {
        let length = 1 + self.draw.next() % 700;
        for _ in 0..length {
            let _ = self.out.push((self.draw.next() as u8).max(1));
        }
        let _ = self.out.push(0);
        count(&DONE.garbage);
    }

    fn bad_command(&mut self) {
        match self.draw.next() % 8 {
            0 => self.request::<wire::SetGrip>(&f32::NAN),
            // Not in a run, and not two for a finger.
            1 => self.request::<wire::SetSensors>(
                &[Sensor { port: Port::Can, finger: 1 }; 2].into_iter().collect(),
            ),
            2 => {
                let start = StartRequest { source: Source::Unit, trial: 0.0, prefill: 200, length: None };
                self.request::<wire::Start>(&start);
            }
            3 => {
                let commit = ModelCommit { length: 1, crc: 0 };
                self.request::<wire::CommitModel>(&commit);
            }
            4 => {
                let singular = wire::Calibration { finger: 1, matrix: [[1.0; 6]; 6] };
                self.request::<wire::SetCalibration>(&singular);
            }
            5 => {
                let limits = wire::GripLimits { rise_n_s: f32::NAN, ..wire::GripLimits::default() };
                self.request::<wire::SetGripLimits>(&limits);
            }
            // Flash is not written in a run.
            6 => self.request::<wire::Store>(&None),
            _ => self.request::<wire::Forget>(&()),
        }
        count(&DONE.refused);
    }

    /// The wrenches of a push.
    fn truth(&mut self, step: u32) {
        let t_s = step as f32 * 0.004;
        let moved = -0.01 * (t_s - 0.4).clamp(0.0, 1.5);
        let sliding = if moved < 0.0 && t_s < 1.9 { 6.0 } else { 0.0 };
        let draw = &mut self.draw;
        for (finger, sign) in self.wrench.iter_mut().zip([-1.0, 1.0]) {
            *finger = [
                -sliding + 0.02 * draw.noise(),
                sign * 20.0 + 0.02 * draw.noise(),
                1.0 + 0.02 * draw.noise(),
                0.001 * draw.noise(),
                0.001 * draw.noise(),
                0.001 * draw.noise(),
            ];
        }
    }

    /// A push with noise and, now and then, a sensor that fails.
    fn measure(&mut self, seq: u32) -> Sample {
        self.truth(self.step);
        let moved = -0.01 * (self.step as f32 * 0.004 - 0.4).clamp(0.0, 1.5);
        let mut finger = [Some(self.wrench[0]), Some(self.wrench[1])];
        if self.fault.0 > 0 {
            self.fault.0 -= 1;
        } else if seq > 50 && self.draw.once_in(250) {
            self.fault = (3 + self.draw.next() % 30, self.draw.next() % 4);
            count(&DONE.sensor_faults);
        }
        if self.fault.0 > 0 {
            match self.fault.1 {
                0 => finger[0] = Some([0.5, -20.0, 1.0, 0.0, 0.0, 0.0]),
                1 => finger[1] = Some([f32::NAN; 6]),
                2 => finger[0] = Some([1e4; 6]),
                _ => finger[1] = None,
            }
        }
        let jitter = if self.draw.once_in(50) { 3000 } else { 0 };
        let at = |x: f32, draw: &mut Draw| Pose {
            position_m: [x + 2e-5 * draw.noise(), 0.1 + 2e-5 * draw.noise(), 0.2],
            quaternion: [1.0, 0.0, 0.0, 0.0],
        };
        let gripper = at(0.3 + moved, &mut self.draw);
        let object = at(0.3, &mut self.draw);
        let mut pusher = at(0.3 - 0.0502, &mut self.draw);
        pusher.position_m[1] = 0.1;
        Sample {
            seq,
            t_us: (self.step * TICK_US + jitter).wrapping_add(self.clock_us),
            grip_cmd_n: 20.0,
            gripper: Some(gripper),
            object: (!self.draw.once_in(20)).then_some(object),
            pusher: Some(pusher),
            finger,
        }
    }
}

impl ErrorType for Host {
    type Error = Infallible;
}

impl Read for Host {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        while self.at >= self.out.len() {
            Timer::at(self.due).await;
            self.due += Duration::from_micros(u64::from(TICK_US));
            self.next();
        }
        let rest = self.out.get(self.at..).unwrap_or_default();
        let length = rest.len().min(buffer.len());
        if let (Some(to), Some(from)) = (buffer.get_mut(..length), rest.get(..length)) {
            to.copy_from_slice(from);
        }
        self.at += length;
        Ok(length)
    }
}

/// The host's side, receiving: reads at 1 Mbaud, and for seconds not at all.
pub struct Ear {
    reader: FrameReader,
    sequence: Option<Sequence>,
    draw: Draw,
}

impl Ear {
    /// Nothing heard.
    pub fn new(draw: Draw) -> Self {
        Self { reader: FrameReader::new(), sequence: None, draw }
    }
}

impl ErrorType for Ear {
    type Error = Infallible;
}

impl Write for Ear {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        if self.draw.once_in(800) && STALLS.contains(&value(&STEP)) {
            count(&DONE.stalls);
            Timer::after_millis(u64::from(200 + self.draw.next() % 800)).await;
        }
        Timer::after_micros(bytes.len() as u64 * 10).await;
        for byte in bytes {
            match self.reader.push(*byte) {
                None => {}
                Some(Err(_)) => count(&DONE.frames_bad),
                Some(Ok(frame)) if frame.key == wire::Telemetry::TOPIC_KEY => {
                    count(&DONE.reports);
                    let Some(report) = frame.decode::<TelemetryReport>() else {
                        count(&DONE.frames_bad);
                        continue;
                    };
                    let sequence = self.sequence.get_or_insert(Sequence::starting_at(report.seq));
                    if let Order::Next { lost } = sequence.judge(report.seq) {
                        DONE.reports_missing.fetch_add(lost, Ordering::Relaxed);
                    }
                }
                Some(Ok(_)) => count(&DONE.answers),
            }
        }
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
