//! Predictions in words.

use stickslip_analysis::run::replay::{FLAGS, VALIDITY};

/// When something begins, s from now.
#[must_use]
pub fn when(seconds: Option<f32>) -> String {
    match seconds {
        None => "not ahead".into(),
        Some(0.0) => "now".into(),
        Some(seconds) if seconds.is_finite() => format!("in {:.0} ms", seconds * 1e3),
        Some(_) => "ahead".into(),
    }
}

/// How probable it is that the grasp holds. Never more than it is: 100 % is certain.
#[must_use]
pub fn holds(probability: Option<f32>) -> String {
    probability.map_or_else(|| "-".into(), |p| format!("{:.1} %", (1e3 * f64::from(p)).floor() * 0.1))
}

/// A coefficient of friction; nothing is known of it before the first contact.
#[must_use]
pub fn coefficient(mu: f32) -> String {
    if mu > 0.0 { format!("{mu:.2}") } else { "-".into() }
}

/// A number with so many digits and its unit; what is not known is none.
#[must_use]
pub fn number(x: f32, digits: usize, unit: &str) -> String {
    if x.is_finite() { format!("{x:.digits$}{unit}") } else { "-".into() }
}

/// Names of the flags that are up.
#[must_use]
pub fn flag_names(bits: u32) -> String {
    names(bits, &FLAGS)
}

/// Names of the doubts.
#[must_use]
pub fn doubt_names(bits: u32) -> String {
    names(bits, &VALIDITY)
}

fn names(bits: u32, of: &[&str]) -> String {
    let set = of.iter().enumerate().filter(|(bit, _)| bits >> bit & 1 == 1);
    let set: Vec<&str> = set.map(|(_, name)| name.strip_prefix("doubt: ").unwrap_or(name)).collect();
    if set.is_empty() { "none".into() } else { set.join(", ") }
}
