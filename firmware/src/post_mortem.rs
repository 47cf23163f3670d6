//! The words that a reset leaves alone, and who writes them: the control task each tick, a handler at the end.

use core::panic::PanicInfo;
use core::sync::atomic::{Ordering, compiler_fence};

use stickslip_shared::wire::{Ending, PostMortem};
use stickslip_unit::post_mortem::{Recorder, STARTS, WORDS, note_end};

use crate::stack::{Frame, call_before, holds};

#[unsafe(link_section = ".uninit.POST_MORTEM")]
static mut KEPT: core::mem::MaybeUninit<[u32; WORDS]> = core::mem::MaybeUninit::uninit();

/// What was kept, and the starts since power-on. To be called once, before anything runs.
pub fn begin() -> (Recorder<'static>, Option<PostMortem>, u32) {
    // SAFETY: called once; every bit pattern is a `u32`. Later only a handler that does not return writes there.
    let words = unsafe { &mut *(&raw mut KEPT).cast::<[u32; WORDS]>() };
    Recorder::begin(words)
}

/// Starts since power-on.
pub fn starts() -> u32 {
    // SAFETY: a word that [`begin`] wrote and nobody changes until the next start.
    unsafe { (&raw const KEPT).cast::<u32>().add(STARTS).read_volatile() }
}

/// Notes the end, from a handler that ends in a reset.
pub fn end(how: Ending, pc: u32, lr: u32, line: u32) {
    // SAFETY: whoever else writes there is never run again.
    note_end(unsafe { &mut *(&raw mut KEPT).cast::<[u32; WORDS]>() }, how, pc, lr, line);
    compiler_fence(Ordering::SeqCst);
}

/// Notes a panic, from its handler, whose own frame is `handler`: who called the core library's panic, and who that function.
/// Without the panic's words: formatting them would take 4 KB of flash.
pub fn panicked(info: &PanicInfo, handler: Frame) {
    let panic = handler.caller();
    let failing = panic.and_then(Frame::caller);
    let [pc, lr] = [panic, failing].map(|frame| frame.map_or(0, Frame::called_at));
    let line = info.location().map_or(0, |place| {
        defmt::error!("panic at {=str}:{=u32}", place.file(), place.line());
        place.line()
    });
    end(Ending::Panic, pc, lr, line);
}

/// Notes an end from the handler of an interrupt that does not return: where the processor was.
///
/// # Safety
/// `stacked` is where the processor put what it interrupted: eight words, the sixth `lr`, the seventh `pc` (Armv7-M manual,
/// B1.5.6).
pub unsafe fn interrupted(how: Ending, stacked: *const u32) {
    // SAFETY: the caller's, and it lies on the stack.
    let [.., lr, pc, _] =
        if holds(stacked as usize, 8) { unsafe { *stacked.cast::<[u32; 8]>() } } else { [0; 8] };
    end(how, pc, call_before(lr), 0);
}
