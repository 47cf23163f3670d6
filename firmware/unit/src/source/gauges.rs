//! Strain gauges on the unit's own converters: six channels a finger.

use super::{Losses, Reading, WrenchSource, count};

/// Channels: six gauges of each of two fingers.
pub const CHANNELS: usize = 12;
/// Counts this close to an end of the converter's 12 bits are not a measurement.
const SATURATION: u16 = 8;
const FULL_SCALE: u16 = 4095;
/// What an amplifier gives without load until a tare says better, counts.
pub const REST: f32 = FULL_SCALE as f32 / 2.0;
/// A scan is of the tick that reads it: it stands for that one.
const STANDS_US: u32 = 3_999;

/// Six channels of one finger, as counts.
#[derive(Clone, Debug)]
pub struct Gauges {
    finger: usize,
    losses: Losses,
}

impl Gauges {
    /// Of finger 0 or 1.
    pub fn new(finger: u8) -> Self {
        Self { finger: usize::from(finger), losses: Losses::default() }
    }
}

impl WrenchSource for Gauges {
    type Input<'a> = &'a [u16; CHANNELS];

    fn take(&mut self, counts: &[u16; CHANNELS], at_us: u32) -> Option<Reading> {
        let own = counts.chunks_exact(6).nth(self.finger)?;
        let sound = SATURATION..=FULL_SCALE - SATURATION;
        if !own.iter().all(|channel| sound.contains(channel)) {
            count(&mut self.losses.faulty);
            return None;
        }
        let mut values = [0.0; 6];
        for (value, channel) in values.iter_mut().zip(own) {
            *value = f32::from(*channel);
        }
        Some(Reading { at_us, stands_us: STANDS_US, values })
    }

    fn losses(&self) -> Losses {
        self.losses
    }
}
