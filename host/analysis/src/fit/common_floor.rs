//! What the bins of a phase share: what a model lacks, it lacks all along a phase.
//!
//! The floor of a feature ([`super::noise`]) is a size. Were it independent from bin to bin it would shrink with their number: six
//! bins of a sliding path that are all off by one floor would be six departures and outweigh a rest of one bin, so that a wrong
//! effect which explains the path and spoils the rest looks well. Part of it is therefore common to a channel's bins of a phase: a
//! direction of the features' covariance.

use crate::channels::COUNT;
use crate::fit::features::{FEATURES, Features};
use crate::fit::phases::{BINS, Phase};

/// Share of the floor's variance that a channel's bins of a phase have in common; the size of each bin's floor is as before.
pub const SHARE: f64 = 0.5;

/// Phases of several bins.
const SEVERAL: [Phase; 3] = [Phase::Onset, Phase::Sliding, Phase::After];

/// For each channel and phase of several bins one standard deviation of what they have in common, of the variance `floor2` of
/// each feature.
#[must_use]
pub fn directions(floor2: &[f64]) -> Vec<Features> {
    let one = |channel: usize, phase: Phase| {
        let mut out = vec![0.0; FEATURES];
        for feature in (0..BINS).filter(|bin| Phase::of(*bin) == phase).map(|bin| channel * BINS + bin) {
            out[feature] = (SHARE * floor2[feature]).sqrt();
        }
        out
    };
    (0..COUNT).flat_map(|channel| SEVERAL.map(|phase| one(channel, phase))).collect()
}

/// Share of the variance of `feature`'s floor that is its own.
#[must_use]
pub fn own_share(feature: usize) -> f64 {
    if SEVERAL.contains(&Phase::of(feature % BINS)) { 1.0 - SHARE } else { 1.0 }
}
