//! A trial as the board needs it: scene, model and limits as bytes, samples, a plan. The same
//! that a replay on the host runs on, so that the two can be compared bit for bit.

use stickslip_shared::model::Model;
use stickslip_shared::predictor::{Limits, Plan};
use stickslip_shared::wire::{self, ModelPackage};

use crate::dataset::{Description, Trial};
use crate::replay::{Feed, feed};
use crate::simulate::SceneError;

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
    /// From a trial; `model` in `f64` as read from the user's file.
    ///
    /// # Errors
    /// Where the description lacks what the scene needs.
    pub fn new(
        description: &Description,
        model: &Model<f64>,
        trial: &Trial,
        ordinal: usize,
    ) -> Result<Self, SceneError> {
        let Feed { scene, plan, samples } = feed(description, trial)?;
        Ok(Self { model: (scene, model.cast(), Limits::default()), plan, ordinal: ordinal as f32, samples })
    }

    /// Scene, model and limits as the board reads them.
    ///
    /// # Errors
    /// Never in practice: every part can be serialised.
    pub fn bytes(&self) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_stdvec(&self.model)
    }
}
