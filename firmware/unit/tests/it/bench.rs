//! A unit without a board: tick and link as on one, the clock in the test's hands.

use std::cell::Cell;

use postcard_rpc::{Endpoint, Topic};
use serde::de::DeserializeOwned;
use stickslip_selftest::push;
use stickslip_shared::predictor::Predictor;
use stickslip_shared::wire::frame::{FrameReader, MAX_LINE, crc32, encode};
use stickslip_shared::wire::{
    self, Answer, MAX_MODEL_BYTES, Mode, ModelPackage, Pose, ResetCause, Sample, TICK_US, TelemetryReport,
};
use stickslip_unit::alarm::{Alarms, LineFault};
use stickslip_unit::between::{Between, SensorLines};
use stickslip_unit::board::{Board, Channels, SetAlarms};
use stickslip_unit::control::Control;
use stickslip_unit::counters::MemoryUse;
use stickslip_unit::link::{Line, Link};
use stickslip_unit::post_mortem::{Recorder, WORDS};
use stickslip_unit::slot::Slot;
use stickslip_unit::source::gauges::CHANNELS;

use super::flash::{RANGE, SharedFlash};

thread_local! {
    static NOW_US: Cell<u64> = const { Cell::new(0) };
    static COUNTS: Cell<Option<[u16; CHANNELS]>> = const { Cell::new(None) };
    static ALARMS: Cell<Alarms> = const { Cell::new(Alarms { slip: true, drop: true, sure: true }) };
}

/// Everything that a board may have; each test has its own.
pub struct Bench;

impl Board for Bench {
    const NAME: &'static str = "bench";
    const TIMER_HZ: u32 = 1_000_000;
    const HAS_GAUGES: bool = true;
    const HAS_SERIAL_SENSOR: bool = true;
    const HAS_CAN: bool = true;
    const MEMORY: core::ops::Range<u32> = RANGE;
    type Channels = Converters;
    type Lines = Wires;
    type Flash = SharedFlash;

    fn timer() -> u32 {
        NOW_US.get() as u32
    }
    fn now_us() -> u64 {
        NOW_US.get()
    }
    fn memory() -> MemoryUse {
        MemoryUse { stack: 100, variables: 200 }
    }
}

pub struct Converters;

impl Channels for Converters {
    fn read(&mut self) -> Option<[u16; CHANNELS]> {
        COUNTS.get()
    }
}

pub struct Wires;

impl SetAlarms for Wires {
    fn set_alarms(&mut self, alarms: Alarms) -> Result<(), LineFault> {
        ALARMS.set(alarms);
        Ok(())
    }
}

pub struct Unit {
    pub between: &'static Between,
    pub sensors: &'static SensorLines,
    control: Control<Bench>,
    link: Link<Bench>,
    reader: FrameReader,
    seq: u32,
}

fn leaked<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

impl Unit {
    /// As after power-on; with flash it takes over what is stored there.
    pub fn start(flash: Option<SharedFlash>) -> Self {
        let between: &'static Between = leaked(Between::new());
        let sensors: &'static SensorLines = leaked(SensorLines::new());
        let slot = leaked(Slot::new());
        let (recorder, post_mortem, boots) = Recorder::begin(leaked([0; WORDS]));
        let predictor: &'static mut Option<Predictor<f32>> = leaked(None);
        let mut control = Control::new(between, predictor, Converters, Wires, recorder);
        let mut link = Link::new((between, sensors), (ResetCause::PowerOn, boots, post_mortem), flash);
        let recalled = link.recall(slot);
        control.recall(link.settings(), slot, recalled);
        Self { between, sensors, control, link, reader: FrameReader::new(), seq: 0 }
    }

    /// Bytes of the line; what is answered, frame by frame, and whether the board is to restart.
    pub fn hear(&mut self, bytes: &[u8]) -> (Vec<Line>, bool) {
        let (mut answers, mut restart) = (Vec::new(), false);
        for byte in bytes {
            let mut line = Line::new();
            restart |= self.link.hear(&mut self.reader, *byte, &mut line);
            answers.extend((!line.is_empty()).then_some(line));
        }
        (answers, restart)
    }

    /// A frame of a request.
    pub fn frame<E: Endpoint>(&mut self, request: &E::Request) -> Vec<u8>
    where
        E::Request: serde::Serialize,
    {
        self.seq += 1;
        encode(E::REQ_KEY, self.seq, request, &mut [0; MAX_LINE]).expect("it fits").to_vec()
    }

    /// The answer in a frame of the unit's.
    pub fn answer<E: Endpoint>(&self, line: &[u8]) -> E::Response
    where
        E::Response: DeserializeOwned,
    {
        let mut reader = FrameReader::new();
        for byte in line {
            if let Some(frame) = reader.push(*byte) {
                let frame = frame.expect("sound");
                assert_eq!((frame.key, frame.seq), (E::RESP_KEY, self.seq));
                return frame.decode().expect("an answer");
            }
        }
        panic!("no frame");
    }

    pub fn request<E: Endpoint>(&mut self, request: &E::Request) -> E::Response
    where
        E::Request: serde::Serialize,
        E::Response: DeserializeOwned,
    {
        let bytes = self.frame::<E>(request);
        let (answers, _) = self.hear(&bytes);
        assert_eq!(answers.len(), 1);
        self.answer::<E>(&answers[0])
    }

    pub fn publish(&mut self, sample: &Sample) {
        let mut line = [0; MAX_LINE];
        let bytes =
            encode(wire::Samples::TOPIC_KEY, sample.seq, sample, &mut line).expect("it fits").to_vec();
        assert_eq!(self.hear(&bytes).0.len(), 0);
    }

    /// Sends a model in pieces of `piece` bytes and commits it.
    pub fn load(&mut self, bytes: &[u8], piece: usize) -> Answer {
        for (k, bytes) in bytes.chunks(piece).enumerate() {
            let chunk = wire::ModelChunk {
                offset: (k * piece) as u16,
                bytes: heapless::Vec::from_slice(bytes).expect("a piece"),
            };
            self.request::<wire::LoadModelChunk>(&chunk)?;
        }
        let commit = wire::ModelCommit { length: bytes.len() as u16, crc: crc32(bytes) };
        self.request::<wire::CommitModel>(&commit)
    }

    /// One with a model that is in use.
    pub fn ready() -> Self {
        let mut unit = Self::start(None);
        assert_eq!(unit.load(&bytes(&push(0.2, 0.4)), wire::CHUNK), Ok(()));
        unit.tick();
        assert_eq!(unit.between.mode(), Mode::Ready);
        unit
    }

    /// The next tick, a period later; the report where it made one.
    pub fn tick(&mut self) -> Option<TelemetryReport> {
        pass(u64::from(TICK_US));
        self.control.tick(Bench::timer(), now_us());
        self.between.reports.try_receive()
    }
}

/// Time passes.
pub fn pass(us: u64) {
    NOW_US.set(NOW_US.get() + us);
}

/// Low 32 bits of the clock.
pub fn now_us() -> u32 {
    NOW_US.get() as u32
}

pub fn set_counts(counts: Option<[u16; CHANNELS]>) {
    COUNTS.set(counts);
}

/// As the lines are.
pub fn alarms() -> Alarms {
    ALARMS.get()
}

/// As they are sent.
pub fn bytes(package: &ModelPackage) -> Vec<u8> {
    postcard::to_slice(package, &mut [0; MAX_MODEL_BYTES]).expect("it fits").to_vec()
}

/// An object held still, by the host.
pub fn sample(seq: u32, t_us: u32) -> Sample {
    let pose = Pose { position_m: [0.0; 3], quaternion: [1.0, 0.0, 0.0, 0.0] };
    let away = Pose { position_m: [-0.2, 0.0, 0.0], ..pose };
    // No reading repeats itself.
    let noise = 1e-4 * ((seq * 7) % 11) as f32;
    let wrench = |side: f32| Some([noise, side * 20.0, 0.98 + noise, 0.0, 0.0, noise]);
    let object = Pose { position_m: [noise * 0.1, 0.0, 0.0], ..pose };
    Sample {
        seq,
        t_us,
        grip_cmd_n: 20.0,
        gripper: Some(pose),
        object: Some(object),
        pusher: Some(away),
        finger: [wrench(-1.0), wrench(1.0)],
    }
}
