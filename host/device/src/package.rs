//! A trial as the board needs it: scene, model and limits as bytes, samples, a plan. The same
//! that a replay on the host runs on, so that the two can be compared bit for bit.

use stickslip_shared::model::{Model, Scene};
use stickslip_shared::predictor::{Limits, Plan};
use stickslip_shared::wire::{self, ModelPackage};

/// Everything for one run.
#[derive(Clone, Debug)]
pub struct Package {
    /// In the board's precision.
    pub model: ModelPackage,
    /// What the gripper will do.
    pub plan: Plan,
    /// Place of the trial in its data set.
    pub ordinal: f32,
    /// One for each row, numbered from 0.
    pub samples: Vec<wire::Sample>,
}

impl Package {
    /// From a trial's scene, plan and samples; `model` in `f64` as read from the user's file.
    #[must_use]
    pub fn new(
        scene: Scene<f32>,
        model: &Model<f64>,
        plan: Plan,
        samples: Vec<wire::Sample>,
        ordinal: usize,
    ) -> Self {
        Self { model: (scene, model.cast(), Limits::default()), plan, ordinal: ordinal as f32, samples }
    }

    /// Scene, model and limits as the board reads them.
    ///
    /// # Errors
    /// Never in practice: every part can be serialised.
    pub fn bytes(&self) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_stdvec(&self.model)
    }
}
