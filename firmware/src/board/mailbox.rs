//! The emulated board's line through memory (`stickslip_shared::wire::mailbox`), looked at
//! twice a millisecond.

use core::convert::Infallible;
use core::sync::atomic::{Ordering, fence};

use embassy_time::Timer;
use stickslip_shared::wire::mailbox::{
    ADDRESS, MARK, MEMORY_BYTES, OFFERED, Ring, TAKEN, TO_BOARD, TO_HOST, steady,
};

/// How long each side may wait for the other to look.
const LOOK_US: u64 = 500;

fn word(offset: u32) -> u32 {
    debug_assert!(offset < MEMORY_BYTES);
    // SAFETY: within memory that only this line uses.
    unsafe { ((ADDRESS + offset) as *const u32).read_volatile() }
}

fn set_word(offset: u32, value: u32) {
    debug_assert!(offset < MEMORY_BYTES);
    // SAFETY: as above.
    unsafe { ((ADDRESS + offset) as *mut u32).write_volatile(value) }
}

/// Whether the host offers this line.
pub fn offered() -> bool {
    word(OFFERED) == MARK
}

/// Tells the host that the board is there.
pub fn take() {
    set_word(TAKEN, MARK);
}

/// A count of the host's.
fn count(offset: u32) -> u32 {
    let Ok(count) = steady(|| Ok::<_, Infallible>(word(offset)));
    count
}

/// Waits for bytes from the host.
pub async fn read(buffer: &mut [u8]) -> usize {
    const RING: Ring = TO_BOARD;
    loop {
        let read = word(RING.read);
        let (from, length) = RING.readable(count(RING.written), read);
        let length = length.min(u32::try_from(buffer.len()).unwrap_or(0));
        if length > 0 {
            fence(Ordering::Acquire);
            for (k, byte) in (0..length).zip(buffer.iter_mut()) {
                // SAFETY: the piece lies within the ring, and the host does not write there
                // before `read` has moved on.
                *byte = unsafe { ((ADDRESS + from + k) as *const u8).read_volatile() };
            }
            set_word(RING.read, read.wrapping_add(length));
            return length as usize;
        }
        Timer::after_micros(LOOK_US).await;
    }
}

/// Waits for room, then writes what fits.
pub async fn write(bytes: &[u8]) -> usize {
    const RING: Ring = TO_HOST;
    loop {
        let written = word(RING.written);
        let (to, room) = RING.writable(written, count(RING.read));
        let length = room.min(u32::try_from(bytes.len()).unwrap_or(0));
        if length > 0 || bytes.is_empty() {
            for (k, byte) in (0..length).zip(bytes) {
                // SAFETY: the piece lies within the ring, and the host does not read there
                // before `written` has moved on.
                unsafe { ((ADDRESS + to + k) as *mut u8).write_volatile(*byte) };
            }
            fence(Ordering::Release);
            set_word(RING.written, written.wrapping_add(length));
            return length as usize;
        }
        Timer::after_micros(LOOK_US).await;
    }
}
