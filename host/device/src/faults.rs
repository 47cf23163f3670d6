//! A bad line on purpose: samples lost, doubled, overtaken and damaged, garbage between
//! them, reports lost, all drawn from a seed and counted, so that the counts of the board
//! can be held against what was really done to the line.

use rand::Rng;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// What was done to the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, schemars::JsonSchema, Serialize)]
pub struct Injected {
    /// Samples never sent.
    pub lost: u32,
    /// Samples sent with a changed byte.
    pub damaged: u32,
    /// Samples sent twice.
    pub repeated: u32,
    /// Samples sent after the next one.
    pub overtaken: u32,
    /// Bursts of random bytes.
    pub garbage: u32,
    /// Reports thrown away on arrival.
    pub reports_lost: u32,
}

/// Damages frames on their way out.
pub struct Faults {
    random: ChaCha8Rng,
    held: Option<Vec<u8>>,
    /// So far.
    pub injected: Injected,
}

/// Share of samples that each fault meets.
const RATE: f64 = 0.02;

impl Faults {
    /// The same for the same seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { random: ChaCha8Rng::seed_from_u64(seed), held: None, injected: Injected::default() }
    }

    /// What goes on the line instead of `frame` (which ends with its 0).
    pub fn damage(&mut self, frame: &[u8]) -> Vec<u8> {
        let mut line = Vec::new();
        if self.random.random_bool(RATE) {
            self.injected.garbage += 1;
            let length = self.random.random_range(1..400);
            line.extend((0..length).map(|_| self.random.random_range(1..=u8::MAX)));
            line.push(0);
        }
        // One fault a frame, so that each count stands for itself.
        let fault = if self.held.is_some() { 1.0 } else { self.random.random::<f64>() / RATE };
        if fault < 1.0 {
            self.injected.lost += 1;
        } else if fault < 2.0 && self.held.is_none() {
            self.injected.damaged += 1;
            let mut bytes = frame.to_vec();
            let at = self.random.random_range(0..bytes.len().saturating_sub(1).max(1));
            // Not the 0 that ends the frame, nor made one: then the count would be off.
            let flip = bytes.get(at).map_or(0, |b| if *b == 0x55 { 0x0f } else { *b ^ 0x55 });
            if let Some(byte) = bytes.get_mut(at) {
                *byte = flip;
            }
            line.extend(bytes);
        } else if fault < 3.0 && self.held.is_none() {
            self.injected.repeated += 1;
            line.extend_from_slice(frame);
            line.extend_from_slice(frame);
        } else if fault < 4.0 && self.held.is_none() {
            self.held = Some(frame.to_vec());
        } else {
            line.extend_from_slice(frame);
            if let Some(late) = self.held.take() {
                self.injected.overtaken += 1;
                line.extend(late);
            }
        }
        line
    }

    /// Whether the report that just came in is thrown away.
    pub fn loses_report(&mut self) -> bool {
        let lost = self.random.random_bool(RATE);
        self.injected.reports_lost += u32::from(lost);
        lost
    }
}
