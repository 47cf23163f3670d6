//! Warnings judged by the key of simulated grasps.

use stickslip_analysis::score::alarms::Episode;
use stickslip_analysis::score::warnings::*;

fn trial(scenario: &str, episodes: &[[f64; 3]], drop: Option<f64>) -> TrialKey {
    TrialKey {
        scenario: scenario.into(),
        sub: "slip".into(),
        episodes: episodes.to_vec(),
        drop,
        ..TrialKey::default()
    }
}

#[test]
fn a_warning_in_time_counts_and_one_that_meets_nothing_is_false() {
    let key = trial("b", &[[3.0, 3.4, 0.02]], Some(3.4));
    let early = [Episode { from_s: 2.5, to_s: 3.3 }, Episode { from_s: 0.5, to_s: 0.6 }];
    let f = judge(&key, &early, &early[..1], 3.4);
    assert_eq!((f.builds_up.found, f.builds_up.of), (1, 1));
    assert_eq!((f.drops.found, f.drops_ahead.found), (1, 1));
    assert_eq!((f.all_false().count, f.false_drop.count), (1, 0));
    let late = [Episode { from_s: 3.05, to_s: 3.3 }];
    let f = judge(&trial("a", &[[3.0, 3.4, 0.02]], None), &late, &late, 4.0);
    assert_eq!((f.sudden_20.found, f.sudden_40.found, f.false_drop.count), (0, 0, 1));
}

#[test]
fn intervals_are_those_of_the_tables() {
    // Clopper and Pearson 1934; Garwood 1936.
    let [low, high] = Share { found: 9, of: 10 }.interval().unwrap();
    assert!((low - 0.5550).abs() < 1e-3 && (high - 0.9975).abs() < 1e-3);
    let [low, high] = Events { count: 3, hours: 1.0 }.rate().unwrap().interval_per_hour;
    assert!((low - 0.6187).abs() < 1e-3 && (high - 8.7673).abs() < 1e-3);
}
