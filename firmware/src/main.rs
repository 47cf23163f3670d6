//! Starts the application on the board that the build chose.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use stickslip_firmware::board::current as board;
use stickslip_firmware::control::Control;
use stickslip_firmware::link::{self, Link};
use stickslip_firmware::state;

#[embassy_executor::task]
async fn control(control: &'static mut Control<board::Channels>, watchdog: board::Watchdog) -> ! {
    control.run(watchdog).await
}

#[embassy_executor::task]
async fn receive(link: &'static mut Link, rx: board::Rx) -> ! {
    link.run(rx).await
}

#[embassy_executor::task]
async fn transmit(tx: board::Tx) -> ! {
    link::transmit(tx).await
}

/// Brings everything up; its stack is free again before anything runs.
#[inline(never)]
fn start() {
    let board = board::init();
    defmt::info!("stickslip on {=str}, start {=u32}", board::NAME, board.boots);
    let (app, link) = state::init(board.gauges, board.reset_cause, board.boots);
    let upper = board::control_executor();
    let lower = board::communication_executor();
    // Each task is spawned once, so its one place is free.
    if let Ok(token) = receive(link, board.rx) {
        lower.spawn(token);
    }
    if let Ok(token) = transmit(board.tx) {
        lower.spawn(token);
    }
    if let Ok(token) = control(app, board::Watchdog::start()) {
        upper.spawn(token);
    }
}

#[entry]
fn main() -> ! {
    start();
    loop {
        board::idle();
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    // Where, without its words: formatting them would take 4 KB of flash.
    if let Some(place) = info.location() {
        defmt::error!("panic at {=str}:{=u32}", place.file(), place.line());
    }
    board::halt()
}
