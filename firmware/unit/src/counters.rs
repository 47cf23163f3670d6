//! Counts of everything that was lost, refused or late, readable at any time.

use core::cell::Cell;
use core::sync::atomic::{AtomicU32, Ordering};

use critical_section::Mutex;
use stickslip_shared::wire::Statistics;

/// A count that stays at its largest value instead of wrapping.
pub struct Counter(AtomicU32);

impl Counter {
    const fn new() -> Self {
        Self(AtomicU32::new(0))
    }
    /// Counts `more`.
    // A function of its own: its loop at some sixty places would take 2 KB of flash.
    #[inline(never)]
    pub fn add(&self, more: u32) {
        let next = |now: u32| Some(now.saturating_add(more));
        let _ = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, next);
    }
    /// What another counter says.
    pub fn set(&self, count: u32) {
        self.0.store(count, Ordering::Relaxed);
    }
    /// The count.
    pub fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Counts of both priorities. Fields as in [`Statistics`].
#[allow(missing_docs)]
pub struct Counters {
    pub ticks: Counter,
    pub ticks_missed: Counter,
    pub samples: Counter,
    pub starved: Counter,
    pub samples_lost: Counter,
    pub samples_repeated: Counter,
    pub samples_reordered: Counter,
    pub samples_dropped: Counter,
    pub samples_unasked: Counter,
    pub reports_dropped: Counter,
    pub bytes_lost: Counter,
    pub frames_damaged: Counter,
    pub frames_too_long: Counter,
    pub keys_unknown: Counter,
    pub bodies_undecodable: Counter,
    pub commands_refused: Counter,
    pub model_swaps: Counter,
    pub solver_marks: Counter,
    pub sensor_marks: Counter,
    pub witnessed: Counter,
    pub witness_apart: Counter,
    pub readings_damaged: Counter,
    pub readings_lost: Counter,
    pub readings_dropped: Counter,
    pub frames_unsent: Counter,
    /// Ticks of runs, sum and largest of their costs.
    cost: Mutex<Cell<(u32, u64, u32)>>,
}

/// Memory that is taken, bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct MemoryUse {
    /// The deepest that the stack was.
    pub stack: u32,
    /// What variables take.
    pub variables: u32,
}

impl Default for Counters {
    fn default() -> Self {
        Self::new()
    }
}

impl Counters {
    /// Nothing counted.
    pub const fn new() -> Self {
        Self {
            ticks: Counter::new(),
            ticks_missed: Counter::new(),
            samples: Counter::new(),
            starved: Counter::new(),
            samples_lost: Counter::new(),
            samples_repeated: Counter::new(),
            samples_reordered: Counter::new(),
            samples_dropped: Counter::new(),
            samples_unasked: Counter::new(),
            reports_dropped: Counter::new(),
            bytes_lost: Counter::new(),
            frames_damaged: Counter::new(),
            frames_too_long: Counter::new(),
            keys_unknown: Counter::new(),
            bodies_undecodable: Counter::new(),
            commands_refused: Counter::new(),
            model_swaps: Counter::new(),
            solver_marks: Counter::new(),
            sensor_marks: Counter::new(),
            witnessed: Counter::new(),
            witness_apart: Counter::new(),
            readings_damaged: Counter::new(),
            readings_lost: Counter::new(),
            readings_dropped: Counter::new(),
            frames_unsent: Counter::new(),
            cost: Mutex::new(Cell::new((0, 0, 0))),
        }
    }

    /// Books the cost of one tick of a run.
    pub fn book(&self, cost: u32) {
        critical_section::with(|cs| {
            let cell = self.cost.borrow(cs);
            let (ticks, sum, worst) = cell.get();
            cell.set((ticks.saturating_add(1), sum.saturating_add(u64::from(cost)), worst.max(cost)));
        });
    }

    /// All counts, with what memory is taken.
    pub fn read(&self, memory: &MemoryUse) -> Statistics {
        let (ticks, sum, worst_cost) = critical_section::with(|cs| self.cost.borrow(cs).get());
        // Seven digits are enough: a division of 64 bits would bring 0.9 KB.
        let mean_cost = (sum as f32 / ticks.max(1) as f32) as u32;
        Statistics {
            ticks: self.ticks.get(),
            ticks_missed: self.ticks_missed.get(),
            worst_cost,
            mean_cost,
            samples: self.samples.get(),
            starved: self.starved.get(),
            samples_lost: self.samples_lost.get(),
            samples_repeated: self.samples_repeated.get(),
            samples_reordered: self.samples_reordered.get(),
            samples_dropped: self.samples_dropped.get(),
            samples_unasked: self.samples_unasked.get(),
            reports_dropped: self.reports_dropped.get(),
            bytes_lost: self.bytes_lost.get(),
            frames_damaged: self.frames_damaged.get(),
            frames_too_long: self.frames_too_long.get(),
            keys_unknown: self.keys_unknown.get(),
            bodies_undecodable: self.bodies_undecodable.get(),
            commands_refused: self.commands_refused.get(),
            model_swaps: self.model_swaps.get(),
            solver_marks: self.solver_marks.get(),
            sensor_marks: self.sensor_marks.get(),
            witnessed: self.witnessed.get(),
            witness_apart: self.witness_apart.get(),
            readings_damaged: self.readings_damaged.get(),
            readings_lost: self.readings_lost.get(),
            readings_dropped: self.readings_dropped.get(),
            frames_unsent: self.frames_unsent.get(),
            stack_bytes: memory.stack,
            static_bytes: memory.variables,
        }
    }
}
