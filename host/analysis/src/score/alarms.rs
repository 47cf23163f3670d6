//! Alarms against events: which were warned, how early, and what was a false alarm.
//!
//! An alarm episode is a time in which a method's alarm is up, pauses under 0.2 s bridged.
//! An event is found by the episode that is up at its onset or begins within 0.1 s after;
//! its lead is onset minus the episode's beginning (negative: late). An episode that meets
//! no event, from half a second before the event's end backwards, is a false alarm.

use super::truth::Event;
use stickslip_shared::predictor::flags;

/// The predictor's flags of slip, now or ahead, of either finger.
pub const SLIPS: u32 = flags::SLIP_1 | flags::SLIP_2 | flags::SLIP_AHEAD_1 | flags::SLIP_AHEAD_2;

/// Validity bits under which no alarm can be believed or expected.
pub const UNTRUSTED: u32 = stickslip_shared::predictor::validity::SAMPLE
    | stickslip_shared::predictor::validity::WAITING
    | stickslip_shared::predictor::validity::WRENCH;

/// Pauses that are bridged.
const BRIDGED_S: f64 = 0.2;
/// An alarm later than this has missed the event.
pub const LATEST_S: f64 = 0.1;
/// An alarm that ended this long before the event still announced it.
const ANNOUNCED_S: f64 = 0.5;

/// A time in which an alarm is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Episode {
    /// First tick.
    pub from_s: f64,
    /// Last tick.
    pub to_s: f64,
}

/// Episodes of an alarm given tick by tick, up to `until_s`.
pub fn episodes(t_s: &[f64], up: impl IntoIterator<Item = bool>, until_s: f64) -> Vec<Episode> {
    let mut all: Vec<Episode> = Vec::new();
    for (t, up) in t_s.iter().zip(up) {
        if !up || *t > until_s {
            continue;
        }
        match all.last_mut() {
            Some(last) if t - last.to_s <= BRIDGED_S => last.to_s = *t,
            _ => all.push(Episode { from_s: *t, to_s: *t }),
        }
    }
    all
}

/// Lead of the alarm over each event, `None` where it was missed.
pub fn leads(events: &[&Event], episodes: &[Episode]) -> Vec<Option<f64>> {
    events
        .iter()
        .map(|e| {
            episodes
                .iter()
                .filter(|a| a.from_s <= e.onset_s + LATEST_S && a.to_s + ANNOUNCED_S >= e.onset_s)
                .map(|a| e.onset_s - a.from_s)
                .reduce(f64::max)
        })
        .collect()
}

/// Episodes that met none of `events`: those that met one of the lesser ones (from, to), and
/// the false alarms.
pub fn unmet(events: &[&Event], lesser: &[(f64, f64)], episodes: &[Episode]) -> (Vec<Episode>, Vec<Episode>) {
    let meets = |a: &Episode, from_s: f64, to_s: f64| {
        a.from_s <= to_s + ANNOUNCED_S && a.to_s + ANNOUNCED_S >= from_s
    };
    episodes
        .iter()
        .filter(|a| !events.iter().any(|e| meets(a, e.onset_s, e.end_s)))
        .partition(|a| lesser.iter().any(|(from, to)| meets(a, *from, *to)))
}
