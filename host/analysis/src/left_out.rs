//! Trials that an analysis leaves out: told first, so that no result passes for one of all trials.

use schemars::JsonSchema;
use serde::Serialize;

use crate::run::scene::SceneError;

/// Reasons that are told in the sentence.
const TOLD: usize = 2;

/// A trial that was left out.
#[derive(Clone, Debug, PartialEq, Eq, JsonSchema, Serialize)]
pub struct LeftOut {
    /// Id.
    pub trial: String,
    /// Why.
    pub reason: String,
}

impl From<&SceneError> for LeftOut {
    fn from(error: &SceneError) -> Self {
        let SceneError::Description { trial, what } = error;
        Self { trial: trial.clone(), reason: what.clone() }
    }
}

impl std::fmt::Display for LeftOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "trial {}: {}", self.trial, self.reason)
    }
}

/// How many trials of how many are left out, and why, the commonest reasons first; nothing where none is.
#[must_use]
pub fn sentence(left_out: &[LeftOut], trials: usize) -> Option<String> {
    let mut reasons: Vec<(&str, usize)> = Vec::new();
    for one in left_out {
        match reasons.iter_mut().find(|(reason, _)| *reason == one.reason) {
            Some((_, count)) => *count += 1,
            None => reasons.push((&one.reason, 1)),
        }
    }
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let (told, others) = reasons.split_at(reasons.len().min(TOLD));
    let mut why: Vec<String> = told.iter().map(|(reason, count)| format!("{reason} ({count})")).collect();
    let rest: usize = others.iter().map(|(_, count)| count).sum();
    why.extend((rest > 0).then(|| format!("other reasons ({rest})")));
    let verb = if left_out.len() == 1 { "is" } else { "are" };
    (!left_out.is_empty())
        .then(|| format!("{} of {trials} trials {verb} left out: {}", left_out.len(), why.join("; ")))
}
