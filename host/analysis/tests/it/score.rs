//! Events and alarms on lifts of the rig whose course is known.

use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::replay::{Replayed, feed, replay};
use stickslip_analysis::run::simulate::scene;
use stickslip_analysis::score::truth::{Cause, Kind, Truth, find};
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Scenario, Setup, objects, run};
use stickslip_shared::predictor::{Limits, flags};

const ALARMS: u32 =
    flags::SLIP_1 | flags::SLIP_2 | flags::SLIP_AHEAD_1 | flags::SLIP_AHEAD_2 | flags::DROP | flags::SAG;

/// obj4 (0.2005 kg) lifted with twice the grip that friction of 0.4 needs: friction 0.42,
/// ordinary noise and constant errors. Time stamps, truth and predictions.
fn lift(scenario: Scenario) -> (Vec<f64>, Truth, Replayed) {
    let description = objects::bench("score");
    let mut reality = Reality::draw(&description, Nuisance::PAPER, 3);
    reality.mu_finger = 0.42;
    let setup = Setup { description, reality, step_s: STEP_S };
    let condition = Condition {
        grip_n: 4.9,
        speed_m_s: 0.06,
        hold_s: 2.0,
        scenario,
        ..Condition::new(Primitive::Lift, "obj4")
    };
    let trial = run(&setup, &condition, 1, 5).expect("the rig runs").trial;
    let limits = Limits::default();
    let rig = scene(&setup.description, &trial).expect("a scene");
    let plan = feed(&setup.description, &trial).expect("a feed").plan;
    let truth = find(&rig, &plan, &trial, &limits);
    let replayed = replay(&setup.description, &trial, &default_model(), limits, 0).expect("replays");
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
