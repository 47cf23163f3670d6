//! Effects by the names that people type: the listed ones and the user's formulas.

use stickslip_shared::effects::{self, REGISTRY};
use thiserror::Error;

use crate::model::file::EffectEntry;

/// Most names that are proposed in place of one that is not known.
const PROPOSED: usize = 3;
/// Names that are less alike than this (Jaro and Winkler, 0 to 1) are not proposed.
const ALIKE: f64 = 0.7;

/// A name that no effect has.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0} (`stickslip effects` lists all)")]
pub struct UnknownEffect(String);

/// Identifiers of all listed effects.
pub fn listed() -> impl Iterator<Item = &'static str> {
    REGISTRY.iter().map(|info| info.id)
}

/// The effect called `name`: a listed one with its typical parameters, or one of `formulas` as it is.
///
/// # Errors
/// Where there is none; the error proposes names that are alike.
pub fn effect(name: &str, formulas: &[EffectEntry]) -> Result<EffectEntry, UnknownEffect> {
    if let Some(info) = effects::find(name) {
        return Ok(EffectEntry::typical(info));
    }
    let found = formulas.iter().find(|f| f.name() == name).cloned();
    found.ok_or_else(|| {
        let mut known: Vec<&str> = formulas.iter().map(EffectEntry::name).collect();
        for id in listed() {
            known.push(id);
        }
        UnknownEffect(unknown(name, known.into_iter()))
    })
}

/// What to say about a `name` that is none of `known`.
pub fn unknown<'k>(name: &str, known: impl Iterator<Item = &'k str>) -> String {
    let mut alike: Vec<(f64, &str)> =
        known.map(|k| (strsim::jaro_winkler(name, k), k)).filter(|(score, _)| *score > ALIKE).collect();
    alike.sort_by(|a, b| b.0.total_cmp(&a.0));
    let alike: Vec<&str> = alike.iter().take(PROPOSED).map(|(_, k)| *k).collect();
    match alike.as_slice() {
        [] => format!("effect '{name}' is not known"),
        [only] => format!("effect '{name}' is not known; did you mean {only}?"),
        [others @ .., last] => {
            format!("effect '{name}' is not known; did you mean {} or {last}?", others.join(", "))
        }
    }
}
