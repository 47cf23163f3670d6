//! Real data of others, brought into our format; see `docs/import.md` for each mapping.

pub mod cmu_push;
pub mod recording;
pub mod tribometer;

use serde::Serialize;

/// A row of a raw file that could not be used.
#[derive(Clone, Debug, PartialEq, schemars::JsonSchema, Serialize)]
pub struct BadRow {
    /// Line of the raw file, from 1.
    pub line: usize,
    /// Its text, shortened.
    pub text: String,
    /// Why.
    pub reason: String,
}

impl BadRow {
    fn new(line: usize, text: &str, reason: impl Into<String>) -> Self {
        BadRow { line, text: text.chars().take(60).collect(), reason: reason.into() }
    }
}

/// Parses `N` finite numbers, separated by blanks or tabs.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let mut numbers = [0.0; N];
    let mut words = text.split_whitespace();
    for slot in &mut numbers {
        let word = words.next().ok_or_else(|| format!("fewer than {N} numbers"))?;
        *slot = word
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite())
            .ok_or_else(|| format!("{word:?} is no finite number"))?;
    }
    match words.next() {
        None => Ok(numbers),
        Some(_) => Err(format!("more than {N} numbers")),
    }
}

/// Value below which `share` (0 to 1) of the sorted `values` lie; NaN for none.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    let at = (share * last as f64).round() as usize;
    sorted.get(at.min(last)).copied().unwrap_or(f64::NAN)
}

fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values
}
