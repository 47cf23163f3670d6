//! What a diagnosis says of effects that it did not find.

use stickslip_analysis::diagnose::diagnose;
use stickslip_analysis::diagnose::report::{Report, Verdict};
use stickslip_analysis::model::file::default_model;
use stickslip_lab::blind::generate::{Class, Plan, Wanted, data, draw};

fn found(hidden: &[&str]) -> Report {
    let effects: Vec<_> = hidden.iter().map(|h| h.parse().unwrap()).collect();
    let class = effects.is_empty().then_some(Class::Nothing);
    let wanted = Wanted { effects, class, plan: Some(Plan::Push), strength: None };
    let (key, list) = draw(7, 0, 8, &wanted);
    diagnose(&data(&key, &list, 7).unwrap(), &default_model(), &[], &()).unwrap()
}

fn upper(report: &Report, effect: &str, strength: &str) -> f64 {
    report.limits_on_effects[effect][strength].upper.unwrap_or(f64::INFINITY)
}

#[test]
fn a_small_mass_error_that_is_not_named_lies_below_its_limit() {
    let report = found(&["mass_error=0.05"]);
    assert!(report.effects.is_empty(), "{}", report.summary);
    let limit = upper(&report, "mass_error", "fraction");
    assert!(limit > 0.05, "{limit}");
}

#[test]
fn where_nothing_is_missing_a_loss_of_grip_of_a_tenth_is_excluded_and_named_where_it_is_there() {
    let nothing = found(&[]);
    assert_eq!(nothing.verdict, Verdict::NothingMissing, "{}", nothing.summary);
    let limit = upper(&nothing, "grip_force_loss", "fraction");
    assert!(limit > 0.0 && limit < 0.1, "{limit}");
    let lost = found(&["grip_force_loss=0.1"]);
    let named =
        |id: &str| lost.effects.contains(&id) || lost.ambiguous_with.iter().flatten().any(|e| *e == id);
    assert!(named("grip_force_loss"), "{}", lost.summary);
    // Wrong sensors read the same where all of them are wrong alike.
    let alike = |report: &Report| {
        report.classes.iter().any(|c| c.contains(&"grip_force_loss") && c.contains(&"sensor_gain"))
    };
    assert!(alike(&nothing), "{:?}", nothing.classes);
}
