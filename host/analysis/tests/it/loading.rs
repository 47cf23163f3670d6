//! How far channels lag where contacts load.

use stickslip_analysis::fit::loading::shares;

#[test]
fn a_contact_that_loads_within_a_bin_lags_as_before_and_one_that_takes_longer_by_its_path() {
    let bins = [1e-4, 2e-4, 4e-4, 8e-4];
    let short = shares(5e-5, &bins);
    assert!((short[0] - 0.5).abs() < 1e-12 && (short[2] - 0.125 * (-2.0_f64).exp()).abs() < 1e-12);
    let long = shares(1e-3, &bins);
    assert!((long[3] - (-0.7_f64).exp()).abs() < 1e-12, "{long:?}");
    assert_eq!(shares(0.0, &bins), [0.0; 4]);
}
