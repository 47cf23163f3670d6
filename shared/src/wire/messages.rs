//! Bodies of the frames. SI units; axes and signs as in the data set format.
//! Plan and prediction are the predictor's own.

use crate::predictor::types::{self, Prediction};
use crate::predictor::validate::ModelError;
use crate::real::Real;
use crate::track;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Longest piece of a model in one frame, bytes.
pub const CHUNK: usize = 96;
/// Longest serialised scene and model, bytes.
pub const MAX_MODEL_BYTES: usize = 1536;

/// Farthest that a pose may lie from the world's origin, m: there single precision has steps of 8 um.
pub const MAX_REACH_M: f32 = 100.0;

/// World pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Pose {
    /// Origin.
    pub position_m: [f32; 3],
    /// `w, x, y, z`, rotating local axes into world axes.
    pub quaternion: [f32; 4],
}

/// What is known at one sampling instant. A component that was not measured is NaN.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Sample {
    /// Counts samples from 0 at every start.
    pub seq: u32,
    /// Time of measurement since the trial's beginning; where the host told its clock ([`HostClock`]), by that. Of the unit's own
    /// sensors: of the tick, since the run's first.
    pub t_us: u32,
    /// Commanded normal force of each finger.
    pub grip_cmd_n: f32,
    /// Measured.
    pub gripper: Option<Pose>,
    /// Measured; absent where no motion capture sees it.
    pub object: Option<Pose>,
    /// Measured.
    pub pusher: Option<Pose>,
    /// Each finger's force (N) and torque (N m) on the object, gripper axes, about its patch's centre.
    pub finger: [Option<[f32; 6]>; 2],
}

impl Pose {
    fn checked<R: Real>(&self) -> Option<track::Pose<R>> {
        if !self.position_m.iter().all(|x| x.abs() <= MAX_REACH_M) {
            return None;
        }
        let widen = |x: f32| R::of(f64::from(x));
        track::Pose::new(self.position_m.map(widen), self.quaternion.map(widen))
    }
}

impl Sample {
    /// As the predictor takes it, at `t_s` by its own clock. A pose whose quaternion is not one, or that is out of reach,
    /// counts as not measured.
    pub fn at<R: Real>(&self, t_s: R) -> types::Sample<R> {
        types::Sample {
            t_s,
            grip_cmd_n: R::of(f64::from(self.grip_cmd_n)),
            gripper: self.gripper.as_ref().and_then(Pose::checked),
            object: self.object.as_ref().and_then(Pose::checked),
            pusher: self.pusher.as_ref().and_then(Pose::checked),
            finger: self.finger.map(|f| f.map(|wrench| wrench.map(|x| R::of(f64::from(x))))),
        }
    }
}

/// What the board is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub enum Mode {
    /// After power-on or reset: no model, nothing predicted.
    #[default]
    Safe,
    /// A model is loaded, no run.
    Ready,
    /// Each tick takes a sample.
    Running,
}

/// Sent every tick of a run, and ten times a second otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct TelemetryReport {
    /// Counts reports from reset; a gap is a report that the line did not take.
    pub seq: u32,
    /// Ticks since reset.
    pub tick: u32,
    /// What the board is doing.
    pub mode: Mode,
    /// The sample behind the prediction; `None`: none was there.
    pub sample_seq: Option<u32>,
    /// Samples taken since the start, this one included: shows, where reports were lost,
    /// whether all samples in between were taken.
    pub taken: u32,
    /// Commands applied since reset, wrapping: shows at which sample one took effect.
    pub commands: u16,
    /// After that sample. Where none was there, of the last one, unsure (`validity::SAMPLE`); before the first one and without a
    /// run: nothing yet, unsure (`validity::WAITING`).
    pub prediction: Prediction,
    /// When the last sample that was taken was measured by the board's clock, us, its low 32 bits: of the unit's own sensors
    /// the oldest wrench in it. When it was taken, where the host sends it and did not send its clock, or no finger is measured.
    pub at_us: u32,
    /// Grip force of each finger that a gripper's controller should command, N; `None` outside a run.
    pub advised_grip_n: Option<f32>,
    /// The poses were the stored ones: no host sent any.
    pub alone: bool,
    /// Samples waiting on the board.
    pub waiting: u8,
    /// Cost of the tick in counts of [`Info::timer_hz`].
    pub cost: u32,
    /// `Prediction::hash` over every prediction since the start.
    pub hash: u32,
}

/// Source of fingertip wrenches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Source {
    /// Samples that the host sends.
    Link,
    /// The unit's own sensors; poses from the host's samples while they are new, or the stored ones where
    /// no host tells any ([`Grasp`]).
    Unit,
}

/// Where a sensor is connected, and its protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Port {
    /// The finger's six channels of the unit's converters.
    Gauges,
    /// A Robotiq FT 300 on the sensors' serial line.
    Ft300,
    /// An ATI NETCANOEM on CAN.
    Ati {
        /// Its base identifier, seven bits.
        base: u8,
    },
    /// Wrenches in the unit's own frames on CAN (`docs/stickslip.dbc`).
    Can,
}

impl Port {
    /// Whether one sensor is all that the port is: it cannot measure both fingers.
    pub fn is_one_sensor(self) -> bool {
        matches!(self, Self::Ft300 | Self::Ati { .. })
    }
}

/// Which sensor measures a finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Sensor {
    /// Where it is connected.
    pub port: Port,
    /// 0 or 1.
    pub finger: u8,
}

/// Sensors of a unit.
pub type Sensors = heapless::Vec<Sensor, 4>;

/// Poses of a unit without a host: the gripper stands still, and the object begins where it says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Grasp {
    /// World; gives the direction of gravity.
    pub gripper: Pose,
    /// World, at the beginning of a run.
    pub object: Pose,
}

/// Within what the advised grip force moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct GripLimits {
    /// Least of each finger, N.
    pub least_n: f32,
    /// Most: what the object or the gripper bears, N.
    pub most_n: f32,
    /// Fastest rise: what the gripper can follow, N/s.
    pub rise_n_s: f32,
    /// Fastest fall, N/s.
    pub fall_n_s: f32,
}

impl Default for GripLimits {
    /// A small electric gripper: the rise of 200 N/s doubles 20 N in 0.1 s.
    fn default() -> Self {
        Self { least_n: 0.0, most_n: 60.0, rise_n_s: 200.0, fall_n_s: 5.0 }
    }
}

/// Begins a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct StartRequest {
    /// Where samples come from.
    pub source: Source,
    /// Place of the trial in its data set (wear goes with it).
    pub trial: f32,
    /// Samples to have waiting before the first is processed, to ride out the host's jitter.
    pub prefill: u8,
    /// Samples in the run: it ends by itself after the last. `None`: it ends with `Stop`.
    pub length: Option<u32>,
}

/// What makes a predictor, as it is serialised for the board.
pub type ModelPackage = (crate::model::Scene<f32>, crate::model::Model<f32>, types::Limits);

/// Piece of a serialised [`ModelPackage`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct ModelChunk {
    /// Of the first byte; the pieces come in order, 0 begins anew.
    pub offset: u16,
    /// The bytes.
    pub bytes: heapless::Vec<u8, CHUNK>,
}

/// Puts the received bytes to use, between two ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct ModelCommit {
    /// Bytes in all.
    pub length: u16,
    /// CRC-32 of all of them.
    pub crc: u32,
}

/// Turns the six numbers of one finger's sensor into its wrench.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Calibration {
    /// 0 or 1.
    pub finger: u8,
    /// Row by column: N and N m a count; of a sensor that gives N and N m, how it is mounted.
    pub matrix: [[f32; 6]; 6],
}

/// Why a command was not carried out. It then changed nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Refusal {
    /// Longer than the board can hold, bytes.
    TooLarge {
        /// Most that it can.
        limit: u16,
    },
    /// A piece of a model is missing before this one.
    Offset {
        /// The offset that it waits for.
        expected: u16,
    },
    /// The pieces do not make up the announced length.
    Length {
        /// Bytes that arrived.
        received: u16,
    },
    /// The received bytes differ from those sent.
    Crc {
        /// Of what arrived.
        received: u32,
    },
    /// The bytes are not a scene, a model and limits.
    Undecodable,
    /// The predictor cannot work with it.
    Model(ModelError),
    /// A number is not finite or beyond its limits.
    OutOfRange {
        /// Which.
        field: Field,
        /// What was sent.
        value: f32,
        /// Smallest accepted.
        low: f32,
        /// Largest accepted.
        high: f32,
    },
    /// The command queue is full, or a run goes on.
    Busy,
    /// This board has no memory for settings.
    NoMemory,
    /// The memory could not be written, or the bytes of the model in use are gone: others were sent that were refused.
    NotStored,
    /// No model is loaded.
    NoModel,
    /// This board has no such port.
    NoPort,
    /// Two sensors for one finger.
    RoleTaken {
        /// 0 or 1.
        finger: u8,
    },
    /// One sensor for two fingers.
    PortTaken {
        /// Where it is.
        port: Port,
    },
    /// The sensor's identifiers are those of the unit's own frames on the bus.
    BaseTaken {
        /// Base identifier.
        base: u8,
    },
    /// An ATI sensor, which knows classic frames only, and wrenches in CAN-FD frames on one bus.
    ClassicBus,
    /// A finger has no sensor.
    NoSensor {
        /// 0 or 1.
        finger: u8,
    },
    /// A finger's matrix is singular: six numbers would not tell six.
    Singular {
        /// 0 or 1.
        finger: u8,
    },
    /// A finger's sensor has no calibration since the start of the board.
    NotCalibrated {
        /// 0 or 1.
        finger: u8,
    },
    /// In a run: a model of another scene (object, pads, pusher, table) than the one in which it began.
    OtherScene,
}

/// What a number was meant for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Field {
    /// Duration of a plan's segment, s.
    Duration,
    /// Velocity in a plan's segment, m/s.
    Velocity,
    /// Angular velocity in a plan's segment, rad/s.
    AngularVelocity,
    /// Grip force, N.
    Grip,
    /// Number of a finger.
    Finger,
    /// Entry of a calibration matrix.
    Calibration,
    /// Samples to have waiting.
    Prefill,
    /// Place of a trial.
    Trial,
    /// When a plan begins, s.
    PlanStart,
    /// Base identifier of an ATI sensor.
    SensorBase,
    /// Largest grip force that may be advised, N.
    GripMost,
    /// Rate of the advised grip force, N/s.
    GripRate,
    /// Position of a stored pose, m.
    Position,
    /// Square of the length of a stored pose's quaternion.
    Quaternion,
    /// Seconds that one clock gains on another each second.
    Drift,
}

/// Why the processor started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub enum ResetCause {
    /// Not reported by the board.
    #[default]
    Unknown,
    /// Supply came up or browned out.
    PowerOn,
    /// The control task did not feed it.
    Watchdog,
    /// Asked for, or after a panic.
    Software,
    /// One of the two.
    WatchdogOrSoftware,
    /// The reset pin.
    Pin,
}

/// How a run of the processor ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub enum Ending {
    /// A reset asked for or from outside, or a watchdog that nothing could warn of: nothing was noted at the end.
    #[default]
    Unnoted,
    /// The code found itself wrong.
    Panic,
    /// The processor refused an instruction or an address.
    HardFault,
    /// The stack grew into its guard.
    StackOverflow,
    /// The control task did not feed the watchdog, whose early warning noted what ran instead.
    Watchdog,
    /// The chip found a memory damaged that is not the one for settings (NMI): the flash with the firmware.
    MemoryDamaged,
}

/// One of the last ticks before an end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub struct TickNote {
    /// Ticks since reset.
    pub tick: u32,
    /// `Prediction::flags` of it.
    pub flags: u32,
    /// Cost, counts of `timer_hz`; zero: it did not end.
    pub cost: u32,
}

/// What was kept over a reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub struct PostMortem {
    /// How it ended.
    pub ending: Ending,
    /// Address of the instruction, where it was noted; of a panic, where the core library's panic was called: in the
    /// function that panics, or in a check of the core library (bounds, `unwrap`) that it called.
    pub pc: u32,
    /// Within the call of that function, by its return address, where it was noted.
    pub lr: u32,
    /// Line of a panic's source; 0 otherwise.
    pub line: u32,
    /// The last ticks, oldest first; those that never were have tick 0.
    pub last: [TickNote; 4],
}

/// What became of the stored settings and model at the start; the later in this list, the more is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub enum Recalled {
    /// The board has no memory for them.
    #[default]
    NoMemory,
    /// Nothing is stored.
    Empty,
    /// Not readable, or refused by the checks: not used.
    Unusable,
    /// Of another version: not used.
    OtherVersion {
        /// That it has.
        found: u16,
    },
    /// The settings are taken over; the model that they were stored with cannot be read, is another one, or cannot be
    /// run: no run begins by itself.
    WithoutModel,
    /// Taken over.
    Done,
}

/// The unit's clock at an exchange, us since its reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct ClockReading {
    /// When the request was read.
    pub received_us: u64,
    /// When this was written.
    pub sent_us: u64,
}

/// The host's clock by the unit's: where both stood at one time, and how fast the unit's gains. It stands for the run
/// that goes on. The clocks' low 32 bits wrap around: tell it anew within half an hour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct HostClock {
    /// Of the host, as in [`Sample::t_us`].
    pub host_us: u32,
    /// Of the unit at that time, the low 32 bits.
    pub board_us: u32,
    /// Seconds that the unit's gains each second of the host's; 0 where it is not known.
    pub drift: f32,
}

/// What became of tares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub struct TareState {
    /// Tares that ended since the board's reset, wrapping.
    pub ended: u32,
    /// Fingers whose tare goes on: their sensors have not given half a second of readings.
    pub waits: [bool; 2],
    /// What counts as no load on each finger, by the sensor's numbers (converter counts, or N and N m).
    pub offsets: [[f32; 6]; 2],
}

/// What the board is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub struct Info {
    /// Version of the protocol that the firmware speaks.
    pub protocol: u16,
    /// Fingerprint of the shared source that the firmware was built from.
    pub source: u32,
    /// Version of the firmware.
    #[cfg_attr(feature = "json-schema", schemars(with = "&'static str"))]
    pub firmware: heapless::String<16>,
    /// Name of the board.
    #[cfg_attr(feature = "json-schema", schemars(with = "&'static str"))]
    pub board: heapless::String<16>,
    /// Counts a second of every cost.
    pub timer_hz: u32,
    /// Time from tick to tick.
    pub tick_us: u32,
    /// Samples that can wait.
    pub sample_queue: u16,
    /// Most contact points of a model.
    pub contacts: u16,
    /// Longest serialised model, bytes.
    pub model_bytes: u16,
    /// Whether converters for strain gauges are there.
    pub gauges: bool,
    /// Number of the unit, given by its user; 0: none.
    pub unit: u32,
    /// What became of what was stored.
    pub recalled: Recalled,
    /// What went before the last reset; `None` after power-on.
    pub post_mortem: Option<PostMortem>,
    /// Now.
    pub mode: Mode,
    /// Why the processor started.
    pub reset_cause: ResetCause,
    /// Starts since power-on.
    pub boots: u32,
    /// CRC-32 of the loaded model's bytes; `None` where none is loaded.
    pub model_crc: Option<u32>,
}

/// Counts since reset. Nothing that is lost goes uncounted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
pub struct Statistics {
    /// Ticks run.
    pub ticks: u32,
    /// Ticks that began a whole period late or later.
    pub ticks_missed: u32,
    /// Tick of a run that took most work, counts of `timer_hz`.
    pub worst_cost: u32,
    /// Mean over the ticks of runs.
    pub mean_cost: u32,
    /// Samples processed.
    pub samples: u32,
    /// Ticks of a run for which no sample was there.
    pub starved: u32,
    /// Samples that never arrived.
    pub samples_lost: u32,
    /// Samples that arrived twice and were dropped.
    pub samples_repeated: u32,
    /// Samples that arrived after a later one and were dropped.
    pub samples_reordered: u32,
    /// Samples for which no room was left.
    pub samples_dropped: u32,
    /// Samples that came outside a run.
    pub samples_unasked: u32,
    /// Reports for which no room was left.
    pub reports_dropped: u32,
    /// Bytes that the receiver had no room for; where their number is unknown, one each time.
    pub bytes_lost: u32,
    /// Frames with a wrong checksum, or no frame at all.
    pub frames_damaged: u32,
    /// Frames too long to be one.
    pub frames_too_long: u32,
    /// Sound frames whose key is not in the table.
    pub keys_unknown: u32,
    /// Sound frames whose body is not what the key says.
    pub bodies_undecodable: u32,
    /// Commands refused.
    pub commands_refused: u32,
    /// Models put to use.
    pub model_swaps: u32,
    /// Ticks whose contact problem was not solved within tolerance.
    pub solver_marks: u32,
    /// Samples that a sensor check marked.
    pub sensor_marks: u32,
    /// Steps that both formulations solved, where the model asks for the other one as a witness.
    pub witnessed: u32,
    /// Of them those in which a point sticks in one and slides in the other.
    pub witness_apart: u32,
    /// Sensors' frames that were damaged or not understood, scans of converters that failed, and times that
    /// the bus was disturbed.
    pub readings_damaged: u32,
    /// Sensors' frames that never came, by the counter of those on CAN and the beat of the serial line's.
    pub readings_lost: u32,
    /// Readings for which no room was left, or that were late, faulty or not finite.
    pub readings_dropped: u32,
    /// Frames that the bus did not take: the unit's state, requests to sensors.
    pub frames_unsent: u32,
    /// Deepest the stack has been, bytes.
    pub stack_bytes: u32,
    /// Memory that is taken whatever the stack does, bytes.
    pub static_bytes: u32,
}

/// Answer to a frame whose key is not in the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct UnknownKey {
    /// The key, as received.
    pub key: [u8; 8],
}
