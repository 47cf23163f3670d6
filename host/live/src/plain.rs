//! A run in lines, for what is no terminal.

use crate::state::{Alarm, State, of_period};
use crate::words::{coefficient, doubt_names, flag_names, holds, number, when};

/// What is known now, in a line.
#[must_use]
pub fn line(state: &State) -> String {
    let health = state.line();
    let work = health.work_ms.map_or(String::new(), |ms| {
        format!(", tick {ms:.2} ms ({:.0} % of its period)", 100.0 * of_period(ms))
    });
    let line = format!("{:.0} samples/s, {} reports lost{work}", health.samples_per_s, health.reports_lost);
    let Some(p) = &state.prediction else {
        let mode = state.mode.map_or("silent".to_owned(), |mode| format!("{mode:?}").to_lowercase());
        return format!("{:7.2} s  {mode}: nothing is predicted; {line}", state.now_s);
    };
    let used = p.finger.map(|f| f.measured_utilisation.map_or("-".to_owned(), |u| format!("{u:.2}")));
    let grip = p.holding_grip_n.map_or("-".to_owned(), |n| format!("{n:.1} N"));
    format!(
        "{:7.2} s  used {} and {} of friction {} (at least {}), holds {}, sag {}, drop {}, grip with reserve {grip}; flags {}; in doubt: {}; {line}",
        state.now_s,
        used[0],
        used[1],
        coefficient(p.friction),
        coefficient(p.friction_least),
        holds(p.hold_probability),
        number(p.sag_m * 1e3, 2, " mm"),
        when(p.drop_in_s),
        flag_names(p.flags),
        doubt_names(p.validity)
    )
}

/// An alarm, in a line.
#[must_use]
pub fn alarm(alarm: &Alarm) -> String {
    let ahead = alarm.foreseen_in_s.map_or(String::new(), |s| format!(", foreseen {}", when(Some(s))));
    let came = alarm.came_after_s.map_or(String::new(), |s| format!(", came after {:.0} ms", s * 1e3));
    let over = alarm.over_s.map_or(String::new(), |s| format!(", over at {s:.2} s"));
    let unsure = if alarm.unsure { " (unsure)" } else { "" };
    format!("{:7.2} s  {}{unsure}{ahead}{came}{over}", alarm.at_s, alarm.what)
}
