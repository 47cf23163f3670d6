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

/// 'So many times' with two or three digits.
pub fn times(x: f64) -> String {
    if x >= 10.0 { format!("{x:.0}\u{d7}") } else { format!("{x:.1}\u{d7}") }
}

/// The first sentence, and what follows.
pub fn first_sentence(text: &str) -> (&str, &str) {
    let ends = text.match_indices(". ").map(|(at, _)| at);
    let begins = |at: &usize| text[at + 2..].starts_with(|c: char| c.is_uppercase());
    match ends.into_iter().find(begins) {
        Some(at) => (&text[..=at], &text[at + 2..]),
        None => (text, ""),
    }
}
