//! Whatever comes over the line or lies in a file, decoder, predictor and readers answer and
//! go on. `make fuzz` searches the same claims guided by coverage.

use std::path::Path;

use postcard_rpc::{Endpoint, Topic};
use proptest::prelude::*;
use stickslip_data::Index;
use stickslip_selftest::push;
use stickslip_shared::model::{Friction, Shape};
use stickslip_shared::predictor::{Intent, Limits, Plan, Predictor, Segment, flags, validity};
use stickslip_shared::wire::frame::{FrameError, FrameReader, MAX_LINE, encode};
use stickslip_shared::wire::{self, Pose, Sample};

/// Any bit pattern: infinities, NaNs and subnormal numbers among them.
fn any_f32() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits)
}

fn any_pose() -> impl Strategy<Value = Pose> {
    (prop::array::uniform3(any_f32()), prop::array::uniform4(any_f32()))
        .prop_map(|(position_m, quaternion)| Pose { position_m, quaternion })
}

fn any_sample() -> impl Strategy<Value = Sample> {
    let wrench = || prop::option::of(prop::array::uniform6(any_f32()));
    let pose = || prop::option::of(any_pose());
    (any::<u32>(), any::<u32>(), any_f32(), pose(), pose(), pose(), wrench(), wrench()).prop_map(
        |(seq, t_us, grip_cmd_n, gripper, object, pusher, a, b)| Sample {
            seq,
            t_us,
            grip_cmd_n,
            gripper,
            object,
            pusher,
            finger: [a, b],
        },
    )
}

/// Plausible poses and wrenches, so that the model steps, with one number that is anything.
fn almost_sound(seq: u32, at: usize, value: f32) -> Sample {
    let x = 0.3 - 4e-5 * seq as f32;
    let pose = |x| Pose { position_m: [x, 0.1, 0.2], quaternion: [1.0, 0.0, 0.0, 0.0] };
    let mut sample = Sample {
        seq,
        t_us: seq * wire::TICK_US,
        grip_cmd_n: 20.0,
        gripper: Some(pose(x)),
        object: Some(pose(0.3)),
        pusher: Some(pose(0.2502)),
        finger: [Some([-3.0, -20.0, 1.0, 0.0, 0.0, 0.0]), Some([-3.0, 20.0, 1.0, 0.0, 0.0, 0.0])],
    };
    let Sample { grip_cmd_n, gripper, object, pusher, finger, .. } = &mut sample;
    let poses = [gripper, object, pusher].into_iter().flatten();
    let numbers = poses
        .flat_map(|p| p.position_m.iter_mut().chain(&mut p.quaternion))
        .chain(finger.iter_mut().flatten().flatten());
    if let Some(number) = std::iter::once(grip_cmd_n).chain(numbers).nth(at) {
        *number = value;
    }
    sample
}

fn frames(reader: &mut FrameReader, bytes: &[u8]) -> Vec<Result<(u32, Vec<u8>), FrameError>> {
    let mut found = Vec::new();
    for byte in bytes {
        if let Some(result) = reader.push(*byte) {
            found.push(result.map(|frame| (frame.seq, frame.body.to_vec())));
        }
    }
    found
}

proptest! {
    #[test]
    fn after_any_bytes_the_next_frame_is_read(garbage: Vec<u8>, sample in any_sample()) {
        let mut reader = FrameReader::new();
        frames(&mut reader, &garbage);
        frames(&mut reader, &[0]);
        let mut line = [0; MAX_LINE];
        let sent = encode(wire::Samples::TOPIC_KEY, 7, &sample, &mut line).unwrap();
        let found = frames(&mut reader, sent);
        prop_assert_eq!(found.len(), 1);
        let (seq, body) = found[0].clone().unwrap();
        prop_assert_eq!(seq, 7);
        prop_assert_eq!(body, postcard::to_allocvec(&sample).unwrap());
    }

    #[test]
    fn a_frame_with_a_changed_byte_is_never_taken_for_a_sound_one(
        sample in any_sample(), at: prop::sample::Index, change in 1..=u8::MAX
    ) {
        let mut line = [0; MAX_LINE];
        let mut sent = encode(wire::Samples::TOPIC_KEY, 7, &sample, &mut line).unwrap().to_vec();
        let at = at.index(sent.len());
        sent[at] ^= change;
        sent.push(0);
        prop_assert!(frames(&mut FrameReader::new(), &sent).iter().all(Result::is_err));
    }

    #[test]
    fn sound_frames_with_any_body_decode_or_are_refused(body: Vec<u8>) {
        let mut line = [0; MAX_LINE];
        let body = heapless::Vec::<u8, 256>::from_iter(body.into_iter().take(256));
        let Some(bytes) = encode(wire::SetPlan::REQ_KEY, 1, &body, &mut line) else { return Ok(()) };
        let bytes = bytes.to_vec();
        let mut reader = FrameReader::new();
        for byte in bytes {
            if let Some(Ok(frame)) = reader.push(byte) {
                let plan: Option<Plan> = frame.decode();
                // What decodes is still checked before it touches anything.
                if let Some(plan) = plan && wire::check::plan(&plan).is_ok() {
                    let finite = |s: &Segment| s.velocity_m_s.iter().chain(&s.angular_rad_s).all(|x| x.is_finite());
                    prop_assert!(plan.segments.iter().all(finite));
                }
                let _: Option<wire::Calibration> = frame.decode();
                let _: Option<wire::ModelPackage> = frame.decode();
            }
        }
    }

    #[test]
    fn any_samples_get_an_answer_of_bounded_cost_that_claims_nothing_it_does_not_know(
        samples in prop::collection::vec(any_sample(), 1..12)
    ) {
        let (scene, model, _) = push(0.2, 0.3);
        let mut predictor = Predictor::new(scene, model, Limits::default()).unwrap();
        for sample in &samples {
            let p = predictor.take(sample);
            prop_assert!(p.solver_iterations <= 600);
            prop_assert!(p.position_m.iter().chain(&p.quaternion).all(|x| x.is_finite()), "{:?}", p);
        }
    }

    #[test]
    fn one_wild_number_in_a_push_does_not_outlast_itself(
        at in 0_usize..34, value in any_f32(), when in 10_u32..30
    ) {
        let (scene, model, _) = push(0.2, 0.3);
        let mut predictor = Predictor::new(scene, model, Limits::default()).unwrap();
        let mut segments = heapless::Vec::new();
        let _ = segments.push(Segment {
            duration_s: 5.0, velocity_m_s: [-0.01, 0.0, 0.0], angular_rad_s: [0.0; 3], grip_n: 20.0,
            intent: Intent::Slide,
        });
        predictor.set_plan(Plan { start_s: 0.0, segments });
        let mut last = predictor.take(&almost_sound(0, usize::MAX, 0.0));
        for seq in 1..60 {
            let at = if seq == when { at } else { usize::MAX };
            last = predictor.take(&almost_sound(seq, at, value));
            prop_assert!(last.position_m.iter().all(|x| x.is_finite()));
        }
        // Half a second later the model follows the rig again.
        let doubt = validity::WAITING | validity::SAMPLE | validity::WRENCH;
        prop_assert_eq!(last.validity & doubt, 0);
        prop_assert!((last.position_m[0] - 4e-5 * 59.0).abs() < 2e-3, "{:?}", last);
        prop_assert!(last.flags & flags::DROP == 0, "{:?}", last);
    }

    #[test]
    fn a_model_with_any_numbers_is_run_or_refused(
        mass_kg in any_f32(), side_m in any_f32(), friction in prop::array::uniform3(any_f32())
    ) {
        let (mut scene, mut model, _) = push(0.2, 0.3);
        scene.object.mass_kg = mass_kg;
        scene.object.shape = Shape::Prism { length_m: 0.1, side_m };
        model.friction = Friction { finger: friction[0], pusher: friction[1], support: friction[2] };
        if let Ok(mut predictor) = Predictor::new(scene, model, Limits::default()) {
            prop_assert!(mass_kg > 0.0 && side_m > 0.0 && friction.iter().all(|m| (0.0..=10.0).contains(m)));
            for seq in 0..3 {
                let p = predictor.take(&almost_sound(seq, usize::MAX, 0.0));
                prop_assert!(p.solver_iterations <= 600);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_data_set_with_any_byte_changed_is_read_or_refused_with_its_file_named(
        which in 0_usize..3, at: prop::sample::Index, byte: u8
    ) {
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
        let folder = tempfile::tempdir().unwrap();
        let names = ["dataset.toml", "trials.csv", "trials/roll-obj1-g3-v15-r1.csv"];
        std::fs::create_dir(folder.path().join("trials")).unwrap();
        for (k, name) in names.iter().enumerate() {
            let mut bytes = std::fs::read(from.join(name)).unwrap();
            if k == which {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        let text = match Index::open(folder.path()) {
            Err(error) => error.to_string(),
            Ok(index) => {
                let roll = index.trials.iter().find(|t| t.trial.starts_with("roll"));
                match roll.map(|t| index.read_trial(t)) {
                    Some(Err(error)) => error.to_string(),
                    _ => return Ok(()),
                }
            }
        };
        prop_assert!(names.iter().any(|name| text.contains(name)) || text.contains("trials"), "{}", text);
    }
}

#[test]
fn hours_later_and_over_the_wrap_of_its_time_stamp_a_push_gives_the_same_predictions() {
    let run = |start_us: u32| {
        let (scene, model, _) = push(0.2, 0.3);
        let mut predictor = Predictor::new(scene, model, Limits::default()).unwrap();
        let mut out = Vec::new();
        for seq in 0..400 {
            let mut sample = almost_sound(seq, usize::MAX, 0.0);
            sample.t_us = start_us.wrapping_add(sample.t_us);
            out.push(predictor.take(&sample));
        }
        out
    };
    let fresh = run(0);
    assert!(fresh.iter().any(|p| p.flags & flags::SLIP_1 != 0));
    for start_us in [1, 2_000_000_000, u32::MAX - 700_000] {
        assert_eq!(
            run(start_us).last().map(|p| p.words().collect::<Vec<_>>()),
            fresh.last().map(|p| p.words().collect())
        );
    }
}
