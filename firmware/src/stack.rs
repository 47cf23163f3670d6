//! What memory is taken, and how deep the stack has been: it is painted at the start, what is still painted was never
//! used. Both priorities and all interrupts share the one stack.

/// Most that the stack may take: with the static memory that `make size` allows (32 KiB), 96 KiB.
/// `make soak` fails beyond it.
pub const BUDGET_BYTES: u32 = 65_536;

/// What cortex-m-rt paints the stack with (feature `paint-stack`).
const PAINT: u32 = 0xcccc_cccc;
/// Looked at from the top: more than any board's firmware uses.
const MOST_WORDS: usize = 32 << 10;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
    static _ram_start: u32;
}

/// Bytes below the stack's end: variables, buffers, tasks.
pub fn static_bytes() -> u32 {
    let (bottom, end) = (&raw const _ram_start, &raw const _stack_end);
    u32::try_from((end as usize).saturating_sub(bottom as usize)).unwrap_or(u32::MAX)
}

/// Bytes used at the deepest since reset.
pub fn depth_bytes() -> u32 {
    let (top, bottom) = (&raw const _stack_start, &raw const _stack_end);
    let words = ((top as usize).saturating_sub(bottom as usize) / 4).min(MOST_WORDS);
    // SAFETY: memory between the ends of the stack that the linker script gives; words below
    // the present one do not change, those above are only compared.
    let painted = (0..words).take_while(|k| unsafe { top.sub(words - k).read_volatile() } == PAINT).count();
    u32::try_from(4 * (words - painted)).unwrap_or(u32::MAX)
}
