//! What the unit remembers: read once at the start, written when the host asks, never in a run: flash may hold up the
//! processor for a page's erasure (22 ms).

use embassy_futures::block_on;
use stickslip_shared::wire::{Recalled, Refusal};
use stickslip_unit::memory::{Memory, MemoryFault, Settings};

use crate::board::current::{self as board, Flash};
use crate::queues::MODEL_CRC;
use crate::slot::Slot;
use crate::upload::Upload;

/// The memory, where the board has one.
pub struct Stored(Option<Memory<Flash>>);

impl Stored {
    /// On the board's flash.
    pub fn new(flash: Option<Flash>) -> Self {
        Self(flash.and_then(|flash| Memory::new(flash, board::MEMORY).ok()))
    }

    /// The settings, and the model decoded into `slot`, checked as if they came over the line.
    pub fn recall(&mut self, upload: &mut Upload, slot: &mut Slot) -> (Settings, Recalled) {
        let Some(memory) = &mut self.0 else { return (Settings::default(), Recalled::NoMemory) };
        let told = |fault| match fault {
            MemoryFault::OtherVersion { found } => Recalled::OtherVersion { found },
            _ => Recalled::Unusable,
        };
        let settings = match block_on(memory.settings()) {
            Ok(Some(settings)) => settings,
            Ok(None) => return (Settings::default(), Recalled::Empty),
            Err(fault) => return (Settings::default(), told(fault)),
        };
        let recalled = match block_on(memory.model()) {
            Ok(None) => Recalled::Done,
            Ok(Some(bytes)) => match upload.of_memory(&bytes, &mut slot.package) {
                Ok([crc, scene_crc]) => {
                    (slot.crc, slot.scene_crc) = (crc, scene_crc);
                    Recalled::Done
                }
                Err(_) => Recalled::Unusable,
            },
            Err(fault) => told(fault),
        };
        (settings, recalled)
    }

    /// Stores the settings, and the model where the upload's bytes are those in use.
    ///
    /// # Errors
    /// No memory, or it fails.
    pub fn store(&mut self, settings: &Settings, upload: &Upload) -> Result<(), Refusal> {
        let memory = self.0.as_mut().ok_or(Refusal::NoMemory)?;
        let failed = |_| Refusal::NotStored;
        // Of a model that came out of the memory nothing is left to store.
        if upload.crc() == MODEL_CRC.load(core::sync::atomic::Ordering::Relaxed) {
            block_on(memory.store_model(upload.bytes())).map_err(failed)?;
        }
        block_on(memory.store_settings(settings)).map_err(failed)
    }

    /// Forgets everything stored.
    ///
    /// # Errors
    /// No memory, or it fails.
    pub fn forget(&mut self) -> Result<(), Refusal> {
        let memory = self.0.as_mut().ok_or(Refusal::NoMemory)?;
        block_on(memory.erase()).map_err(|_| Refusal::NotStored)
    }
}
