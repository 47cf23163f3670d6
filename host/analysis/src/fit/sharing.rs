//! How two fingers share a load before anything has slid.
//!
//! Closing the grasp leaves any share between them: what one finger bears more across the grip's axis the other bears less. That
//! is a couple on the object, which the pads' moments balance, half of it each. Neither is a property of the contact, but
//! balance ties them: a direction of the features' covariance for each axis along the faces, not a floor of each channel.

use nalgebra::Vector3;

use crate::evidence::tolerance::RIGID;
use crate::fit::campaign::Run;
use crate::fit::features::{FEATURES, Features, quantity};
use crate::fit::phases::{BINS, Phase};

/// Channels of the fingers' torques together and of the difference of their forces ([`crate::fit::features`]).
const TORQUES: usize = 9;
const DIFFERENCE: usize = 12;

/// Directions of one standard deviation each, N and N m; none where nothing is grasped.
#[must_use]
pub fn directions(run: &Run) -> Vec<Features> {
    let scene = &run.prepared.scene;
    if scene.fingers.is_none() {
        return Vec::new();
    }
    let closing = run.prepared.start.rotation.inverse() * Vector3::y();
    let apart_m = scene.object.shape.reach(&closing) + scene.object.shape.reach(&-closing);
    let before = (0..BINS).filter(|bin| Phase::of(*bin) == Phase::Before);
    let rest: Vec<usize> = before.collect();
    let direction = |axis: usize| {
        let mut more_n = Vector3::zeros();
        more_n[axis] = RIGID.shared_weight(scene, quantity(DIFFERENCE * BINS));
        // Half of the difference at each end.
        let couple_nm = Vector3::new(0.0, 0.5 * apart_m, 0.0).cross(&more_n);
        let mut out = vec![0.0; FEATURES];
        for bin in &rest {
            for k in 0..3 {
                out[(DIFFERENCE + k) * BINS + bin] = more_n[k];
                out[(TORQUES + k) * BINS + bin] = -couple_nm[k];
            }
        }
        out
    };
    [0, 2].map(direction).into()
}
