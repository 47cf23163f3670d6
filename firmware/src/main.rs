//! Starts the application on the board that the build chose.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use stickslip_firmware::board::current as board;
use stickslip_firmware::control::Control;
use stickslip_firmware::link::{self, Link};
use stickslip_firmware::state::{self, Started};
use stickslip_firmware::{post_mortem, stack};

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

#[cfg(feature = "nucleo-g474re")]
#[embassy_executor::task]
async fn serial_sensor(rx: board::SensorRx, tx: board::SensorTx) -> ! {
    stickslip_firmware::sensors::serial(rx, tx).await
}

#[cfg(feature = "nucleo-g474re")]
#[embassy_executor::task]
async fn can_bus(can: board::CanBus) -> ! {
    stickslip_firmware::sensors::bus(can).await
}

/// Brings everything up; its stack is free again before anything runs.
#[inline(never)]
fn start() {
    stack::guard();
    let (recorder, post_mortem, boots) = post_mortem::begin();
    let board = board::init(post_mortem.is_some());
    defmt::info!("stickslip on {=str}, start {=u32}", board::NAME, boots);
    let started = Started { cause: board.reset_cause, boots, post_mortem, recorder };
    let (app, link) = state::init(board.gauges, board.alarms, board.flash, started);
    let upper = board::control_executor();
    let lower = board::communication_executor();
    // Each task is spawned once, so its one place is free.
    if let Ok(token) = receive(link, board.rx) {
        lower.spawn(token);
    }
    if let Ok(token) = transmit(board.tx) {
        lower.spawn(token);
    }
    #[cfg(feature = "nucleo-g474re")]
    {
        let (rx, tx) = board.sensor;
        if let Ok(token) = serial_sensor(rx, tx) {
            lower.spawn(token);
        }
        if let Ok(token) = can_bus(board.can) {
            lower.spawn(token);
        }
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
        post_mortem::end(stickslip_shared::wire::Ending::Panic, place.line(), 0);
    }
    board::halt()
}
