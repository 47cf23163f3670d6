//! How far channels lag where contacts load.

use std::path::Path;

use stickslip_analysis::fit::campaign::Campaign;
use stickslip_analysis::fit::features::FEATURES;
use stickslip_analysis::fit::loading::{lags, late, shares};
use stickslip_analysis::fit::phases::{BINS, PEAK, Phase};
use stickslip_analysis::model::file::default_model;
use stickslip_data::read;

#[test]
fn a_contact_that_loads_within_a_bin_lags_as_before_and_one_that_takes_longer_by_its_path() {
    let bins = [1e-4, 2e-4, 4e-4, 8e-4];
    let short = shares(5e-5, &bins);
    assert!((short[0] - 0.5).abs() < 1e-12 && (short[2] - 0.125 * (-2.0_f64).exp()).abs() < 1e-12);
    let long = shares(1e-3, &bins);
    assert!((long[3] - (-0.7_f64).exp()).abs() < 1e-12, "{long:?}");
    assert_eq!(shares(0.0, &bins), [0.0; 4]);
}

#[test]
fn after_a_pause_a_channel_may_lag_by_a_share_of_what_the_stop_took_away_and_by_nothing_else() {
    let mut data = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")).expect("the demo");
    data.trials.truncate(1);
    let campaign = Campaign::new(&data, &default_model());
    // Push force, channel 18: 4 N on the way, 3 N in the pause.
    let of = |pause_n: f64| {
        let mut measured = vec![f64::NAN; FEATURES];
        for bin in 0..BINS {
            measured[18 * BINS + bin] = if Phase::of(bin) == Phase::Pause { pause_n } else { 4.0 };
        }
        lags(&campaign.runs[0], &measured)
    };
    assert!(of(4.0).is_empty(), "nothing changes at the pause");
    let [direction] = &of(3.0)[..] else { panic!("one direction") };
    for (feature, size) in direction.iter().enumerate().filter(|(_, size)| **size != 0.0) {
        assert_eq!((feature / BINS, Phase::of(feature % BINS)), (18, Phase::Restart));
        assert!(*size > 0.0 && *size < 0.5, "{size} N of 1 N");
    }
}

#[test]
fn a_rise_within_one_sample_may_be_off_by_half_of_it_in_its_bin_and_what_does_not_change_by_nothing() {
    let data = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")).expect("the demo");
    let mut campaign = Campaign::new(&data, &default_model());
    let run = &mut campaign.runs[0];
    // The push force stands at zero until the middle of the first millimetres, and at 10 N from there on.
    let begins = run.prepared.drive_speed().iter().position(|v| *v > 1e-4).expect("it moves") + 60;
    for (i, row) in run.prepared.measured.iter_mut().enumerate() {
        row[6..].fill(1.0);
        row[18] = if i < begins { 0.0 } else { 10.0 };
    }
    run.measured = run.bins.measured(&run.prepared);
    let direction = late(run);
    for (feature, size) in direction.iter().enumerate().filter(|(_, size)| size.abs() > 1e-12) {
        assert_eq!(feature / BINS, 18, "constant channels do not change");
        // One sample of 10 N fewer in a bin of at least one; the peak is counted from the level that follows.
        assert!(size.abs() <= 5.0 && (*size < 0.0 || feature % BINS == PEAK), "{size}");
    }
    assert!(direction.iter().any(|x| *x < 0.0), "{direction:?}");
}
