//! Probabilities of sets of effects from what they leave on held-out conditions.

use std::collections::BTreeMap;

use stickslip_analysis::diagnose::detection::factor;
use stickslip_analysis::diagnose::posterior::{LeftInPlace, Posterior, Weighed, weights};

/// One place, `x` run spreads left in each condition; `form` may be the law's own.
fn left(x: &[f64], form: f64) -> Vec<LeftInPlace> {
    vec![LeftInPlace { seen: x.iter().enumerate().map(|(c, x)| (c, *x, form)).collect() }]
}

#[test]
fn sets_that_do_alike_share_the_probability_as_their_prior_has_it() {
    let places = left(&[1.0, 0.5, 2.0, 4.0], 0.0);
    let got = weights(&[(places.clone(), 0.0), (places.clone(), 0.0), (places, -(24.0_f64).ln())], 4, 1.0);
    assert!((got[0] - got[1]).abs() < 1e-12);
    assert!((got[0] / got[2] - 24.0).abs() < 1e-9);
    assert!((got.iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

#[test]
fn what_only_one_condition_says_stays_in_doubt_and_what_all_say_does_not() {
    let pair = |before: &[f64], after: f64| {
        weights(&[(left(before, 0.0), 0.0), (left(&[after; 10], 0.0), 0.0)], 10, 1.0)[1]
    };
    let one = [vec![8.0], vec![0.5; 9]].concat();
    let (by_one, by_all) = (pair(&one, 0.5), pair(&[1.5; 10], 0.5));
    assert!(by_one < by_all && by_one < 0.97, "{by_one} {by_all}");
    assert!(by_all > 0.999);
}

#[test]
fn conditions_that_are_wrong_alike_count_as_fewer() {
    let rows = [(left(&[1.0; 12], 0.0), 0.0), (left(&[0.5; 12], 0.0), 0.0)];
    let independent = weights(&rows, 12, 1.0)[1];
    let alike = weights(&rows, 12, 1.0 / 12.0)[1];
    assert!(independent > 0.98 && alike < 0.7, "{independent} {alike}");
}

#[test]
fn a_further_effect_that_takes_up_the_form_of_a_law_wins_no_more_by_more_conditions_or_places() {
    let further = |conditions: usize, places: usize, form: f64| {
        let of = |x: f64| (0..places).flat_map(|_| left(&vec![x; conditions], form)).collect();
        weights(&[(of(4.0), 0.0), (of(0.5), -(25.0_f64).ln())], conditions, 1.0)[1]
    };
    let got = [further(8, 1, 5.0), further(40, 1, 5.0), further(8, 30, 5.0)];
    assert!(got.iter().all(|p| *p < 0.1), "{got:?}");
    // Where the law explains nothing, what is left is no matter of its form.
    assert!(further(8, 1, 0.0) > 0.999);
}

#[test]
fn a_set_shares_its_probability_with_one_effect_more_that_may_hide_and_the_effect_keeps_all_of_it() {
    let set = |effects: &[&'static str], probability| Weighed { effects: effects.to_vec(), probability };
    let mut p = Posterior {
        sets: vec![set(&["mass_error"], 0.8), set(&["face_tilt", "mass_error"], 0.1), set(&[], 0.06)],
        unlisted: 0.04,
        ..Posterior::default()
    };
    let hidden = BTreeMap::from([("face_tilt", 1.0), ("adhesion", 1.0), ("gravity_tilt", 0.0)]);
    p.share_with(&hidden);
    let of = |effects: &[&str]| p.sets.iter().find(|s| s.effects == effects).map_or(0.0, |s| s.probability);
    let all: f64 = p.sets.iter().map(|s| s.probability).sum();
    assert!((all - 0.96).abs() < 1e-12);
    assert!(of(&["adhesion", "mass_error"]) > 0.01 && of(&["mass_error"]) < 0.79);
    // What was fitted has its own evidence.
    assert!(of(&["face_tilt", "mass_error"]) <= 0.1);
    assert!(of(&["gravity_tilt", "mass_error"]) < 1e-12);
    assert!((p.of("mass_error") - 0.9).abs() < 0.01);
}

#[test]
fn what_the_data_exclude_is_improbable_and_what_they_cannot_show_is_as_before_them() {
    assert!(factor(0.0, 0.01, 0.02) < 0.01);
    assert!((factor(0.0, 100.0, 100.0) - 1.0).abs() < 1e-3);
    // Three standard errors speak for it, a hundred no louder than a linear model may.
    let (three, hundred) = (factor(0.9, 0.3, 0.1), factor(30.0, 0.3, 0.1));
    assert!(three > 2.0 && hundred >= three && hundred < 20.1, "{three} {hundred}");
}
