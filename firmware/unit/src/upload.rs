//! A model that arrives in pieces: collected, checked as a whole, then decoded.

use heapless::Vec;
use stickslip_shared::on_board;
use stickslip_shared::wire::frame::crc32;
use stickslip_shared::wire::package::decode_into;
use stickslip_shared::wire::{MAX_MODEL_BYTES, ModelChunk, ModelCommit, ModelPackage, Refusal};

/// Bytes received so far.
#[derive(Default)]
pub struct Upload {
    bytes: Vec<u8, MAX_MODEL_BYTES>,
}

impl Upload {
    /// Takes the next piece; offset 0 begins anew, and a piece that was already taken is
    /// taken again (its answer may have been lost).
    ///
    /// # Errors
    /// A piece is missing before this one, or the model is too long.
    pub fn take(&mut self, chunk: &ModelChunk) -> Result<(), Refusal> {
        let offset = usize::from(chunk.offset);
        if offset > self.bytes.len() {
            return Err(Refusal::Offset { expected: short(self.bytes.len()) });
        }
        self.bytes.truncate(offset);
        self.bytes
            .extend_from_slice(&chunk.bytes)
            .map_err(|_| Refusal::TooLarge { limit: short(MAX_MODEL_BYTES) })
    }

    /// Decodes what was received into `place`, which is empty where that fails; the checksum of its scene.
    ///
    /// # Errors
    /// Length or checksum differ from the announced, the bytes are not a scene and a
    /// model, or the model cannot be run here.
    pub fn commit(&self, commit: &ModelCommit, place: &mut Option<ModelPackage>) -> Result<u32, Refusal> {
        *place = None;
        if self.bytes.len() != usize::from(commit.length) {
            return Err(Refusal::Length { received: short(self.bytes.len()) });
        }
        let received = crc32(&self.bytes);
        if received != commit.crc {
            return Err(Refusal::Crc { received });
        }
        checked(&self.bytes, place)
    }

    /// A model that was stored, as if it had been sent; the checksum of its scene.
    ///
    /// # Errors
    /// As [`Self::commit`]: its checksum is another than `crc`, too.
    pub fn of_memory(
        &mut self,
        bytes: Vec<u8, MAX_MODEL_BYTES>,
        crc: u32,
        place: &mut Option<ModelPackage>,
    ) -> Result<u32, Refusal> {
        self.bytes = bytes;
        self.commit(&ModelCommit { length: short(self.bytes.len()), crc }, place)
    }

    /// What was received.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Checksum of what was received.
    pub fn crc(&self) -> u32 {
        crc32(&self.bytes)
    }
}

/// Decodes into `place`, where it stays only if it can be run here; the checksum of its scene.
// In place: a tick may begin while this is on the stack.
#[inline(never)]
fn checked(bytes: &[u8], place: &mut Option<ModelPackage>) -> Result<u32, Refusal> {
    let scene = decode_into(bytes, place).ok_or(Refusal::Undecodable)?;
    if let Some(Err(error)) = place.as_ref().map(on_board::check) {
        *place = None;
        return Err(Refusal::Model(error));
    }
    Ok(crc32(bytes.get(..scene).unwrap_or_default()))
}

fn short(length: usize) -> u16 {
    u16::try_from(length).unwrap_or(u16::MAX)
}
