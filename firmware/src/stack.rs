//! What memory is taken, and how deep the stack has been: it is painted at the start, what is still painted was never
//! used. Both priorities and all interrupts share the one stack.

/// Most that the stack may take: with the static memory that `make size` allows (48 KiB), 96 KiB.
/// `make soak` fails beyond it where painted, `make size` where the frames in the machine code add up to more.
pub const BUDGET_BYTES: u32 = 49_152;

/// What cortex-m-rt paints the stack with (feature `paint-stack`).
const PAINT: u32 = 0xcccc_cccc;
/// Looked at from the top: more than any board's firmware uses.
const MOST_WORDS: usize = 32 << 10;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
    static _ram_start: u32;
}

/// Bytes above the static memory that the stack may not touch: what a handler that meets it puts on the stack lies in them
/// and spares the variables below.
const GUARD: usize = 256;

/// Where the guard begins: a region of the memory protection unit is aligned to its size.
fn guard_start() -> usize {
    ((&raw const _stack_end) as usize).next_multiple_of(GUARD)
}

/// From now on a stack that grows into the guard is a fault, not silent damage.
pub fn guard() {
    // SAFETY: called once, before anything runs; the region holds nothing.
    unsafe {
        let mpu = &*cortex_m::peripheral::MPU::PTR;
        mpu.rnr.write(0);
        mpu.rbar.write(guard_start() as u32);
        // No access, no execution; the size is two to the power of seven and one.
        mpu.rasr.write(1 << 28 | 7 << 1 | 1);
        // Elsewhere the map is as without the unit; not while a hard fault is handled.
        mpu.ctrl.write(0b101);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Whether the fault that is handled came of the guard.
pub fn met_guard() -> bool {
    // SAFETY: reading a status has no effect.
    let scb = unsafe { &*cortex_m::peripheral::SCB::PTR };
    let (status, address) = (scb.cfsr.read(), scb.mmfar.read() as usize);
    // Bit 4: while a frame was put on the stack; bit 7: the address is known.
    status & 1 << 4 != 0
        || (status & 1 << 7 != 0 && (guard_start()..guard_start() + GUARD).contains(&address))
}

/// Whether so many words from an address on lie on the stack.
pub fn holds(address: usize, words: usize) -> bool {
    let (top, bottom) = ((&raw const _stack_start) as usize, (&raw const _stack_end) as usize);
    address.is_multiple_of(4) && address >= bottom && address.saturating_add(4 * words) <= top
}

/// Where a function stores its caller's frame and, after it, where it returns to: this target's functions have the address in
/// a register of its own (r7) and save the return address even where they never return, so that ends can be told.
#[derive(Clone, Copy)]
pub struct Frame(usize);

impl Frame {
    /// Of the function in which this is called.
    #[inline(always)]
    pub fn here() -> Self {
        let frame: usize;
        // SAFETY: reads a register.
        unsafe { core::arch::asm!("mov {}, r7", out(reg) frame, options(nomem, nostack, preserves_flags)) };
        Self(frame)
    }

    fn word(self, k: usize) -> usize {
        // SAFETY: two words on the stack, whatever they say.
        if holds(self.0, 2) { unsafe { (self.0 as *const usize).add(k).read_volatile() } } else { 0 }
    }

    /// Of the function that called this one; `None` where the words are none: frames lie one above the other.
    pub fn caller(self) -> Option<Self> {
        let caller = Self(self.word(0));
        (caller.0 > self.0 && holds(caller.0, 2)).then_some(caller)
    }

    /// Address within the call of this function.
    pub fn called_at(self) -> u32 {
        call_before(self.word(1) as u32)
    }
}

/// Address within the call that returns to `address`, where another function may begin: a call that never returns is the last
/// of its own.
pub fn call_before(address: u32) -> u32 {
    (address & !1).saturating_sub(2)
}

/// Bytes below the stack's end: variables, buffers, tasks.
pub fn static_bytes() -> u32 {
    let (bottom, end) = (&raw const _ram_start, &raw const _stack_end);
    u32::try_from((end as usize).saturating_sub(bottom as usize)).unwrap_or(u32::MAX)
}

/// Bytes used at the deepest since reset.
pub fn depth_bytes() -> u32 {
    let (top, bottom) = (&raw const _stack_start, guard_start() + GUARD);
    let words = ((top as usize).saturating_sub(bottom) / 4).min(MOST_WORDS);
    // SAFETY: memory between the ends of the stack that the linker script gives; words below
    // the present one do not change, those above are only compared.
    let painted = (0..words).take_while(|k| unsafe { top.sub(words - k).read_volatile() } == PAINT).count();
    u32::try_from(4 * (words - painted)).unwrap_or(u32::MAX)
}
