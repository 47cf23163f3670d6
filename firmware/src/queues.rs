//! What the two priorities hand each other. The control task only ever tries: a full
//! queue costs a counted loss, not time.

use core::cell::Cell;
use core::sync::atomic::{AtomicU8, Ordering};

use critical_section::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use heapless::Vec;
use stickslip_shared::predictor::Plan;
use stickslip_shared::wire::frame::MAX_LINE;
use stickslip_shared::wire::{
    Calibration, Grasp, GripLimits, HostClock, Mode, Port, SAMPLE_QUEUE, Sample, Sensors, StartRequest,
    TareState, TelemetryReport,
};
use stickslip_unit::source::Reading;

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
    /// Of one finger's sensor.
    Calibration(Calibration),
    /// Take the sensors' present readings for no load.
    Tare,
    /// Which sensor measures which finger.
    Sensors(Sensors),
    /// Poses without a host.
    Grasp(Option<Grasp>),
    /// Within what the grip is advised.
    GripLimits(GripLimits),
    /// The host's clock, for the run that goes on.
    Clock(HostClock),
    /// Begin a run.
    Start(StartRequest),
    /// End it.
    Stop,
}

/// Samples from the host.
pub static SAMPLES: Queue<Sample, SAMPLE_QUEUE> = Queue::new();
/// Readings of sensors that are not read by the tick itself, each with its port and finger.
pub static READINGS: Queue<(Port, u8, Reading), 16> = Queue::new();
/// Commands from the host.
pub static COMMANDS: Queue<Command, 4> = Queue::new();
/// Reports to the host.
pub static REPORTS: Queue<TelemetryReport, 8> = Queue::new();
/// Encoded answers to the host.
pub static ANSWERS: Channel<CriticalSectionRawMutex, Vec<u8, MAX_LINE>, 4> = Channel::new();
/// The slot, while no model waits in it.
pub static SPARE: Queue<&'static mut Slot, 1> = Queue::new();

/// What became of tares: set by the control task.
pub static TARED: Mutex<Cell<TareState>> =
    Mutex::new(Cell::new(TareState { ended: 0, waits: [false; 2], offsets: [[0.0; 6]; 2] }));

/// The same, as it stands.
pub fn tared() -> TareState {
    critical_section::with(|cs| TARED.borrow(cs).get())
}

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
