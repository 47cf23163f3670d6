//! Tolerances that bins of a phase share.

use stickslip_analysis::fit::common_floor::{directions, own_share};
use stickslip_analysis::fit::features::{FEATURES, Features};
use stickslip_analysis::fit::gls::Whitener;
use stickslip_analysis::fit::phases::{BINS, Phase};

/// A floor of its own size in each feature.
fn floor2() -> Vec<f64> {
    (0..FEATURES).map(|f| 1.0 + (f % 7) as f64).collect()
}

fn whitener(floor2: &[f64]) -> Whitener {
    let own: Vec<f64> = floor2.iter().enumerate().map(|(f, x)| own_share(f) * x).collect();
    Whitener::new((0..FEATURES).collect(), &own, &directions(floor2))
}

/// One floor in every bin of a phase of a channel.
fn departure(floor2: &[f64], channel: usize, phase: Phase) -> Features {
    let mut out = vec![0.0; FEATURES];
    for bin in (0..BINS).filter(|bin| Phase::of(*bin) == phase) {
        out[channel * BINS + bin] = floor2[channel * BINS + bin].sqrt();
    }
    out
}

#[test]
fn bins_of_a_phase_that_are_off_alike_count_less_than_two_however_many_they_are() {
    let floor2 = floor2();
    let whitener = whitener(&floor2);
    for channel in [0, 7, 23] {
        for phase in Phase::ALL {
            let count = (0..BINS).filter(|bin| Phase::of(*bin) == phase).count() as f64;
            let square = whitener.square(&departure(&floor2, channel, phase));
            // Half alone and half in common: n / (1/2 + n/2).
            let expected = if count > 1.0 { 2.0 * count / (1.0 + count) } else { 1.0 };
            assert!((square - expected).abs() < 1e-9 && square < 2.0, "{phase:?}: {square}");
        }
    }
}

#[test]
fn the_size_of_each_bins_floor_is_what_it_is_without_a_share_in_common() {
    let floor2 = floor2();
    let mut variance: Vec<f64> = floor2.iter().enumerate().map(|(f, x)| own_share(f) * x).collect();
    for direction in directions(&floor2) {
        variance.iter_mut().zip(&direction).for_each(|(v, d)| *v += d * d);
    }
    assert!(variance.iter().zip(&floor2).all(|(v, f)| (v - f).abs() < 1e-12));
}

#[test]
fn what_differs_from_channel_to_channel_or_from_phase_to_phase_is_as_many_departures() {
    let floor2 = floor2();
    let whitener = whitener(&floor2);
    let sliding = departure(&floor2, 6, Phase::Sliding);
    for other in [departure(&floor2, 7, Phase::Sliding), departure(&floor2, 6, Phase::After)] {
        let both: Features = sliding.iter().zip(&other).map(|(a, b)| a + b).collect();
        let sum = whitener.square(&sliding) + whitener.square(&other);
        assert!((whitener.square(&both) - sum).abs() < 1e-9);
    }
}
