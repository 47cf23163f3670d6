//! One statement of the paper, and what became of it.

use serde::Serialize;

/// One statement and what became of it.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// Primitive it is about.
    pub about: &'static str,
    /// The paper's statement.
    pub statement: &'static str,
    /// What the paper saw or predicted.
    pub paper: String,
    /// What the synthetic reality shows.
    pub rig: String,
    /// What the hard model gives.
    pub hard: String,
    /// What the soft model gives.
    pub soft: String,
    /// Whether the models bear the statement out.
    pub outcome: Outcome,
    /// Why, where it does not come out or only under a reading.
    pub reason: String,
}

/// Whether a statement comes out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Both models agree with the paper's statement.
    Yes,
    /// Under one reading, or in one model only.
    Partly,
    /// Neither model.
    No,
}

impl Outcome {
    /// In words.
    pub fn word(self) -> &'static str {
        match self {
            Self::Yes => "yes",
            Self::Partly => "partly",
            Self::No => "no",
        }
    }

    /// From both models' answers.
    pub fn of(hard: bool, soft: bool) -> Self {
        match (hard, soft) {
            (true, true) => Self::Yes,
            (false, false) => Self::No,
            _ => Self::Partly,
        }
    }
}
