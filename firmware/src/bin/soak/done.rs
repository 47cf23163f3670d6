//! What was done to the board, counted apart from its own counts, and what varies it.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// What was done to the board, and what it answered.
pub struct Done {
    /// Sample frames that went out whole and in order.
    pub sound: AtomicU32,
    pub lost: AtomicU32,
    pub damaged: AtomicU32,
    pub garbage: AtomicU32,
    pub repeated: AtomicU32,
    pub overtaken: AtomicU32,
    pub refused: AtomicU32,
    pub requests: AtomicU32,
    pub models: AtomicU32,
    pub sensor_faults: AtomicU32,
    pub stalls: AtomicU32,
    pub answers: AtomicU32,
    pub reports: AtomicU32,
    pub reports_missing: AtomicU32,
    pub frames_bad: AtomicU32,
    pub gauge_faults: AtomicU32,
    pub scans_failed: AtomicU32,
    pub scans_saturated: AtomicU32,
    pub saturated: AtomicU32,
    pub readings_lost: AtomicU32,
    pub readings_damaged: AtomicU32,
    pub readings_refused: AtomicU32,
    pub unplugged: AtomicU32,
    pub clock_steps: AtomicU32,
    pub bus_off: AtomicU32,
    pub states: AtomicU32,
    pub requests_begun: AtomicU32,
    pub asked: AtomicU32,
    pub silences: AtomicU32,
    pub told: AtomicU32,
    pub unsure_late: AtomicU32,
    pub sure_ticks: AtomicU32,
    pub unit_ticks: AtomicU32,
    pub unit_runs: AtomicU32,
    pub late_by_clock: AtomicU32,
}

const fn none() -> AtomicU32 {
    AtomicU32::new(0)
}

pub static DONE: Done = Done {
    sound: none(),
    lost: none(),
    damaged: none(),
    garbage: none(),
    repeated: none(),
    overtaken: none(),
    refused: none(),
    requests: none(),
    models: none(),
    sensor_faults: none(),
    stalls: none(),
    answers: none(),
    reports: none(),
    reports_missing: none(),
    frames_bad: none(),
    gauge_faults: none(),
    scans_failed: none(),
    scans_saturated: none(),
    saturated: none(),
    readings_lost: none(),
    readings_damaged: none(),
    readings_refused: none(),
    unplugged: none(),
    clock_steps: none(),
    bus_off: none(),
    states: none(),
    requests_begun: none(),
    asked: none(),
    silences: none(),
    told: none(),
    unsure_late: none(),
    sure_ticks: none(),
    unit_ticks: none(),
    unit_runs: none(),
    late_by_clock: none(),
};

/// A run on the unit's sensors goes on.
pub static ON_SENSORS: AtomicBool = AtomicBool::new(false);
/// Sample's time of the host's run; beyond the run's samples: the ticks between two runs.
pub static STEP: AtomicU32 = AtomicU32::new(u32::MAX);
/// When the host last told poses, by the unit's clock.
pub static TOLD_US: AtomicU32 = AtomicU32::new(0);

pub fn count(counter: &AtomicU32) {
    counter.fetch_add(1, Ordering::Relaxed);
}

pub fn value(counter: &AtomicU32) -> u32 {
    counter.load(Ordering::Relaxed)
}

/// Marsaglia's xorshift: enough to vary faults.
pub struct Draw(pub u32);

impl Draw {
    /// The next 32 bits.
    pub fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }
    /// True once in `n` times.
    pub fn once_in(&mut self, n: u32) -> bool {
        self.next().is_multiple_of(n)
    }
    /// Uniform in -1 to 1.
    pub fn noise(&mut self) -> f32 {
        (self.next() >> 8) as f32 / 8_388_608.0 - 1.0
    }
}
