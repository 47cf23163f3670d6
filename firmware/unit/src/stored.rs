//! What the unit remembers: read once at the start, written when the host asks, never in a run: flash may hold up the
//! processor for a page's erasure (22 ms).
//!
//! Two copies, each in its half of the memory, each with the settings and the model that they belong to (by its CRC).
//! One is written and read back before the other is touched, and in each the settings come last: wherever power is cut,
//! one copy is whole, with the old state or the new one, whatever the word or page looks like at which it went.

use core::ops::Range;

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::NorFlash;
use stickslip_shared::wire::{Recalled, Refusal};

use crate::memory::{Memory, MemoryFault, Settings, Stamp};
use crate::slot::Slot;
use crate::upload::Upload;

/// The memory, where the board has one.
pub struct Stored<F: NorFlash> {
    memory: Option<Memory<F>>,
    range: Range<u32>,
    /// Whether the second copy is the one in use: the other is written first.
    second: bool,
}

impl<F: NorFlash> Stored<F> {
    /// In a part of the board's flash: four whole pages or more, an even number.
    pub fn new(flash: Option<F>, range: Range<u32>) -> Self {
        let memory = flash.and_then(|flash| Memory::new(flash, range.clone()).ok());
        Self { memory, range, second: false }
    }

    /// A copy, where there is memory.
    #[inline(never)]
    fn copy(&mut self, second: bool) -> Option<&mut Memory<F>> {
        let half = self.range.end.saturating_sub(self.range.start) / 2;
        let start = self.range.start + if second { half } else { 0 };
        self.memory = self.memory.take().and_then(|memory| memory.within(start..start + half).ok());
        self.memory.as_mut()
    }

    /// The settings, and the model decoded into `slot`, checked as if they came over the line: of the newer copy that is
    /// whole.
    pub fn recall(&mut self, upload: &mut Upload, slot: &mut Slot) -> (Settings, Recalled) {
        let (mut best, mut told) = (Stamp::default(), Recalled::Empty);
        for second in [false, true] {
            let Some(memory) = self.copy(second) else { return (Settings::default(), Recalled::NoMemory) };
            let (stamp, found) = match block_on(memory.stamp()) {
                Ok(None) => continue,
                Ok(Some(stamp)) if has_model(memory, stamp) => (stamp, Recalled::Done),
                Ok(Some(stamp)) => (stamp, Recalled::WithoutModel),
                Err(MemoryFault::OtherVersion { found }) => (best, Recalled::OtherVersion { found }),
                Err(_) => (best, Recalled::Unusable),
            };
            // The better of two is told.
            if found > told || (found == told && stamp.generation > best.generation) {
                (best, told, self.second) = (stamp, found, second);
            }
        }
        if told < Recalled::WithoutModel {
            return (Settings::default(), told);
        }
        let settings = self.copy(self.second).map(|memory| block_on(memory.settings()));
        let Some(Ok(Some(settings))) = settings else { return (Settings::default(), Recalled::Unusable) };
        if told == Recalled::Done && self.model(settings.stamp.model, upload, slot).is_none() {
            told = Recalled::WithoutModel;
        }
        (settings, told)
    }

    /// Decodes the model of the copy in use into `slot`, where it is the one with this checksum, or there is to be none.
    fn model(&mut self, crc: u32, upload: &mut Upload, slot: &mut Slot) -> Option<()> {
        if crc == 0 {
            return Some(());
        }
        let bytes = block_on(self.copy(self.second)?.model()).ok()??;
        slot.scene_crc = upload.of_memory(bytes, crc, &mut slot.package).ok()?;
        slot.crc = crc;
        Some(())
    }

    /// Stores the settings, and the model in use, by its checksum, where it is another than the stored one.
    ///
    /// # Errors
    /// No memory, or it fails: then the old state or the new one is recalled; or the bytes of the model in use are gone,
    /// since others were sent that were refused: then nothing is written.
    pub fn store(
        &mut self,
        settings: &mut Settings,
        upload: &Upload,
        in_use: Option<u32>,
    ) -> Result<(), Refusal> {
        let order = [!self.second, self.second];
        let sent = (in_use == Some(upload.crc())).then_some(upload.bytes());
        settings.stamp.model = in_use.unwrap_or(0);
        for second in order {
            let memory = self.copy(second).ok_or(Refusal::NoMemory)?;
            if sent.is_none() && !has_model(memory, settings.stamp) {
                return Err(Refusal::NotStored);
            }
        }
        settings.stamp.generation = settings.stamp.generation.wrapping_add(1);
        for second in order {
            let memory = self.copy(second).ok_or(Refusal::NoMemory)?;
            // One that fails held something else, or a page of it is half erased: it begins anew, and the other stands.
            let whole = write(memory, settings, sent)
                || (block_on(memory.erase()).is_ok() && write(memory, settings, sent));
            if !whole {
                return Err(Refusal::NotStored);
            }
            self.second = second;
        }
        Ok(())
    }

    /// Forgets everything stored.
    ///
    /// # Errors
    /// No memory, or it fails.
    pub fn forget(&mut self) -> Result<(), Refusal> {
        // The one in use last: cut between, it stands.
        for second in [!self.second, self.second] {
            let memory = self.copy(second).ok_or(Refusal::NoMemory)?;
            block_on(memory.erase()).map_err(|_| Refusal::NotStored)?;
        }
        Ok(())
    }
}

/// Writes a copy: the model where it is another than the stored one, then the settings. Whether all of it is there.
#[inline(never)]
fn write<F: NorFlash>(memory: &mut Memory<F>, settings: &Settings, model: Option<&[u8]>) -> bool {
    (has_model(memory, settings.stamp) || model.is_some_and(|bytes| block_on(memory.store_model(bytes)).is_ok()))
        && block_on(memory.store_settings(settings)).is_ok()
        // Making room may have lost it.
        && has_model(memory, settings.stamp)
}

/// Whether the model that the settings belong to is there.
// A function of its own: its room is not on the stack while something is stored.
#[inline(never)]
fn has_model<F: NorFlash>(memory: &mut Memory<F>, stamp: Stamp) -> bool {
    stamp.model == 0 || block_on(memory.model_crc()) == Some(stamp.model)
}
