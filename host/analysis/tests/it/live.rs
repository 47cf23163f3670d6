//! Samples as they come, one by one: the same predictions as of the record, whatever the clock does.

use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::live::{Live, LiveError, PlanError, SampleError, limits_of_json, plan_of_json};
use stickslip_analysis::run::replay::{Converter, feed, plan_for, replay};
use stickslip_analysis::run::summary::Document;
use stickslip_data::{Description, Sample, Trial, TrialInfo};
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, objects};
use stickslip_shared::predictor::{HASH_START, Limits, Plan, Prediction, validity};

fn push() -> (Description, Trial) {
    let description = objects::bench("live");
    let reality = Reality::draw(&description, Nuisance::PAPER, 8);
    let setup = Setup { description, reality, step_s: STEP_S };
    let condition =
        Condition { grip_n: 20.0, speed_m_s: 0.01, ..Condition::new(Primitive::LinearPush, "obj4") };
    let mut trial = stickslip_rig::run(&setup, &condition, 1, 2).expect("the rig runs").trial;
    // As the trial is read from a table.
    for s in &mut trial.samples {
        for pose in [&mut s.gripper, &mut s.object, &mut s.pusher].into_iter().flatten() {
            *pose = pose.normalised().expect("a rotation");
        }
    }
    (setup.description, trial)
}

fn live(description: &Description, trial: &Trial, plan: Plan) -> Live {
    Live::new(description, &trial.info, 3, plan, &default_model(), Limits::default()).expect("a predictor")
}

fn at(sample: &Sample, by_s: f64) -> Sample {
    Sample { t_s: sample.t_s + by_s, ..*sample }
}

#[test]
fn samples_one_by_one_are_predicted_bit_for_bit_as_their_record() {
    let (description, trial) = push();
    let record = replay(&description, &trial, &default_model(), Limits::default(), 3).expect("a replay");
    // As a trial's clock counts, and as one that counts from 1970.
    for by_s in [0.0, 1.7e9] {
        let mut live = live(&description, &trial, plan_for(&trial));
        let said: Vec<Prediction> =
            trial.samples.iter().map(|s| live.step(&at(s, by_s)).expect("a sample")).collect();
        assert_eq!(live.hash(), record.hash, "by {by_s} s");
        assert!(said == record.predictions);
    }
}

#[test]
fn the_plan_of_a_replays_document_is_the_plan_of_the_replay() {
    let (description, trial) = push();
    let plan = plan_for(&trial);
    let replayed = replay(&description, &trial, &default_model(), Limits::default(), 3).expect("a replay");
    let t_s: Vec<f64> = trial.samples.iter().map(|s| s.t_s).collect();
    let document = Document::new("push", &t_s, &plan, &replayed, None);
    let text = serde_json::to_string(&document.plan).expect("JSON");
    assert!(plan.segments.len() > 1);
    assert_eq!(plan_of_json(&text).expect("a plan"), plan);
}

#[test]
fn a_plan_that_is_given_on_the_way_counts_from_its_sample() {
    let (description, trial) = push();
    let mut given = live(&description, &trial, Plan::default());
    let first = given.step(&trial.samples[0]).expect("a sample");
    given.set_plan(plan_for(&trial), None);
    let mut known = live(&description, &trial, plan_for(&trial));
    assert_eq!(first.flags, known.step(&trial.samples[0]).expect("a sample").flags);
    for sample in &trial.samples[1..] {
        assert!(given.step(sample).expect("a sample") == known.step(sample).expect("a sample"));
    }
    let mut none = live(&description, &trial, Plan::default());
    let said = trial.samples.iter().map(|s| none.step(s).expect("a sample")).last().expect("samples");
    assert_ne!(said.validity & validity::NO_PLAN, 0);
}

#[test]
fn a_sample_that_is_refused_changes_nothing() {
    let (description, trial) = push();
    let (mut tried, mut spared) =
        (live(&description, &trial, plan_for(&trial)), live(&description, &trial, plan_for(&trial)));
    for sample in &trial.samples[..100] {
        tried.step(sample).expect("a sample");
        spared.step(sample).expect("a sample");
    }
    let good = trial.samples[100];
    let with = |change: &dyn Fn(&mut Sample)| {
        let mut bad = good;
        change(&mut bad);
        bad
    };
    let refused = [
        (with(&|s| s.t_s = f64::NAN), "t_s has a number that is not finite"),
        (with(&|s| s.t_s = trial.samples[99].t_s), "time does not rise"),
        (with(&|s| s.t_s -= 1.0), "time does not rise"),
        (with(&|s| s.grip_cmd_n = Some(-1.0)), "grip_n is -1"),
        (with(&|s| s.finger[1].as_mut().expect("measured").torque_nm[2] = f64::INFINITY), "finger2 has"),
        (with(&|s| s.object.as_mut().expect("seen").position_m[0] = f64::NAN), "object has"),
        (
            with(&|s| s.gripper.as_mut().expect("seen").quaternion = [0.0; 4]),
            "gripper: the quaternion's norm is 0",
        ),
    ];
    for (sample, words) in refused {
        let text = tried.step(&sample).expect_err(words).to_string();
        assert!(text.contains(words), "{text}");
    }
    for sample in &trial.samples[100..] {
        assert!(tried.step(sample).expect("a sample") == spared.step(sample).expect("a sample"));
    }
    assert_eq!(tried.hash(), spared.hash());
}

#[test]
fn after_a_restart_the_clock_may_say_anything_and_the_grasp_is_new() {
    let (description, trial) = push();
    let record = replay(&description, &trial, &default_model(), Limits::default(), 3).expect("a replay");
    let mut live = live(&description, &trial, plan_for(&trial));
    for sample in &trial.samples[..200] {
        live.step(&at(sample, 5000.0)).expect("a sample");
    }
    let back = live.step(&trial.samples[0]).expect_err("the clock went back");
    assert!(matches!(back, SampleError::TimeNotRising { .. }));
    live.restart();
    live.reset_friction();
    live.set_plan(plan_for(&trial), None);
    assert_eq!(live.hash(), HASH_START);
    let said: Vec<Prediction> = trial.samples.iter().map(|s| live.step(s).expect("a sample")).collect();
    let waits = |p: &Prediction| p.validity & validity::WAITING != 0;
    assert!(!said.iter().any(waits));
    // What was learnt of the sensors' noise stays: flags are those of a predictor that has not run before, bits need not be.
    let differ = said.iter().zip(&record.predictions).filter(|(a, b)| a.flags != b.flags).count();
    assert!(differ * 20 < said.len(), "{differ} of {} ticks", said.len());
}

#[test]
fn after_a_pause_of_any_length_prediction_goes_on() {
    let (description, trial) = push();
    // 0.2 s; 40 minutes, which 32 bits of microseconds could take for the past; a day.
    for pause_s in [0.2, 2400.0, 86_400.0] {
        let mut live = live(&description, &trial, plan_for(&trial));
        for sample in &trial.samples[..100] {
            live.step(sample).expect("a sample");
        }
        let after: Vec<Prediction> =
            trial.samples[100..200].iter().map(|s| live.step(&at(s, pause_s)).expect("a sample")).collect();
        let lost = |p: &&Prediction| p.validity & (validity::SAMPLE | validity::WAITING) != 0;
        let lost = after.iter().filter(lost).count();
        assert!(lost < 20, "{pause_s} s: {lost} of 100 ticks without a prediction");
        assert!(after.last().is_some_and(|p| p.validity & validity::NO_FORESIGHT == 0));
    }
}

#[test]
fn stamps_of_a_record_of_hours_wrap_around_as_a_boards_do() {
    let mut convert = Converter::since(10.0, &TrialInfo::default());
    let stamp = |convert: &mut Converter, t_s: f64| convert.sample(&Sample { t_s, ..Sample::default() }).t_us;
    assert_eq!(stamp(&mut convert, 10.0), 0);
    assert_eq!(stamp(&mut convert, 10.004), 4000);
    let wrapped_s = 2f64.powi(32) * 1e-6;
    assert_eq!(stamp(&mut convert, 10.0 + wrapped_s - 1e-6), u32::MAX);
    assert_eq!(stamp(&mut convert, 10.0 + wrapped_s + 0.004), 4000);
}

#[test]
fn an_object_a_plan_or_a_limit_that_cannot_be_is_refused_with_what_can() {
    let (description, trial) = push();
    let info = TrialInfo { object: "obj99".into(), ..trial.info.clone() };
    let refused = Live::new(&description, &info, 0, Plan::default(), &default_model(), Limits::default());
    let text = refused.expect_err("no such object").to_string();
    assert!(
        text.contains("obj99") && text.contains("no such object in dataset.toml, which has obj1"),
        "{text}"
    );
    let limits = Limits { sag_m: -1.0, ..Limits::default() };
    let refused = Live::new(&description, &trial.info, 0, Plan::default(), &default_model(), limits);
    assert!(matches!(refused, Err(LiveError::Refused(_))));

    let segment = r#"{"duration_s": 1, "grip_n": 20}"#;
    assert_eq!(plan_of_json(&format!("[{segment}]")).expect("a plan").segments.len(), 1);
    let nine = [segment; 9].join(",");
    assert!(matches!(plan_of_json(&format!("[{nine}]")), Err(PlanError::TooLong(9))));
    for (rows, words) in [
        (r#"[{"duration_s": 1}]"#, "grip_n"),
        (r#"[{"duration_s": 1, "grip_n": 20, "speed": 1}]"#, "unknown field `speed`"),
        (r#"[{"duration_s": 1, "grip_n": 20, "intent": "throw"}]"#, "throw"),
        (r#"[{"duration_s": -1, "grip_n": 20}]"#, "Duration is -1; give 0 to 3600"),
        (r#"[{"duration_s": 1, "grip_n": 20, "velocity_m_s": [0, 0, 9]}]"#, "Velocity is 9; give -5 to 5"),
    ] {
        let text = plan_of_json(rows).expect_err(words).to_string();
        assert!(text.contains(words), "{text}");
    }

    assert_eq!(limits_of_json("{}").expect("limits"), Limits::default());
    let of = limits_of_json(r#"{"sag_m": 0.01}"#).expect("limits");
    assert_eq!(of, Limits { sag_m: 0.01, ..Limits::default() });
    let text = limits_of_json(r#"{"sag": 0.01}"#).expect_err("no limit").to_string();
    assert!(text.contains("no limit `sag`; there are") && text.contains("sag_m"), "{text}");
}

#[test]
fn a_grip_command_holds_until_the_next() {
    let (description, trial) = push();
    let fed = feed(&description, &trial).expect("a scene");
    let mut said = live(&description, &trial, fed.plan.clone());
    let mut once = live(&description, &trial, fed.plan);
    let commanded = trial.info.grip_n;
    for sample in &trial.samples {
        let each = Sample { grip_cmd_n: commanded, ..*sample };
        let first = Sample { grip_cmd_n: None, ..*sample };
        assert!(said.step(&each).expect("a sample") == once.step(&first).expect("a sample"));
    }
}
