//! Order of numbered messages: what was lost, repeated or overtaken.

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

/// Follows the numbers of a stream, by default from 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sequence {
    next: u32,
}

impl Sequence {
    /// A stream whose next message is `seq`.
    pub fn starting_at(seq: u32) -> Self {
        Self { next: seq }
    }

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
