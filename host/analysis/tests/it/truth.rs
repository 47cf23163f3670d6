//! Slips found in poses.

use nalgebra::Vector3;
use stickslip_analysis::score::truth::*;

const DT_S: f64 = 0.004;

/// A path along X through `(time s, place m)`, with noise of 19 um on each axis.
fn path(knots: &[(f64, f64)], until_s: f64) -> (Vec<f64>, Vec<Option<Vector3<f64>>>) {
    let noise = |i: usize| 2.7e-5 * (1.9 * i as f64 + 0.7 * (i * i) as f64).sin();
    let at = |t: f64| {
        let after = knots.partition_point(|k| k.0 <= t);
        match (after.checked_sub(1).and_then(|i| knots.get(i)), knots.get(after)) {
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0),
            (Some(k), None) | (None, Some(k)) => k.1,
            (None, None) => 0.0,
        }
    };
    let t: Vec<f64> = (0..(until_s / DT_S) as usize).map(|i| i as f64 * DT_S).collect();
    let q = |(i, t): (usize, &f64)| {
        Some(Vector3::new(at(*t) + noise(i), noise(i + 7919), noise(i + 104_729) * 0.3))
    };
    let places = t.iter().enumerate().map(q).collect();
    (t, places)
}

#[test]
fn the_second_of_two_slips_is_dated_by_its_own_beginning() {
    let knots = [(1.0, 0.0), (1.04, 1.6e-3), (1.7, 1.6e-3), (1.74, 3.2e-3)];
    let (t, q) = path(&knots, 3.0);
    let found = slips(&t, &q, 3.0, 0, SLIPPED_M);
    let onsets: Vec<f64> = found.iter().map(|s| s.1).collect();
    assert_eq!(onsets.len(), 2, "{found:?}");
    for (onset, began) in onsets.iter().zip([1.0, 1.7]) {
        assert!((began - 0.005..began + 0.009).contains(onset), "{onset} for {began}");
    }
}

#[test]
fn a_lasting_step_of_a_tenth_of_a_millimetre_is_a_near_slip_and_steady_creep_is_none() {
    let (t, q) = path(&[(2.0, 0.0), (2.02, 1.0e-4)], 4.0);
    assert!(slips(&t, &q, 4.0, 0, SLIPPED_M).is_empty());
    let found = steps(&t, &q, 4.0);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].0 < 2.02 && found[0].1 > 2.0 && found[0].1 - found[0].0 < 0.2, "{found:?}");
    // Half a millimetre in a second.
    let (t, q) = path(&[(0.0, 0.0), (4.0, 2.0e-3)], 4.0);
    assert!(steps(&t, &q, 4.0).is_empty());
}
