//! Square root of an `f32`, correctly rounded (IEEE 754), and so the same bits everywhere:
//! `vsqrt.f32` on a Cortex-M4F, for which `core` has no stable name, `libm` elsewhere.
//!
//! A crate of its own because of the one `unsafe` line, which `stickslip-shared` forbids.
#![no_std]

/// Square root of `x`; NaN below zero.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[inline(always)]
pub fn sqrtf(x: f32) -> f32 {
    let mut bits = x.to_bits();
    // SAFETY: only registers; what a register of that class holds before and after cannot be said on stable, but that it is lost.
    unsafe {
        core::arch::asm!(
            "vmov s15, {bits}",
            "vsqrt.f32 s15, s15",
            "vmov {bits}, s15",
            bits = inout(reg) bits,
            out("s15") _,
            options(pure, nomem, nostack),
        );
    }
    f32::from_bits(bits)
}

/// Square root of `x`; NaN below zero.
#[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
#[inline]
pub fn sqrtf(x: f32) -> f32 {
    libm::sqrtf(x)
}
