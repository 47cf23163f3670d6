//! Which conditions of a trial a recording may have as columns, and in which units.

use std::collections::BTreeMap;

use super::units::Quantity;

/// From the unit of a condition, as `units` of the mapping gives it, to SI.
///
/// # Errors
/// A condition without a unit, a unit of something else.
pub fn factor(units: &BTreeMap<String, String>, name: &str) -> Result<f64, String> {
    let Some(unit) = units.get(name) else { return Ok(1.0) };
    let quantity = quantity(name).ok_or_else(|| format!("trials.units: {name} has no unit"))?;
    quantity.factor(unit).map_err(|error| format!("trials.units.{name}: {error}"))
}

/// Conditions that a recording can have as columns.
const RECORDED: [&str; 6] = ["grip_n", "speed_m_s", "speed_rad_s", "slope_rad", "pusher_offset_m", "run"];

/// Can `trials.columns` name `condition`, beside these `constants` and `units` of the mapping?
///
/// # Errors
/// What is no number, or is given elsewhere too.
pub fn recorded_in_columns(
    condition: &str,
    constants: &BTreeMap<String, toml::Value>,
    units: &BTreeMap<String, String>,
) -> Result<(), String> {
    if !RECORDED.contains(&condition) {
        let hint = crate::spelling::with_hint(condition, &RECORDED);
        return Err(format!(
            "trials.columns: {hint} is no condition in numbers; one of {}",
            RECORDED.join(", ")
        ));
    }
    if constants.contains_key(condition) {
        return Err(format!("trials: {condition} is in the columns and in the constants"));
    }
    factor(units, condition).map(|_| ())
}

/// What a column of trials.csv measures.
fn quantity(column: &str) -> Option<Quantity> {
    match column {
        "grip_n" => Some(Quantity::Force),
        "speed_m_s" => Some(Quantity::Speed),
        "speed_rad_s" => Some(Quantity::AngularSpeed),
        "slope_rad" => Some(Quantity::Angle),
        "pusher_offset_m" => Some(Quantity::Length),
        _ => None,
    }
}
