//! The two places that hold a predictor.
//!
//! One runs, in the other the link builds the next model at its low priority. A swap
//! passes a reference from task to task at the beginning of a tick, so it costs nothing
//! and happens whole or not at all.

use stickslip_shared::predictor::Predictor;

/// A place for one predictor.
#[derive(Default)]
pub struct Slot {
    /// `None` before the first model.
    pub predictor: Option<Predictor<f32>>,
    /// CRC-32 of the model's bytes.
    pub crc: u32,
}

impl Slot {
    /// Without a model.
    pub const fn new() -> Self {
        Self { predictor: None, crc: 0 }
    }
}
