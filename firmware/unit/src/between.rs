//! What the two priorities hand each other. The control task only ever tries: a full
//! queue costs a counted loss, not time.

use core::cell::{Cell, RefCell};
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use critical_section::Mutex;
use stickslip_shared::predictor::Plan;
use stickslip_shared::wire::{
    Calibration, Grasp, GripLimits, HostClock, Mode, SAMPLE_QUEUE, Sample, Sensors, StartRequest, TareState,
    TelemetryReport,
};

use crate::bus::State;
use crate::counters::Counters;
use crate::queue::Queue;
use crate::slot::Slot;
use crate::source::ft300::BYTE_US;
use crate::source::hub::{Hub, Measured};

/// A checked command, to be applied at the beginning of a tick.
pub enum Command {
    /// Take over the model in the slot, which goes back to [`Between::spare`].
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

/// All that the tick and what is below it share.
pub struct Between {
    /// What was lost, refused or late.
    pub counters: Counters,
    /// Samples from the host.
    pub samples: Queue<Sample, SAMPLE_QUEUE>,
    /// Readings of sensors that are not read by the tick itself, each with its port and finger.
    pub readings: Queue<Measured, 16>,
    /// Commands from the host.
    pub commands: Queue<Command, 4>,
    /// Reports to the host.
    pub reports: Queue<TelemetryReport, 8>,
    /// The unit's state, to be sent on the bus.
    pub states: Queue<State, 2>,
    /// The slot, while no model waits in it.
    pub spare: Queue<&'static mut Slot, 1>,
    /// What became of tares: set by the control task.
    tared: Mutex<Cell<TareState>>,
    mode: AtomicU8,
    /// CRC-32 of the model in use; meaningful where the mode is not `Safe`.
    model_crc: AtomicU32,
}

impl Default for Between {
    fn default() -> Self {
        Self::new()
    }
}

impl Between {
    /// Nothing waits, nothing is counted, no model.
    pub const fn new() -> Self {
        Self {
            counters: Counters::new(),
            samples: Queue::new(),
            readings: Queue::new(),
            commands: Queue::new(),
            reports: Queue::new(),
            states: Queue::new(),
            spare: Queue::new(),
            tared: Mutex::new(Cell::new(TareState { ended: 0, waits: [false; 2], offsets: [[0.0; 6]; 2] })),
            mode: AtomicU8::new(0),
            model_crc: AtomicU32::new(0),
        }
    }

    /// What became of tares.
    pub fn tared(&self) -> TareState {
        critical_section::with(|cs| self.tared.borrow(cs).get())
    }

    /// Set by the control task.
    pub fn set_tared(&self, state: TareState) {
        critical_section::with(|cs| self.tared.borrow(cs).set(state));
    }

    /// What the board is doing.
    pub fn mode(&self) -> Mode {
        match self.mode.load(Ordering::Relaxed) {
            0 => Mode::Safe,
            1 => Mode::Ready,
            _ => Mode::Running,
        }
    }

    /// Set by the control task.
    pub fn set_mode(&self, mode: Mode) {
        self.mode.store(mode as u8, Ordering::Relaxed);
    }

    /// CRC-32 of the model in use.
    pub fn model_crc(&self) -> Option<u32> {
        (self.mode() != Mode::Safe).then(|| self.model_crc.load(Ordering::Relaxed))
    }

    /// Set by the control task.
    pub fn set_model_crc(&self, crc: u32) {
        self.model_crc.store(crc, Ordering::Relaxed);
    }

    /// Hands the unit's state to the bus. One that finds no room is counted: those that wait are sent first.
    pub fn tell(&self, state: State) {
        if self.states.try_send(state).is_err() {
            self.counters.frames_unsent.add(1);
        }
    }
}

/// The sensors on the unit's lines, for the tasks at them and for the link.
// Not a part of `Between`: that begins as zeros, which take no flash.
pub struct SensorLines(Mutex<RefCell<Hub>>);

impl Default for SensorLines {
    fn default() -> Self {
        Self::new()
    }
}

impl SensorLines {
    /// Nothing connected.
    pub const fn new() -> Self {
        Self(Mutex::new(RefCell::new(Hub::new())))
    }

    /// The decoders, where nobody else is at them.
    pub fn with<T>(&self, what: impl FnOnce(&mut Hub) -> T) -> Option<T> {
        critical_section::with(|cs| self.0.borrow(cs).try_borrow_mut().ok().map(|mut hub| what(&mut hub)))
    }

    /// Bytes of the serial line, the last of which came at `at_us`.
    pub fn bytes(&self, between: &Between, bytes: &[u8], at_us: u32) {
        let last = bytes.len().saturating_sub(1) as u32;
        let mut byte_us = at_us.wrapping_sub(BYTE_US * last);
        for byte in bytes {
            self.take(between, |hub| hub.byte(*byte, byte_us));
            byte_us = byte_us.wrapping_add(BYTE_US);
        }
    }

    /// Something for the decoders to take; what was damaged by it is counted, what it measured handed on.
    pub fn take(&self, between: &Between, what: impl FnOnce(&mut Hub) -> Option<Measured>) {
        let counters = &between.counters;
        let measured = self.with(|hub| {
            let before = hub.losses();
            let measured = what(hub);
            let after = hub.losses();
            counters.readings_damaged.add(after.damaged.saturating_sub(before.damaged));
            counters.readings_dropped.add(after.faulty.saturating_sub(before.faulty));
            counters.readings_lost.add(after.lost.saturating_sub(before.lost));
            measured
        });
        if let Some(measured) = measured.flatten()
            && between.readings.try_send(measured).is_err()
        {
            counters.readings_dropped.add(1);
        }
    }
}
