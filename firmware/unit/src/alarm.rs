//! Alarm lines for a gripper's controller or a safety circuit: one for slip, one for drop, one that says whether the two
//! can be relied on.
//!
//! The third is high while they can: a unit without power, in reset, without a run or in doubt, and a cut
//! wire, all read as 'unsure'.

use embedded_hal::digital::OutputPin;
use stickslip_shared::predictor::{Prediction, flags};

/// What the lines say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Alarms {
    /// Motion in the grasp that the plan does not intend, now or ahead.
    pub slip: bool,
    /// The grasp will be lost.
    pub drop: bool,
    /// The other two can be relied on, up or down.
    pub sure: bool,
}

impl Alarms {
    /// Of a tick's prediction. Without one the default holds: nothing, and not sure of it.
    pub fn of(prediction: &Prediction) -> Self {
        let up = |bits| prediction.flags & bits != 0;
        Self {
            slip: up(flags::UNEXPECTED | flags::SAG | flags::ROTATION),
            drop: up(flags::DROP),
            sure: !up(flags::UNSURE),
        }
    }
}

/// A line that could not be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineFault;

/// The three lines.
pub struct Lines<S, D, U> {
    /// High: slip.
    pub slip: S,
    /// High: drop.
    pub drop: D,
    /// High: sure.
    pub sure: U,
}

impl<S: OutputPin, D: OutputPin, U: OutputPin> Lines<S, D, U> {
    /// Sets all three; where one fails, 'sure' goes down.
    ///
    /// # Errors
    /// A pin's driver failed.
    pub fn set(&mut self, alarms: Alarms) -> Result<(), LineFault> {
        let drop = self.drop.set_state(alarms.drop.into()).is_ok();
        let slip = self.slip.set_state(alarms.slip.into()).is_ok();
        let sure = self.sure.set_state((alarms.sure && drop && slip).into()).is_ok();
        if drop && slip && sure { Ok(()) } else { Err(LineFault) }
    }
}
