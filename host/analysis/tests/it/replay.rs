//! Records that are not as a board takes its samples: other rates, interpolated poses, any length.

use std::path::Path;

use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::replay::{at_board_rate, feed, first_difference, interpolated_poses, run};
use stickslip_data::{Description, Index, Pose, Sample, Trial, Wrench};
use stickslip_rig::{Condition, HiddenEffect, Kind, Nuisance, Primitive, Reality, STEP_S, Setup, objects};
use stickslip_shared::model::{Formulation, Model};
use stickslip_shared::predictor::{Limits, MAX_SEGMENTS, Prediction, flags, validity};

fn push() -> (Description, Trial) {
    let description = objects::bench("replay");
    let reality = Reality::draw(&description, Nuisance::PAPER, 8);
    let setup = Setup { description, reality, step_s: STEP_S };
    let condition =
        Condition { grip_n: 20.0, speed_m_s: 0.01, ..Condition::new(Primitive::LinearPush, "obj4") };
    let trial = stickslip_rig::run(&setup, &condition, 1, 2).expect("the rig runs").trial;
    (setup.description, trial)
}

/// `share` of the way from one sample to the next, as a program that resamples does it.
fn between(a: &Sample, b: &Sample, share: f64) -> Sample {
    fn mix<const N: usize>(a: [f64; N], b: [f64; N], share: f64) -> [f64; N] {
        std::array::from_fn(|k| a[k] + (b[k] - a[k]) * share)
    }
    let pose = |a: Option<Pose>, b: Option<Pose>| {
        let (a, b) = a.zip(b)?;
        let position_m = mix(a.position_m, b.position_m, share);
        Some(Pose { position_m, quaternion: mix(a.quaternion, b.quaternion, share) })
    };
    let wrench = |a: Option<Wrench>, b: Option<Wrench>| {
        let (a, b) = a.zip(b)?;
        let force_n = mix(a.force_n, b.force_n, share);
        Some(Wrench { force_n, torque_nm: mix(a.torque_nm, b.torque_nm, share) })
    };
    Sample {
        t_s: a.t_s + (b.t_s - a.t_s) * share,
        grip_cmd_n: a.grip_cmd_n,
        gripper: pose(a.gripper, b.gripper),
        object: pose(a.object, b.object),
        pusher: pose(a.pusher, b.pusher),
        finger: [0, 1].map(|k| wrench(a.finger[k], b.finger[k])),
        pusher_wrench: wrench(a.pusher_wrench, b.pusher_wrench),
    }
}

fn predictions(description: &Description, trial: &Trial) -> Vec<Prediction> {
    let feed = feed(description, trial).expect("a scene");
    run(&feed, &default_model(), Limits::default(), 0, |_| ()).expect("accepted").predictions
}

#[test]
fn a_record_interpolated_to_1_khz_is_predicted_bit_for_bit_as_at_250_hz() {
    let (description, trial) = push();
    let pairs = trial.samples.windows(2);
    let mut samples: Vec<Sample> =
        pairs.flat_map(|w| [0.0, 0.25, 0.5, 0.75].map(|share| between(&w[0], &w[1], share))).collect();
    samples.extend(trial.samples.last());
    let fast = Trial { info: trial.info.clone(), samples };
    let (taken, every) = at_board_rate(fast);
    assert_eq!((every, taken.samples.len()), (4, trial.samples.len()));
    let logged: Vec<(usize, Prediction)> =
        predictions(&description, &trial).into_iter().enumerate().collect();
    assert_eq!(first_difference(&logged, &predictions(&description, &taken)), None);
    // A record at the board's own rate, or below it, is taken as it is.
    let slow =
        Trial { info: trial.info.clone(), samples: trial.samples.iter().step_by(2).copied().collect() };
    for whole in [trial, slow] {
        assert_eq!(at_board_rate(whole.clone()), (whole, 1));
    }
}

#[test]
fn poses_interpolated_from_60_to_120_hz_are_told_and_measured_ones_are_not() {
    let (_, trial) = push();
    assert_eq!(interpolated_poses(&trial), None);
    for rate_hz in [60.0, 100.0, 120.0] {
        let mut captured = trial.clone();
        let frame = |k: usize| ((k as f64 / rate_hz / 0.004).round() as usize).min(trial.samples.len() - 1);
        for sample in &mut captured.samples {
            let k = (0..).find(|k| trial.samples[frame(k + 1)].t_s >= sample.t_s).expect("a frame");
            let (a, b) = (&trial.samples[frame(k)], &trial.samples[frame(k + 1)]);
            let share = ((sample.t_s - a.t_s) / (b.t_s - a.t_s)).clamp(0.0, 1.0);
            let pose = between(a, b, share);
            (sample.gripper, sample.object) = (pose.gripper, pose.object);
        }
        let told = interpolated_poses(&captured).unwrap_or_default();
        assert!(told.contains("interpolated from a lower rate"), "{rate_hz} Hz: {told}");
    }
}

#[test]
fn a_record_of_an_hour_has_a_plan_of_the_segments_that_fit_and_says_that_some_were_joined() {
    let (description, trial) = push();
    assert!(!feed(&description, &trial).expect("a scene").crowded);
    let mut there: Vec<Sample> = trial.samples.clone();
    let back: Vec<Sample> = there.iter().rev().copied().collect();
    there.extend(back);
    let samples = (0..900_000).map(|i| Sample { t_s: 0.004 * i as f64, ..there[i % there.len()] }).collect();
    let feed = feed(&description, &Trial { info: trial.info, samples }).expect("a scene");
    assert!(feed.crowded);
    let plan = feed.plan;
    assert_eq!(plan.segments.len(), MAX_SEGMENTS);
    let whole_s: f32 = plan.segments.iter().map(|s| s.duration_s).sum();
    assert!((whole_s - 3600.0).abs() < 0.1, "{whole_s}");
}

/// A push's last second in which the gripper rests: from 0.1 s after it has come within noise of its last place.
fn at_rest(trial: &Trial) -> f64 {
    let place = |s: &Sample| s.gripper.map(|g| nalgebra::Vector3::from(g.position_m));
    let last = trial.samples.iter().rev().take(20).filter_map(place);
    let (sum, count) = last.fold((nalgebra::Vector3::zeros(), 0.0), |(sum, n), p| (sum + p, n + 1.0));
    let moves = |s: &&Sample| place(s).is_some_and(|p| (p - sum / count).norm() > 3e-4);
    trial.samples.iter().rev().find(moves).map_or(0.0, |s| s.t_s) + 0.1
}

#[test]
fn pads_that_rest_after_a_push_slip_no_more_though_the_load_stays_at_the_limit() {
    let mut rested_s = 0.0;
    for seed in 21..25 {
        for (object, hidden) in [("obj3", None), ("obj4", Some(Kind::FingerFrictionMismatch)), ("obj5", None)]
        {
            let description = objects::bench("rest");
            let mut reality = Reality::draw(&description, Nuisance::PAPER, seed);
            reality
                .effects
                .extend(hidden.map(|kind| HiddenEffect { kind, strength: kind.typical_strength() }));
            let setup = Setup { description, reality, step_s: STEP_S };
            for (grip_n, speed_m_s) in [(20.0, 0.02), (35.0, 0.02)] {
                let condition =
                    Condition { grip_n, speed_m_s, ..Condition::new(Primitive::LinearPush, object) };
                let trial = stickslip_rig::run(&setup, &condition, 1, seed).expect("the rig runs").trial;
                let rests_s = at_rest(&trial);
                let said = predictions(&setup.description, &trial);
                assert!(
                    said.iter().any(|p| p.flags & flags::SLIP_1 != 0),
                    "{object}, seed {seed}: a push slips"
                );
                for (sample, p) in trial.samples.iter().zip(&said).filter(|(s, _)| s.t_s > rests_s) {
                    let raised = p.flags & (flags::SLIP_1 | flags::SLIP_2 | flags::UNEXPECTED);
                    assert_eq!(
                        raised,
                        0,
                        "{object}, seed {seed}, {grip_n} N, at {} s of rest",
                        sample.t_s - rests_s
                    );
                }
                rested_s += trial.samples.last().map_or(0.0, |s| s.t_s - rests_s);
            }
        }
    }
    assert!(rested_s > 3.0, "{rested_s} s of rest");
}

/// In the pushes of the demonstration 28 ticks were unsure of a step that began with little of a tick's work left.
#[test]
fn what_the_rest_of_a_tick_leaves_unsolved_of_the_look_ahead_is_solved_in_the_next() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let index = Index::open(&folder).expect("data/demo is part of the repository");
    for info in index.trials.iter().filter(|info| info.primitive == "linear_push") {
        let trial = index.read_trial(info).expect("it is sound");
        let said = predictions(&index.description, &trial);
        let marked = said.iter().filter(|p| p.validity & validity::FORESIGHT != 0).count();
        assert_eq!(marked, 0, "{}", info.trial);
    }
}

#[test]
fn pyramids_are_solved_as_pyramids_in_most_ticks_of_a_push() {
    let (description, trial) = push();
    let feed = feed(&description, &trial).expect("a scene");
    let replayed = |formulation| {
        let model = Model { formulation, ..default_model() };
        run(&feed, &model, Limits::default(), 0, |_| ()).expect("accepted")
    };
    let (cone, lcp) = (replayed(Formulation::Cone), replayed(Formulation::Lcp));
    assert_ne!(cone.hash, lcp.hash, "the pyramids are not those of the file");
    // Mostly by pyramids; how often is a figure of docs/lab.
    let instead = lcp.predictions.iter().filter(|p| p.validity & validity::CONE_INSTEAD != 0).count();
    assert!(2 * instead <= lcp.predictions.len(), "{instead} of {} ticks", lcp.predictions.len());
    assert!(cone.predictions.iter().all(|p| p.validity & validity::CONE_INSTEAD == 0));
}
