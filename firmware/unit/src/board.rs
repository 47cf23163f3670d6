//! What the tick and the link need of the board that they run on.

use core::ops::Range;

use embedded_hal::digital::OutputPin;
use embedded_storage_async::nor_flash::NorFlash;

use crate::alarm::{Alarms, LineFault, Lines};
use crate::counters::MemoryUse;
use crate::source::gauges::CHANNELS;

/// A board, above its registers.
pub trait Board {
    /// Name that it reports.
    const NAME: &'static str;
    /// Counts a second of [`Board::timer`].
    const TIMER_HZ: u32;
    /// Whether strain gauges may be wired to it.
    const HAS_GAUGES: bool;
    /// Whether a sensor with a serial line may be wired to it.
    const HAS_SERIAL_SENSOR: bool;
    /// Whether it has CAN-FD.
    const HAS_CAN: bool;
    /// Where in its flash settings are stored.
    const MEMORY: Range<u32>;
    /// Strain gauges.
    type Channels: Channels;
    /// Alarm lines.
    type Lines: SetAlarms;
    /// For settings.
    type Flash: NorFlash;

    /// A count that runs freely, for the cost of a tick.
    fn timer() -> u32;
    /// Time since the start, us.
    fn now_us() -> u64;
    /// What memory is taken.
    fn memory() -> MemoryUse;
}

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
pub trait Channels {
    /// The newest readings; `None` where there are no gauges or the converter failed.
    fn read(&mut self) -> Option<[u16; CHANNELS]>;
}
