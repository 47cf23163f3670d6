//! How differently a grasp closes from trial to trial.
//!
//! The middle of a pad's pressure is where the two faces happen to touch, and not the same twice: its finger's sensor shows the
//! grip times that distance as a moment that stays as long as the grasp holds. Repetitions show how much; where no trial was
//! repeated it is a direction of the features' covariance for each finger and each axis along its face.

use stickslip_shared::model::FingerContact;

use crate::fit::campaign::Run;
use crate::fit::features::Features;
use crate::fit::gls::constant;

/// Standard deviation of the middle of the pressure from trial to trial, as share of the pad's diameter: 0.2 mm of 20 mm.
const OF_DIAMETER: f64 = 0.01;

/// Directions of one standard deviation each, N m; none where the fingers have no discs.
#[must_use]
pub fn directions(run: &Run) -> Vec<Features> {
    let Some(FingerContact::Disc { diameter_m }) = run.prepared.scene.fingers else { return Vec::new() };
    let moment_nm = OF_DIAMETER * diameter_m * run.prepared.grip_n();
    // Torques about X and Z of finger 1, and of finger 2.
    [3, 5, 9, 11].map(|offset| constant(offset, moment_nm)).into()
}
