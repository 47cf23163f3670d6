//! What the two priorities hand each other. The control task only ever tries: a full
//! queue costs a counted loss, not time.

use core::sync::atomic::{AtomicU8, Ordering};

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use heapless::Vec;
use stickslip_shared::predictor::Plan;
use stickslip_shared::wire::frame::MAX_LINE;
use stickslip_shared::wire::{Calibration, Mode, SAMPLE_QUEUE, Sample, StartRequest, TelemetryReport};

use crate::queue::Queue;
use crate::slot::Slot;

/// A checked command, to be applied at the beginning of a tick.
pub enum Command {
    /// Take over the model in the slot, which goes back to [`SPARE`].
    Install(&'static mut Slot),
    /// Planned motion.
    Plan(Plan),
    /// Grip set-point, N.
    Grip(f32),
    /// Of one finger's gauges.
    Calibration(Calibration),
    /// Take the gauges' present readings for no load.
    Tare,
    /// Begin a run.
    Start(StartRequest),
    /// End it.
    Stop,
}

/// Samples from the host.
pub static SAMPLES: Queue<Sample, SAMPLE_QUEUE> = Queue::new();
/// Commands from the host.
pub static COMMANDS: Queue<Command, 4> = Queue::new();
/// Reports to the host.
pub static REPORTS: Queue<TelemetryReport, 8> = Queue::new();
/// Encoded answers to the host.
pub static ANSWERS: Channel<CriticalSectionRawMutex, Vec<u8, MAX_LINE>, 4> = Channel::new();
/// The slot, while no model waits in it.
pub static SPARE: Queue<&'static mut Slot, 1> = Queue::new();

static MODE: AtomicU8 = AtomicU8::new(0);
/// CRC-32 of the model in use; meaningful where the mode is not `Safe`.
pub static MODEL_CRC: core::sync::atomic::AtomicU32 = core::sync::atomic::AtomicU32::new(0);

/// What the board is doing.
pub fn mode() -> Mode {
    match MODE.load(Ordering::Relaxed) {
        0 => Mode::Safe,
        1 => Mode::Ready,
        _ => Mode::Running,
    }
}

/// Set by the control task.
pub fn set_mode(mode: Mode) {
    MODE.store(mode as u8, Ordering::Relaxed);
}
