//! Overflows its stack. The guard must stop it before it reaches the variables below, and the next start must say so:
//! `make hil` runs it in QEMU.
#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hprintln;
use stickslip_firmware::board::current as board;
use stickslip_firmware::{post_mortem, stack};
use stickslip_shared::wire::Ending;

/// The first variable above which the guard lies is as good as any: it is looked at after the reset.
const CANARY: u32 = 0x5afe_5afe;
#[unsafe(link_section = ".uninit.CANARY")]
static mut VARIABLES: core::mem::MaybeUninit<[u32; 64]> = core::mem::MaybeUninit::uninit();

fn variables() -> &'static mut [u32; 64] {
    // SAFETY: called once a start; every bit pattern is a `u32`.
    unsafe { &mut *(&raw mut VARIABLES).cast::<[u32; 64]>() }
}

#[inline(never)]
fn deeper(depth: u32) -> u32 {
    if depth == u32::MAX {
        return 0;
    }
    let room = black_box([depth; 24]);
    deeper(black_box(depth + 1)).wrapping_add(black_box(room).iter().sum())
}

#[entry]
fn main() -> ! {
    let (_recorder, before, _) = post_mortem::begin();
    let variables = variables();
    if let Some(before) = before {
        let whole = variables.iter().all(|word| *word == CANARY);
        let stopped = before.ending == Ending::StackOverflow;
        hprintln!("stopped by the guard: {}; variables whole: {}", stopped, whole);
        debug::exit(if stopped && whole { EXIT_SUCCESS } else { EXIT_FAILURE });
    }
    variables.fill(CANARY);
    stack::guard();
    hprintln!("never said: {}", deeper(0));
    board::halt()
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    board::halt()
}
