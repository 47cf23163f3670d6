//! Causes that build up and sudden ones.

use stickslip_analysis::score::cause::*;

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
            let ratio: Vec<f64> =
                t.iter().enumerate().map(|(i, t)| ratio_at((t - 2.0).min(0.0)) + noise(i as f64)).collect();
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
