//! The statistics of the diagnosis against known answers.

use nalgebra::{DMatrix, DVector};
use rand::{Rng, SeedableRng};
use rand_distr::StandardNormal;
use stickslip_analysis::diagnose::select::{halves, of_gain, p_value, paired};
use stickslip_analysis::fit::FOLDS;
use stickslip_analysis::fit::features::FEATURES;
use stickslip_analysis::fit::gls::{self, Columns, Gram, Prior, Whitener};

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
        let of = |residual: DVector<f64>| {
            let nuisances = Columns::new(DMatrix::from_columns(std::slice::from_ref(&nuisance)));
            gls::gram(condition, &DMatrix::from_columns(&[effect.clone(), residual]), &nuisances)
        };
        grams.push(of(residual.clone()));
        shifted.push(of(residual + &nuisance * 7.0));
    }
    let of =
        |g: &[gls::Gram]| gls::solve(g.iter().map(|g| (1.0, g)), &gls::Prior::none(2)).expect("solvable");
    let (a, b) = (of(&grams), of(&shifted));
    assert!((a[0] - b[0]).abs() < 1e-7);
    assert!((b[1] - a[1] - 7.0).abs() < 1e-7);
}

#[test]
fn bounded_coefficients_cost_least_among_all_sets_of_bounds_that_may_hold() {
    let mut rng = rng(5);
    for _ in 0..300 {
        let n = 4;
        let root = nalgebra::DMatrix::from_fn(6, n, |_, _| rng.sample::<f64, _>(StandardNormal));
        let a = root.transpose() * &root;
        let b = DVector::from_fn(n, |_, _| 5.0 * rng.sample::<f64, _>(StandardNormal));
        // Of the first nothing is known.
        let prior =
            gls::Prior { precision: vec![0.0, 0.3, 0.3, 0.3], bound: vec![f64::INFINITY, 0.4, 0.7, 1.0] };
        let h = &a + nalgebra::DMatrix::from_diagonal(&DVector::from_row_slice(&prior.precision));
        let cost = |x: &DVector<f64>| 0.5 * x.dot(&(&h * x)) - b.dot(x);
        let found = gls::solve_normal(a, b.clone(), &prior).expect("solvable");
        // Each of the three is free, at its lower or at its upper bound.
        let mut least = f64::INFINITY;
        for set in 0..27 {
            let held = [set % 3, set / 3 % 3, set / 9].map(|k| [0.0, -1.0, 1.0][k]);
            let mut m = h.clone();
            let mut r = b.clone();
            for (k, side) in held.iter().enumerate().filter(|(_, side)| **side != 0.0) {
                m.row_mut(k + 1).fill(0.0);
                m[(k + 1, k + 1)] = 1.0;
                r[k + 1] = side * prior.bound[k + 1];
            }
            let x = m.lu().solve(&r).expect("solvable");
            if (1..n).all(|k| x[k].abs() <= prior.bound[k] + 1e-12) {
                least = least.min(cost(&x));
            }
        }
        assert!((1..n).all(|k| found[k].abs() <= prior.bound[k]));
        assert!((cost(&found) - least).abs() < 1e-6 * (1.0 + least.abs()), "{} {least}", cost(&found));
    }
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
fn what_falls_to_the_noise_in_each_of_four_conditions_is_no_chance_however_unlike_their_sizes() {
    // A sensor's gain at two grips: the misfit of one is thirty times that of the other.
    let (before, after) = ([221.0, 244.0, 7488.0, 7454.0], [45.0, 48.0, 129.0, 93.0]);
    let p = of_gain(&before, &after, None);
    assert!(p < 0.01, "{p}");
    assert!(p_value(&before, &after) > 0.05, "their sizes alone do not tell");
    // One condition decides nothing, nor does what falls in as many as it rises in.
    assert!(of_gain(&before, &[223.0, 243.0, 129.0, 7450.0], None) > 0.05);
    assert!(of_gain(&before, &[45.0, 1300.0, 129.0, 40_000.0], None) > 0.2);
}

#[test]
fn an_effect_is_clear_where_it_takes_half_of_the_loss_of_most_conditions_and_not_of_one_alone() {
    let before = [40.0, 35.0, 52.0, 44.0, 38.0, 61.0, 47.0, 55.0, 36.0, 49.0];
    let share = |share: f64| before.map(|b| share * b);
    assert!(halves(&before, &share(0.45)));
    assert!(!halves(&before, &share(0.55)), "less than half, however sure");
    // One condition that is far off makes most of both losses.
    let with =
        |of: [f64; 10], first: f64| std::array::from_fn::<f64, 10, _>(|k| if k == 0 { first } else { of[k] });
    assert!(!halves(&with(before, 4000.0), &before), "one condition alone");
    assert!(halves(&with(before, 40.0), &with(share(0.2), 9.0)));
    assert!(!halves(&before[..2], &share(0.01)[..2]), "two conditions decide nothing");
}

#[test]
fn the_tests_of_a_gain_together_alarm_no_more_often_than_twice_their_level_under_pure_chance() {
    // Conditions are of unlike sizes, and each loss is as likely to fall as to rise by as much.
    for (conditions, seed) in [(4, 6), (6, 7), (14, 8), (40, 9)] {
        let mut rng = rng(seed);
        let (trials, level) = (4000, 0.05);
        let mut alarms = 0;
        for _ in 0..trials {
            let draw = |size: f64, rng: &mut rand_chacha::ChaCha8Rng| {
                (size + 0.5 * rng.sample::<f64, _>(StandardNormal)).exp()
            };
            let sizes: Vec<f64> =
                (0..conditions).map(|_| 4.0 + 2.0 * rng.sample::<f64, _>(StandardNormal)).collect();
            let before: Vec<f64> = sizes.iter().map(|s| draw(*s, &mut rng)).collect();
            let after: Vec<f64> = sizes.iter().map(|s| draw(*s, &mut rng)).collect();
            alarms += i32::from(of_gain(&before, &after, None) < level);
        }
        let rate = f64::from(alarms) / f64::from(trials);
        assert!(rate < 2.0 * level, "{conditions} conditions: {rate}");
    }
}

/// One feature of a condition that was measured as `value`; the model says `2 x`.
fn seen(condition: usize, value: f64) -> Gram {
    gls::gram(condition, &DMatrix::from_row_slice(1, 2, &[2.0, value]), &Columns::new(DMatrix::zeros(1, 0)))
}

#[test]
fn a_condition_is_predicted_by_a_fit_that_has_not_seen_it() {
    const CONDITIONS: usize = 23;
    let grams: Vec<Gram> = (0..CONDITIONS).map(|c| seen(c, (c as f64).sin())).collect();
    let prior = Prior::none(1);
    let of = |grams: &[Gram]| gls::held_out(grams, &gls::fold_solutions(grams, &prior, FOLDS));
    let before = of(&grams);
    for c in 0..CONDITIONS {
        let without: Vec<Gram> =
            grams.iter().filter(|g| gls::fold(g.condition, FOLDS) != gls::fold(c, FOLDS)).cloned().collect();
        let x = gls::solve(without.iter().map(|g| (1.0, g)), &prior).expect("determined");
        assert!((before[c] - gls::loss(&grams[c], &x)).abs() < 1e-12, "condition {c}");
        // What it says of others changes, what is said of it by its own value alone.
        let mut changed = grams.clone();
        changed[c] = seen(c, 50.0);
        let after = of(&changed);
        assert!((after[c] - gls::loss(&changed[c], &x)).abs() < 1e-9, "condition {c} has seen itself");
        let others = (0..CONDITIONS).filter(|o| gls::fold(*o, FOLDS) != gls::fold(c, FOLDS));
        assert!(
            others.into_iter().all(|o| (after[o] - before[o]).abs() > 1e-3),
            "condition {c} teaches nothing"
        );
    }
}

#[test]
fn parts_of_the_conditions_are_of_equal_size() {
    for conditions in FOLDS..60 {
        let mut sizes = [0; FOLDS];
        (0..conditions).for_each(|c| sizes[gls::fold(c, FOLDS)] += 1);
        let (least, most) = (sizes.iter().min().expect("parts"), sizes.iter().max().expect("parts"));
        assert!(most - least <= 1, "{conditions} conditions: {sizes:?}");
    }
}
