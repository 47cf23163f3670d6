//! Names that were meant: keys and columns with a slip of the pen.

/// The name of `known` that `name` was meant to be, if it differs by a slip of the pen: at most
/// two letters, and at most a third of them; upper and lower case count as equal.
#[must_use]
pub fn did_you_mean<'k>(name: &str, known: &[&'k str]) -> Option<&'k str> {
    let lower = name.to_lowercase();
    known
        .iter()
        .filter(|other| **other != name)
        .map(|other| (strsim::damerau_levenshtein(&lower, &other.to_lowercase()), *other))
        .filter(|(distance, other)| *distance <= 2 && distance * 3 <= other.len())
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, other)| other)
}

/// `name`, with what it was meant to be.
#[must_use]
pub fn with_hint(name: &str, known: &[&str]) -> String {
    match did_you_mean(name, known) {
        Some(meant) => format!("{name} (did you mean {meant}?)"),
        None => name.to_owned(),
    }
}
