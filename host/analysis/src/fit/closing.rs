//! How differently a grasp closes from trial to trial.
//!
//! The middle of a pad's pressure is where the two faces happen to touch, and not the same twice: its finger's sensor shows the
//! grip times that distance as a moment that stays as long as the grasp holds. Repetitions show how much; where no trial was
//! repeated it is as unsure as from rig to rig ([`super::constants`]): a direction of the features' covariance for each finger and
//! each axis along its face.

use crate::fit::campaign::Run;
use crate::fit::constants::{OF_DIAMETER, constant};
use crate::fit::features::Features;

/// Directions of one standard deviation each, N m; none where the fingers have no discs.
#[must_use]
pub fn directions(run: &Run) -> Vec<Features> {
    let Some(diameter_m) = run.prepared.pad_diameter_m() else { return Vec::new() };
    let moment_nm = OF_DIAMETER * diameter_m * run.prepared.grip_n();
    // Torques about X and Z of finger 1, and of finger 2.
    [3, 5, 9, 11].map(|offset| constant(offset, moment_nm)).into()
}
