//! Probabilities of sets of effects from what they leave on held-out conditions.

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
fn an_effect_in_no_set_has_the_probability_zero_without_a_sign() {
    assert!(Posterior::default().of("plate_tilt").is_sign_positive());
}

#[test]
fn sets_as_probable_as_what_is_named_are_its_equals_unless_they_hold_more() {
    let of = |sets: &[(&[&'static str], f64)]| Posterior {
        sets: sets.iter().map(|(e, p)| Weighed { effects: e.to_vec(), probability: *p }).collect(),
        ..Posterior::default()
    };
    let pair = of(&[
        (&["external_force", "pressure_offset"], 0.51),
        (&["mass_error", "pressure_offset"], 0.49),
        (&["adhesion", "pressure_offset"], 0.2),
    ]);
    assert_eq!(pair.as_probable(&["pressure_offset", "external_force"]), [["mass_error", "pressure_offset"]]);
    let fewer = of(&[(&["face_tilt"], 0.31), (&["face_tilt", "sensor_bias"], 0.08)]);
    assert_eq!(fewer.as_probable(&["face_tilt", "sensor_bias"]), [["face_tilt"]]);
    assert!(fewer.as_probable(&["face_tilt"]).is_empty());
    let more = of(&[(&["plate_tilt", "wear_drift"], 0.9), (&["plate_tilt"], 0.06), (&[], 0.04)]);
    assert!(more.as_probable(&["plate_tilt"]).is_empty());
    let unlikely = of(&[(&["adhesion"], 1e-4), (&["plate_tilt"], 1e-6)]);
    assert!(unlikely.as_probable(&["plate_tilt"]).is_empty(), "something unlisted is missing");
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
