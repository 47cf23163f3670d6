//! The key of grasps: gross slip, partial slip and drops are where physics says.

use crate::common::clean;
use stickslip_second_rig::physics::friction::{Kind, Law};
use stickslip_second_rig::physics::layout::Profile;
use stickslip_second_rig::physics::slip::Watch;

#[test]
fn gross_slip_needs_all_bristles_of_both_pads_for_3_ms_and_300_um() {
    let dt = 1e-4;
    let truth = |sliding: [f64; 2], speed: f64, seconds: f64| {
        let mut watch = Watch::default();
        for i in 0..(seconds / dt) as usize {
            watch.step(i as f64 * dt, sliding, [speed; 2], [speed * dt; 2], dt);
        }
        watch.finish()
    };
    assert_eq!(truth([1.0, 1.0], 0.1, 0.005).episodes.len(), 1);
    assert!(truth([1.0, 1.0], 0.1, 0.002).episodes.is_empty(), "too short");
    assert!(truth([1.0, 1.0], 0.01, 0.02).episodes.is_empty(), "too little");
    let one = truth([1.0, 0.5], 0.1, 0.02);
    assert!(one.episodes.is_empty(), "one pad holds");
    assert_eq!(one.partial.len(), 1);
    assert!((one.partial[0].plastic_m - 0.002).abs() < 2e-5);
}

#[test]
fn a_decaying_grip_slips_when_twice_mu_n_falls_to_the_weight() {
    let mut set = clean("grasp-medium", 4, &[], 44);
    set.reality.finger = Law { kind: Kind::ElastoPlastic, ..Law::coulomb(set.reality.break_away_mu()) };
    set.reality.pad.profile = Profile::Uniform;
    let mut checked = 0;
    for t in set.trials.iter().filter(|t| t.note["scenario"] == "b" && t.note["sub"] == "slip") {
        let run = set.run_one(t);
        let holds = set.reality.objects[t.object].mass_kg * 9.81 / (2.0 * set.reality.finger.mu);
        let crossing = (0..20_000).map(|i| f64::from(i) * 1e-3).find(|x| t.grip.at(*x) < holds);
        let start = run.truth.episodes.first().map(|e| e.start_s);
        let (Some(crossing), Some(start)) = (crossing, start) else { panic!("{}: no slip", t.id) };
        // The jaw follows within a few of its lags.
        let late = 0.02 + 5.0 * set.reality.jaw.lag_s;
        assert!((start - crossing).abs() < late, "{}: slip at {start}, limit at {crossing}", t.id);
        checked += 1;
    }
    assert!(checked > 1);
}

#[test]
fn quiet_holds_safe_steps_of_grip_and_ramps_that_stop_short_do_not_slip() {
    for (family, seed) in [("grasp-hard", 1), ("grasp-soft", 2)] {
        let set = clean(family, seed, &[], 44);
        for t in &set.trials {
            let quiet = t.note["scenario"] == "g" || t.note["scenario"] == "h" || t.note["sub"] == "short";
            if quiet {
                let truth = set.run_one(t).truth;
                assert!(truth.episodes.is_empty() && truth.drop_s.is_none(), "{family} {}: {truth:?}", t.id);
            }
        }
    }
}

#[test]
fn lifting_with_too_little_grip_drops_and_with_enough_does_not() {
    let set = clean("grasp-medium", 11, &[], 44);
    for t in set.trials.iter().filter(|t| t.note["scenario"] == "a") {
        let truth = set.run_one(t).truth;
        match t.note["sub"].as_str() {
            Some("enough") => assert!(truth.episodes.is_empty(), "{}: {truth:?}", t.id),
            Some("little") => assert!(!truth.episodes.is_empty() && truth.drop_s.is_some(), "{}", t.id),
            _ => {}
        }
    }
}
