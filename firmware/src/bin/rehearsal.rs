//! The product's application with what a test must provoke: sensors at the converters, and ends of every kind. `make hil`
//! runs it in QEMU; no product links it.
//!
//! The first message of an unknown kind ends the run: the first start by an index out of range, the second by a panic with a
//! text, the third by an instruction that there is not, the fourth by a tick that never ends. Then nothing is provoked any
//! more.
#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use embassy_time::{Duration, Ticker};
use stickslip_firmware::board::current as board;
use stickslip_firmware::post_mortem;
use stickslip_firmware::queues::BETWEEN;
use stickslip_firmware::stack::Frame;
use stickslip_firmware::start::{self, Ends};

/// Amplifiers without load: each channel alternates about 2000 counts and ten times its number.
#[embassy_executor::task]
async fn sensors() -> ! {
    let mut ticker = Ticker::every(Duration::from_millis(1));
    let mut counts = core::array::from_fn(|k| 2001 + 10 * k as u16);
    loop {
        critical_section::with(|cs| board::COUNTS.borrow(cs).set(Some(counts)));
        counts = counts.map(|count| if count.is_multiple_of(2) { count + 1 } else { count - 1 });
        // Each reading of a tick is the other one of the two.
        for _ in 0..4 {
            ticker.next().await;
        }
    }
}

#[inline(never)]
fn ends_by_index(numbers: &[u32], k: usize) -> u32 {
    numbers[k] + black_box(1)
}

#[inline(never)]
fn ends_by_panic(number: u32) {
    assert!(black_box(number) > 4, "{number} was provoked");
}

#[inline(never)]
fn ends_by_fault() {
    black_box(0);
    cortex_m::asm::udf();
}

/// As a tick that never ends: what is below it and it itself get no turn any more.
#[inline(never)]
fn ends_by_hanging() {
    // SAFETY: nothing is meant to run after this.
    unsafe { cortex_m::register::basepri::write(0x40) };
    while black_box(true) {}
}

#[embassy_executor::task]
async fn provoke() -> ! {
    let mut ticker = Ticker::every(Duration::from_millis(1));
    loop {
        ticker.next().await;
        if BETWEEN.counters.keys_unknown.get() == 0 {
            continue;
        }
        // Lets the answer out first.
        embassy_time::Timer::after_millis(50).await;
        match post_mortem::starts() {
            1 => drop(black_box(ends_by_index(&[1, 2], black_box(7)))),
            2 => ends_by_panic(3),
            3 => ends_by_fault(),
            4 => ends_by_hanging(),
            _ => {}
        }
    }
}

fn spawn(ends: Ends, lower: embassy_executor::SendSpawner) {
    start::host_line(ends.link, ends.rx, ends.tx, lower);
    // Each task is spawned once, so its one place is free.
    if let (Ok(sensors), Ok(provoke)) = (sensors(), provoke()) {
        lower.spawn(sensors);
        lower.spawn(provoke);
    }
}

#[entry]
fn main() -> ! {
    start::run(spawn)
}

// A function of its own: its frame is the first of those that tell where.
#[panic_handler]
#[inline(never)]
fn panic(info: &core::panic::PanicInfo) -> ! {
    post_mortem::panicked(info, Frame::here());
    board::halt()
}
