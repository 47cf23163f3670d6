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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rose_over_the_last_second_builds_up_and_what_came_within_the_lead_is_sudden() {
        use Cause::{BuildsUp, Sudden};
        let taken_up = |t: f64| 0.35 * ((t + 0.8) / 0.1).clamp(0.0, 1.0);
        let knock = |t: f64| 0.3 * ((t + 0.03) / 0.03).clamp(0.0, 1.0);
        // Time counts from the onset; the friction there is is 0.5.
        type Course<'a> = (&'a str, &'a dyn Fn(f64) -> f64, Cause);
        let courses: [Course<'_>; 12] = [
            (
                "a grip that decays within 0.6 s",
                &|t| 0.2 / (1.0 - 0.6 * ((t + 0.6) / 0.6).clamp(0.0, 1.0)),
                BuildsUp,
            ),
            ("a grip that decays within 3 s", &|t| 0.5 / (1.0 - 0.6 * t / 3.0), BuildsUp),
            ("a mass poured in 6 s", &|t| 0.5 * (1.0 + t / 6.0), BuildsUp),
            ("a ramp of 0.3 s after a hold", &|t| 0.3 + 0.2 * ((t + 0.3) / 0.3).clamp(0.0, 1.0), BuildsUp),
            ("a sway of 1 Hz", &|t| 0.4 + 0.1 * (std::f64::consts::TAU * t).cos(), BuildsUp),
            ("a ramp of 0.1 s after a hold", &|t| 0.3 + 0.2 * ((t + 0.1) / 0.1).clamp(0.0, 1.0), Sudden),
            ("a lift-off straight into the slip", &|t| 0.5 * ((t + 0.15) / 0.15).clamp(0.0, 1.0), Sudden),
            ("a knock after a hold", &|t| 0.35 + 0.5 * knock(t), Sudden),
            ("taken up, held, knocked", &|t| taken_up(t) + 0.5 * knock(t), Sudden),
            ("shaken at 8 Hz", &|t| 0.35 + 0.15 * (8.0 * std::f64::consts::TAU * t).cos(), Sudden),
            ("friction falls under a load that stays", &|_| 0.5, Sudden),
            ("not measured", &|_| f64::NAN, Sudden),
        ];
        for (what, ratio_at, expected) in courses {
            for seed in 0..5 {
                let t: Vec<f64> = (0..600).map(|i| f64::from(i) * 0.004).collect();
                // 0.5 % of noise, as forces within 0.02 N leave after smoothing.
                let noise = |i: f64| 0.0025 * (1.9 * i + 0.7 * i * i + f64::from(seed)).sin();
                let ratio: Vec<f64> = t
                    .iter()
                    .enumerate()
                    .map(|(i, t)| ratio_at((t - 2.0).min(0.0)) + noise(i as f64))
                    .collect();
                assert_eq!(cause(&t, &ratio, 2.0, 0.1), expected, "{what}, noise {seed}");
            }
        }
    }

    #[test]
    fn a_longer_lead_needs_a_longer_course() {
        let t: Vec<f64> = (0..600).map(|i| f64::from(i) * 0.004).collect();
        let ratio: Vec<f64> = t.iter().map(|t| 0.3 + 0.2 * ((t - 1.6) / 0.4).clamp(0.0, 1.0)).collect();
        assert_eq!(cause(&t, &ratio, 2.0, 0.1), Cause::BuildsUp);
        assert_eq!(cause(&t, &ratio, 2.0, 0.36), Cause::Sudden);
        assert_eq!(cause(&t[..400], &ratio[..400], 9.0, 0.1), Cause::Sudden);
    }
}
