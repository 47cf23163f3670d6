//! Numbers as people read them.

/// Three significant digits.
pub fn short(x: f64) -> String {
    if x == 0.0 || (x.abs() >= 0.01 && x.abs() < 1e4) { format!("{x:.3}") } else { format!("{x:.2e}") }
}
