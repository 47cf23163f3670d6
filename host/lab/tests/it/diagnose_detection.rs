//! What a diagnosis says of effects that it did not find.

use stickslip_analysis::diagnose::report::{Report, Verdict};

use crate::diagnose_inputs::{found, made, nothing_hidden};

fn upper(report: &Report, effect: &str, strength: &str) -> f64 {
    report.limits_on_effects[effect][strength].upper.unwrap_or(f64::INFINITY)
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_small_mass_error_that_is_not_named_lies_below_its_limit() {
    let report = found(&made("mass_error=0.05", 8, |_| true));
    assert!(report.effects.is_empty(), "{}", report.summary);
    let limit = upper(&report, "mass_error", "fraction");
    assert!(limit > 0.05, "{limit}");
}

#[test]
fn where_nothing_is_missing_a_loss_of_grip_of_a_tenth_is_excluded_and_named_where_it_is_there() {
    let nothing = nothing_hidden();
    assert_eq!(nothing.verdict, Verdict::NothingMissing, "{}", nothing.summary);
    let mentioned: Vec<&str> = nothing.weaker.iter().map(|c| c.id).collect();
    assert!(mentioned.is_empty(), "{mentioned:?}");
    let limit = upper(nothing, "grip_force_loss", "fraction");
    assert!(limit > 0.0 && limit < 0.1, "{limit}");
    // What is not excluded has a limit above its typical strength, or none.
    let open = |id: &str| {
        nothing.limits_on_effects[id].values().any(|l| l.upper.is_none_or(|upper| upper > l.plausible))
    };
    assert!(nothing.not_excluded.iter().all(|id| open(id)), "{:?}", nothing.not_excluded);
    assert!(!nothing.not_excluded.contains(&"grip_force_loss"), "{:?}", nothing.not_excluded);
    let lost = found(&made("grip_force_loss=0.1", 8, |_| true));
    let named =
        |id: &str| lost.effects.contains(&id) || lost.ambiguous_with.iter().flatten().any(|e| *e == id);
    assert!(named("grip_force_loss"), "{}", lost.summary);
    // Wrong sensors read the same where all of them are wrong alike.
    let alike = |report: &Report| {
        report.classes.iter().any(|c| c.contains(&"grip_force_loss") && c.contains(&"sensor_gain"))
    };
    assert!(alike(nothing), "{:?}", nothing.classes);
}
