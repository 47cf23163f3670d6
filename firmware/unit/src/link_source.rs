//! The tick's sample of a run whose samples the host sends. Of a run on the unit's own sensors it is
//! [`fingers`](crate::fingers) that makes it.

use stickslip_shared::wire::{SAMPLE_QUEUE, Sample, StartRequest};

use crate::queue::Queue;

/// What a source has for a tick.
pub enum Next {
    /// A sample.
    Sample(Sample),
    /// Nothing yet, by intention.
    Filling,
    /// Nothing, though there should be.
    Starved,
}

/// Samples that the host sends, in its order, one a tick.
pub struct LinkSource {
    prefill: usize,
    begun: bool,
    /// Ticks spent waiting with a sample there.
    waited: u8,
}

/// Ticks after which a run begins with fewer samples than asked for: some were lost.
const PATIENCE: u8 = 125;

impl LinkSource {
    /// For one run.
    pub fn new(request: &StartRequest) -> Self {
        Self { prefill: usize::from(request.prefill), begun: false, waited: 0 }
    }

    /// The sample for this tick.
    pub fn take(&mut self, samples: &Queue<Sample, SAMPLE_QUEUE>) -> Next {
        if !self.begun && samples.len() < self.prefill.max(1) {
            self.waited = self.waited.saturating_add(u8::from(!samples.is_empty()));
            if self.waited < PATIENCE {
                return Next::Filling;
            }
        }
        self.begun = true;
        samples.try_receive().map_or(Next::Starved, Next::Sample)
    }
}
