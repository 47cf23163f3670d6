//! What experiments are expected to tell.

use stickslip_analysis::diagnose::experiment::{entropy_bits, greedy, information_bits};

/// Squared difference of each two of `means`, in standard deviations.
fn distances(means: &[Vec<f64>]) -> Vec<f64> {
    let square = |a: &Vec<f64>, b: &Vec<f64>| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    means.iter().flat_map(|a| means.iter().map(move |b| square(a, b))).collect()
}

/// Mutual information between `means` and one observation with unit variance, by quadrature, bits.
fn exact_bits(probabilities: &[f64], means: &[f64]) -> f64 {
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let step = 1e-3;
    let sum = (-40_000..40_000).map(|k| {
        let x = f64::from(k) * step;
        let each: Vec<f64> = probabilities.iter().zip(means).map(|(p, m)| p * density(x - m)).collect();
        let all: f64 = each.iter().sum();
        let term =
            |(joint, p): (&f64, &f64)| if *joint > 1e-200 { joint * (joint / (p * all)).log2() } else { 0.0 };
        each.iter().zip(probabilities).map(term).sum::<f64>() * step
    });
    sum.sum()
}

#[test]
fn the_information_is_a_lower_bound_of_the_exact_one_and_close_at_both_ends() {
    for probabilities in [vec![0.5, 0.5], vec![0.9, 0.1], vec![0.2, 0.5, 0.3]] {
        for apart in [0.0, 0.5, 1.0, 2.0, 4.0, 12.0] {
            let means: Vec<f64> = (0..probabilities.len()).map(|k| apart * k as f64).collect();
            let each: Vec<Vec<f64>> = means.iter().map(|m| vec![*m]).collect();
            let (bound, exact) =
                (information_bits(&probabilities, &distances(&each)), exact_bits(&probabilities, &means));
            assert!(bound <= exact + 1e-6, "{probabilities:?} {apart}: {bound} of {exact}");
            assert!(
                bound >= 0.5 * exact - 1e-6 || exact < 0.05,
                "{probabilities:?} {apart}: {bound} of {exact}"
            );
        }
        let open = entropy_bits(&probabilities);
        let far: Vec<Vec<f64>> = (0..probabilities.len()).map(|k| vec![100.0 * k as f64]).collect();
        assert!((information_bits(&probabilities, &distances(&far)) - open).abs() < 1e-9);
    }
}

#[test]
fn a_plan_tells_nearly_as_much_as_the_best_of_all_plans_and_its_beginning_is_a_plan() {
    // Three sets; kind 0 parts the first from the others, kind 1 the second, kind 2 all of them a little.
    let means: [&[f64]; 3] = [&[3.0, 0.0, 0.0], &[0.0, 3.0, 0.0], &[0.0, 1.0, 2.0]];
    let probabilities = [0.4, 0.35, 0.25];
    // Run-to-run variance 1, tolerance 0.5: it does not average out.
    let of = |k: usize, runs: usize| {
        let scale = (1.5 / (0.5 + 1.0 / runs as f64)).sqrt();
        let each: Vec<Vec<f64>> = means[k].iter().map(|m| vec![m * scale]).collect();
        distances(&each)
    };
    let told = |runs: [usize; 3]| {
        let mut sum = vec![0.0; 9];
        for (k, n) in runs.iter().enumerate().filter(|(_, n)| **n > 0) {
            sum.iter_mut().zip(of(k, *n)).for_each(|(s, d)| *s += d);
        }
        information_bits(&probabilities, &sum)
    };
    let longest = greedy(&probabilities, 3, 6, of);
    for trials in 1..=6 {
        let plan = greedy(&probabilities, 3, trials, of);
        assert_eq!(plan, longest[..trials], "its beginning is a plan");
        let mut best: f64 = 0.0;
        for a in 0..=trials {
            for b in 0..=trials - a {
                best = best.max(told([a, b, trials - a - b]));
            }
        }
        let bits = plan[trials - 1].1;
        // (1 - 1/e) of the best is what a greedy plan is sure of (Nemhauser, Wolsey and Fisher 1978).
        assert!(bits >= 0.632 * best && bits <= best + 1e-9, "{trials}: {bits} of {best}");
    }
    assert!(longest.iter().any(|(k, _)| *k == 0) && longest.iter().any(|(k, _)| *k == 1), "{longest:?}");
}

#[test]
fn a_trial_in_which_all_sets_predict_the_same_tells_nothing() {
    let same = distances(&[vec![1.0], vec![1.0]]);
    assert!(information_bits(&[0.5, 0.5], &same).abs() < 1e-12);
    assert_eq!(
        greedy(&[0.5, 0.5], 2, 1, |k, _| if k == 0 { same.clone() } else { vec![0.0, 1.0, 1.0, 0.0] })[0].0,
        1
    );
}
