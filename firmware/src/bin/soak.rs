//! Hours of virtual time with everything going wrong at once: the application of the
//! emulated board with a line that loses, doubles, swaps and damages samples, sends garbage,
//! bursts and bad commands, swaps models while running, stores settings between runs, and a host that stops reading for
//! seconds; sensors that stick, saturate, fall out and give NaN.
//!
//! What is done to the board is counted here, independently of the board's own counts, and
//! both are held against each other at the end. Run by `make soak` under QEMU's `-icount`,
//! where time is instructions: no tick may begin late, no loss may go uncounted. The number
//! of ticks is the program's argument.
#![no_std]
#![no_main]

use core::convert::Infallible;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use embassy_time::{Duration, Instant, Timer};
use embedded_io_async::{ErrorType, Read, Write};
use heapless::Vec;
use postcard_rpc::{Endpoint, Topic};
use static_cell::StaticCell;
use stickslip_firmware::board::current as board;
use stickslip_firmware::control::Control;
use stickslip_firmware::link::{self, Link};
use stickslip_firmware::post_mortem;
use stickslip_firmware::queues::SAMPLES;
use stickslip_firmware::stack;
use stickslip_firmware::stack::BUDGET_BYTES;
use stickslip_firmware::state::{self, Started};
use stickslip_firmware::stats::COUNTERS;
use stickslip_shared::predictor::{Intent, Plan, Segment};
use stickslip_shared::selftest::push;
use stickslip_shared::wire::frame::{FrameReader, MAX_LINE, crc32, encode};
use stickslip_shared::wire::sequence::{Order, Sequence};
use stickslip_shared::wire::{
    self, CHUNK, ModelChunk, ModelCommit, Pose, Sample, Source, StartRequest, TICK_US, TelemetryReport,
};

/// Samples of one run: rest, push, rest.
const RUN_SAMPLES: u32 = 750;
/// Ticks if the argument names none: a minute.
const TICKS: u32 = 15_000;
/// Room for what goes out at once: a few frames and a burst of garbage.
const ROOM: usize = 4096;

/// What was done to the board, and what it answered.
struct Done {
    /// Sample frames that went out whole and in order.
    sound: AtomicU32,
    lost: AtomicU32,
    damaged: AtomicU32,
    garbage: AtomicU32,
    repeated: AtomicU32,
    overtaken: AtomicU32,
    refused: AtomicU32,
    requests: AtomicU32,
    models: AtomicU32,
    sensor_faults: AtomicU32,
    stalls: AtomicU32,
    answers: AtomicU32,
    reports: AtomicU32,
    reports_missing: AtomicU32,
    frames_bad: AtomicU32,
}

const fn none() -> AtomicU32 {
    AtomicU32::new(0)
}

static DONE: Done = Done {
    sound: none(),
    lost: none(),
    damaged: none(),
    garbage: none(),
    repeated: none(),
    overtaken: none(),
    refused: none(),
    requests: none(),
    models: none(),
    sensor_faults: none(),
    stalls: none(),
    answers: none(),
    reports: none(),
    reports_missing: none(),
    frames_bad: none(),
};

fn count(counter: &AtomicU32) {
    counter.fetch_add(1, Ordering::Relaxed);
}

fn value(counter: &AtomicU32) -> u32 {
    counter.load(Ordering::Relaxed)
}

/// Marsaglia's xorshift: enough to vary faults.
struct Draw(u32);

impl Draw {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }
    /// True once in `n` times.
    fn once_in(&mut self, n: u32) -> bool {
        self.next().is_multiple_of(n)
    }
    /// Uniform in -1 to 1.
    fn noise(&mut self) -> f32 {
        (self.next() >> 8) as f32 / 8_388_608.0 - 1.0
    }
}

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
type Bytes = Vec<u8, { wire::MAX_MODEL_BYTES }>;

/// Of two frictions. Made once, before anything runs: on the host's stack they would be on the board's.
#[inline(never)]
fn models() -> &'static [Bytes; 2] {
    static MODELS: StaticCell<[Bytes; 2]> = StaticCell::new();
    let models = MODELS.init([const { Vec::new() }; 2]);
    for (bytes, friction) in models.iter_mut().zip([0.15, 0.3]) {
        let _ = bytes.resize_default(wire::MAX_MODEL_BYTES);
        let length = postcard::to_slice(&push(0.2, friction), bytes).map_or(0, |used| used.len());
        bytes.truncate(length);
    }
    models
}

/// The host's side of the line, sending: what the receiving task reads.
struct Host {
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
}

impl Host {
    fn new(seed: u32, models: &'static [Bytes; 2]) -> Self {
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
        match self.step {
            step if step < RUN_SAMPLES => self.sample(step),
            // Between two runs, some ticks apart: the board takes commands at its tick.
            750 => self.request::<wire::Stop>(&()),
            753 => self.model(),
            757 => self.request::<wire::Store>(&None),
            760 => self.request::<wire::SetPlan>(&plan()),
            763 => {
                let start = StartRequest {
                    source: Source::Link,
                    trial: (self.run % 1000) as f32,
                    prefill: 8,
                    length: Some(RUN_SAMPLES),
                };
                self.request::<wire::Start>(&start);
            }
            766 => {
                self.run += 1;
                self.step = 0;
                return;
            }
            _ => {}
        }
        self.step += 1;
    }

    fn sample(&mut self, seq: u32) {
        if self.draw.once_in(400) {
            self.bad_command();
        }
        if self.draw.once_in(300) {
            self.garbage();
        }
        // A model swap in the middle of a run: it goes on with plan, friction and, in the same scene, object.
        if seq == 300 && self.run.is_multiple_of(7) {
            self.model();
        }
        let sample = self.measure(seq);
        let mut line = [0; MAX_LINE];
        let Some(bytes) = encode(wire::Samples::TOPIC_KEY, seq, &sample, &mut line) else { return };
        // The ends of a run stay whole: a loss shows by its successor.
        let end = seq < 2 || seq + 3 > RUN_SAMPLES;
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
                count(&DONE.sound);
                count(&DONE.repeated);
            }
            7..=8 => self.held = Vec::from_slice(bytes).ok(),
            _ => {
                let _ = self.out.extend_from_slice(bytes);
                count(&DONE.sound);
            }
        }
        if let Some(late) = late {
            let _ = self.out.extend_from_slice(&late);
            count(&DONE.overtaken);
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
            1 => self.request::<wire::Tare>(&()),
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

    /// A push with noise and, now and then, a sensor that fails.
    fn measure(&mut self, seq: u32) -> Sample {
        let t_s = seq as f32 * 0.004;
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
            t_us: seq * TICK_US + jitter,
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
struct Ear {
    reader: FrameReader,
    sequence: Option<Sequence>,
    draw: Draw,
}

impl ErrorType for Ear {
    type Error = Infallible;
}

impl Write for Ear {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        if self.draw.once_in(1500) {
            count(&DONE.stalls);
            Timer::after_millis(u64::from(200 + self.draw.next() % 2000)).await;
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

#[embassy_executor::task]
async fn control(control: &'static mut Control<board::Channels>, watchdog: board::Watchdog) -> ! {
    control.run(watchdog).await
}

#[embassy_executor::task]
async fn receive(link: &'static mut Link, seed: u32, models: &'static [Bytes; 2]) -> ! {
    link.run(Host::new(seed, models)).await
}

#[embassy_executor::task]
async fn transmit(seed: u32) -> ! {
    link::transmit(Ear { reader: FrameReader::new(), sequence: None, draw: Draw(seed) }).await
}

#[embassy_executor::task]
async fn judge(ticks: u32) {
    while COUNTERS.ticks.get() < ticks {
        Timer::after_millis(100).await;
    }
    let (s, d) = (COUNTERS.read(), &DONE);
    let waiting = u32::try_from(SAMPLES.len()).unwrap_or(u32::MAX);
    hprintln!("virtual time {} s: {} ticks, {} missed", s.ticks / 250, s.ticks, s.ticks_missed);
    // 8 ns an instruction, 40 ns a count.
    hprintln!("instructions a tick: mean {}, worst {}", s.mean_cost * 5, s.worst_cost * 5);
    hprintln!(
        "stack: {} of {} bytes at the deepest; static, with this program: {}",
        s.stack_bytes,
        BUDGET_BYTES,
        s.static_bytes
    );
    hprintln!(
        "done: {} samples sound, {} lost, {} damaged, {} overtaken, {} repeated, {} bursts of garbage, {} sensor faults",
        value(&d.sound),
        value(&d.lost),
        value(&d.damaged),
        value(&d.overtaken),
        value(&d.repeated),
        value(&d.garbage),
        value(&d.sensor_faults)
    );
    hprintln!(
        "board: {} processed, {} dropped, {} unasked, {} waiting, {} missing, {} late, {} repeated",
        s.samples,
        s.samples_dropped,
        s.samples_unasked,
        waiting,
        s.samples_lost,
        s.samples_reordered,
        s.samples_repeated
    );
    hprintln!(
        "board: {} frames damaged, {} too long; {} samples marked, {} contact problems unsolved",
        s.frames_damaged,
        s.frames_too_long,
        s.sensor_marks,
        s.solver_marks
    );
    hprintln!(
        "commands: {} sent, {} answered; {} bad, {} refused; {} models sent, {} put to use",
        value(&d.requests),
        value(&d.answers),
        value(&d.refused),
        s.commands_refused,
        value(&d.models),
        s.model_swaps
    );
    hprintln!(
        "reports: {} received, {} missing, {} dropped; the host stopped reading {} times",
        value(&d.reports),
        value(&d.reports_missing),
        s.reports_dropped,
        value(&d.stalls)
    );
    let missing = value(&d.lost) + value(&d.damaged) + value(&d.overtaken);
    let taken = s.samples + s.samples_dropped + s.samples_unasked + waiting;
    let near = |a: u32, b: u32, slack: u32| a.abs_diff(b) <= slack;
    // Slack: what is on its way at this moment.
    let held = [
        ("no tick began late", s.ticks_missed == 0),
        ("the stack keeps within its budget", s.stack_bytes <= BUDGET_BYTES),
        ("every sound sample is accounted for", near(value(&d.sound), taken, 2)),
        ("every missing sample is counted", near(missing, s.samples_lost, 2)),
        ("every late sample is counted", near(value(&d.overtaken), s.samples_reordered, 1)),
        ("every repeated sample is counted", near(value(&d.repeated), s.samples_repeated, 1)),
        (
            "every bad frame is counted",
            near(value(&d.damaged) + value(&d.garbage), s.frames_damaged + s.frames_too_long, 1),
        ),
        ("every bad command is refused", near(value(&d.refused), s.commands_refused, 1)),
        ("every model is put to use", near(value(&d.models), s.model_swaps, 1)),
        ("every request is answered", near(value(&d.requests), value(&d.answers), 12)),
        // A stall may end after this moment: its drops show later.
        ("every missing report was counted", near(value(&d.reports_missing), s.reports_dropped, 600)),
        ("no frame came out broken", value(&d.frames_bad) == 0),
        ("no byte was lost", s.bytes_lost == 0),
    ];
    let mut failed = false;
    for (claim, holds) in held {
        if !holds {
            failed = true;
            hprintln!("NOT SO: {}", claim);
        }
    }
    hprintln!("{}", if failed { "soak failed" } else { "soak passed" });
    debug::exit(if failed { debug::EXIT_FAILURE } else { debug::EXIT_SUCCESS });
}

/// The number in the program's arguments.
fn argument() -> Option<u32> {
    let mut text = [0_u8; 64];
    let mut block = [text.as_mut_ptr() as usize, text.len()];
    // SAFETY: SYS_GET_CMDLINE (0x15) writes at most `block[1]` bytes to `block[0]`, and
    // their number to `block[1]`.
    let failed = unsafe { cortex_m_semihosting::syscall1(0x15, block.as_mut_ptr() as usize) };
    if failed != 0 {
        return None;
    }
    let length = block[1].min(text.len());
    core::str::from_utf8(text.get(..length)?).ok()?.split_whitespace().find_map(|word| word.parse().ok())
}

/// Brings everything up; its stack is free again before anything runs.
#[inline(never)]
fn start() {
    stack::guard();
    let (recorder, post_mortem, boots) = post_mortem::begin();
    let board = board::init(post_mortem.is_some());
    let started = Started { cause: board.reset_cause, boots, post_mortem, recorder };
    let (app, link) = state::init(board.gauges, board.alarms, board.flash, started);
    let upper = board::control_executor();
    let lower = board::communication_executor();
    let ticks = argument().unwrap_or(TICKS);
    // Each task is spawned once, so its one place is free.
    if let Ok(token) = receive(link, 0x9e37_79b9 ^ ticks, models()) {
        lower.spawn(token);
    }
    if let Ok(token) = transmit(0x85eb_ca6b ^ ticks) {
        lower.spawn(token);
    }
    if let Ok(token) = judge(ticks) {
        lower.spawn(token);
    }
    if let Ok(token) = control(app, board::Watchdog::start()) {
        upper.spawn(token);
    }
}

#[entry]
fn main() -> ! {
    start();
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    hprintln!("{}", info);
    board::halt()
}
