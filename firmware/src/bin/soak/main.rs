//! Hours of virtual time with everything going wrong at once: the application of the
//! emulated board with a line that loses, doubles, swaps and damages samples, sends garbage,
//! bursts and bad commands, swaps models while running, stores settings between runs, and a host that stops reading for
//! seconds; sensors that stick, saturate, fall out and give NaN; a host's clock that makes steps. Three runs of four are
//! on the unit's own sensors ([`sensors`]), with all that goes wrong there, a host that falls silent and flash that
//! wears. The low 32 bits of the unit's clock wrap around after 20 s.
//!
//! What is done to the board is counted here, independently of the board's own counts, and
//! both are held against each other at the end. Run by `make soak` under QEMU's `-icount`,
//! where time is instructions: no tick may begin late, no loss may go uncounted. The number
//! of ticks is the program's argument; a second one is the seed, so that the beginning of a longer soak can be run alone.
#![no_std]
#![no_main]

mod done;
mod host;
mod judge;
mod sensors;

use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use done::Draw;
use host::{Bytes, Ear, Host, models};
use judge::{judge, watch};
use stickslip_firmware::board::current as board;
use stickslip_firmware::link::{self, Link};
use stickslip_firmware::queues::{BETWEEN, SENSORS};
use stickslip_firmware::start::{self, Ends};
use stickslip_unit::lines;

/// Ticks if the argument names none: a minute.
const TICKS: u32 = 15_000;

#[embassy_executor::task]
async fn receive(link: &'static mut Link, seed: u32, models: &'static [Bytes; 2]) -> ! {
    link::receive(link, Host::new(seed, models)).await
}

#[embassy_executor::task]
async fn transmit(seed: u32) -> ! {
    link::transmit(Ear::new(Draw(seed))).await
}

#[embassy_executor::task]
async fn gauges(seed: u32) -> ! {
    sensors::gauges(Draw(seed)).await
}

#[embassy_executor::task]
async fn serial(seed: u32) -> ! {
    lines::serial(&BETWEEN, &SENSORS, sensors::SerialOut::new(Draw(seed)), sensors::SerialIn).await
}

#[embassy_executor::task]
async fn bus(seed: u32) -> ! {
    lines::bus(&BETWEEN, &SENSORS, sensors::SimulatedBus::new(Draw(seed))).await
}

/// The numbers in the program's arguments: ticks, and the seed of what goes wrong (as many as ticks, if it is not named).
fn arguments() -> (u32, u32) {
    let mut text = [0_u8; 64];
    let mut words = command_line(&mut text).split_whitespace().filter_map(|word| word.parse().ok());
    let ticks = words.next().unwrap_or(TICKS);
    (ticks, words.next().unwrap_or(ticks))
}

/// The program's arguments, written to `text`; empty where they cannot be read.
fn command_line(text: &mut [u8; 64]) -> &str {
    let mut block = [text.as_mut_ptr() as usize, text.len()];
    // SAFETY: SYS_GET_CMDLINE (0x15) writes at most `block[1]` bytes to `block[0]`, and
    // their number to `block[1]`.
    let failed = unsafe { cortex_m_semihosting::syscall1(0x15, block.as_mut_ptr() as usize) };
    let length = if failed == 0 { block[1].min(text.len()) } else { 0 };
    text.get(..length).and_then(|text| core::str::from_utf8(text).ok()).unwrap_or_default()
}

fn spawn(ends: Ends, lower: embassy_executor::SendSpawner) {
    let (ticks, seed) = arguments();
    // Each task is spawned once, so its one place is free.
    if let Ok(token) = receive(ends.link, 0x9e37_79b9 ^ seed, models()) {
        lower.spawn(token);
    }
    if let Ok(token) = transmit(0x85eb_ca6b ^ seed) {
        lower.spawn(token);
    }
    if let Ok(token) = gauges(0xc2b2_ae35 ^ seed) {
        lower.spawn(token);
    }
    if let Ok(token) = serial(0x27d4_eb2f ^ seed) {
        lower.spawn(token);
    }
    if let Ok(token) = bus(0x1656_67b1 ^ seed) {
        lower.spawn(token);
    }
    if let Ok(token) = watch() {
        lower.spawn(token);
    }
    if let Ok(token) = judge(ticks) {
        lower.spawn(token);
    }
}

#[entry]
fn main() -> ! {
    start::run(spawn)
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    hprintln!("{}", info);
    board::halt()
}
