//! Arrays of a TOML file that must have as many numbers as they are told: read as an array of fixed length,
//! numbers too many would be dropped without a word.

use serde::{Deserialize, Deserializer, de};

fn exactly<T, const N: usize, E: de::Error>(given: Vec<T>) -> Result<[T; N], E> {
    let count = given.len();
    given.try_into().map_err(|_| E::custom(format!("{count} number(s) where {N} are needed")))
}

/// `N` numbers.
///
/// # Errors
/// Another count of them, or something that is no number.
pub fn numbers<'de, D: Deserializer<'de>, T: Deserialize<'de>, const N: usize>(
    from: D,
) -> Result<[T; N], D::Error> {
    exactly(Vec::deserialize(from)?)
}

/// A list of `N` numbers each.
pub fn rows<'de, D: Deserializer<'de>, const N: usize>(from: D) -> Result<Option<Vec<[f64; N]>>, D::Error> {
    let given = Option::<Vec<Vec<f64>>>::deserialize(from)?;
    given.map(|rows| rows.into_iter().map(exactly).collect()).transpose()
}

/// Three rows of three numbers.
pub fn matrix<'de, D: Deserializer<'de>>(from: D) -> Result<Option<[[f64; 3]; 3]>, D::Error> {
    let Some(given) = rows::<D, 3>(from)? else { return Ok(None) };
    let count = given.len();
    let whole = given.try_into();
    whole.map(Some).map_err(|_| de::Error::custom(format!("{count} row(s) where 3 are needed")))
}
