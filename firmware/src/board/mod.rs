//! One module a board; the chosen one is [`current`].
//!
//! A board gives: the two halves of its link (`embedded_io_async`), two interrupt
//! executors with control above communication, a time driver for embassy, a free-running
//! timer, a watchdog, alarm lines, flash for settings, sensors where it has them, and why it started.

#[cfg(feature = "mps2-an386")]
#[path = "mps2_an386.rs"]
pub mod current;
#[cfg(feature = "nucleo-g474re")]
#[path = "nucleo_g474re.rs"]
pub mod current;
#[cfg(feature = "mps2-an386")]
mod mailbox;

#[cfg(all(feature = "mps2-an386", feature = "nucleo-g474re"))]
compile_error!("choose one board: --features mps2-an386 or --features nucleo-g474re");
#[cfg(not(any(feature = "mps2-an386", feature = "nucleo-g474re")))]
compile_error!("choose a board: --features mps2-an386 or --features nucleo-g474re");

pub use stickslip_shared::wire::ResetCause;
use stickslip_unit::board::Board;
use stickslip_unit::counters::MemoryUse;

impl Board for current::This {
    const NAME: &'static str = current::NAME;
    const TIMER_HZ: u32 = current::TIMER_HZ;
    const HAS_GAUGES: bool = current::HAS_GAUGES;
    const HAS_SERIAL_SENSOR: bool = current::HAS_SERIAL_SENSOR;
    const HAS_CAN: bool = current::HAS_CAN;
    const MEMORY: core::ops::Range<u32> = current::MEMORY;
    type Channels = current::Channels;
    type Lines = current::AlarmLines;
    type Flash = current::Flash;

    fn timer() -> u32 {
        current::timer()
    }
    fn now_us() -> u64 {
        embassy_time::Instant::now().as_micros()
    }
    fn memory() -> MemoryUse {
        MemoryUse { stack: crate::stack::depth_bytes(), variables: crate::stack::static_bytes() }
    }
}
