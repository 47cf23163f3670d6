//! The statements of the paper's results and discussion, checked one by one: what the paper
//! saw, what a synthetic reality of springs and bristles (`rig`) shows, what the hard and
//! what the soft contact model give on the same trials.
//!
//! Kolbert, Chavan-Dafle and Rodriguez, Experimental validation of contact dynamics for
//! in-hand manipulation (ISER 2016). Friction is the middle of the paper's ranges: 0.4 at
//! the fingers, 0.25 at the pusher. Where the paper is ambiguous about the grip force, both
//! readings are shown.

mod pivoting;
mod pushing;
pub mod pyramids;
mod rolling;
mod runs;

use serde::Serialize;

pub use runs::{Bench, Run};

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

    fn of(hard: bool, soft: bool) -> Self {
        match (hard, soft) {
            (true, true) => Self::Yes,
            (false, false) => Self::No,
            _ => Self::Partly,
        }
    }
}

/// All statements. Runs the rig for about forty trials: some seconds.
///
/// # Errors
/// Where a trial of the rig cannot be made or simulated, which no user input can cause.
pub fn findings() -> anyhow::Result<Vec<Finding>> {
    let mut all = pushing::findings()?;
    all.extend(pivoting::findings()?);
    all.extend(rolling::findings()?);
    Ok(all)
}
