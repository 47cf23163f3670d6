//! Whether the cause of a slip built up in the measured forces, or came suddenly: by the course of the
//! required friction over the last second before it.
//!
//! What builds up could be warned of: some course of up to a second that ends at the onset rose throughout,
//! in each of its quarters, and its first half lay before the moment at which a warning is due. A load that is
//! taken up, held and then knocked has a flat quarter in every such course, a slow decay in none, however
//! little of its rise is left in the last tenth of a second. Friction that falls does not show at all.

/// Longest course that is looked at, s.
const LONGEST_S: f64 = 1.0;
/// Courses between the shortest and the longest.
const COURSES: usize = 5;
/// Rise of a course, as a share of the ratio at which it slips: three times what noise and drift leave of it.
const RISES: f64 = 0.03;
/// Share of the rise that lies in each quarter: a hyperbola, the ratio of a grip that decays to 0.4 of itself,
/// has 12 % in its first one.
const QUARTER: f64 = 0.1;
/// Below this share of the ratio at which it slips, nothing warns yet.
const WARNS: f64 = 0.5;
/// The ratio at which it slips is looked for so long after onset, s: a lift-off is still rising there.
const SETTLED_S: f64 = 0.04;

/// How the cause of an event showed in the measured forces beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, schemars::JsonSchema, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The ratio of tangential to normal force rose steadily before onset, and was half or more of
    /// its value there when a warning was due: there was something to see.
    BuildsUp,
    /// It came later, or did not show in the forces at all (friction fell).
    Sudden,
}

/// Whether the cause of what began at `onset_s` could be seen `lead_s` before. `t`: times of the samples, rising;
/// `ratio`: required friction at each of them, NaN where it is not measured.
pub fn cause(t: &[f64], ratio: &[f64], onset_s: f64, lead_s: f64) -> Cause {
    let at = |s: f64| {
        let i = t.partition_point(|t| *t <= s).saturating_sub(1);
        ratio.get(i).copied().unwrap_or(f64::NAN)
    };
    let from = t.partition_point(|t| *t < onset_s);
    let to = t.partition_point(|t| *t <= onset_s + SETTLED_S);
    let last = ratio.get(from..to).unwrap_or(&[]).iter().fold(at(onset_s), |a, b| a.max(*b));
    // NaN is no rise.
    let rose = |course_s: f64| {
        let [a, b, c, d] = [1.0, 0.75, 0.5, 0.25].map(|part| at(onset_s - part * course_s));
        let rise = last - a;
        onset_s > course_s
            && rise > RISES * last
            && [b - a, c - b, d - c, last - d].iter().all(|quarter| *quarter > QUARTER * rise)
    };
    let shortest_s = 2.0 * lead_s;
    let longest_s = LONGEST_S.max(shortest_s);
    let mut courses =
        (0..COURSES).map(|k| shortest_s + (longest_s - shortest_s) * k as f64 / (COURSES - 1) as f64);
    let warns = at(onset_s - lead_s) > WARNS * last;
    if warns && courses.any(rose) { Cause::BuildsUp } else { Cause::Sudden }
}
