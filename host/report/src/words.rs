//! Numbers as people read them.

/// Three significant digits.
pub fn short(x: f64) -> String {
    if x == 0.0 || (x.abs() >= 0.01 && x.abs() < 1e4) { format!("{x:.3}") } else { format!("{x:.2e}") }
}

/// How early a warning came, from its lead in s.
#[must_use]
pub fn how_early(lead_s: f64) -> String {
    match (1e3 * lead_s).round() {
        ms if ms >= 0.0 => format!("{ms:.0} ms ahead"),
        ms => format!("{:.0} ms after it began", -ms),
    }
}

/// An identifier as words.
#[must_use]
pub fn identifier_words(id: &str) -> String {
    id.replace('_', " ")
}

/// A text with words in place of the identifiers of effects.
#[must_use]
pub fn effects_in_words(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for part in text.split_inclusive(|c: char| !(c.is_ascii_alphanumeric() || c == '_')) {
        let (id, end) =
            part.split_at(part.trim_end_matches(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).len());
        let known = stickslip_shared::effects::find(id).is_some();
        out.push_str(&if known { identifier_words(id) } else { id.to_owned() });
        out.push_str(end);
    }
    out
}

/// A parameter's name without its unit, which stands beside its value: 'offset x' of `offset_x_m`.
#[must_use]
pub fn parameter_words(name: &str) -> String {
    const UNITS: [&str; 10] = ["_n_m", "_m_n", "_1_m", "_s_m", "_nm", "_rad", "_n", "_m", "_s", "_kg"];
    let cut = UNITS.iter().find_map(|unit| name.strip_suffix(unit)).filter(|cut| !cut.is_empty());
    let plain = cut.unwrap_or(name).replace(['_', '.'], " ");
    plain.replace("finger1", "finger 1").replace("finger2", "finger 2")
}

/// An interval. Data may bound one side only; too few conditions bound none.
pub fn interval(low: f64, high: f64) -> String {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("{} to {}", short(low), short(high)),
        (true, false) => format!("at least {}", short(low)),
        (false, true) => format!("at most {}", short(high)),
        (false, false) => "no interval".into(),
    }
}

/// 'So many times' with two or three digits.
pub fn times(x: f64) -> String {
    if x >= 10.0 { format!("{x:.0}\u{d7}") } else { format!("{x:.1}\u{d7}") }
}

/// A probability behind a 'p'; what is nearly none is said to be so.
#[must_use]
pub fn probability(p: f64) -> String {
    if p < 1e-4 { "< 0.0001".into() } else { format!("= {p:.4}") }
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
