//! Rates and their intervals.

use statrs::distribution::{DiscreteCDF, Poisson};
use stickslip_analysis::score::rate::*;

#[test]
fn at_either_end_of_the_interval_the_count_has_two_and_a_half_per_cent_chance() {
    for count in [0, 1, 2, 7, 40, 300] {
        let rate = Rate::of(count, 3600.0).expect("an hour");
        let [low, high] = rate.interval_per_hour;
        let at_most = Poisson::new(high).expect("a rate").cdf(count as u64);
        assert!((at_most - 0.025).abs() < 1e-6, "{count}: {at_most}");
        if count == 0 {
            assert_eq!(low, 0.0);
        } else {
            let at_least = 1.0 - Poisson::new(low).expect("a rate").cdf(count as u64 - 1);
            assert!((at_least - 0.025).abs() < 1e-6, "{count}: {at_least}");
        }
    }
}

#[test]
fn nothing_seen_in_73_s_leaves_up_to_182_an_hour_open_and_no_time_tells_nothing() {
    let rate = Rate::of(0, 73.0).expect("some time");
    assert!((rate.interval_per_hour[1] - 181.9).abs() < 0.1, "{rate:?}");
    assert_eq!(Rate::of(0, 0.0), None);
    assert_eq!(Rate::of(3, f64::NAN), None);
}
