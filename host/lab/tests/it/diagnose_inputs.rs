//! What a diagnosis says about data from which little can be concluded, and about models that
//! bring their own effects.

use std::sync::OnceLock;

use stickslip_analysis::diagnose::report::{Report, Verdict};
use stickslip_analysis::diagnose::{base_misfit, diagnose};
use stickslip_analysis::evidence::conditions::condition_of;
use stickslip_analysis::model::candidate::CandidateEffect;
use stickslip_analysis::model::file::{ModelFile, default_model};
use stickslip_data::{Dataset, Sample, TrialInfo, read, write};
use stickslip_lab::blind::generate::{Class, Key, Plan, Wanted, data, draw};
use stickslip_rig::Condition;
use stickslip_shared::effects::Effect;

fn drawn(hidden: &str, conditions: usize) -> (Key, Vec<(Condition, usize)>) {
    let effects = if hidden.is_empty() { Vec::new() } else { vec![hidden.parse().unwrap()] };
    let class = effects.is_empty().then_some(Class::Nothing);
    let wanted = Wanted { effects, class, plan: Some(Plan::Push), strength: None };
    let (key, mut list) = draw(7, 0, 8, &wanted);
    let mut labels: Vec<String> = list.iter().map(|(c, _)| c.label.clone()).collect();
    labels.sort();
    labels.dedup();
    labels.truncate(conditions);
    list.retain(|(c, _)| labels.contains(&c.label));
    (key, list)
}

pub fn made(hidden: &str, conditions: usize, keep: impl Fn(usize) -> bool) -> Dataset {
    let (key, mut list) = drawn(hidden, conditions);
    list.retain(|(_, run)| keep(*run));
    data(&key, &list, 7).unwrap()
}

/// The same data, written to files and read again.
fn filed(dataset: &Dataset) -> Dataset {
    let folder = tempfile::tempdir().unwrap();
    write(dataset, folder.path()).unwrap();
    read(folder.path()).unwrap()
}

/// From file to verdict.
pub fn found(dataset: &Dataset) -> Report {
    diagnose(&filed(dataset), &default_model(), &[], &()).unwrap()
}

/// Where the model lacks nothing.
pub fn nothing_hidden() -> &'static Report {
    static REPORT: OnceLock<Report> = OnceLock::new();
    REPORT.get_or_init(|| found(&made("", 8, |_| true)))
}

fn says(report: &Report, what: &str) {
    assert!(report.limits.iter().any(|l| l.contains(what)), "{what}: {:?}", report.limits);
}

#[test]
fn an_empty_data_set_is_refused_with_its_reason() {
    let mut dataset = made("", 1, |run| run == 1);
    dataset.trials.clear();
    let error = diagnose(&dataset, &default_model(), &[], &()).unwrap_err().to_string();
    assert!(error.contains("no trial"), "{error}");
}

#[test]
fn one_condition_concludes_nothing_however_wrong_the_model_is() {
    let report = found(&made("grip_force_loss=0.3", 1, |_| true));
    assert_eq!(report.verdict, Verdict::Inconclusive);
    assert!(report.summary.contains("Nothing can be concluded"), "{}", report.summary);
    let (reason, tell) = (report.reason.as_deref().unwrap(), report.would_tell.as_deref().unwrap());
    assert!(reason.contains("1 different condition(s), at least 4 are needed"), "{reason}");
    assert!(tell.contains("run 3 more condition(s)"), "{tell}");
    says(&report, "at least 4 conditions");
}

/// No law of the list: a torque of the pusher that goes with the square of the path, up to `most_nm` of a trial.
fn with_torque(clean: &Dataset, most_nm: impl Fn(&TrialInfo) -> f64) -> Dataset {
    let mut dataset = clean.clone();
    for trial in &mut dataset.trials {
        let x = |s: &Sample| s.gripper.map_or(0.0, |g| g.position_m[0]);
        let (start_m, end_m) = (x(&trial.samples[0]), x(&trial.samples[trial.samples.len() - 1]));
        let most_nm = most_nm(&trial.info);
        for sample in &mut trial.samples {
            let share = (x(sample) - start_m) / (end_m - start_m);
            sample.pusher_wrench.as_mut().unwrap().torque_nm[0] += most_nm * share * share;
        }
    }
    dataset
}

#[test]
fn a_clear_misfit_of_no_law_that_is_listed_is_unexplained() {
    let report = found(&with_torque(&made("", 8, |_| true), |_| 0.1));
    assert_eq!(report.verdict, Verdict::Unexplained, "{}", report.summary);
    assert!(report.effects.is_empty(), "{:?}", report.effects);
    assert!(
        report.places[0].before > 4.0 && report.places[0].channel.contains("pusher"),
        "{:?}",
        report.places[0]
    );
    assert!(!report.unexplained.is_empty(), "what is left is described");
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_cable_that_pulls_at_the_object_is_named_with_its_force() {
    let report = found(&made("external_force=1.2", 8, |_| true));
    assert!(report.effects.contains(&"external_force"), "{}", report.summary);
    for (name, hidden_n) in [("x_n", 0.8), ("y_n", 0.4), ("z_n", -0.8)] {
        let found = &report.parameters[&format!("external_force.{name}")];
        // Constant errors of three sensors, each within what is stated, are part of it.
        assert!((found.value - hidden_n).abs() < 0.3, "{name}: {} for {hidden_n}", found.value);
    }
    assert!(report.error.after < 1.3 * report.error.perfect_model, "{:?}", report.error);
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_wrong_mass_comes_before_a_force_that_does_as_well() {
    let report = found(&made("mass_error=1.0", 8, |_| true));
    assert_eq!(report.effects, ["mass_error"], "{}", report.summary);
    let fraction = &report.parameters["mass_error.fraction"];
    assert!((fraction.value - 1.0).abs() < 0.2, "{}", fraction.value);
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_misfit_that_one_condition_alone_shows_is_inconclusive() {
    let clean = made("", 8, |_| true);
    let of = condition_of(&clean.trials.iter().map(|trial| trial.info.clone()).collect::<Vec<_>>());
    let one: Vec<String> = (clean.trials.iter().zip(&of).filter(|(_, at)| **at == of[0]))
        .map(|(trial, _)| trial.info.trial.clone())
        .collect();
    let report = found(&with_torque(&clean, |info| if one.contains(&info.trial) { 0.1 } else { 0.0 }));
    assert_eq!(report.verdict, Verdict::Inconclusive, "{}", report.summary);
    let (reason, tell) = (report.reason.as_deref().unwrap(), report.would_tell.as_deref().unwrap());
    // Friction follows the one condition, so that the largest misfit may stand in another.
    assert!(reason.contains("mostly in one condition"), "{reason}");
    assert!(tell.contains("run conditions near it"), "{tell}");
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_misfit_between_relevant_and_clear_that_nothing_explains_is_inconclusive() {
    let clean = made("", 8, |_| true);
    let with = |most_nm: f64| with_torque(&clean, |_| most_nm);
    // What counts is what remains once friction and offsets have taken their share of it, which depends
    // on how large it is beside them: the size is set by that, near the middle of the range.
    let (mut low_nm, mut high_nm) = (0.0, 0.5);
    let remains = |nm: f64| base_misfit(&with(nm), &default_model()).unwrap().worst();
    let (noise, large) = (remains(low_nm), remains(high_nm));
    assert!(noise < 2.5 && large > 10.0, "{noise} {large}");
    let mut most_nm = high_nm * 3.2 / large;
    let mut now = remains(most_nm);
    while (now - 3.2).abs() > 0.2 {
        if now < 3.2 {
            low_nm = most_nm
        } else {
            high_nm = most_nm
        }
        most_nm = (most_nm * 3.2 / now).clamp(0.9 * low_nm + 0.1 * high_nm, 0.1 * low_nm + 0.9 * high_nm);
        now = remains(most_nm);
    }
    let report = found(&with(most_nm));
    let worst = report.places[0].before;
    assert!(worst > 2.5 && worst < 4.0, "{worst}");
    assert_eq!(report.verdict, Verdict::Inconclusive, "{}", report.summary);
    let reason = report.reason.as_deref().unwrap();
    assert!(reason.contains("pusher torque x") && reason.contains("no effect explains it"), "{reason}");
    assert!(report.would_tell.as_deref().unwrap().contains("repeat the condition of trial"));
}

#[test]
#[ignore = "long: make test-host-rest"]
fn without_repetitions_a_strong_effect_is_found_as_the_best_candidate_and_the_doubt_is_told() {
    let report = found(&made("finger_friction_mismatch=0.3", 8, |run| run == 1));
    says(&report, "no repetitions");
    assert_ne!(report.verdict, Verdict::NothingMissing, "{}", report.summary);
    // Best on held-out conditions, as the report puts them in order.
    assert_eq!(report.candidates[0].id, "finger_friction_mismatch", "{}", report.summary);
    assert!(report.effects.contains(&"finger_friction_mismatch"), "{}", report.summary);
    assert!(report.error.after < 0.25 * report.error.before, "{:?}", report.error);
    let mismatch = &report.parameters["finger_friction_mismatch.mismatch"];
    assert!((mismatch.value / 0.3 - 1.0).abs() < 0.05, "{mismatch:?}");
}

#[test]
#[ignore = "long: make test-host-rest"]
fn channels_that_were_not_measured_are_named_as_a_limit() {
    let mut dataset = made("finger_friction_mismatch=0.3", 8, |_| true);
    for sample in dataset.trials.iter_mut().flat_map(|t| &mut t.samples) {
        sample.pusher_wrench = None;
    }
    let report = found(&dataset);
    says(&report, "the pusher's forces: not measured");
    assert!(report.effects.contains(&"finger_friction_mismatch"), "{}", report.summary);
    for sample in dataset.trials.iter_mut().flat_map(|t| &mut t.samples) {
        sample.finger = [None; 2];
    }
    let blind = found(&dataset);
    says(&blind, "the fingers' forces: not measured");
    let unseen = blind.limits.iter().find(|l| l.starts_with("not visible in these data"));
    assert!(unseen.is_some_and(|l| l.contains("sensor_gain")), "{:?}", blind.limits);
}

#[test]
#[ignore = "long: make test-host-rest"]
fn forces_that_swing_while_the_object_slides_are_never_nothing_missing() {
    let mut dataset = made("", 8, |_| true);
    assert_eq!(nothing_hidden().verdict, Verdict::NothingMissing);
    for trial in &mut dataset.trials {
        let x: Vec<f64> = trial.samples.iter().map(|s| s.gripper.map_or(0.0, |g| g.position_m[0])).collect();
        for (i, sample) in trial.samples.iter_mut().enumerate().skip(1) {
            let moves = (x[i] - x[i - 1]).abs() > 1e-6;
            // A push that swings by 14 % rms: plus on the pusher, minus on the fingers.
            let push_n = &mut sample.pusher_wrench.as_mut().unwrap().force_n[0];
            let swing = if moves { 0.2 * (std::f64::consts::TAU * 31.0 * sample.t_s).sin() } else { 0.0 };
            let swing_n = swing * *push_n;
            *push_n += swing_n;
            sample.finger.iter_mut().for_each(|f| f.as_mut().unwrap().force_n[0] -= 0.5 * swing_n);
        }
    }
    let report = found(&dataset);
    assert_eq!(report.verdict, Verdict::Unexplained, "{}", report.summary);
    assert!(report.summary.contains("oscillates by"), "{}", report.summary);
    // What is missing may hide anything.
    assert!(report.limits_on_effects.is_empty());
    let swing = report.unexplained.iter().find(|u| u.phase == "swing in sliding").unwrap();
    assert!(swing.channel.ends_with("_fx_n") && swing.size > 10.0, "{swing:?}");
}

#[test]
#[ignore = "long: make test-host-rest"]
fn contacts_that_load_over_a_tenth_of_a_millimetre_are_no_missing_effect() {
    let mut dataset = made("", 8, |_| true);
    // The forces take up a change over 60 um of the gripper's travel, as bristles do; levels stay.
    let length_m = 6e-5;
    for trial in &mut dataset.trials {
        let x: Vec<f64> = trial.samples.iter().map(|s| s.gripper.map_or(0.0, |g| g.position_m[0])).collect();
        let mut before = trial.samples[0];
        for (i, sample) in trial.samples.iter_mut().enumerate().skip(1) {
            let moved_m = (x[i] - x[i - 1]).abs();
            let share = if moved_m < 1e-6 { 1.0 } else { moved_m / (moved_m + length_m) };
            let towards = |to: &mut [f64; 3], from: &[f64; 3]| {
                to.iter_mut().zip(from).for_each(|(to, from)| *to = from + share * (*to - from));
            };
            let wrenches = sample.finger.iter_mut().chain([&mut sample.pusher_wrench]);
            for (to, from) in wrenches.zip(before.finger.iter().chain([&before.pusher_wrench])) {
                if let (Some(to), Some(from)) = (to.as_mut(), from) {
                    towards(&mut to.force_n, &from.force_n);
                    towards(&mut to.torque_nm, &from.torque_nm);
                }
            }
            before = *sample;
        }
    }
    let report = found(&dataset);
    assert_eq!(report.verdict, Verdict::NothingMissing, "{}", report.summary);
}

#[test]
#[ignore = "long: make test-host-rest"]
fn forces_that_do_not_balance_are_never_nothing_missing() {
    let mut dataset = made("", 8, |_| true);
    for sample in dataset.trials.iter_mut().flat_map(|t| &mut t.samples) {
        sample.pusher_wrench.as_mut().unwrap().force_n[2] -= 2.5;
    }
    let report = found(&dataset);
    assert_ne!(report.verdict, Verdict::NothingMissing, "{}", report.summary);
    let told = report.limits.iter().chain([&report.summary]).any(|l| l.contains("do not balance"));
    assert!(told, "{} {:?}", report.summary, report.limits);
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_model_that_has_the_effect_lacks_nothing_and_its_parameters_are_fitted() {
    let mut model = default_model();
    let _ = model.effects.push(Effect::typical("grip_force_loss").unwrap());
    let report = diagnose(&made("grip_force_loss=0.3", 8, |_| true), &model, &[], &()).unwrap();
    assert_eq!(report.verdict, Verdict::NothingMissing, "{}", report.summary);
    says(&report, "already has grip_force_loss");
    let fraction = report.parameters["grip_force_loss.fraction"].value;
    assert!((fraction - 0.3).abs() < 0.03, "{fraction}");
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_formula_of_the_user_is_ranked_beside_the_listed_effects() {
    let text = r#"
format = "stickslip-model/1"
base = "hard"
[friction]
finger = 0.4
pusher = 0.25
support = 0.3
[[effects]]
id = "formula"
name = "weak_jaw"
target = "grip"
expression = "1 - a"
parameters = { a = { value = 0.1, low = 0, high = 0.6, unit = "1" } }
"#;
    let (model, own) = ModelFile::parse(text, "model.toml").unwrap().without_proposals();
    let own: Vec<CandidateEffect> = own.iter().filter_map(CandidateEffect::of).collect();
    let report = diagnose(&made("grip_force_loss=0.3", 8, |_| true), &model, &own, &()).unwrap();
    let candidate = report.candidates.iter().find(|c| c.id == "weak_jaw").expect("refitted");
    assert!((candidate.parameters["a"].value - 0.3).abs() < 0.03, "{:?}", candidate.parameters);
    assert!(candidate.explained > 0.9, "{}", report.summary);
    // The formula is the law of an effect of the list: no data separate the two.
    assert_eq!(report.verdict, Verdict::Ambiguous, "{}", report.summary);
}

#[test]
fn friction_that_drifts_with_the_order_of_trials_is_named_wear() {
    let report = found(&made("wear_drift=-0.3", 8, |_| true));
    assert_eq!(report.verdict, Verdict::Effect, "{}", report.summary);
    assert_eq!(report.effects, ["wear_drift"], "{}", report.summary);
    assert!(report.error.after < 0.8 * report.error.before, "{:?}", report.error);
}
