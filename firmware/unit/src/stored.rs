//! What the unit remembers: read once at the start, written when the host asks, never in a run: flash may hold up the
//! processor for a page's erasure (22 ms).

use core::ops::Range;

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::NorFlash;
use stickslip_shared::wire::{Recalled, Refusal};

use crate::memory::{Memory, MemoryFault, Settings};
use crate::slot::Slot;
use crate::upload::Upload;

/// The memory, where the board has one.
pub struct Stored<F: NorFlash>(Option<Memory<F>>);

impl<F: NorFlash> Stored<F> {
    /// In a part of the board's flash.
    pub fn new(flash: Option<F>, range: Range<u32>) -> Self {
        Self(flash.and_then(|flash| Memory::new(flash, range).ok()))
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

    /// Stores the settings, and the model in use, by its checksum, where it is another than the stored one.
    ///
    /// # Errors
    /// No memory, or it fails; or the bytes of the model in use are gone, since others were sent that were refused: then
    /// nothing is written.
    pub fn store(
        &mut self,
        settings: &Settings,
        upload: &Upload,
        in_use: Option<u32>,
    ) -> Result<(), Refusal> {
        let memory = self.0.as_mut().ok_or(Refusal::NoMemory)?;
        let sent = in_use == Some(upload.crc());
        if in_use.is_some() && !sent && model_crc(memory) != in_use {
            return Err(Refusal::NotStored);
        }
        let failed = |_| Refusal::NotStored;
        block_on(memory.store_settings(settings)).map_err(failed)?;
        // Looked at anew: memory that held something else was erased.
        if in_use.is_none() || model_crc(memory) == in_use {
            Ok(())
        } else if sent {
            block_on(memory.store_model(upload.bytes())).map_err(failed)
        } else {
            Err(Refusal::NotStored)
        }
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

/// Checksum of the stored model; `None` where none can be read.
// A function of its own: its room is not on the stack while something is stored.
#[inline(never)]
fn model_crc<F: NorFlash>(memory: &mut Memory<F>) -> Option<u32> {
    block_on(memory.model_crc())
}
