//! Which trials friction is found from.

use stickslip_analysis::calibrate::{Share, pick};

#[test]
fn calibration_trials_are_distinct_conditions_spread_over_the_list() {
    let names: Vec<String> = (0..420).map(|i| format!("{}", i % 140)).collect();
    let conditions: Vec<&str> = names.iter().map(String::as_str).collect();
    let taken = pick(&conditions, Share::of(0.1));
    assert_eq!(taken.len(), 42);
    assert!(taken.windows(2).all(|w| w[0] < w[1] && w[1] - w[0] < 30), "{taken:?}");
    let mut touched: Vec<&str> = taken.iter().map(|i| conditions[*i]).collect();
    touched.sort_unstable();
    touched.dedup();
    assert_eq!(touched.len(), 42);
    assert_eq!(pick(&conditions[..2], Share::of(0.1)), vec![0, 1]);
}
