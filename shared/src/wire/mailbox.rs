//! The line to the emulated board: two rings of bytes in memory that QEMU shares with the
//! host. Its UART takes a byte at a time, each for several switches between QEMU's threads;
//! a push in real time is a hundred thousand of them a second.
//!
//! Words are little-endian. Counts of bytes written and read wrap; each has one writer, who
//! moves it on after the bytes are there, or have been taken.

/// Where the board sees it: `mps2-an386`'s second memory.
pub const ADDRESS: u32 = 0x2100_0000;
/// Size of that memory, all of which QEMU shares.
pub const MEMORY_BYTES: u32 = 16 << 20;
/// Marks a line that the host offers ([`OFFERED`]) and the board has taken ([`TAKEN`]).
pub const MARK: u32 = 0x5353_4c4b;

/// The host's mark.
pub const OFFERED: u32 = 0;
/// The board's mark.
pub const TAKEN: u32 = 4;
/// From host to board.
pub const TO_BOARD: Ring = Ring { written: 8, read: 12, bytes: 0x1_0000, length: 0x1_0000 };
/// From board to host.
pub const TO_HOST: Ring = Ring { written: 16, read: 20, bytes: 0x2_0000, length: 0x1_0000 };

/// Offsets of a ring's parts from the beginning of the memory.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// Count of bytes written, the sender's.
    pub written: u32,
    /// Count of bytes read, the receiver's.
    pub read: u32,
    /// The bytes.
    pub bytes: u32,
    /// Their number: a power of two.
    pub length: u32,
}

/// A count of the other side, which may be written just now: `word` is read until it stands still.
///
/// # Errors
/// That of `word`.
pub fn steady<E>(mut word: impl FnMut() -> Result<u32, E>) -> Result<u32, E> {
    let mut last = word()?;
    loop {
        let now = word()?;
        if now == last {
            return Ok(now);
        }
        last = now;
    }
}

impl Ring {
    /// Offset and length of the longest piece that can be read at once.
    #[must_use]
    pub fn readable(&self, written: u32, read: u32) -> (u32, u32) {
        self.piece(read, written.wrapping_sub(read))
    }

    /// Offset and length of the longest piece that can be written at once.
    #[must_use]
    pub fn writable(&self, written: u32, read: u32) -> (u32, u32) {
        self.piece(written, self.length.saturating_sub(written.wrapping_sub(read)))
    }

    /// Counts that no sound pair of sides writes give an empty piece.
    fn piece(&self, from: u32, available: u32) -> (u32, u32) {
        let at = from & self.length.wrapping_sub(1);
        let available = if available > self.length { 0 } else { available };
        (self.bytes.wrapping_add(at), available.min(self.length.wrapping_sub(at)))
    }
}
