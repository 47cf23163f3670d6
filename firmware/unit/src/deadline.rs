//! When ticks are due.

/// Due times a period apart, by a clock in us. One that was missed is not made up for by a longer period: those after it
/// are due when they would have been.
#[derive(Clone, Copy, Debug)]
pub struct Deadline {
    due_us: u64,
    period_us: u32,
}

impl Deadline {
    /// The first is due a period from now.
    pub fn from(now_us: u64, period_us: u32) -> Self {
        Self { due_us: now_us, period_us }
    }

    /// When the next one is due.
    pub fn next_us(&mut self) -> u64 {
        self.due_us = self.due_us.saturating_add(u64::from(self.period_us));
        self.due_us
    }

    /// Whether one that begins now has missed its period.
    pub fn missed(&self, now_us: u64) -> bool {
        now_us >= self.due_us.saturating_add(u64::from(self.period_us))
    }
}
