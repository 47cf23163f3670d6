//! The words that a reset leaves alone, and who writes them: the control task each tick, a handler at the end.

use core::sync::atomic::{Ordering, compiler_fence};

use stickslip_shared::wire::{Ending, PostMortem};
use stickslip_unit::post_mortem::{Recorder, WORDS, note_end};

#[unsafe(link_section = ".uninit.POST_MORTEM")]
static mut KEPT: core::mem::MaybeUninit<[u32; WORDS]> = core::mem::MaybeUninit::uninit();

/// What was kept, and the starts since power-on. To be called once, before anything runs.
pub fn begin() -> (Recorder<'static>, Option<PostMortem>, u32) {
    // SAFETY: called once; every bit pattern is a `u32`. Later only a handler that does not return writes there.
    let words = unsafe { &mut *(&raw mut KEPT).cast::<[u32; WORDS]>() };
    Recorder::begin(words)
}

/// Notes the end, from a handler that ends in a reset.
pub fn end(how: Ending, pc: u32, lr: u32) {
    // SAFETY: whoever else writes there is never run again.
    note_end(unsafe { &mut *(&raw mut KEPT).cast::<[u32; WORDS]>() }, how, pc, lr);
    compiler_fence(Ordering::SeqCst);
}
