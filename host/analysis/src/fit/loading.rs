//! How contacts load while they begin to slide: what the onset's bins cannot tell.
//!
//! A sample's travel, and the length over which pads, bristles and plates take up a force, lie between
//! the first touch and sliding. Models of contact differ there by the whole of the force, each channel
//! by its own share, common to the onset's bins. These are directions of the covariance, not
//! a floor: a lag that decays along the path is ordinary, a level that stays is a finding.

use crate::channels::{COUNT, Quantity};
use crate::fit::campaign::Run;
use crate::fit::features::{FEATURES, Features, quantity};
use crate::fit::phases::{BINS, PEAK, onset_lengths};

/// Stiffness of a contact's loading beyond what the model has of it, N/m: pads of 5e4 to 2e7 N/m load within
/// three lengths `F / K` (LuGre bristles, Canudas de Wit et al. 1995). Doubled: models that
/// load over 0.1 mm are blamed at the onset. Halved: static friction is harder to see.
const STIFFNESS_N_M: f64 = 3e5;
/// Share of a force's rise by which the peak of its onset may be off: springs and bristles overshoot by some
/// per cent, and samples meet the peak or not. Doubled: break-away forces below a tenth above sliding are missed.
const OVERSHOOT: f64 = 0.05;
/// First channel of forces and torques.
const FIRST: usize = 6;

/// One direction of one standard deviation for each channel of force and torque; `modelled` features of the run.
pub fn lags(run: &Run, modelled: &Features) -> Vec<Features> {
    let fastest = run.prepared.drive_speed().into_iter().fold(0.0, f64::max);
    let lengths = onset_lengths(&run.prepared);
    // From the rest before to the beginning of the sliding path.
    let jump = |channel: usize| {
        let d = modelled[channel * BINS + 5] - modelled[channel * BINS];
        if d.is_finite() { d } else { 0.0 }
    };
    let largest = (FIRST..COUNT)
        .filter(|c| quantity(c * BINS) == Quantity::Force)
        .map(|c| jump(c).abs())
        .fold(0.0, f64::max);
    let length = (run.prepared.period_s() * fastest).hypot(largest / STIFFNESS_N_M);
    (FIRST..COUNT)
        .map(|channel| {
            let mut d = vec![0.0; FEATURES];
            d[channel * BINS + PEAK] = OVERSHOOT * jump(channel);
            for (k, bin_m) in lengths.iter().enumerate() {
                let share = (length / bin_m).min(1.0) * (-(k as f64)).exp();
                d[channel * BINS + 1 + k] = share * jump(channel);
            }
            d
        })
        .filter(|d| d.iter().any(|x| *x != 0.0))
        .collect()
}
