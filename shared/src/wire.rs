//! The protocol between host and board: one table of postcard-rpc endpoints and topics,
//! compiled into both sides.
//!
//! A frame on the line is `COBS(header, body, CRC-32) 0x00` ([`frame`]): the header and
//! the keys are postcard-rpc's (a key hashes path and schema, so two sides with different
//! messages do not misread each other: a key that is not in the table is answered and
//! counted), the body is postcard. Commands are requests with an answer; samples and
//! telemetry are topics, numbered so that loss, repetition and reordering show.

pub mod check;
pub mod frame;
pub mod mailbox;
pub mod messages;
pub mod package;
pub mod sequence;

pub use messages::*;
pub use table::*;

include!(concat!(env!("OUT_DIR"), "/source.rs"));

/// Changes when frames of the two sides no longer fit.
pub const PROTOCOL: u16 = 13;
/// Longest body of a frame, bytes.
pub const MAX_BODY: usize = 320;
/// Time from one tick to the next.
pub const TICK_US: u32 = 4_000;
/// Samples that the board can hold before they are processed.
pub const SAMPLE_QUEUE: usize = 32;

#[allow(missing_docs)]
mod table {
    use super::messages::*;
    use crate::predictor::plan::Plan;
    use postcard_rpc::{TopicDirection, endpoints, topics};

    /// Answer to a command.
    pub type Answer = Result<(), Refusal>;
    /// Poses without a host; `None`: there are none, and without a host there is no prediction.
    pub type MaybeGrasp = Option<Grasp>;
    /// The run that begins by itself after a start; `None`: the unit waits for a host.
    pub type MaybeStart = Option<StartRequest>;

    endpoints! {
        list = ENDPOINTS;
        omit_std = true;
        | EndpointTy     | RequestTy    | ResponseTy   | Path                     |
        | ----------     | ---------    | ----------   | ----                     |
        | GetInfo        | ()           | Info         | "stickslip/info"         |
        | GetStatistics  | ()           | Statistics   | "stickslip/statistics"   |
        | LoadModelChunk | ModelChunk   | Answer       | "stickslip/model/chunk"  |
        | CommitModel    | ModelCommit  | Answer       | "stickslip/model/commit" |
        | SetPlan        | Plan         | Answer       | "stickslip/plan"         |
        | SetGrip        | f32          | Answer       | "stickslip/grip"         |
        | SetCalibration | Calibration  | Answer       | "stickslip/calibration"  |
        | Tare           | ()           | Answer       | "stickslip/tare"         |
        | GetTare        | ()           | TareState    | "stickslip/tare/state"   |
        | SetSensors     | Sensors      | Answer       | "stickslip/sensors"      |
        | SetGrasp       | MaybeGrasp   | Answer       | "stickslip/grasp"        |
        | SetGripLimits  | GripLimits   | Answer       | "stickslip/griplimits"   |
        | SetUnit        | u32          | Answer       | "stickslip/unit"         |
        | Store          | MaybeStart   | Answer       | "stickslip/store"        |
        | Forget         | ()           | Answer       | "stickslip/forget"       |
        | ReadClock      | ()           | ClockReading | "stickslip/clock"        |
        | SetClock       | HostClock    | Answer       | "stickslip/clock/host"   |
        | Start          | StartRequest | Answer       | "stickslip/start"        |
        | Stop           | ()           | Answer       | "stickslip/stop"         |
        | ResetBoard     | ()           | Answer       | "stickslip/reset"        |
    }

    topics! {
        list = TOPICS_IN;
        direction = TopicDirection::ToServer;
        omit_std = true;
        | TopicTy | MessageTy | Path               |
        | ------- | --------- | ----               |
        | Samples | Sample    | "stickslip/sample" |
    }

    topics! {
        list = TOPICS_OUT;
        direction = TopicDirection::ToClient;
        omit_std = true;
        | TopicTy   | MessageTy       | Path                   | Cfg |
        | -------   | ---------       | ----                   | --- |
        | Telemetry | TelemetryReport | "stickslip/telemetry"  |     |
        | Unknown   | UnknownKey      | "stickslip/unknown"    |     |
    }
}
