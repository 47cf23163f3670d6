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
    /// Time of measurement since the trial's beginning.
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
        let widen = |x: f32| R::of(f64::from(x));
        track::Pose::new(self.position_m.map(widen), self.quaternion.map(widen))
    }
}

impl Sample {
    /// As the predictor takes it, at `t_s` by its own clock. A pose whose quaternion is not one
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
    /// Samples taken since the start, this one included: tells, where reports were lost,
    /// whether all samples in between were taken.
    pub taken: u32,
    /// Commands applied since reset, wrapping: tells at which sample one took effect.
    pub commands: u16,
    /// After that sample; of the last one where none was there.
    pub prediction: Prediction,
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
    /// The board's strain gauges; poses from the host's samples while they are new
    /// ([`crate::gauges`]).
    Gauges,
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

/// Turns one finger's six gauge channels into its wrench.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Calibration {
    /// 0 or 1.
    pub finger: u8,
    /// Row by column: N and N m a count.
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
    /// No model is loaded.
    NoModel,
    /// This board has no gauges.
    NoGauges,
    /// A finger's gauges have no calibration since the start of the board.
    NotCalibrated {
        /// 0 or 1.
        finger: u8,
    },
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
}

/// Why the processor started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum ResetCause {
    /// Not told by the board.
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

/// What the board is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct Info {
    /// [`super::PROTOCOL`] of the firmware.
    pub protocol: u16,
    /// [`super::SOURCE`] of the firmware.
    pub source: u32,
    /// Version of the firmware.
    pub firmware: heapless::String<16>,
    /// Name of the board.
    pub board: heapless::String<16>,
    /// Counts a second behind [`TelemetryReport::cost`].
    pub timer_hz: u32,
    /// Time from tick to tick.
    pub tick_us: u32,
    /// Samples that can wait.
    pub sample_queue: u16,
    /// Most contact points of a model.
    pub contacts: u16,
    /// Longest serialised model, bytes.
    pub model_bytes: u16,
    /// Whether `Source::Gauges` is there.
    pub gauges: bool,
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
    /// Bytes that the receiver had no room for.
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
