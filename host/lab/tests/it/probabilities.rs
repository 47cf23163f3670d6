//! Stated probabilities and ceilings, on predictions and paths that are known.

use std::path::Path;

use stickslip_analysis::score::warnings::TrialKey;
use stickslip_lab::ceilings::{From, Sight, found};
use stickslip_lab::reliability::{EDGES, Stated};
use stickslip_shared::predictor::{Prediction, validity};

fn says(p: f32) -> Prediction {
    Prediction { hold_probability: Some(p), friction: 0.4, friction_least: 0.3, ..Prediction::default() }
}

fn times(seconds: f64) -> Vec<f64> {
    (0..(seconds / 0.004) as u32).map(|k| f64::from(k) * 0.004).collect()
}

#[test]
fn a_trial_counts_once_in_each_bin_by_its_first_tick_there() {
    let t_s = times(2.0);
    let slips = TrialKey { episodes: vec![[1.05, 1.2, 0.01]], mu: Some(0.35), ..TrialKey::default() };
    // 0.93 until 0.97 s, then 0.6: at its first tick the slip is less than 0.1 s away.
    let all: Vec<Prediction> = t_s.iter().map(|t| says(if *t < 0.97 { 0.93 } else { 0.6 })).collect();
    let stated = Stated::of(&slips, &t_s, &all, 2.0);
    let of = |p: f64| stated.holds[EDGES.iter().rposition(|e| p >= *e).unwrap()];
    assert_eq!(
        (of(0.93).trials.found, of(0.93).trials.of, of(0.6).trials.found, of(0.6).trials.of),
        (1, 1, 0, 1)
    );
    assert!(of(0.93).ticks.found < of(0.93).ticks.of, "the last ticks before 0.97 s did not hold");
    assert!((of(0.6).mean().unwrap() - 0.6).abs() < 1e-6);
    assert_eq!((stated.above_median.found, stated.above_least.found, stated.above_least.of), (0, 1, 1));
    // What is in doubt states nothing.
    let doubted: Vec<Prediction> =
        all.iter().map(|p| Prediction { validity: validity::WRENCH, ..*p }).collect();
    assert!(Stated::of(&slips, &t_s, &doubted, 2.0).holds.iter().all(|b| b.trials.of == 0));
}

/// A slip that begins at 1 s and moves by 30 um in a sample from then on, and one before that crept by 5 um in a sample.
fn slip(creeps: bool) -> TrialKey {
    let path = (-25..=12).map(|k| {
        let creep = if creeps { 5e-6 * f64::from(k + 25) } else { 0.0 };
        [1.0 + 0.004 * f64::from(k), creep + 3e-5 * f64::from(k.max(0)), 0.0]
    });
    TrialKey {
        episodes: vec![[0.2, 0.3, 1e-4], [1.0, 1.3, 0.01]],
        about_slips: vec![vec![], path.collect()],
        ..TrialKey::default()
    }
}

#[test]
fn an_oracle_sees_what_a_matched_filter_sees() {
    let sight = Sight { sigma_m: 3e-5, share: 1.0 };
    // 1, 2, ..., 5 standard deviations in 20 ms.
    let d = sight.stands_out(&slip(false), 0.021, From::Onset).unwrap();
    assert!((d - 55f64.sqrt()).abs() < 1e-6, "{d}");
    assert!((sight.stands_out(&slip(false), 0.021, From::Before).unwrap() - d).abs() < 1e-6);
    assert!(sight.stands_out(&slip(true), 0.021, From::Before).unwrap() > d);
    let rare = Sight { share: 0.25, ..sight };
    assert!((rare.stands_out(&slip(false), 0.021, From::Onset).unwrap() - 0.5 * d).abs() < 1e-6);
    // 3 alarms an hour in tests of 20 ms: one in 60,000, 4.15 standard deviations.
    assert!((found(4.149, 0.02, 3.0) - 0.5).abs() < 0.01, "{}", found(4.149, 0.02, 3.0));
    assert!(found(0.0, 0.02, 3.0) < 1e-4 && found(9.0, 0.02, 3.0) > 0.999);
    assert!(sight.stands_out(&TrialKey::default(), 0.021, From::Onset).is_none());
}

#[test]
fn a_key_that_does_not_tell_the_sensors_is_named() {
    let error = Sight::told(Path::new("no/such.key.json")).unwrap_err().to_string();
    assert!(error.contains("no/such.key.json"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let key = folder.path().join("a.key.json");
    let sensors =
        r#"{"rate_hz": 250.0, "position_noise_m": 2e-5, "gripper_noisy": true, "pose_rate": {"gaps": 60.0}}"#;
    std::fs::write(&key, format!(r#"{{"reality": {{"sensors": {sensors}}}}}"#)).unwrap();
    let sight = Sight::told(&key).unwrap();
    assert!((sight.sigma_m - 2e-5 * 2f64.sqrt()).abs() < 1e-12 && (sight.share - 0.24).abs() < 1e-12);
    std::fs::write(&key, "{}").unwrap();
    assert!(Sight::told(&key).unwrap_err().to_string().contains("does not state the sensors"));
}
