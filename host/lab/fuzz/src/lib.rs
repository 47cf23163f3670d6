//! What must hold for any bytes: `make fuzz` looks for bytes for which it does not, guided by
//! the code that they reach (libFuzzer); what it found is kept in `kept/` and tried by the
//! tests.

pub mod files;

use postcard_rpc::{Endpoint, Topic};
use serde::Serialize;
use serde::de::DeserializeOwned;
use stickslip_selftest::push;
use stickslip_shared::predictor::{HASH_START, Plan, Predictor};
use stickslip_shared::wire::frame::{Frame, FrameReader, MAX_LINE, encode};
use stickslip_shared::wire::{self, ModelPackage, Pose, Sample, TICK_US, check};

/// Whatever comes in, the reader stays in step: a frame after it, behind a 0, is read as it was
/// sent. A sound frame's body is decoded as everything that the table knows; what decodes also
/// encodes, and decodes as the same bytes again.
pub fn line(bytes: &[u8]) {
    let mut reader = FrameReader::new();
    for byte in bytes {
        if let Some(Ok(frame)) = reader.push(*byte) {
            body(&frame);
        }
    }
    // The same bytes as a body behind each key: no checksum is guessed by chance.
    for key in [wire::Samples::TOPIC_KEY, wire::Telemetry::TOPIC_KEY, wire::SetPlan::REQ_KEY] {
        body(&Frame { key, seq: 0, body: bytes });
    }
    reader.push(0);
    let mut line = [0; MAX_LINE];
    let sent = encode(wire::SetGrip::REQ_KEY, 7, &1.5_f32, &mut line).expect("it fits");
    let (last, before) = sent.split_last().expect("not empty");
    assert!(before.iter().all(|byte| reader.push(*byte).is_none()), "a frame before its end");
    let frame = reader.push(*last).expect("a frame at its end").expect("a sound one");
    assert_eq!((frame.key, frame.seq, frame.decode::<f32>()), (wire::SetGrip::REQ_KEY, 7, Some(1.5)));
}

fn body(frame: &Frame<'_>) {
    again::<Sample>(frame);
    again::<wire::TelemetryReport>(frame);
    again::<wire::Info>(frame);
    again::<wire::Statistics>(frame);
    again::<wire::ModelChunk>(frame);
    again::<wire::ModelCommit>(frame);
    again::<wire::Answer>(frame);
    again::<ModelPackage>(frame);
    if let Some(plan) = again::<Plan>(frame) {
        let _ = check::plan(&plan);
    }
    if let Some(calibration) = again::<wire::Calibration>(frame) {
        let _ = check::calibration(&calibration);
    }
    if let Some(request) = again::<wire::StartRequest>(frame) {
        let _ = check::start(&request);
    }
}

/// Through bytes, since a NaN is not equal to itself.
fn again<T: Serialize + DeserializeOwned>(frame: &Frame<'_>) -> Option<T> {
    let value: T = frame.decode()?;
    let mut first = [0; 4096];
    let first = postcard::to_slice(&value, &mut first).expect("what decodes encodes");
    let same: T = postcard::from_bytes(first).expect("what was encoded decodes");
    let mut second = [0; 4096];
    assert_eq!(*first, *postcard::to_slice(&same, &mut second).expect("the same length"));
    Some(value)
}

/// A model, a plan and samples from bytes: whatever the model takes for valid must be run
/// without panic through whatever samples, twice with the same outputs.
///
/// The first byte chooses: a model from the bytes (even), or the push. Then the plan where one
/// decodes, then samples: as they decode, or, where the first bit of the second byte is set,
/// those of a push in which single numbers are replaced by what the bytes say.
pub fn predictor(bytes: &[u8]) {
    let Some((choice, bytes)) = bytes.split_at_checked(2) else { return };
    let (package, bytes) = match choice[0] % 2 {
        0 => match postcard::take_from_bytes::<ModelPackage>(bytes) {
            Ok(taken) => taken,
            Err(_) => return,
        },
        _ => (push(0.2, 0.3), bytes),
    };
    let (plan, bytes) = postcard::take_from_bytes::<Plan>(bytes).unwrap_or((Plan::default(), bytes));
    let samples = if choice[1] % 2 == 0 { decoded(bytes) } else { damaged(bytes) };
    assert_eq!(run(&package, &plan, &samples), run(&package, &plan, &samples), "not the same twice");
}

/// Far more than it takes to settle and look ahead; a run ends soon.
const MOST_SAMPLES: usize = 60;

fn decoded(mut bytes: &[u8]) -> Vec<Sample> {
    let mut samples = Vec::new();
    while let Ok((sample, rest)) = postcard::take_from_bytes(bytes)
        && samples.len() < MOST_SAMPLES
    {
        samples.push(sample);
        bytes = rest;
    }
    samples
}

/// Six bytes a change: sample, place in it, and the number's four.
fn damaged(bytes: &[u8]) -> Vec<Sample> {
    let mut samples: Vec<Sample> = (0..MOST_SAMPLES as u32).map(sound).collect();
    for change in bytes.chunks_exact(6).take(64) {
        let number = f32::from_le_bytes([change[2], change[3], change[4], change[5]]);
        let at = usize::from(change[0]) % MOST_SAMPLES;
        let sample = &mut samples[at];
        let place = usize::from(change[1]);
        let pose = |pose: &mut Option<Pose>, k: usize| {
            if let Some(pose) = pose {
                let all = pose.position_m.iter_mut().chain(&mut pose.quaternion);
                if let Some(x) = all.skip(k).take(1).next() {
                    *x = number;
                }
            }
        };
        match place % 48 {
            k @ 0..=6 => pose(&mut sample.gripper, k),
            k @ 7..=13 => pose(&mut sample.object, k - 7),
            k @ 14..=20 => pose(&mut sample.pusher, k - 14),
            k @ 21..=32 => {
                if let Some(wrench) = &mut sample.finger[(k - 21) / 6] {
                    wrench[(k - 21) % 6] = number;
                }
            }
            33 => sample.grip_cmd_n = number,
            34 => sample.t_us = number.to_bits(),
            35 => sample.gripper = None,
            36 => sample.object = None,
            37 => sample.pusher = None,
            k => sample.finger[k % 2] = None,
        }
    }
    samples
}

fn sound(seq: u32) -> Sample {
    let moved = -0.01 * seq.saturating_sub(20) as f32 * 0.004;
    let at = |x: f32| Some(Pose { position_m: [x, 0.1, 0.2], quaternion: [1.0, 0.0, 0.0, 0.0] });
    let finger = |sign: f32| Some([0.0, sign * 20.0, 1.0, 0.0, 0.0, 0.0]);
    Sample {
        seq,
        t_us: seq * TICK_US,
        grip_cmd_n: 20.0,
        gripper: at(0.3 + moved),
        object: at(0.3),
        pusher: at(0.2498),
        finger: [finger(-1.0), finger(1.0)],
    }
}

fn run((scene, model, limits): &ModelPackage, plan: &Plan, samples: &[Sample]) -> Option<u32> {
    let mut predictor = Predictor::new(scene.clone(), model.clone(), *limits).ok()?;
    predictor.set_plan(plan.clone());
    Some(samples.iter().fold(HASH_START, |hash, sample| predictor.take(sample).hash(hash)))
}
