//! Numbers as people read them.

/// Three significant digits.
pub fn short(x: f64) -> String {
    if x == 0.0 || (x.abs() >= 0.01 && x.abs() < 1e4) { format!("{x:.3}") } else { format!("{x:.2e}") }
}

/// An interval; too few conditions give none.
pub fn interval(low: f64, high: f64) -> String {
    match low.is_finite() && high.is_finite() {
        true => format!("{} to {}", short(low), short(high)),
        false => "no interval".into(),
    }
}
