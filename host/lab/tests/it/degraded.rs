//! A push of the demonstration as a faulty rig would have recorded it: the predictor says that it is unsure.

use std::path::Path;

use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::replay::feed;
use stickslip_data::Index;
use stickslip_lab::degrade::Fault;
use stickslip_shared::predictor::{Limits, Prediction, Predictor, flags, validity};

/// Predictions of the first trial, and their times, s.
fn predicted(fault: Option<Fault>) -> Vec<(f64, Prediction)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let index = Index::open(&folder).expect("the demonstration");
    let trial = index.read_trial(&index.trials[0]).expect("a trial");
    let mut feed = feed(&index.description, &trial).expect("a scene");
    let mut model = default_model();
    if let Some(fault) = fault {
        fault.apply(&mut feed.samples, &mut model);
    }
    let mut predictor = Predictor::new(feed.scene, model.cast(), Limits::default()).expect("a model");
    predictor.set_plan(feed.plan);
    feed.samples.iter().map(|sample| (f64::from(sample.t_us) * 1e-6, predictor.take(sample))).collect()
}

/// Share of the ticks after a second in which `holds`.
fn share(predictions: &[(f64, Prediction)], holds: impl Fn(&Prediction) -> bool) -> f64 {
    let late: Vec<bool> = predictions.iter().filter(|(t_s, _)| *t_s > 1.0).map(|(_, p)| holds(p)).collect();
    assert!(late.len() > 100, "{}", late.len());
    late.iter().filter(|holds| **holds).count() as f64 / late.len() as f64
}

fn unsure(p: &Prediction) -> bool {
    p.flags & flags::UNSURE != 0
}

#[test]
fn a_good_push_is_sure_and_one_with_a_frozen_pose_or_without_a_finger_is_not() {
    assert!(share(&predicted(None), unsure) < 0.05);
    for fault in [Fault::PoseFrozen, Fault::FingerMissing] {
        assert_eq!(share(&predicted(Some(fault)), unsure), 1.0, "{fault:?}");
    }
}

#[test]
fn a_pose_that_is_missing_or_rare_is_not_doubted_and_one_held_between_frames_is() {
    let doubted = |p: &Prediction| p.validity & validity::POSE != 0;
    for (fault, expected) in [(Fault::PoseGone, 0.0), (Fault::PoseRare, 0.0), (Fault::PoseHeld, 1.0)] {
        assert_eq!(share(&predicted(Some(fault)), doubted), expected, "{fault:?}");
    }
}
