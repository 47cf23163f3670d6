//! The bodies of a recorded trial and where they are over time: what a drawing of the bench needs.

use stickslip_shared::model::Scene;
use stickslip_shared::track::{Pose, Poses};

use crate::run::simulate::Prepared;

/// Shapes, the object's start, and the poses of the bodies that are driven.
#[derive(Clone, Debug)]
pub struct Bench {
    /// Shapes of object, fingers and pusher.
    pub scene: Scene<f64>,
    /// Object in the carrier frame at the start; the object's channels count from its rotation.
    pub start: Pose<f64>,
    /// Carrier and pusher, one for each sample.
    pub poses: Vec<Poses<f64>>,
}

impl Bench {
    /// Of a trial that is made ready.
    #[must_use]
    pub fn of(prepared: &Prepared) -> Self {
        Bench { scene: prepared.scene.clone(), start: prepared.start, poses: prepared.poses().to_vec() }
    }
}
