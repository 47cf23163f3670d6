//! What a board says, in words: for `stream` and `board`.

use stickslip_report::terminal::table;
use stickslip_shared::predictor::{flags, validity};
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
        "{table}\nsag {:.2} mm, {:.2} mm ahead, rotation {:.2}°, drop {}, grip to hold {}\nflags: {}\nvalidity: {}",
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
    names(
        bits,
        &[
            (flags::SLIP_1 | flags::SLIP_2, "slip"),
            (flags::SLIP_AHEAD_1 | flags::SLIP_AHEAD_2, "slip ahead"),
            (flags::UNEXPECTED, "UNEXPECTED SLIP"),
            (flags::SAG, "SAG"),
            (flags::ROTATION, "ROTATION"),
            (flags::DROP, "DROP"),
            (flags::PUSHING, "pushing"),
            (flags::UNSURE, "UNSURE"),
        ],
    )
}

/// Names of the doubts.
pub fn doubt_names(bits: u32) -> String {
    names(
        bits,
        &[
            (validity::SOLVER, "solver"),
            (validity::DIVERGED, "model diverged"),
            (validity::SAMPLE, "sample unusable"),
            (validity::GAP, "gap in the samples"),
            (validity::NO_WRENCH, "no fingertip wrench"),
            (validity::NO_PLAN, "no plan"),
            (validity::WAITING, "waiting for the object's pose"),
            (validity::POINTS_LOST, "contact points left out"),
            (validity::WRENCH, "wrench not finite"),
            (validity::ONE_FINGER, "one finger's wrench missing"),
            (validity::STUCK, "wrench stuck"),
            (validity::SATURATED, "wrench at the end of its range"),
            (validity::BIASED, "constant error of the wrench"),
            (validity::MODEL, "model and measurement disagree"),
            (validity::FORESIGHT, "look-ahead not solved"),
            (validity::POSE, "object's pose not believed"),
            (validity::CONE_INSTEAD, "cone in place of pyramids"),
        ],
    )
}

fn names(bits: u32, table: &[(u32, &str)]) -> String {
    let set: Vec<&str> = table.iter().filter(|(bit, _)| bits & bit != 0).map(|(_, name)| *name).collect();
    if set.is_empty() { "none".into() } else { set.join(", ") }
}
