//! What can be told of a run, whatever tells it.

use stickslip_shared::model::Scene;
use stickslip_shared::predictor::Prediction;
use stickslip_shared::wire::{Info, Sample, Statistics, TelemetryReport};
use stickslip_unit::bus::State;

/// What happened.
#[derive(Clone, Debug)]
pub enum Happened {
    /// A board answered.
    Board(Box<Info>),
    /// What is held, where it is known, and the trial's name.
    Scene(Box<Scene<f32>>, String),
    /// A remark for the user.
    Note(String),
    /// Counts a second of the costs in reports (of a log, whose board is not there).
    Timer(u32),
    /// Measured, as the board was sent it.
    Sample(Sample),
    /// From the board.
    Report(Box<TelemetryReport>),
    /// From the bus: what a board says there each tick.
    Heard(Box<State>),
    /// From the bus: frames so far that arrived here with a length or a value that there is not.
    Damaged(u64),
    /// From the bus: wrench on the object at a finger, gripper axes, N and N m; `None`: its sensor says that it
    /// measured none.
    Wrench(usize, Option<[f32; 6]>),
    /// Of a replay's log: one a tick.
    Prediction(Box<Prediction>),
    /// The board's counts since its reset; frames that arrived here damaged.
    Counts(Box<Statistics>, u64),
}

impl Happened {
    /// Whether it tells what a tick predicts.
    #[must_use]
    pub fn predicts(&self) -> bool {
        matches!(self, Self::Report(_) | Self::Prediction(_) | Self::Heard(_))
    }
}

/// What happened, and when: s since the first.
#[derive(Clone, Debug)]
pub struct Event {
    /// By this machine's clock, of a log by that of its run.
    pub at_s: f64,
    /// What.
    pub what: Happened,
}
