//! What a board says, in words: for `stream` and `board`.

use stickslip_device::clock::Clock;
use stickslip_live::words::{doubt_names, flag_names, holds, when};
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

/// A board's clock by this machine's.
pub fn told(clock: &Clock) -> String {
    let drift =
        clock.drift.map_or("unknown after so short a time".to_owned(), |d| format!("{:.1} ppm", d * 1e6));
    format!("{:.6} s ahead (\u{b1} {:.2} ms); drift {drift}", clock.offset_s, clock.uncertainty_s * 1e3)
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
        "{table}\nholds {}, friction {:.2}, at least {:.2}\nsag {:.2} mm, {:.2} mm ahead, rotation {:.2}°, drop {}, grip with reserve {}\nflags: {}\nin doubt: {}",
        holds(p.hold_probability),
        p.friction,
        p.friction_least,
        p.sag_m * 1e3,
        p.sag_ahead_m * 1e3,
        p.rotation_rad.to_degrees(),
        when(p.drop_in_s),
        p.holding_grip_n.map_or_else(|| "not planned".into(), |n| format!("{n:.1} N")),
        flag_names(p.flags),
        doubt_names(p.validity),
    )
}
