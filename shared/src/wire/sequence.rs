//! Order of numbered messages, and the running hash that proves two sides equal.

use super::messages::Prediction;

/// What the number of a message says about those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The one after the last, or later by `lost` messages that never came.
    Next {
        /// Messages missing in between.
        lost: u32,
    },
    /// The same as the last.
    Repeated,
    /// Earlier than the last.
    Late,
}

/// Follows the numbers of a stream that begins at 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sequence {
    next: u32,
}

impl Sequence {
    /// Judges `seq`; a message that is [`Order::Next`] moves the count on.
    pub fn judge(&mut self, seq: u32) -> Order {
        if seq >= self.next {
            let lost = seq.wrapping_sub(self.next);
            self.next = seq.wrapping_add(1);
            Order::Next { lost }
        } else if seq.wrapping_add(1) == self.next {
            Order::Repeated
        } else {
            Order::Late
        }
    }
}

/// Beginning of [`chain`].
pub const HASH_START: u32 = 0x811c_9dc5;

/// FNV-1a of `hash` continued over the postcard bytes of a prediction: every output word
/// counts, so equal hashes mean equal runs up to here.
pub fn chain(hash: u32, prediction: &Prediction) -> u32 {
    let mut bytes = [0; super::MAX_BODY];
    let used: &[u8] = match postcard::to_slice(prediction, &mut bytes) {
        Ok(used) => used,
        Err(_) => &[],
    };
    used.iter().fold(hash, |hash, byte| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193))
}
