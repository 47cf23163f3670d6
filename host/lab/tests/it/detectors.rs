//! The detectors that the predictor is compared with.

use std::path::Path;

use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::replay::feed;
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::warnings::{Events, Figures, Share, TrialKey};
use stickslip_data::Index;
use stickslip_lab::curves::{Learnt, Point, at_most, features, force_rate, threshold};
use stickslip_lab::grasps::Grasp;

fn truth() -> TrialKey {
    TrialKey { scenario: "b".into(), sub: "slip".into(), ..TrialKey::default() }
}

/// The first trial of the demonstration, its first `samples`.
fn grasp(truth: &TrialKey, samples: usize) -> Grasp<'_> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let index = Index::open(&folder).expect("the demonstration");
    let trial = index.read_trial(&index.trials[0]).expect("a trial");
    let mut feed = feed(&index.description, &trial).expect("a scene");
    feed.samples.truncate(samples);
    let t_s: Vec<f64> = feed.samples.iter().map(|s| f64::from(s.t_us) * 1e-6).collect();
    let until_s = t_s.last().copied().unwrap_or(0.0);
    Grasp { trial: "first", ordinal: 0, truth, feed, model: default_model(), t_s, until_s }
}

#[test]
fn no_detector_sees_what_comes_later() {
    let truth = truth();
    let (whole, half) = (grasp(&truth, 400), grasp(&truth, 200));
    assert_eq!(threshold(&whole)[..200], threshold(&half));
    assert_eq!(force_rate(&whole)[..200], force_rate(&half));
    for pose in [ObjectPose::Every, ObjectPose::Start] {
        assert_eq!(features(&whole, pose)[..200], features(&half, pose));
    }
}

#[test]
fn trees_learn_what_a_feature_tells() {
    let truth = truth();
    let grasp = grasp(&truth, 400);
    let ratio = threshold(&grasp);
    let middle = 0.5 * ratio.iter().copied().fold(0.0, f64::max);
    let above = |x: &f64| f64::from(u8::from(*x > middle));
    let rows = features(&grasp, ObjectPose::Start).into_iter().zip(ratio.iter().map(above)).collect();
    let said = Learnt::from(rows).unwrap().course(&grasp, ObjectPose::Start).unwrap();
    let right = said.iter().zip(&ratio).filter(|(s, r)| (**s > 0.5) == (**r > middle)).count();
    assert!(right > 390, "{right}");
    assert!(Learnt::from(Vec::new()).is_err());
}

fn point(level: f64, found: usize, count: usize, up: usize) -> Point {
    let mut figures = Figures { builds_up: Share { found, of: 10 }, ..Figures::default() };
    figures.false_slip.insert("g".into(), Events { count, hours: 1.0 });
    Point { level, figures, up: Share { found: up, of: 100 } }
}

#[test]
fn of_a_curve_the_point_is_taken_that_finds_most_within_the_false_alarms_allowed() {
    // The first is always up: no alarm of it is false, and it is no detector.
    let curve = [point(0.1, 10, 0, 99), point(0.2, 9, 20, 9), point(0.3, 7, 20, 7), point(0.4, 5, 1, 2)];
    let level = |most: f64| at_most(&curve, (most, 0.1), |f| &f.builds_up).map(|p| p.level);
    assert_eq!([level(60.0), level(20.0), level(19.9), level(0.5)], [Some(0.2), Some(0.2), Some(0.4), None]);
}
