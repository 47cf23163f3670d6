//! Names of effects that people type: what to say where one is not known.

use stickslip_shared::effects::REGISTRY;
use thiserror::Error;

/// Most names that are proposed in place of one that is not known.
const PROPOSED: usize = 3;
/// Names that are less alike than this (Jaro and Winkler, 0 to 1) are not proposed.
const ALIKE: f64 = 0.7;

/// A name that no effect has.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0} (`stickslip effects` lists all)")]
pub struct UnknownEffect(pub String);

/// Identifiers of all listed effects.
pub fn listed() -> impl Iterator<Item = &'static str> {
    REGISTRY.iter().map(|info| info.id)
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
