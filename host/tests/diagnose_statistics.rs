//! The statistics of the diagnosis against known answers.

use nalgebra::DVector;
use rand::{Rng, SeedableRng};
use rand_distr::StandardNormal;
use stickslip_host::diagnose::features::FEATURES;
use stickslip_host::diagnose::gls::{self, Whitener};
use stickslip_host::diagnose::select::{p_value, paired};

fn rng(seed: u64) -> rand_chacha::ChaCha8Rng {
    rand_chacha::ChaCha8Rng::seed_from_u64(seed)
}

#[test]
fn whitening_turns_the_noise_it_was_made_for_into_the_identity() {
    let mut rng = rng(1);
    let active: Vec<usize> = (0..6).collect();
    let variance: Vec<f64> = (0..FEATURES).map(|f| 0.5 + 0.1 * f as f64).collect();
    let mut common = vec![0.0; FEATURES];
    common[..6].copy_from_slice(&[3.0, 3.0, -2.0, 1.0, 0.0, 5.0]);
    let whitener = Whitener::new(active, &variance, std::slice::from_ref(&common));
    let n = 20_000;
    let mut covariance = nalgebra::DMatrix::<f64>::zeros(6, 6);
    for _ in 0..n {
        let z: f64 = rng.sample(StandardNormal);
        let x: Vec<f64> = (0..FEATURES)
            .map(|f| common[f] * z + variance[f].sqrt() * rng.sample::<f64, _>(StandardNormal))
            .collect();
        let w = whitener.apply(&x);
        covariance += &w * w.transpose() / f64::from(n);
    }
    for i in 0..6 {
        for j in 0..6 {
            let expected = f64::from(u8::from(i == j));
            assert!((covariance[(i, j)] - expected).abs() < 0.05, "{i} {j}: {}", covariance[(i, j)]);
        }
    }
}

#[test]
fn a_nuisance_in_the_residual_is_projected_out_exactly() {
    let mut rng = rng(2);
    let column =
        |rng: &mut rand_chacha::ChaCha8Rng| DVector::from_fn(40, |_, _| rng.sample::<f64, _>(StandardNormal));
    let mut grams = Vec::new();
    let mut shifted = Vec::new();
    for condition in 0..8 {
        let (effect, nuisance, residual) = (column(&mut rng), column(&mut rng), column(&mut rng));
        let offsets = [nuisance.clone()];
        grams.push(gls::gram(condition, std::slice::from_ref(&effect), &offsets, &residual));
        shifted.push(gls::gram(condition, &[effect], &offsets, &(residual + nuisance * 7.0)));
    }
    let of = |g: &[gls::Gram]| gls::solve(g.iter().map(|g| (1.0, g)), &gls::Prior::none(2)).expect("solvable");
    let (a, b) = (of(&grams), of(&shifted));
    assert!((a[0] - b[0]).abs() < 1e-7);
    assert!((b[1] - a[1] - 7.0).abs() < 1e-7);
}

#[test]
fn the_paired_test_alarms_no_more_often_than_its_level_under_pure_chance() {
    let mut rng = rng(3);
    let trials = 4000;
    let level = 0.01;
    let mut alarms = 0;
    for _ in 0..trials {
        // Heavy tails: a few conditions are far off.
        let a: Vec<f64> = (0..14).map(|_| rng.sample::<f64, _>(StandardNormal).powi(3)).collect();
        if p_value(&a, &[0.0; 14]) < level {
            alarms += 1;
        }
    }
    assert!(f64::from(alarms) < 1.5 * level * f64::from(trials), "{alarms} of {trials}");
}

#[test]
fn the_paired_test_sees_a_difference_of_one_standard_deviation_in_twenty_conditions() {
    let mut rng = rng(4);
    let a: Vec<f64> = (0..20).map(|_| 1.0 + rng.sample::<f64, _>(StandardNormal)).collect();
    assert!(p_value(&a, &[0.0; 20]) < 0.01);
    assert!(paired(&a[..2], &[0.0; 2]).is_none(), "two conditions decide nothing");
}

#[test]
fn every_condition_is_held_out_exactly_once() {
    for folds in [2, 5, 10] {
        for condition in 0..100 {
            assert!(gls::fold(condition, folds) < folds);
        }
        let used: std::collections::BTreeSet<usize> = (0..folds).map(|c| gls::fold(c, folds)).collect();
        assert!(used.len() >= folds.min(2));
    }
}
