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

use embedded_hal::digital::OutputPin;
pub use stickslip_shared::wire::ResetCause;
use stickslip_unit::alarm::{Alarms, LineFault, Lines};

/// Alarm lines, whatever they are made of.
pub trait SetAlarms {
    /// # Errors
    /// One of them cannot be set.
    fn set_alarms(&mut self, alarms: Alarms) -> Result<(), LineFault>;
}

impl<S: OutputPin, D: OutputPin, U: OutputPin> SetAlarms for Lines<S, D, U> {
    fn set_alarms(&mut self, alarms: Alarms) -> Result<(), LineFault> {
        self.set(alarms)
    }
}

/// Twelve strain-gauge channels, six a finger, as raw converter counts.
pub trait Gauges {
    /// The newest readings; `None` where there are no gauges or the converter failed.
    fn read(&mut self) -> Option<[u16; 12]>;
}
