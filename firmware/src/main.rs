//! Starts the application on the board that the build chose.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use stickslip_firmware::board::current as board;
use stickslip_firmware::post_mortem;
#[cfg(feature = "nucleo-g474re")]
use stickslip_firmware::queues::{BETWEEN, SENSORS};
use stickslip_firmware::stack::Frame;
use stickslip_firmware::start::{self, Ends};
#[cfg(feature = "nucleo-g474re")]
use stickslip_unit::lines;

#[cfg(feature = "nucleo-g474re")]
#[embassy_executor::task]
async fn serial_sensor(rx: board::SensorRx, tx: board::SensorTx) -> ! {
    lines::serial(&BETWEEN, &SENSORS, rx, tx).await
}

#[cfg(feature = "nucleo-g474re")]
#[embassy_executor::task]
async fn can_bus(can: board::CanBus) -> ! {
    lines::bus(&BETWEEN, &SENSORS, can).await
}

fn spawn(ends: Ends, lower: embassy_executor::SendSpawner) {
    start::host_line(ends.link, ends.rx, ends.tx, lower);
    #[cfg(feature = "nucleo-g474re")]
    {
        // Each task is spawned once, so its one place is free.
        let (rx, tx) = ends.sensor;
        if let Ok(token) = serial_sensor(rx, tx) {
            lower.spawn(token);
        }
        if let Ok(token) = can_bus(ends.can) {
            lower.spawn(token);
        }
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
