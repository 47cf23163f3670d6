//! Intervals of friction hold the truth as often as they say, where few conditions alone tell of it too.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use stickslip_analysis::evidence::draws::{against, draws, ends, fitting, scan};

const CONDITIONS: usize = 20;

/// In how many of 200 simulated cases the interval holds the truth: of [`CONDITIONS`], the first `telling` see a coefficient, each
/// with an error of its own.
fn held(telling: usize) -> usize {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let all = draws(CONDITIONS, 1);
    let mut case = || {
        let seen: Vec<f64> = (0..telling)
            .map(|_| {
                let error: f64 = StandardNormal.sample(&mut rng);
                (0.4f64).ln() + 0.05 * error
            })
            .collect();
        let best = seen.iter().sum::<f64>() / telling as f64;
        let scan = scan(best);
        let cost = |x: f64, c: usize| seen.get(c).map_or(0.01, |y| 0.01 + (y - x).powi(2));
        let costs: Vec<Vec<f64>> =
            scan.iter().map(|x| (0..CONDITIONS).map(|c| cost(*x, c)).collect()).collect();
        let set = |draw: &Vec<f64>| {
            let of = |at: &Vec<f64>| at.iter().zip(draw).map(|(cost, weight)| cost * weight).sum();
            fitting(&costs.iter().map(of).collect::<Vec<f64>>())
        };
        let sets: Vec<(usize, usize)> = all.iter().filter_map(|draw| set(&draw.condition)).collect();
        let [low, high] = ends(&scan, best, &sets, &costs).logs;
        low.is_none_or(|low| low <= (0.4f64).ln()) && high.is_none_or(|high| high >= (0.4f64).ln())
    };
    (0..200).filter(|_| case()).count()
}

#[test]
fn an_interval_that_two_of_twenty_conditions_tell_of_holds_the_truth_as_one_of_all_does() {
    let [few, all] = [2, CONDITIONS].map(held);
    // 95 % of 200, less three standard deviations.
    assert!(few >= 180 && all >= 180, "{few} and {all} of 200");
}

#[test]
fn what_two_of_twenty_conditions_exclude_two_speak_against() {
    let mut costs = vec![vec![1.0; CONDITIONS]; 3];
    costs[0] = vec![2.0; CONDITIONS];
    costs[2][4] = 3.0;
    costs[2][11] = 3.0;
    let [below, above] = against(&costs, 1);
    assert!((below - 20.0).abs() < 1e-9 && (above - 2.0).abs() < 1e-9, "{below} {above}");
}

#[test]
fn a_side_that_costs_nothing_more_has_no_more_than_one_condition_against_it() {
    assert_eq!(against(&[vec![1.0; 4], vec![1.0; 4]], 1), [1.0, 1.0]);
    assert_eq!(against(&[], 0), [1.0, 1.0]);
}
