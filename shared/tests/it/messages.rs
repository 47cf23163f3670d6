//! A number that is none, in every place of every message in which there may be a number: refused with a typed error, or,
//! in a sample, marked; what was there before stays.

use std::collections::BTreeSet;

use serde::Serialize;
use serde::de::DeserializeOwned;
use stickslip_selftest::push;
use stickslip_shared::effects::Effect;
use stickslip_shared::on_board;
use stickslip_shared::predictor::{Intent, Plan, Predictor, Segment, flags, validity};
use stickslip_shared::wire::package::decode;
use stickslip_shared::wire::{
    self, Calibration, Grasp, GripLimits, HostClock, Pose, Refusal, Sample, Source, StartRequest, check,
};

/// Not a number, without end, and farther off than any quantity of a rig.
const NONE: [f32; 5] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30];

/// Every message that differs from `sound` by one of [`NONE`] in a place of a number: what the postcard bytes say with
/// four of them replaced, where that is a message in which the number stands.
fn spoilt<M: Serialize + DeserializeOwned + core::fmt::Debug>(sound: &M) -> Vec<M> {
    let bytes = postcard::to_slice(sound, &mut [0; 1024]).expect("it fits").to_vec();
    let mut all = Vec::new();
    for at in 0..bytes.len().saturating_sub(3) {
        for none in NONE {
            let mut changed = bytes.clone();
            changed[at..at + 4].copy_from_slice(&none.to_le_bytes());
            if let Ok((message, [])) = postcard::take_from_bytes::<M>(&changed)
                && has_none(&message)
            {
                all.push(message);
            }
        }
    }
    assert!(all.len() >= NONE.len(), "{sound:?}: no place of a number was found");
    all
}

fn has_none(message: &impl core::fmt::Debug) -> bool {
    let text = format!("{message:?}");
    ["NaN", "inf", "1e30"].iter().any(|none| text.contains(none))
}

fn pose() -> Pose {
    Pose { position_m: [0.3, 0.1, 0.2], quaternion: [1.0, 0.0, 0.0, 0.0] }
}

fn segment() -> Segment {
    Segment {
        duration_s: 1.0,
        velocity_m_s: [-0.01, 0.0, 0.0],
        angular_rad_s: [0.0, 0.1, 0.0],
        grip_n: 20.0,
        intent: Intent::Slide,
    }
}

/// Messages to the board whose numbers are spoilt here; those of a model come in pieces, whose bytes have a checksum.
const SPOILT: [&str; 10] = [
    "stickslip/plan",
    "stickslip/grip",
    "stickslip/calibration",
    "stickslip/grasp",
    "stickslip/griplimits",
    "stickslip/clock/host",
    "stickslip/start",
    "stickslip/store",
    "stickslip/model/commit",
    "stickslip/sample",
];
/// Those whose numbers are whole: each value of them is one, or is refused by a test of its own.
const WHOLE: [&str; 11] = [
    "stickslip/info",
    "stickslip/statistics",
    // Offset and length: `hil-tests`, 'a model with a missing piece' and 'a model longer than the board'.
    "stickslip/model/chunk",
    "stickslip/tare",
    "stickslip/tare/state",
    // Finger and base identifier: `firmware/unit/tests/it/fingers.rs`, 'two sensors for one finger'.
    "stickslip/sensors",
    "stickslip/unit",
    "stickslip/forget",
    "stickslip/clock",
    "stickslip/stop",
    "stickslip/reset",
];

#[test]
fn every_message_of_the_protocol_is_spoilt_here_or_has_no_number_that_could_be_none() {
    let requests = wire::ENDPOINTS.endpoints.iter().map(|(path, ..)| *path);
    let topics = wire::TOPICS_IN.topics.iter().map(|(path, ..)| *path);
    let known: BTreeSet<&str> = SPOILT.into_iter().chain(WHOLE).collect();
    let all: BTreeSet<&str> = requests.chain(topics).collect();
    assert_eq!(all, known, "a message that is new or gone: say here how its numbers are refused");
}

#[test]
fn a_command_with_a_number_that_is_none_is_refused_wherever_it_stands() {
    let refused = |answer: Result<(), Refusal>, message: &dyn core::fmt::Debug| {
        assert!(matches!(answer, Err(Refusal::OutOfRange { .. })), "{answer:?} to {message:?}");
    };
    let mut plan = Plan { start_s: 0.5, ..Plan::default() };
    plan.segments.extend([segment(), segment()]);
    assert_eq!(check::plan(&plan), Ok(()));
    for m in spoilt(&plan) {
        refused(check::plan(&m), &m);
    }
    for m in spoilt(&20.0_f32) {
        refused(check::grip(m), &m);
    }
    for m in spoilt(&HostClock { host_us: 7, board_us: 9, drift: 1e-4 }) {
        refused(check::clock(&m), &m);
    }
    let mut matrix = [[0.0; 6]; 6];
    for (k, row) in matrix.iter_mut().enumerate() {
        row[k] = 0.01;
    }
    let calibration = Calibration { finger: 1, matrix };
    assert_eq!(check::calibration(&calibration), Ok(()));
    for m in spoilt(&calibration) {
        refused(check::calibration(&m), &m);
    }
    let grasp = Grasp { gripper: pose(), object: pose() };
    assert_eq!(check::grasp(&grasp), Ok(()));
    for m in spoilt(&grasp) {
        refused(check::grasp(&m), &m);
    }
    assert_eq!(check::grip_limits(&GripLimits::default()), Ok(()));
    for m in spoilt(&GripLimits::default()) {
        refused(check::grip_limits(&m), &m);
    }
    let start = StartRequest { source: Source::Link, trial: 3.0, prefill: 8, length: Some(100) };
    assert_eq!(check::start(&start), Ok(()));
    for m in spoilt(&start) {
        refused(check::start(&m), &m);
    }
    // Of a store: the run that is to begin by itself.
    for m in spoilt(&Some(start)) {
        refused(m.as_ref().map_or(Ok(()), check::start), &m);
    }
    // The numbers that are whole.
    refused(check::finger(2), &2);
    refused(check::ati_base(128), &128);
    refused(check::start(&StartRequest { prefill: 200, ..start }), &200);
}

#[test]
fn a_model_with_a_number_that_is_none_is_refused_wherever_it_stands() {
    let (scene, mut model, limits) = push(0.2, 0.3);
    model.effects.clear();
    for id in ["viscous_friction", "grip_force_lag"] {
        model.effects.push(Effect::typical(id).expect("known")).expect("room");
    }
    let package = (scene, model, limits);
    assert_eq!(on_board::check(&package), Ok(()));
    for m in spoilt(&package) {
        assert!(on_board::check(&m).is_err(), "{m:?}");
        let bytes = postcard::to_slice(&m, &mut [0; 1024]).expect("it fits").to_vec();
        assert!(decode(&bytes).is_some(), "it is refused for its numbers, not for its bytes");
    }
}

#[test]
fn a_sample_with_a_number_that_is_none_is_marked_and_the_next_sound_one_predicted_from_as_before() {
    let (scene, model, limits) = push(0.2, 0.3);
    let mut predictor = Predictor::new(scene, model, limits).expect("sound");
    let mut plan = Plan::default();
    let _ = plan.segments.push(Segment {
        velocity_m_s: [0.0; 3],
        angular_rad_s: [0.0; 3],
        duration_s: 10.0,
        ..segment()
    });
    predictor.set_plan(plan);
    let sample = |seq: u32| Sample {
        seq,
        t_us: seq * 4_000,
        grip_cmd_n: 20.0,
        gripper: Some(pose()),
        object: Some(pose()),
        pusher: Some(Pose { position_m: [0.2498, 0.1, 0.2], ..pose() }),
        finger: [Some([0.0, -20.0, 1.0, 0.0, 0.0, 0.0]), Some([0.0, 20.0, 1.0, 0.0, 0.0, 0.0])],
    };
    for seq in 0..60 {
        predictor.take(&sample(seq));
    }
    let (mut sure, mut sound) = (predictor.clone(), None);
    for seq in 60..64 {
        sound = Some(sure.take(&sample(seq)));
    }
    let sound = sound.expect("four of them");
    assert_eq!(sound.flags & flags::UNSURE, 0, "{sound:?}");
    for m in spoilt(&sample(60)) {
        if m.seq != 60 || m.t_us != 240_000 {
            continue;
        }
        let mut own = predictor.clone();
        let marked = own.take(&m);
        // A pose that is none counts as not measured: of the object that is no doubt in one sample.
        let unmeasured = predictor.clone().take(&Sample { object: None, ..sample(60) });
        if has_none(&m.object) && marked == unmeasured {
            continue;
        }
        assert!(marked.flags & flags::UNSURE != 0 && marked.validity != 0, "{m:?} {marked:?}");
        assert!(!has_none(&marked), "{m:?} {marked:?}");
        let mut last = marked;
        for seq in 61..64 {
            last = own.take(&sample(seq));
        }
        assert!(!has_none(&last), "{m:?} {last:?}");
        let moved = (0..3).map(|k| (last.position_m[k] - sound.position_m[k]).abs()).fold(0.0, f32::max);
        assert!(moved < 1e-4, "{m:?}: the object is {moved} m off");
        assert_eq!(last.validity & (validity::SAMPLE | validity::WAITING), 0, "{m:?} {last:?}");
    }
}
