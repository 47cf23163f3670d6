//! What a board says, in words: for `stream` and `board`.

use stickslip_analysis::run::replay::{FLAGS, VALIDITY};
use stickslip_report::terminal::table;
use stickslip_shared::wire::{Info, TelemetryReport};

/// A line on what the board is.
pub fn describe(info: &Info) -> String {
    format!(
        "{} firmware {}, start {} ({:?}), {} ms tick",
        info.board,
        info.firmware,
        info.boots,
        info.reset_cause,
        info.tick_us / 1000
    )
}

/// The newest prediction, as a table.
pub fn live(report: &TelemetryReport) -> String {
    let p = &report.prediction;
    let mut table = table(["", "used", "model", "peak ahead", "slip", "towards", "begins"]);
    for (name, f) in ["finger 1", "finger 2"].into_iter().zip(&p.finger) {
        table.add_row([
            name.to_owned(),
            f.measured_utilisation.map_or_else(|| "-".into(), |u| format!("{u:.2}")),
            format!("{:.2}", f.model_utilisation),
            format!("{:.2}", f.peak_utilisation),
            format!("{:.1} mm/s", f.slip_speed_m_s * 1e3),
            format!("{:.0}°", f.slip_direction_rad.to_degrees()),
            when(f.slip.in_s()),
        ]);
    }
    format!(
        "{table}\nsag {:.2} mm, {:.2} mm ahead, rotation {:.2}°, drop {}, grip to hold {}\nflags: {}\nin doubt: {}",
        p.sag_m * 1e3,
        p.sag_ahead_m * 1e3,
        p.rotation_rad.to_degrees(),
        when(p.drop_in_s),
        p.holding_grip_n.map_or_else(|| "not planned".into(), |n| format!("{n:.1} N")),
        flag_names(p.flags),
        doubt_names(p.validity),
    )
}

fn when(seconds: Option<f32>) -> String {
    match seconds {
        None => "not ahead".into(),
        Some(0.0) => "now".into(),
        Some(seconds) => format!("in {:.0} ms", seconds * 1e3),
    }
}

/// Names of the flags that are up.
pub fn flag_names(bits: u32) -> String {
    names(bits, &FLAGS)
}

/// Names of the doubts.
pub fn doubt_names(bits: u32) -> String {
    names(bits, &VALIDITY)
}

fn names(bits: u32, of: &[&str]) -> String {
    let set = of.iter().enumerate().filter(|(bit, _)| bits >> bit & 1 == 1);
    let set: Vec<&str> = set.map(|(_, name)| name.strip_prefix("doubt: ").unwrap_or(name)).collect();
    if set.is_empty() { "none".into() } else { set.join(", ") }
}
