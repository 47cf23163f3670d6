//! Records as other programs read them: protobuf, by `proto/stickslip.proto`, which says what each field is.
//!
//! Foxglove, Rerun and PlotJuggler read protobuf with the schema in the file; JSON is none of Rerun's encodings, and what may be
//! null in it is no schema that Foxglove takes. The types here carry the numbers of the `.proto`'s fields;
//! `DESCRIPTORS` is that file as the protobuf compiler gives it. A test holds the three together.

use prost::Message;
use stickslip_shared::predictor::{self, FingerPrediction, flags};
use stickslip_shared::solve::SolveStatus;
use stickslip_shared::wire;

/// `proto/stickslip.proto` as a `FileDescriptorSet`.
pub(super) const DESCRIPTORS: &[u8] = include_bytes!("../../proto/stickslip.binpb");

#[derive(Clone, PartialEq, Message)]
pub(super) struct Exact {
    #[prost(bytes = "vec", tag = "1")]
    pub record: Vec<u8>,
}

#[derive(Clone, PartialEq, Message)]
struct Vector3 {
    #[prost(float, tag = "1")]
    x: f32,
    #[prost(float, tag = "2")]
    y: f32,
    #[prost(float, tag = "3")]
    z: f32,
}

#[derive(Clone, PartialEq, Message)]
struct Quaternion {
    #[prost(float, tag = "1")]
    w: f32,
    #[prost(float, tag = "2")]
    x: f32,
    #[prost(float, tag = "3")]
    y: f32,
    #[prost(float, tag = "4")]
    z: f32,
}

#[derive(Clone, PartialEq, Message)]
struct Pose {
    #[prost(message, optional, tag = "1")]
    position_m: Option<Vector3>,
    #[prost(message, optional, tag = "2")]
    quaternion: Option<Quaternion>,
}

#[derive(Clone, PartialEq, Message)]
struct Wrench {
    #[prost(message, optional, tag = "1")]
    force_n: Option<Vector3>,
    #[prost(message, optional, tag = "2")]
    torque_nm: Option<Vector3>,
}

#[derive(Clone, PartialEq, Message)]
struct Sample {
    #[prost(uint32, tag = "1")]
    seq: u32,
    #[prost(uint32, tag = "2")]
    t_us: u32,
    #[prost(float, tag = "3")]
    grip_cmd_n: f32,
    #[prost(message, optional, tag = "4")]
    gripper: Option<Pose>,
    #[prost(message, optional, tag = "5")]
    object: Option<Pose>,
    #[prost(message, optional, tag = "6")]
    pusher: Option<Pose>,
    #[prost(message, optional, tag = "7")]
    finger1: Option<Wrench>,
    #[prost(message, optional, tag = "8")]
    finger2: Option<Wrench>,
}

#[derive(Clone, PartialEq, Message)]
struct Flags {
    #[prost(bool, tag = "1")]
    slip_1: bool,
    #[prost(bool, tag = "2")]
    slip_2: bool,
    #[prost(bool, tag = "3")]
    slip_ahead_1: bool,
    #[prost(bool, tag = "4")]
    slip_ahead_2: bool,
    #[prost(bool, tag = "5")]
    unexpected: bool,
    #[prost(bool, tag = "6")]
    sag: bool,
    #[prost(bool, tag = "7")]
    rotation: bool,
    #[prost(bool, tag = "8")]
    drop: bool,
    #[prost(bool, tag = "9")]
    pushing: bool,
    #[prost(bool, tag = "10")]
    unsure: bool,
}

#[derive(Clone, PartialEq, Message)]
struct Finger {
    #[prost(float, optional, tag = "1")]
    measured_utilisation: Option<f32>,
    #[prost(float, tag = "2")]
    model_utilisation: f32,
    #[prost(float, tag = "3")]
    peak_utilisation: f32,
    #[prost(float, tag = "4")]
    slip_speed_m_s: f32,
    #[prost(float, tag = "5")]
    slip_direction_rad: f32,
    #[prost(float, optional, tag = "6")]
    slip_in_s: Option<f32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, prost::Enumeration)]
#[repr(i32)]
enum SolverStatus {
    Solved = 0,
    IterationLimit = 1,
    BadInput = 2,
    Numerical = 3,
    Contradiction = 4,
}

#[derive(Clone, PartialEq, Message)]
pub(super) struct Prediction {
    #[prost(uint32, tag = "1")]
    flags: u32,
    #[prost(uint32, tag = "2")]
    validity: u32,
    #[prost(message, optional, tag = "3")]
    raised: Option<Flags>,
    #[prost(message, optional, tag = "4")]
    finger1: Option<Finger>,
    #[prost(message, optional, tag = "5")]
    finger2: Option<Finger>,
    #[prost(float, tag = "6")]
    sag_m: f32,
    #[prost(float, tag = "7")]
    sag_ahead_m: f32,
    #[prost(float, tag = "8")]
    rotation_rad: f32,
    #[prost(float, optional, tag = "9")]
    drop_in_s: Option<f32>,
    #[prost(float, optional, tag = "10")]
    holding_grip_n: Option<f32>,
    #[prost(float, tag = "11")]
    friction: f32,
    #[prost(float, tag = "12")]
    friction_least: f32,
    #[prost(float, optional, tag = "13")]
    hold_probability: Option<f32>,
    #[prost(message, optional, tag = "14")]
    object: Option<Pose>,
    #[prost(message, optional, tag = "15")]
    wrench1: Option<Wrench>,
    #[prost(message, optional, tag = "16")]
    wrench2: Option<Wrench>,
    #[prost(message, optional, tag = "17")]
    pusher_force_n: Option<Vector3>,
    #[prost(enumeration = "SolverStatus", tag = "18")]
    solver_status: i32,
    #[prost(float, tag = "19")]
    solver_residual_n: f32,
    #[prost(uint32, tag = "20")]
    solver_iterations: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, prost::Enumeration)]
#[repr(i32)]
enum Mode {
    Safe = 0,
    Ready = 1,
    Running = 2,
}

#[derive(Clone, PartialEq, Message)]
struct TelemetryReport {
    #[prost(uint32, tag = "1")]
    seq: u32,
    #[prost(uint32, tag = "2")]
    tick: u32,
    #[prost(enumeration = "Mode", tag = "3")]
    mode: i32,
    #[prost(uint32, optional, tag = "4")]
    sample_seq: Option<u32>,
    #[prost(uint32, tag = "5")]
    taken: u32,
    #[prost(uint32, tag = "6")]
    commands: u32,
    #[prost(message, optional, tag = "7")]
    prediction: Option<Prediction>,
    #[prost(uint32, tag = "8")]
    at_us: u32,
    #[prost(float, optional, tag = "9")]
    advised_grip_n: Option<f32>,
    #[prost(bool, tag = "10")]
    alone: bool,
    #[prost(uint32, tag = "11")]
    waiting: u32,
    #[prost(uint32, tag = "12")]
    cost: u32,
    #[prost(uint32, tag = "13")]
    hash: u32,
}

/// A sample, encoded.
pub(super) fn sample(of: &wire::Sample) -> Vec<u8> {
    let [finger1, finger2] = of.finger.map(|wrench| wrench.map(Wrench::from));
    let pose = |p: &Option<wire::Pose>| p.as_ref().map(|p| Pose::of(p.position_m, p.quaternion));
    let message = Sample {
        seq: of.seq,
        t_us: of.t_us,
        grip_cmd_n: of.grip_cmd_n,
        gripper: pose(&of.gripper),
        object: pose(&of.object),
        pusher: pose(&of.pusher),
        finger1,
        finger2,
    };
    message.encode_to_vec()
}

/// A prediction, encoded.
pub(super) fn prediction(of: &predictor::Prediction) -> Vec<u8> {
    Prediction::from(of).encode_to_vec()
}

/// A report, encoded.
pub(super) fn report(of: &wire::TelemetryReport) -> Vec<u8> {
    let mode = match of.mode {
        wire::Mode::Safe => Mode::Safe,
        wire::Mode::Ready => Mode::Ready,
        wire::Mode::Running => Mode::Running,
    };
    let message = TelemetryReport {
        seq: of.seq,
        tick: of.tick,
        mode: mode.into(),
        sample_seq: of.sample_seq,
        taken: of.taken,
        commands: of.commands.into(),
        prediction: Some((&of.prediction).into()),
        at_us: of.at_us,
        advised_grip_n: of.advised_grip_n,
        alone: of.alone,
        waiting: of.waiting.into(),
        cost: of.cost,
        hash: of.hash,
    };
    message.encode_to_vec()
}

impl From<[f32; 3]> for Vector3 {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<[f32; 6]> for Wrench {
    fn from([fx, fy, fz, tx, ty, tz]: [f32; 6]) -> Self {
        Self { force_n: Some([fx, fy, fz].into()), torque_nm: Some([tx, ty, tz].into()) }
    }
}

impl Pose {
    fn of(position_m: [f32; 3], [w, x, y, z]: [f32; 4]) -> Self {
        Self { position_m: Some(position_m.into()), quaternion: Some(Quaternion { w, x, y, z }) }
    }
}

impl From<u32> for Flags {
    fn from(word: u32) -> Self {
        let up = |flag: u32| word & flag != 0;
        Self {
            slip_1: up(flags::SLIP_1),
            slip_2: up(flags::SLIP_2),
            slip_ahead_1: up(flags::SLIP_AHEAD_1),
            slip_ahead_2: up(flags::SLIP_AHEAD_2),
            unexpected: up(flags::UNEXPECTED),
            sag: up(flags::SAG),
            rotation: up(flags::ROTATION),
            drop: up(flags::DROP),
            pushing: up(flags::PUSHING),
            unsure: up(flags::UNSURE),
        }
    }
}

impl From<&FingerPrediction> for Finger {
    fn from(of: &FingerPrediction) -> Self {
        Self {
            measured_utilisation: of.measured_utilisation,
            model_utilisation: of.model_utilisation,
            peak_utilisation: of.peak_utilisation,
            slip_speed_m_s: of.slip_speed_m_s,
            slip_direction_rad: of.slip_direction_rad,
            slip_in_s: of.slip.in_s(),
        }
    }
}

impl From<&predictor::Prediction> for Prediction {
    fn from(of: &predictor::Prediction) -> Self {
        let status = match of.solver_status {
            SolveStatus::Solved => SolverStatus::Solved,
            SolveStatus::IterationLimit => SolverStatus::IterationLimit,
            SolveStatus::BadInput => SolverStatus::BadInput,
            SolveStatus::Numerical => SolverStatus::Numerical,
            SolveStatus::Contradiction => SolverStatus::Contradiction,
        };
        let [finger1, finger2] = &of.finger;
        let [wrench1, wrench2] = of.finger_wrench;
        Self {
            flags: of.flags,
            validity: of.validity,
            raised: Some(of.flags.into()),
            finger1: Some(finger1.into()),
            finger2: Some(finger2.into()),
            sag_m: of.sag_m,
            sag_ahead_m: of.sag_ahead_m,
            rotation_rad: of.rotation_rad,
            drop_in_s: of.drop_in_s,
            holding_grip_n: of.holding_grip_n,
            friction: of.friction,
            friction_least: of.friction_least,
            hold_probability: of.hold_probability,
            object: Some(Pose::of(of.position_m, of.quaternion)),
            wrench1: Some(wrench1.into()),
            wrench2: Some(wrench2.into()),
            pusher_force_n: Some(of.pusher_force_n.into()),
            solver_status: status.into(),
            solver_residual_n: of.solver_residual_n,
            solver_iterations: of.solver_iterations.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prost_reflect::{DescriptorPool, DynamicMessage, SerializeOptions};
    use serde_json::{Value, json};
    use std::path::Path;
    use stickslip_shared::predictor::Slip;

    fn shown(name: &str, bytes: &[u8]) -> Value {
        let pool = DescriptorPool::decode(DESCRIPTORS).expect("descriptors");
        let message = pool.get_message_by_name(name).expect("a message of the file");
        let message = DynamicMessage::decode(message, bytes).expect("a message");
        assert_eq!(message.unknown_fields().count(), 0, "{name}");
        let options = SerializeOptions::new().use_proto_field_name(true).skip_default_fields(false);
        let mut text = serde_json::Serializer::new(Vec::new());
        message.serialize_with_options(&mut text, &options).expect("JSON");
        serde_json::from_slice(&text.into_inner()).expect("JSON")
    }

    /// Every number of it is another, and none is zero.
    fn filled() -> wire::TelemetryReport {
        let mut count = 0.0;
        let mut next = || {
            count += 0.5;
            count
        };
        let mut finger = |slip| FingerPrediction {
            measured_utilisation: Some(next()),
            model_utilisation: next(),
            peak_utilisation: next(),
            slip_speed_m_s: next(),
            slip_direction_rad: next(),
            slip,
        };
        let finger = [finger(Slip::Now), finger(Slip::In(0.0625))];
        let prediction = predictor::Prediction {
            flags: flags::SLIP_1 | flags::SLIP_AHEAD_2 | flags::DROP | flags::UNSURE,
            validity: 12,
            finger,
            sag_m: next(),
            sag_ahead_m: next(),
            rotation_rad: next(),
            drop_in_s: Some(next()),
            holding_grip_n: Some(next()),
            friction: next(),
            friction_least: next(),
            hold_probability: Some(next()),
            position_m: [next(), next(), next()],
            quaternion: [next(), next(), next(), next()],
            finger_wrench: [[0; 6]; 2].map(|wrench| wrench.map(|_| next())),
            pusher_force_n: [next(), next(), next()],
            solver_status: SolveStatus::Numerical,
            solver_residual_n: next(),
            solver_iterations: 31,
        };
        wire::TelemetryReport {
            seq: 1001,
            tick: 1002,
            mode: wire::Mode::Running,
            sample_seq: Some(1003),
            taken: 1004,
            commands: 1005,
            prediction,
            at_us: 1006,
            advised_grip_n: Some(next()),
            alone: true,
            waiting: 107,
            cost: 1008,
            hash: 1009,
        }
    }

    fn vector([x, y, z]: [f32; 3]) -> Value {
        json!({ "x": x, "y": y, "z": z })
    }

    fn wrench([fx, fy, fz, tx, ty, tz]: [f32; 6]) -> Value {
        json!({ "force_n": vector([fx, fy, fz]), "torque_nm": vector([tx, ty, tz]) })
    }

    fn pose(position_m: [f32; 3], [w, x, y, z]: [f32; 4]) -> Value {
        json!({ "position_m": vector(position_m), "quaternion": { "w": w, "x": x, "y": y, "z": z } })
    }

    /// What is named alike in both has one value.
    fn assert_same(named: &Value, record: &Value, but: &[&str]) {
        let (named, record) = (named.as_object().expect("an object"), record.as_object().expect("an object"));
        for (key, value) in record.iter().filter(|(key, _)| !but.contains(&key.as_str())) {
            let of = |value: &Value| value.as_f64().map_or(value.clone(), |x| json!(x));
            assert_eq!(named.get(key).map(of), Some(of(value)), "{key}");
        }
    }

    #[test]
    fn a_report_is_shown_with_all_that_it_holds() {
        let of = filled();
        let named = shown("stickslip.TelemetryReport", &report(&of));
        assert_same(&named, &serde_json::to_value(of).expect("JSON"), &["mode", "prediction"]);
        assert_eq!(named["mode"], "RUNNING");
        let (p, prediction) = (&of.prediction, &named["prediction"]);
        let apart =
            ["finger", "position_m", "quaternion", "finger_wrench", "pusher_force_n", "solver_status"];
        assert_same(prediction, &serde_json::to_value(p).expect("JSON"), &apart);
        for (k, slip_in_s) in [0.0, 0.0625].into_iter().enumerate() {
            let finger = &prediction[format!("finger{}", k + 1)];
            assert_same(finger, &serde_json::to_value(p.finger[k]).expect("JSON"), &["slip"]);
            assert_eq!(finger["slip_in_s"], slip_in_s);
            assert_eq!(prediction[format!("wrench{}", k + 1)], wrench(p.finger_wrench[k]));
        }
        assert_eq!(prediction["object"], pose(p.position_m, p.quaternion));
        assert_eq!(prediction["pusher_force_n"], vector(p.pusher_force_n));
        assert_eq!(prediction["solver_status"], "NUMERICAL");
        let raised = prediction["raised"].as_object().expect("flags");
        let up: Vec<&str> =
            raised.iter().filter(|(_, up)| **up == json!(true)).map(|(flag, _)| &**flag).collect();
        assert_eq!((raised.len(), up), (10, vec!["drop", "slip_1", "slip_ahead_2", "unsure"]));
    }

    #[test]
    fn what_was_not_measured_or_is_not_foreseen_is_absent() {
        let named = shown("stickslip.Prediction", &prediction(&predictor::Prediction::default()));
        for key in ["drop_in_s", "holding_grip_n", "hold_probability"] {
            assert_eq!(named.get(key), None, "{key}");
        }
        assert_eq!(named["finger1"].get("slip_in_s"), None);
        let gripper = wire::Pose { position_m: [1.0, 2.0, 3.0], quaternion: [0.5, 0.25, 0.125, 4.0] };
        let six = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let of = wire::Sample {
            seq: 7,
            t_us: 28_000,
            grip_cmd_n: 20.5,
            gripper: Some(gripper),
            object: None,
            pusher: None,
            finger: [None, Some(six)],
        };
        let named = shown("stickslip.Sample", &sample(&of));
        let gripper = pose(gripper.position_m, gripper.quaternion);
        let expected = json!({ "seq": 7, "t_us": 28_000, "grip_cmd_n": 20.5, "gripper": gripper, "finger2": wrench(six) });
        assert_eq!(named, expected);
    }

    /// With STICKSLIP_WRITE_SCHEMA the descriptors are written anew.
    #[test]
    fn the_descriptors_are_those_of_the_proto_file() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("proto");
        let mut compiler = protox::Compiler::new([&folder]).expect("a folder");
        compiler.include_source_info(false).open_file("stickslip.proto").expect("a proto file");
        let today = compiler.file_descriptor_set().encode_to_vec();
        if std::env::var_os("STICKSLIP_WRITE_SCHEMA").is_some() {
            std::fs::write(folder.join("stickslip.binpb"), &today).expect("written");
        }
        let kept = std::fs::read(folder.join("stickslip.binpb")).expect("descriptors");
        assert!(
            kept == today,
            "stickslip.binpb is not of today: run this test with STICKSLIP_WRITE_SCHEMA=1"
        );
    }
}
