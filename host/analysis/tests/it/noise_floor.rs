//! The noise floor of repeated runs.

use stickslip_analysis::evidence::noise::*;

#[test]
fn the_floor_of_two_runs_is_their_standard_deviation_whatever_their_length() {
    // Two runs of one ramp, the second 2 units higher and twice as slow.
    let ramp = |steps: i32, up: f64| -> Vec<f64> {
        (0..steps).map(|k| (f64::from(k) + 0.5) / f64::from(steps) + up).collect()
    };
    let (a, b) = (Course::of(&ramp(80, 0.0)), Course::of(&ramp(160, 2.0)));
    let mut pool = Pool::default();
    pool.add([(&a, 0.0), (&b, 0.0)].into_iter());
    // Two values 2 apart: standard deviation sqrt(2).
    let floor = pool.floor().expect("repeated");
    assert!((floor - 2f64.sqrt()).abs() < 1e-9, "{floor}");
}

#[test]
fn white_noise_alone_is_the_floor_of_runs_that_differ_by_nothing_else() {
    let of = |seed: u32| -> Vec<f64> {
        // A linear congruence: uniform on 0..1, standard deviation 1 / sqrt(12).
        let mut x = seed;
        let mut next = || {
            x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(x) / f64::from(u32::MAX)
        };
        (0..4000).map(|_| next()).collect()
    };
    let runs: Vec<(Course, f64)> =
        (1..6).map(|s| (Course::of(&of(s)), white_noise(of(s).into_iter()).expect("noise"))).collect();
    let mut pool = Pool::default();
    pool.add(runs.iter().map(|(c, w)| (c, *w)));
    let floor = pool.floor().expect("repeated");
    assert!((floor * 12f64.sqrt() - 1.0).abs() < 0.2, "{floor}");
}

#[test]
fn without_repetition_there_is_no_floor() {
    let mut pool = Pool::default();
    pool.add([(&Course::of(&[1.0, 2.0, 3.0]), 0.1)].into_iter());
    assert_eq!(pool.floor(), None);
    assert!((pool.white() - 0.1).abs() < 1e-12);
}
