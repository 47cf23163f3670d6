//! The predictor behind a fixed interface, and the two places that hold one.
//!
//! Two slots: one runs, in the other the link builds the next model at its low priority.
//! A swap passes a reference from task to task at the beginning of a tick, so it costs
//! nothing and happens whole or not at all.

use stickslip_shared::model::{Model, Scene};
use stickslip_shared::wire::{ModelFault, Plan, Prediction, Sample};

/// What the tick needs of a predictor.
pub trait Control: Sized {
    /// Most contact points.
    const CONTACTS: u16;
    /// # Errors
    /// The model cannot be run here.
    fn build(scene: Scene<f32>, model: Model<f32>) -> Result<Self, ModelFault>;
    /// Forgets every sample; the model stays.
    fn restart(&mut self);
    /// Planned motion from the next sample on.
    fn set_plan(&mut self, plan: &Plan);
    /// Takes one sample.
    fn tick(&mut self, sample: &Sample) -> Prediction;
}

/// The predictor that this firmware runs.
pub type Active = crate::holding::Holding;

/// A place for one predictor.
pub struct Slot {
    /// `None` before the first model.
    pub control: Option<Active>,
    /// CRC-32 of the model's bytes.
    pub crc: u32,
}

impl Slot {
    /// Without a model.
    pub const fn new() -> Self {
        Self { control: None, crc: 0 }
    }
}

impl Default for Slot {
    fn default() -> Self {
        Self::new()
    }
}
