//! Adding the effect that is missing.

use stickslip_analysis::model::file::ModelFile;
use stickslip_analysis::{add, calibrate, model::candidate};
use stickslip_data::Dataset;
use stickslip_rig::plan::{self, PlanName};
use stickslip_rig::{Condition, HiddenEffect, Kind, Nuisance, Reality, STEP_S, Setup, objects, simulate};

const MU_PUSHER: f64 = 0.22;
const MISMATCH: f64 = 0.2;

/// Pushes at one speed, each twice, with fingers of different friction.
fn pushes() -> Dataset {
    let description = objects::trimmed(objects::bench("pushes"), &["linear_push"], &["obj4"]);
    let mut reality = Reality::draw(&description, Nuisance::PAPER, 5);
    (reality.mu_finger, reality.mu_pusher) = (0.38, MU_PUSHER);
    reality.effects.push(HiddenEffect { kind: Kind::FingerFrictionMismatch, strength: MISMATCH });
    let setup = Setup { reality, description: description.clone(), step_s: STEP_S };
    let mut conditions = plan::conditions(PlanName::PushSmall, &[], 5, 0.0);
    conditions.truncate(9);
    let run = |c: &Condition| [1, 2].map(|run| simulate(&setup, c, run, 5).expect("suits the rig"));
    Dataset { description, trials: conditions.iter().flat_map(run).collect(), folder: Default::default() }
}

#[test]
#[ignore = "long: make test-host-rest"]
fn with_the_missing_effect_add_finds_the_friction_that_a_model_without_it_does_not_determine() {
    let data = pushes();
    let base = calibrate(&data, &ModelFile::default(), &Default::default(), &()).expect("calibrated").model;
    assert!(!base.friction_intervals.contains_key("pusher"), "{:?}", base.friction_intervals);
    let effect = candidate::named("finger_friction_mismatch", &[]).expect("listed");
    let report = add(&data, &base, &[effect], &()).expect("fitted");
    let value = |name: &str| report.parameters.iter().find(|p| p.name == name).expect("fitted").value;
    let (pusher, mismatch) = (value("friction.pusher"), value("finger_friction_mismatch.mismatch"));
    assert!((pusher / MU_PUSHER - 1.0).abs() < 0.1, "{pusher}");
    assert!((mismatch / MISMATCH - 1.0).abs() < 0.1, "{mismatch}");
    // Trials agree to a per cent on a strength that is two per cent off: all of them have the same law.
    let of =
        report.parameters.iter().find(|p| p.name == "finger_friction_mismatch.mismatch").expect("fitted");
    assert!(of.low < MISMATCH && MISMATCH < of.high, "{MISMATCH} is not within {} to {}", of.low, of.high);
    // The rig's contacts of 1e6 N/m, which no loading shows.
    let ids: Vec<&str> = report.model.effects.iter().map(|e| e.name()).collect();
    assert_eq!(ids, ["contact_compliance", "finger_friction_mismatch"]);
    assert!(report.notes.iter().any(|n| n.contains("contact_compliance is added")), "{:?}", report.notes);
}
