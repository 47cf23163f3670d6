//! Hidden effects do what their names say, and nothing at strength zero; data sets follow
//! from their seed.

use stickslip_rig::plan::{self, PlanName};
use stickslip_rig::{
    Condition, HiddenEffect, Kind, Nuisance, Outcome, Primitive, Reality, STEP_S, Setup, objects, run,
    simulate,
};

fn bench(effects: &[(Kind, f64)]) -> Setup {
    let mut reality = Reality::ideal(0.4, 0.25);
    reality.effects =
        effects.iter().map(|(kind, strength)| HiddenEffect { kind: *kind, strength: *strength }).collect();
    Setup { description: objects::bench("test"), reality, step_s: STEP_S }
}

fn push() -> Condition {
    Condition { speed_m_s: 0.02, worn: 0.5, ..Condition::new(Primitive::LinearPush, "obj4") }
}

fn outcome(kind: Kind, strength: f64, condition: &Condition) -> Outcome {
    run(&bench(&[(kind, strength)]), condition, 1, 3).expect("suits the rig")
}

/// Push force just before the motion ends, N.
fn push_force(outcome: &Outcome) -> f64 {
    outcome.exact[outcome.exact.len() - 90].pusher[0]
}

fn plain() -> Outcome {
    run(&bench(&[]), &push(), 1, 3).expect("suits the rig")
}

fn condition_that_shows(kind: Kind) -> Condition {
    match kind {
        Kind::RollingResistance => {
            Condition { grip_n: 3.0, speed_m_s: 0.02, ..Condition::new(Primitive::Roll, "obj1") }
        }
        // Across the plate the object slides only on a sloped push.
        Kind::PusherHeight => Condition { slope_rad: -0.35, ..push() },
        // 20 N is where this effect is nil by definition.
        Kind::LoadDependentFriction => Condition { grip_n: 30.0, ..push() },
        Kind::TorsionalFriction => Condition { travel: 0.2, ..Condition::new(Primitive::Pivot, "obj4") },
        _ => push(),
    }
}

#[test]
fn every_effect_is_nothing_at_strength_zero_and_something_at_its_typical_one() {
    for kind in Kind::ALL.iter().copied() {
        let condition = condition_that_shows(kind);
        let base = run(&bench(&[]), &condition, 1, 3).unwrap();
        let off = outcome(kind, 0.0, &condition);
        assert!(base.trial == off.trial, "{} acts at strength zero", kind.name());
        let on = outcome(kind, kind.typical_strength(), &condition);
        let differs = base.trial.samples.iter().zip(&on.trial.samples).any(|(a, b)| {
            let gap = |x: [f64; 3], y: [f64; 3]| (0..3).map(|i| (x[i] - y[i]).abs()).fold(0.0, f64::max);
            let fingers = (0..2).map(|i| gap(a.finger[i].unwrap().force_n, b.finger[i].unwrap().force_n));
            let torque = gap(a.finger[0].unwrap().torque_nm, b.finger[0].unwrap().torque_nm);
            let moved = gap(a.object.unwrap().position_m, b.object.unwrap().position_m);
            // Five times the paper's noise.
            fingers.fold(0.0, f64::max) > 0.1 || torque > 0.002 || moved > 1.5e-4
        });
        assert!(differs, "{} does not show at its typical strength", kind.name());
    }
}

#[test]
fn friction_effects_change_the_push_force_by_what_they_say() {
    let base = push_force(&plain());
    let with = |kind, strength| push_force(&outcome(kind, strength, &push()));
    let near = |x: f64, y: f64| (x - y).abs() < 0.02 * y.abs();
    assert!(near(with(Kind::GripForceLoss, 0.2), 0.8 * base));
    assert!(near(with(Kind::Adhesion, 5.0), base + 2.0 * 0.4 * 5.0));
    assert!(near(with(Kind::ViscousFriction, 40.0), base + 2.0 * 40.0 * 0.02));
    assert!(near(with(Kind::AnisotropicFriction, 0.4), 1.2 * base));
    assert!(near(with(Kind::WearDrift, -0.3), 0.85 * base));
    assert!(near(with(Kind::FingerFrictionMismatch, 0.2), base));
    assert!(near(with(Kind::LoadDependentFriction, 0.333), base), "20 N is the nominal load");
    let firm = Condition { grip_n: 35.0, ..push() };
    let falls = push_force(&outcome(Kind::LoadDependentFriction, 0.333, &firm));
    let expected = 2.0 * 0.4 * 35.0 * (35.0_f64 / 20.0).powf(-0.333);
    assert!(near(falls, expected), "{falls} N, {expected} N");
}

#[test]
fn break_away_shows_as_a_peak_and_leaves_the_sliding_force() {
    let peak = |o: &Outcome| o.exact.iter().map(|s| s.pusher[0]).fold(0.0, f64::max);
    // The peak is a few milliseconds long: look at every one.
    let with = |effects: &[(Kind, f64)]| {
        let mut setup = bench(effects);
        setup.description.sample_rate_hz = 1000.0;
        run(&setup, &Condition { speed_m_s: 0.01, ..push() }, 1, 3).unwrap()
    };
    let (base, sticky) = (with(&[]), with(&[(Kind::StaticFriction, 0.3)]));
    assert!(peak(&sticky) > 1.2 * peak(&base), "{} N over {} N", peak(&sticky), peak(&base));
    let sliding = |o: &Outcome| o.exact[o.exact.len() - 360].pusher[0];
    assert!((sliding(&sticky) / sliding(&base) - 1.0).abs() < 0.02);
}

#[test]
fn a_longer_rest_strengthens_the_contact() {
    let peak = |rest_s: f64| {
        let o = outcome(Kind::DwellStrengthening, 0.08, &Condition { rest_s, ..push() });
        o.exact.iter().map(|s| s.pusher[0]).fold(0.0, f64::max)
    };
    assert!(peak(100.0) > 1.1 * peak(0.1), "{} N, {} N", peak(100.0), peak(0.1));
}

#[test]
fn a_point_contact_has_no_torsional_friction() {
    let condition = condition_that_shows(Kind::TorsionalFriction);
    let o = outcome(Kind::TorsionalFriction, -1.0, &condition);
    assert!(o.exact.iter().all(|s| s.finger[0][4].abs() < 1e-3));
}

#[test]
fn a_wedge_changes_the_grip_as_the_object_slides() {
    let normal = |o: &Outcome| {
        let of = |s: &stickslip_rig::Exact| (s.finger[1][1] - s.finger[0][1]) / 2.0;
        (of(&o.exact[20]), of(&o.exact[o.exact.len() - 90]))
    };
    // The pads move 14 mm towards -X, where the wedge is thinner by 0.02 * 14 mm: 20 N/mm on half of it.
    let (before, after) = normal(&outcome(Kind::FaceTilt, 0.02, &push()));
    assert!((before - 20.0).abs() < 0.1 && (after - before + 2.8).abs() < 0.4, "{before} N, {after} N");
}

#[test]
fn sensor_effects_leave_the_motion_alone() {
    let base = plain();
    for kind in [Kind::SensorBias, Kind::SensorGain, Kind::SensorMisalignment, Kind::SensorCrosstalk] {
        let seen = outcome(kind, kind.typical_strength(), &push());
        for (a, b) in base.exact.iter().zip(&seen.exact) {
            assert!(a.object == b.object && a.finger == b.finger, "{}", kind.name());
        }
    }
    let late = outcome(Kind::MocapLatency, 0.02, &push());
    let (a, b) = (&late.exact[100].object.0, &late.trial.samples[105].object.unwrap().position_m);
    assert!((a[0] - b[0]).abs() < 1e-7 && (a[2] - b[2]).abs() < 1e-7);
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_seed_other_ones() {
    let description = objects::bench("test");
    let of = |seed: u64| {
        let reality = Reality::draw(&description, Nuisance::PAPER, seed);
        let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
        simulate(&setup, &push(), 2, seed).unwrap()
    };
    assert_eq!(of(5), of(5));
    assert_ne!(of(5).samples, of(6).samples);
}

#[test]
fn runs_differ_as_much_as_their_friction_and_noise_is_as_stated() {
    let description = objects::bench("test");
    let reality = Reality::draw(&description, Nuisance::PAPER, 9);
    let setup = Setup { description, reality, step_s: STEP_S };
    let runs: Vec<_> = (1..=8).map(|r| run(&setup, &push(), r, 9).unwrap()).collect();
    let forces: Vec<f64> = runs.iter().map(push_force).collect();
    let mean = forces.iter().sum::<f64>() / 8.0;
    let spread = (forces.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / 7.0).sqrt() / mean;
    assert!((0.005..0.045).contains(&spread), "{spread}");
    let errors: Vec<f64> = runs[0].trial.samples[..45]
        .iter()
        .zip(&runs[0].exact)
        .map(|(s, e)| s.finger[0].unwrap().force_n[2] - e.finger[0][2])
        .collect();
    let bias = errors.iter().sum::<f64>() / 45.0;
    let noise = (errors.iter().map(|e| (e - bias).powi(2)).sum::<f64>() / 44.0).sqrt();
    assert!((0.013..0.028).contains(&noise), "{noise} N");
    assert!(bias.abs() < 0.25, "{bias} N");
}

#[test]
fn the_papers_plan_has_its_2760_trials() {
    let conditions = plan::conditions(PlanName::Paper, &[], 1, 5.0);
    let trials = plan::trials(&conditions, 3);
    assert_eq!(trials.len(), 2760);
    let count = |primitive: Primitive, object: &str| {
        trials.iter().filter(|(c, _)| c.primitive == primitive && c.object == object).count()
    };
    for object in ["obj3", "obj4", "obj5"] {
        assert_eq!(count(Primitive::LinearPush, object), 420);
    }
    for object in ["obj4", "obj5"] {
        assert_eq!(count(Primitive::Pivot, object), 630);
    }
    for object in ["obj1", "obj2"] {
        assert_eq!(count(Primitive::Roll, object), 120);
    }
    let mut labels: Vec<_> = conditions.iter().map(|c| &c.label).collect();
    labels.sort();
    labels.dedup();
    assert_eq!(labels.len(), conditions.len());
    assert!(trials.windows(2).all(|w| w[0].0.worn <= w[1].0.worn));
}

#[test]
fn every_plan_runs_on_its_own_objects() {
    for name in [PlanName::PivotSmall, PlanName::RollSmall, PlanName::Planar, PlanName::Demo] {
        let conditions = plan::conditions(name, &[], 1, 1.0);
        let setup = bench(&[]);
        let last = conditions.last().unwrap();
        let trial = simulate(&setup, last, 1, 1).unwrap();
        assert!(trial.samples.len() > 200, "{name:?}");
        assert!(trial.samples.iter().all(|s| s.object.unwrap().position_m.iter().all(|x| x.is_finite())));
    }
    let hours = plan::conditions(PlanName::SlipHours, &[], 1, 0.5);
    assert!(hours.len() > 50);
}
