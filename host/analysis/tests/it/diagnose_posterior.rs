//! Probabilities of sets of effects from their scores on held-out conditions.

use stickslip_analysis::diagnose::posterior::weights;

#[test]
fn sets_that_do_alike_share_the_probability_as_their_prior_has_it() {
    let scores = vec![-3.0, -1.0, -2.0, -4.0];
    let got = weights(&[(scores.clone(), 0.0), (scores.clone(), 0.0), (scores, -(24.0_f64).ln())], 1.0);
    assert!((got[0] - got[1]).abs() < 1e-12);
    assert!((got[0] / got[2] - 24.0).abs() < 1e-9);
    assert!((got.iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

#[test]
fn what_only_one_condition_says_stays_in_doubt_and_what_all_say_does_not() {
    let none = vec![0.0; 10];
    let one = [vec![10.0], vec![0.0; 9]].concat();
    let all = vec![1.0; 10];
    let by_one = weights(&[(none.clone(), 0.0), (one, 0.0)], 1.0)[1];
    let by_all = weights(&[(none, 0.0), (all, 0.0)], 1.0)[1];
    assert!(by_one < by_all && by_one < 0.97, "{by_one} {by_all}");
    assert!(by_all > 0.999);
}

#[test]
fn conditions_that_are_wrong_alike_count_as_fewer() {
    let rows = [(vec![0.0; 12], 0.0), (vec![0.4; 12], 0.0)];
    let independent = weights(&rows, 1.0)[1];
    let alike = weights(&rows, 1.0 / 12.0)[1];
    assert!(independent > 0.98 && alike < 0.7, "{independent} {alike}");
}
