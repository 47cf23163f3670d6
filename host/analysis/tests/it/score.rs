//! Events and alarms on lifts of the rig whose course is known.

use crate::lifts;
use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::replay::{Replayed, plan_for, replay};
use stickslip_analysis::run::scene::scene;
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::document::{Options, score_tuned};
use stickslip_analysis::score::figures::{Case, Class, Outcome};
use stickslip_analysis::score::traces::{Drawn, cases, traces};
use stickslip_analysis::score::truth::{Cause, Kind, Truth, find};
use stickslip_data::{Dataset, Index};
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Scenario, Setup, objects, run};
use stickslip_shared::predictor::{Checked, Intent, Limits, Plan, flags};

const ALARMS: u32 =
    flags::SLIP_1 | flags::SLIP_2 | flags::SLIP_AHEAD_1 | flags::SLIP_AHEAD_2 | flags::DROP | flags::SAG;

/// Time stamps, truth and predictions of a lift.
fn lift(scenario: Scenario) -> (Vec<f64>, Truth, Replayed) {
    let (description, trial) = lifts::lift(scenario);
    let limits = Limits::default();
    let rig = scene(&description, &trial).expect("a scene");
    let truth = find(&rig, &trial, &limits);
    let replayed = replay(&description, &trial, &default_model(), limits, 0).expect("replays");
    (trial.samples.iter().map(|s| s.t_s).collect(), truth, replayed)
}

#[test]
fn a_steady_lift_has_no_event_and_no_alarm() {
    let (t, truth, replayed) = lift(Scenario::Steady);
    assert!(truth.events.is_empty() && truth.near.is_empty(), "{:?} {:?}", truth.events, truth.near);
    for (t, p) in t.iter().zip(&replayed.predictions) {
        assert_eq!(p.flags & ALARMS, 0, "at {t} s: {p:?}");
    }
}

#[test]
fn a_load_beyond_friction_is_dated_to_within_16_ms_of_it_and_flagged_within_20_ms_more() {
    // At 2.1 s, within 10 ms; friction bears 4.1 N, the load and the weight are 6 N.
    let (at_s, force_n) = (2.1, [0.0, 0.0, -4.0]);
    let (t, truth, replayed) = lift(Scenario::SuddenLoad { force_n, at_s });
    let slip = truth.events.iter().find(|e| e.kind == Kind::Slip).expect("it slips");
    assert!((at_s..at_s + 0.016).contains(&slip.onset_s), "onset {}", slip.onset_s);
    assert_eq!((slip.cause, slip.intended), (Cause::Sudden, false));
    let flagged =
        t.iter().zip(&replayed.predictions).find(|(_, p)| p.flags & ALARMS != 0).expect("flagged").0;
    assert!((at_s..slip.onset_s + 0.0205).contains(flagged), "flagged at {flagged}, onset {}", slip.onset_s);
    assert!(truth.events.iter().any(|e| e.kind == Kind::Drop), "half a second of it drops the object");
}

#[test]
fn a_grip_that_decays_is_warned_of_100_ms_before_the_slip_and_360_ms_before_the_drop() {
    let scenario = Scenario::DecayingGrip { share: 0.3, from_s: 1.3, until_s: 2.3 };
    let (t, truth, replayed) = lift(scenario);
    let onset = |kind| truth.events.iter().find(|e| e.kind == kind).map(|e| e.onset_s).expect("happens");
    let first = |bits: u32| {
        t.iter()
            .zip(&replayed.predictions)
            .find(|(_, p)| p.flags & bits != 0)
            .map(|(t, _)| *t)
            .expect("flagged")
    };
    let slip = onset(Kind::Slip) - first(flags::SLIP_AHEAD_1 | flags::SLIP_1);
    let drop = onset(Kind::Drop) - first(flags::DROP);
    assert!(slip >= 0.1, "slip warned {slip} s ahead");
    assert!(drop >= 0.36, "drop warned {drop} s ahead");
    assert!(first(flags::SLIP_AHEAD_1) > 1.3, "not before the grip falls");
}

/// obj4 pushed 15 mm against the plate with the fingers' friction given, ordinary noise and constant
/// errors. Plan, truth, predictions and the exact height of the object in the grasp, downwards, m.
fn pushed(mu_finger: f64, grip_n: f64, slope_rad: f64) -> (Plan, Truth, Replayed, Vec<f64>) {
    let description = objects::bench("score");
    let mut reality = Reality::draw(&description, Nuisance::PAPER, 3);
    reality.mu_finger = mu_finger;
    let setup = Setup { description, reality, step_s: STEP_S };
    let condition =
        Condition { grip_n, slope_rad, rest_s: 0.5, ..Condition::new(Primitive::LinearPush, "obj4") };
    let outcome = run(&setup, &condition, 1, 5).expect("the rig runs");
    let limits = Limits::default();
    let rig = scene(&setup.description, &outcome.trial).expect("a scene");
    let truth = find(&rig, &outcome.trial, &limits);
    let replayed = replay(&setup.description, &outcome.trial, &default_model(), limits, 0).expect("replays");
    let plan = plan_for(&outcome.trial);
    // Across the push: the object stays where it is in the world, but for its sag.
    let exact: Vec<f64> = outcome
        .exact
        .iter()
        .map(|e| {
            let way: [f64; 3] = std::array::from_fn(|i| e.object.0[i] - e.gripper.0[i]);
            let start = &outcome.exact[0];
            let first: [f64; 3] = std::array::from_fn(|i| start.object.0[i] - start.gripper.0[i]);
            let moved: [f64; 3] = std::array::from_fn(|i| way[i] - first[i]);
            let along = [-slope_rad.cos(), 0.0, slope_rad.sin()];
            let slid: f64 = moved.iter().zip(along).map(|(a, b)| a * b).sum();
            along[2] * slid - moved[2]
        })
        .collect();
    (plan, truth, replayed, exact)
}

#[test]
fn a_push_that_keeps_its_height_has_no_sag_and_no_unexpected_slip_in_prediction_and_truth() {
    // On a slope the rig's object does sag across the push: 1.2 mm at 0.17 rad.
    let slope_rad = 0.0;
    {
        let (plan, truth, replayed, exact) = pushed(0.4, 20.0, slope_rad);
        let most = exact.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!(most < 2e-4, "the object keeps its height: {most} m");
        assert!(truth.events.iter().all(|e| e.kind != Kind::Moved), "{:?}", truth.events);
        let stated = replayed.predictions.iter().fold(0.0_f32, |m, p| m.max(p.sag_m));
        assert!(stated < 4e-4, "slope {slope_rad}: {stated} m stated, {most} m exact");
        for (k, p) in replayed.predictions.iter().enumerate() {
            let bits = flags::SAG | flags::UNEXPECTED | flags::DROP;
            assert_eq!(p.flags & bits, 0, "slope {slope_rad}, tick {k}: {p:?} under {plan:?}");
        }
        // What is at rest means to hold.
        for s in &plan.segments {
            let moves = s.velocity_m_s != [0.0; 3];
            assert_eq!(s.intent, if moves { Intent::Slide } else { Intent::Hold }, "{plan:?}");
        }
        assert!(plan.segments.iter().any(|s| s.intent == Intent::Hold), "{plan:?}");
    }
}

#[test]
fn a_push_that_sags_is_flagged_and_its_sag_stated_within_a_fifth() {
    let (_, truth, replayed, exact) = pushed(0.15, 12.0, 0.0);
    let sagged = exact[exact.len() - 1];
    assert!(sagged > 2.5e-3, "{sagged} m");
    let stated = f64::from(replayed.predictions[exact.len() - 1].sag_m);
    assert!((stated / sagged - 1.0).abs() < 0.2, "{stated} m stated, {sagged} m exact");
    let t = exact.iter().position(|x| *x > f64::from(Limits::default().sag_m)).expect("beyond the limit");
    let event = truth.events.iter().find(|e| e.kind == Kind::Moved).expect("found");
    assert!((event.onset_s - t as f64 * 0.004).abs() < 0.1, "{event:?}, exact {}", t as f64 * 0.004);
    assert!(replayed.predictions.iter().any(|p| p.flags & flags::SAG != 0));
}

/// A score of one lift, the predictor being given the object's pose as `object_pose` says, and what its page draws.
fn scored(object_pose: ObjectPose) -> (Vec<(Class, Case)>, Drawn) {
    let (description, mut trial) = lifts::lift(Scenario::SuddenLoad { force_n: [0.0, 0.0, -4.0], at_s: 2.1 });
    trial.info.trial = "lift".to_owned();
    let index = Index::from(Dataset { folder: "lifts".into(), description, trials: vec![trial] });
    let (model, tuning) = (default_model(), Checked::default());
    let options = Options { object_pose, ..Options::default() };
    let document = score_tuned(&index, &model, &tuning, &options, &()).expect("a score");
    // In the document's words, each failure is listed.
    let ours = document.rows.iter().filter(|r| r.method == document.rows[0].method);
    let failed: Vec<&String> = ours.flat_map(|r| r.not_in_time.iter().chain(&r.false_alarms)).collect();
    let listed: Vec<String> = cases(&document)
        .iter()
        .filter(|(_, case)| case.fails())
        .map(|(_, case)| format!("{} at {:.3} s", case.trial, case.at_s))
        .collect();
    assert!(
        failed.iter().all(|f| listed.contains(f)) && listed.iter().all(|l| failed.contains(&l)),
        "{failed:?}: {listed:?}"
    );
    (cases(&document), traces(&index, &model, &tuning, &document, 24))
}

#[test]
fn each_failure_has_a_trace_about_it_and_where_nothing_fails_an_event_of_each_class_has() {
    // Without the object's pose sag is found late or not at all.
    for (pose, fails) in [(ObjectPose::Every, false), (ObjectPose::Start, true)] {
        let (cases, drawn) = scored(pose);
        assert!(!cases.is_empty() && drawn.shown.len() == cases.len(), "{cases:?}");
        assert_eq!(cases.iter().any(|(_, case)| case.fails()), fails, "{cases:?}");
        for shown in &drawn.shown {
            let trace = &drawn.traces[shown.trace.expect("drawn")];
            let (first, last) = (trace.t_s[0], trace.t_s[trace.t_s.len() - 1]);
            let case = &shown.case;
            assert!(
                first <= case.at_s && case.at_s <= last && last - first < 8.0,
                "{first} to {last}: {case:?}"
            );
            assert_eq!((trace.samples.len(), trace.predictions.len()), (trace.t_s.len(), trace.t_s.len()));
            let (at, alarm) =
                (case.at_s, flags::SLIP_1 | flags::SLIP_2 | flags::SAG | flags::ROTATION | flags::DROP);
            match case.outcome {
                // What it is about is in it: the event, or the flag that rose.
                Outcome::FalseAlarm => {
                    let here = trace.t_s.iter().position(|t| *t == at).expect("a tick");
                    let ahead = flags::SLIP_AHEAD_1 | flags::SLIP_AHEAD_2;
                    assert!(trace.predictions[here].flags & (alarm | ahead) != 0, "{case:?}");
                }
                _ => assert!(trace.events.iter().any(|e| e.onset_s == at), "{case:?}"),
            }
        }
    }
}
