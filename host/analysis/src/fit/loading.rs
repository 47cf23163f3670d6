//! How contacts load while they begin to slide: what the bins of the onset, and of the start after a pause, cannot tell.
//!
//! A sample's travel, and the length over which pads, bristles and plates take up a force, lie between
//! the first touch and sliding. Models of contact differ there by the whole of the force, each channel
//! by its own share, common to the onset's bins. After a pause the same holds of the change from the pause to the end of
//! the path: how far pads of a given stiffness along the face give way in torsion depends on how their pressure is spread
//! (a ring of points, as in the model, 0.44 of `K R^2`, an even pressure on springs 0.5, a half-space 1.0 to 1.1: Johnson
//! 1985, 3.7). These are directions of the covariance, not a floor: a lag that decays along the path is ordinary, a level
//! that stays is a finding.

use crate::channels::{COUNT, FINGER_FORCE, Quantity};
use crate::evidence::pads::mean_square_m2;
use crate::fit::campaign::Run;
use crate::fit::features::{FEATURES, Features, quantity};
use crate::fit::phases::{BINS, LAST, PAUSE, PEAK, RESTART, RESTART_M, onset_lengths};
use crate::run::simulate::TURN_ARM_M;

/// Stiffness of a contact's loading beyond what the model has of it, N/m: pads of 5e4 to 2e7 N/m load within
/// three lengths `F / K` (LuGre bristles, Canudas de Wit et al. 1995). Doubled: models that
/// load over 0.1 mm are blamed at the onset. Halved: static friction is harder to see.
const STIFFNESS_N_M: f64 = 3e5;
/// Share of a force's rise by which the peak of its onset may be off: springs and bristles overshoot by some
/// per cent, and samples meet the peak or not. Doubled: break-away forces below a tenth above sliding are missed.
const OVERSHOOT: f64 = 0.05;

/// Torque of both fingers about the closing direction.
const TURNING: usize = FINGER_FORCE + 4;

/// Directions of one standard deviation for each channel of force and torque, at the onset and after a pause, by the
/// features `measured`: what
/// a model does not move in a channel loads there all the same.
pub fn lags(run: &Run, measured: &Features) -> Vec<Features> {
    let change = |channel: usize, [from, to]: [usize; 2]| {
        let d = measured[channel * BINS + to] - measured[channel * BINS + from];
        if d.is_finite() { d } else { 0.0 }
    };
    // From the rest before to the beginning of the sliding path.
    let jump = |channel: usize| change(channel, [0, 5]);
    let length_m = length(run, jump);
    let shares = shares(length_m, &onset_lengths(&run.prepared));
    let onset = |channel: usize| {
        let mut d = vec![0.0; FEATURES];
        d[channel * BINS + PEAK] = OVERSHOOT * jump(channel);
        for (k, share) in shares.iter().enumerate() {
            d[channel * BINS + 1 + k] = share * jump(channel);
        }
        d
    };
    let restart = |channel: usize| {
        let mut d = vec![0.0; FEATURES];
        d[channel * BINS + RESTART] = (length_m / RESTART_M).min(1.0) * change(channel, [PAUSE, LAST]);
        d
    };
    let all = (FINGER_FORCE..COUNT).flat_map(|channel| [onset(channel), restart(channel)]);
    all.filter(|d| d.iter().any(|x| *x != 0.0)).collect()
}

/// Share of a sample's period between a contact's forces and the model's, one standard deviation: a sample lies anywhere in
/// a rise that takes less than one, and filters of the sensors add as much.
const OFF_BY: f64 = 0.5;

/// What all forces and torques later by a share of a sample change, of one standard deviation: in a quick push the whole rise
/// lies in one sample.
pub fn late(run: &Run) -> Features {
    let rows = &run.prepared.measured;
    let shifted = |i: usize| {
        let mut row = rows[i];
        row[FINGER_FORCE..].copy_from_slice(&rows[i.saturating_sub(1)][FINGER_FORCE..]);
        row
    };
    let later = run.bins.reduce(&(0..rows.len()).map(shifted).collect::<Vec<_>>());
    later.iter().zip(&run.measured).map(|(l, m)| if l.is_finite() { OFF_BY * (l - m) } else { 0.0 }).collect()
}

/// Length of the drive's path over which contacts load, m: in one sample, under the largest force, and where the
/// fingers hold a torque, under that: a patch turns by `T / (2 K r^2)` before it slides.
fn length(run: &Run, jump: impl Fn(usize) -> f64) -> f64 {
    let fastest = run.prepared.drive_speed().into_iter().fold(0.0, f64::max);
    let largest = (FINGER_FORCE..COUNT)
        .filter(|c| quantity(c * BINS) == Quantity::Force)
        .map(|c| jump(c).abs())
        .fold(0.0, f64::max);
    let patch_m2 = run.prepared.scene.fingers.as_ref().map_or(0.0, mean_square_m2);
    let turn = if patch_m2 > 0.0 { jump(TURNING).abs() / (2.0 * STIFFNESS_N_M * patch_m2) } else { 0.0 };
    let sheared = (largest / STIFFNESS_N_M).hypot(TURN_ARM_M * turn);
    (run.prepared.period_s() * fastest).hypot(sheared)
}

/// Share of its rise by which a channel may lag in bins of these lengths: it decays over `length` of path, and no
/// faster than from bin to bin, as `length` is known to a factor of three.
pub fn shares(length: f64, bins_m: &[f64; 4]) -> [f64; 4] {
    let mut from_m = 0.0;
    std::array::from_fn(|k| {
        let decay = (from_m / length.max(f64::MIN_POSITIVE)).min(k as f64);
        from_m += bins_m[k];
        (length / bins_m[k]).min(1.0) * (-decay).exp()
    })
}
