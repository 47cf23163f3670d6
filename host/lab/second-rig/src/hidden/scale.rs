//! What effects are drawn with.

use serde_json::{Map, Value};

/// What an effect may ask when it draws its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Strength over the typical one.
    pub level: f64,
    /// A typical sliding speed of the plan, m/s.
    pub speed_m_s: f64,
    /// A typical sliding distance of the plan, m.
    pub distance_m: f64,
    /// Is anything grasped?
    pub grasped: bool,
}

/// A map of named numbers.
pub fn named<const N: usize>(pairs: [(&str, f64); N]) -> Map<String, Value> {
    pairs.into_iter().map(|(k, v)| (k.to_owned(), Value::from(v))).collect()
}
