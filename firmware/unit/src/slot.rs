//! The place where a new model waits.
//!
//! The link decodes and checks it there at its low priority; the control task takes it over at
//! the beginning of a tick. So the predictor that runs never sees half a model, and there is
//! memory for one predictor only.

use stickslip_shared::wire::ModelPackage;

/// A place for one model.
#[derive(Default)]
pub struct Slot {
    /// `None` before the first.
    pub package: Option<ModelPackage>,
    /// CRC-32 of its bytes, and of those of its scene.
    pub crc: u32,
    /// See `crc`.
    pub scene_crc: u32,
}

impl Slot {
    /// Without a model.
    pub const fn new() -> Self {
        Self { package: None, crc: 0, scene_crc: 0 }
    }
}
