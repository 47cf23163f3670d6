//! What the tick and what is below it hand each other on this board.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use stickslip_unit::between::{Between, SensorLines};
use stickslip_unit::link::Line;

/// Queues, counts, mode.
pub static BETWEEN: Between = Between::new();
/// Sensors on serial line and bus.
pub static SENSORS: SensorLines = SensorLines::new();
/// Encoded answers to the host.
pub static ANSWERS: Channel<CriticalSectionRawMutex, Line, 4> = Channel::new();
