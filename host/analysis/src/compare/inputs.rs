//! What a comparison is given, and why it may refuse.

use thiserror::Error;

use super::tare::Tare;
use crate::evidence::conditions::HeldOut;
use stickslip_data::{Index, Trial};

/// Family-wise chance of a false alarm.
pub const SIGNIFICANCE: f64 = 0.01;

/// Why nothing can be compared.
#[derive(Debug, Error)]
pub enum CompareError {
    /// Nothing is listed.
    #[error("the data set lists no trials")]
    Empty,
    /// A choice of held out trials that cannot be made; the text says why and what to do.
    #[error("{0}")]
    HeldOut(String),
    /// No such trial.
    #[error("no trial is named `{id}`; there are {count} ({some} ...)")]
    NoSuchTrial {
        /// Asked for.
        id: String,
        /// Trials that there are.
        count: usize,
        /// The first of them.
        some: String,
    },
    /// None could be read and simulated; the first reason.
    #[error("no trial can be compared: {0}")]
    NoTrial(String),
}

/// What counts as an error where rigid contact leaves something open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Forces {
    /// What is outside the interval of all force distributions with the same motion, net wrench
    /// and grip, of all paths that cannot be distinguished from the measured one, and of the
    /// tolerance of any rigid model ([`crate::evidence::tolerance`]).
    #[default]
    OutsideBand,
    /// The distance to the solution that the model returns, that of least elastic energy.
    AsReturned,
}

/// What is good of trial `i`, and what of it was refused.
pub fn load(data: &Index, i: usize) -> (Result<Trial, String>, Option<String>) {
    let reading = data.read_trial_lenient(&data.trials[i]);
    let refused = reading.refusal();
    (reading.trial.ok_or_else(|| "it cannot be read".to_owned()), refused)
}

/// What to compare.
#[derive(Clone, Debug)]
pub struct Options {
    /// Only this trial.
    pub trial: Option<String>,
    /// Only these trials are compared, and none of them is calibrated on.
    pub held_out: HeldOut,
    /// Sensor offsets.
    pub tare: Tare,
    /// Forces that are not determined.
    pub forces: Forces,
    /// Most trials whose signals are kept for a page: the worst and the median one, then the worst run of
    /// each further condition.
    pub drawn: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            trial: None,
            held_out: HeldOut::Nothing,
            tare: Tare::BeforeContact,
            forces: Forces::default(),
            drawn: 2,
        }
    }
}
