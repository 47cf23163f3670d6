//! Comparison: errors of known signals, phases of a synthetic trace, tests against their
//! definitions, and what the reports hold.

use std::path::Path;

use stickslip_analysis::channels::{COUNT, NAMES};
use stickslip_analysis::compare::document::Fate;
use stickslip_analysis::compare::noise::Source;
use stickslip_analysis::compare::tare::Tare;
use stickslip_analysis::compare::trial::Cell;
use stickslip_analysis::compare::{Forces, NamedModel, Options, compare, noise::sensor_noise};
use stickslip_analysis::evidence::conditions::{HeldOut, conditions};
use stickslip_analysis::evidence::contact::Evidence;
use stickslip_analysis::evidence::phases::{PHASES, Phase, split};
use stickslip_analysis::evidence::statistics::{critical_f, holm, lack_of_fit, regression};
use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::replay;
use stickslip_analysis::run::simulate::prepare;
use stickslip_data::{Dataset, Index, Trial, TrialInfo};
use stickslip_rig::objects::{bench, trimmed};
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, simulate};
use stickslip_shared::predictor::{Limits, Prediction};

const SEED: u64 = 11;

/// Short linear pushes at two grips, made by the rig with friction 0.4 and 0.25.
fn pushes(runs: usize, nuisance: Nuisance) -> Dataset {
    let description = trimmed(bench("pushes"), &["linear_push"], &["obj4"]);
    let mut reality = Reality::draw(&description, nuisance, SEED);
    (reality.mu_finger, reality.mu_pusher) = (0.4, 0.25);
    let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
    let mut trials = Vec::new();
    for grip_n in [20.0, 35.0] {
        let mut condition = Condition::new(Primitive::LinearPush, "obj4");
        condition.label = format!("g{grip_n}");
        (condition.grip_n, condition.speed_m_s, condition.travel) = (grip_n, 0.02, 0.006);
        for run in 0..runs {
            trials.push(simulate(&setup, &condition, run, SEED).expect("a trial"));
        }
    }
    Dataset { folder: "pushes".into(), description, trials }
}

fn named(name: &str, finger: f64) -> NamedModel {
    let mut model = default_model();
    model.friction.finger = finger;
    NamedModel::own(name, "test", model)
}

#[test]
fn errors_of_hand_made_signals_are_their_mean_rms_and_largest() {
    let cell = Cell::of(&[1.0, -3.0, f64::NAN, 2.0, 4.0]);
    assert_eq!(cell.samples, 4);
    assert!((cell.bias() - 1.0).abs() < 1e-12);
    assert!((cell.mean_square() - 30.0 / 4.0).abs() < 1e-12);
    assert!((cell.largest() - 4.0).abs() < 1e-12);
    let tared = cell.shifted(-1.0);
    assert!(tared.bias().abs() < 1e-12);
    // Sum of squares of 0, -4, 1, 3.
    assert!((tared.mean_square() - 26.0 / 4.0).abs() < 1e-12);
    assert!((tared.largest() - 4.0).abs() < 1e-12);
}

#[test]
fn lack_of_fit_is_the_ratio_of_mean_squares() {
    // Means 2 and -2 of two runs each; pure error variance 0.5 each.
    let of = |groups: &[Vec<f64>]| lack_of_fit(groups, groups);
    let found = of(&[vec![1.5, 2.5], vec![-1.5, -2.5]]).expect("repetitions");
    assert!((found.pure_error - 0.5f64.sqrt()).abs() < 1e-12);
    assert!((found.f - (2.0 * 4.0 + 2.0 * 4.0) / 2.0 / 0.5).abs() < 1e-12);
    assert!(of(&[vec![1.0], vec![2.0]]).is_none(), "no repetitions, no test");
    let centred = of(&[vec![-0.5, 0.5], vec![0.4, -0.4]]).expect("repetitions");
    assert!(centred.f.abs() < 1e-12 && centred.p > 0.99);
    // Chance as the measurement shows it: half as wide, four times the ratio.
    let narrow = [vec![0.25, -0.25], vec![0.25, -0.25]];
    let sharper = lack_of_fit(&[vec![1.5, 2.5], vec![-1.5, -2.5]], &narrow).expect("repetitions");
    assert!((sharper.f / found.f - 4.0).abs() < 1e-9);
}

#[test]
fn the_critical_ratio_is_that_of_the_tables() {
    // F(1, 2) at 1 % and F(4, 10) at 5 %, as printed in tables of the distribution.
    for (of_fit, of_error, p, table) in [(1.0, 2.0, 0.01, 98.50), (4.0, 10.0, 0.05, 3.478)] {
        let found = critical_f(of_fit, of_error, p).expect("degrees of freedom");
        assert!((found / table - 1.0).abs() < 1e-3, "{found} of {table}");
    }
}

#[test]
fn holm_multiplies_the_smallest_by_their_number_and_never_lets_order_change() {
    let corrected = holm(&[0.04, 0.01, f64::NAN, 0.03]);
    assert!((corrected[1] - 0.03).abs() < 1e-12);
    assert!((corrected[3] - 0.06).abs() < 1e-12);
    assert!((corrected[0] - 0.06).abs() < 1e-12, "not below that of the smaller p");
    assert!(corrected[2].is_nan());
}

#[test]
fn regression_finds_slope_and_significance() {
    let exact: Vec<(f64, f64)> = (0..6).map(|k| (f64::from(k), 2.0 - 3.0 * f64::from(k))).collect();
    let line = regression(&exact, 2).expect("a line");
    assert!((line.slope + 3.0).abs() < 1e-12 && (line.intercept - 2.0).abs() < 1e-12);
    assert!(line.p < 1e-6);
    let flat = [(0.0, 1.0), (1.0, -1.0), (2.0, 1.0), (3.0, -1.0), (4.0, 1.0)];
    assert!(regression(&flat, 2).expect("a line").p > 0.5);
}

#[test]
fn a_push_is_split_where_contact_and_sliding_begin() {
    let data = pushes(1, Nuisance::PAPER);
    let trial = &data.trials[0];
    let prepared = prepare(&data.description, trial, 0).expect("prepared");
    let simulated = prepared.simulate(&default_model());
    let phases = split(&prepared, &simulated, &sensor_noise(&data.description));
    assert_eq!((phases.contact, phases.motion), (Evidence::Measured, Evidence::Measured));
    let mut at = 0;
    for phase in PHASES {
        let range = phases.range(phase);
        assert_eq!(range.start, at, "phases follow each other");
        at = range.end;
    }
    assert_eq!(at, trial.samples.len());
    // Before contact the pusher's force is its offset alone; while sliding it is near 2 mu N.
    let force = |phase: Phase| {
        let rows = &prepared.measured[phases.range(phase)];
        rows.iter().map(|s| s[18]).sum::<f64>() / rows.len() as f64
    };
    let push = (force(Phase::Sliding) - force(Phase::BeforeContact)).abs();
    assert!((push - 2.0 * 0.4 * 20.0).abs() < 1.5, "{push}");
    // While sliding the object moves with the pushing speed, before onset it does not.
    let moved = |phase: Phase| {
        let range = phases.range(phase);
        (prepared.measured[range.end - 1][0] - prepared.measured[range.start][0]).abs()
    };
    assert!(moved(Phase::Sliding) > 4e-3 && moved(Phase::BeforeContact) < 2e-4);
}

#[test]
fn the_true_friction_agrees_better_than_a_wrong_one_and_the_failures_are_gone() {
    let data = pushes(3, Nuisance::PAPER);
    let models = [named("wrong", 0.3), named("right", 0.4)];
    let c = compare(&data.clone().into(), &models, &Options::default(), &()).expect("compared");
    let row = |model: usize| {
        let rows = &c.models[model].errors;
        rows.iter()
            .find(|r| r.place.channel == "pusher_fx_n" && r.place.phase == Phase::Sliding)
            .expect("pusher force")
    };
    // 2 (0.4 - 0.3) N at 20 N and 35 N.
    let size = row(0).error.rms;
    assert!((size - (0.5f64 * (4.0 * 4.0 + 7.0 * 7.0)).sqrt()).abs() < 0.7, "{size}");
    assert!(row(1).error.rms < 0.25 * size);
    assert!(row(0).fails);
    assert_eq!(c.data.noise_floor, Source::Repetitions);
    assert!(c.changes.iter().any(|c| c.fate == Fate::Gone || c.fate == Fate::Smaller));
    assert!(c.summary.contains("From wrong to right"), "{}", c.summary);
}

#[test]
fn without_a_model_friction_is_calibrated_to_what_the_rig_has() {
    let data = pushes(1, Nuisance { friction_run: 0.0, ..Nuisance::PAPER });
    let c = compare(&data.clone().into(), &[], &Options::default(), &()).expect("compared");
    let friction = &c.models[0].friction;
    assert!((friction["finger"] - 0.4).abs() < 0.02, "{friction:?}");
    assert!(c.models[0].origin.contains("calibrated"), "{}", c.models[0].origin);
}

#[test]
fn friction_is_told_of_the_contacts_that_a_primitive_has() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let mut index = Index::open(&folder).expect("the demo");
    // The first three are one of each primitive.
    index.trials.truncate(3);
    let told = |models: &[NamedModel], options: &Options| -> Vec<String> {
        let c = compare(&index, models, options, &()).expect("compared");
        c.models[0].friction.keys().cloned().collect()
    };
    // The demo's pushers are a plate at the side, an edge, and a platform under the object.
    let own = [
        "linear_push.finger",
        "linear_push.pusher",
        "pivot.finger",
        "pivot.pusher",
        "roll.finger",
        "roll.support",
    ];
    assert_eq!(told(&[], &Options::default()), own);
    let model = [named("one", 0.4)];
    assert_eq!(told(&model, &Options::default()), ["finger", "pusher", "support"]);
    let trial = index.trials.iter().find(|i| i.primitive == "pivot").map(|i| i.trial.clone());
    assert_eq!(told(&model, &Options { trial, ..Options::default() }), ["finger", "pusher"]);
}

#[test]
fn one_noise_floor_serves_all_models_whatever_their_order() {
    let data = pushes(3, Nuisance::PAPER);
    let (wrong, right) = (named("wrong", 0.3), named("right", 0.4));
    let floors = |models: &[NamedModel]| {
        let options = Options { forces: Forces::AsReturned, ..Options::default() };
        let c = compare(&data.clone().into(), models, &options, &()).expect("compared");
        let of = |m: usize| {
            let mut rows = c.models[m].errors.clone();
            rows.sort_by(|a, b| a.place.cmp(&b.place));
            rows.iter().map(|r| r.noise_floor.expect("repeated")).collect::<Vec<f64>>()
        };
        assert!(of(0) == of(1), "one floor for both");
        of(0)
    };
    let (one, other) = (floors(&[wrong.clone(), right.clone()]), floors(&[right, wrong]));
    let apart = one.iter().zip(&other).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    assert!(one.len() == other.len() && apart < 1e-6, "{apart}");
}

#[test]
fn without_repetitions_the_report_says_that_fit_cannot_be_tested() {
    let data = pushes(1, Nuisance::PAPER);
    let c = compare(&data.clone().into(), &[named("m", 0.4)], &Options::default(), &()).expect("compared");
    assert_eq!(c.data.noise_floor, Source::SensorNoise);
    assert!(c.models[0].errors.iter().all(|r| r.lack_of_fit.is_none() && !r.fails));
    assert!(c.notes.iter().any(|n| n.contains("cannot be tested")), "{:?}", c.notes);
    assert!(c.summary.contains("condition was run more than once"), "{}", c.summary);
    assert!(!c.summary.contains("times"), "no multiple of the sensor noise is a verdict: {}", c.summary);
}

#[test]
fn of_unrepeated_data_only_what_lasts_and_exceeds_the_stated_uncertainty_contradicts_a_model() {
    let mut data = pushes(1, Nuisance::PAPER);
    // Far beyond the noise at the touch, for two samples.
    for sample in
        data.trials.iter_mut().flat_map(|t| &mut t.samples).filter(|s| (0.2..0.208).contains(&s.t_s))
    {
        if let Some(w) = &mut sample.pusher_wrench {
            w.force_n[0] -= 30.0;
        }
    }
    let of = |finger| {
        compare(&data.clone().into(), &[named("m", finger)], &Options::default(), &()).expect("compared")
    };
    let (right, wrong) = (of(0.4), of(0.3));
    assert!(right.summary.contains("Nothing in these unrepeated trials contradicts"), "{}", right.summary);
    // 4 to 7 N in the push, where the sensor may be off by 0.75 N.
    assert!(wrong.summary.contains("does not agree"), "{}", wrong.summary);
    let sustained: Vec<&str> = wrong.models[0]
        .errors
        .iter()
        .filter(|r| r.sustained == Some(true))
        .map(|r| r.place.channel)
        .collect();
    assert!(sustained.contains(&"pusher_fx_n"), "{sustained:?}");
}

/// A model's own figures, in an order that does not depend on them.
#[test]
fn sensors_that_state_nothing_have_an_estimated_floor_and_bound_and_never_zero() {
    let stated = pushes(1, Nuisance::PAPER);
    let mut silent = stated.clone();
    silent.description.sensors = Default::default();
    let options = Options { forces: Forces::AsReturned, ..Options::default() };
    let of = |data: &Dataset| {
        compare(&data.clone().into(), &[named("true", 0.4)], &options, &()).expect("a comparison")
    };
    let (known, estimated) = (of(&stated), of(&silent));
    assert_eq!(estimated.data.noise_floor, Source::SensorNoise);
    let told = estimated.notes.iter().find(|n| n.contains("taken from the data")).expect("a note");
    assert!(told.contains("finger.force_noise_n") && told.contains("1 % of the largest reading"), "{told}");
    assert!(!known.notes.iter().any(|n| n.contains("taken from the data")), "{:?}", known.notes);
    for row in &known.models[0].errors {
        let same = estimated.models[0].errors.iter().find(|r| r.place == row.place).expect("the same rows");
        let (a, b) = (row.noise_floor.expect("a floor"), same.noise_floor.expect("a floor"));
        // The root mean square over the axes stands for each.
        assert!((b / a - 1.0).abs() < 0.35, "{:?}: {a} {b}", row.place);
    }
    let bound = &estimated.models[0].offsets.channels;
    let forces = bound.iter().filter(|c| c.unit == "N" && !c.channel.starts_with("pusher"));
    assert!(
        forces.clone().count() > 0 && forces.clone().all(|c| (0.1..0.5).contains(&c.stated_bound)),
        "{bound:?}"
    );
}

fn own(c: &stickslip_analysis::compare::document::Comparison, name: &str) -> Vec<(String, bool, f64, f64)> {
    let report = c.models.iter().find(|m| m.name == name).expect("compared");
    let mut rows: Vec<_> = report
        .errors
        .iter()
        .map(|r| {
            let place = format!("{}-{}-{:?}", r.place.primitive, r.place.channel, r.place.phase);
            (place, r.fails, r.error.rms, r.noise_floor.unwrap_or(-1.0))
        })
        .collect();
    rows.sort_by(|a, b| a.0.cmp(&b.0));
    rows
}

#[test]
fn a_models_failures_do_not_depend_on_what_stands_beside_it() {
    let data = pushes(2, Nuisance::PAPER);
    let mut loose = named("loose", 0.3);
    loose.model.friction.pusher = 0.7;
    let (base, other) = (named("base", 0.3), named("other", 0.42));
    let of = |models: &[&NamedModel]| {
        let models: Vec<NamedModel> = models.iter().map(|m| (*m).clone()).collect();
        own(&compare(&data.clone().into(), &models, &Options::default(), &()).expect("compared"), "base")
    };
    let alone = of(&[&base]);
    assert!(alone.iter().any(|r| r.1), "the wrong model fails somewhere");
    for beside in [of(&[&base, &loose]), of(&[&other, &base])] {
        assert!(alone == beside, "the same failures, errors and floors in any company");
    }
}

#[test]
fn a_model_that_leaves_more_open_gains_nothing_by_it() {
    let data = pushes(3, Nuisance::PAPER);
    let base = named("base", 0.3);
    // Nothing in the pushes moves along the plate: its friction only widens what sticking leaves open.
    let mut loose = named("loose", 0.3);
    loose.model.friction.pusher = 0.7;
    let c = compare(&data.clone().into(), &[base.clone(), loose.clone()], &Options::default(), &())
        .expect("compared");
    let open = |m: usize| c.models[m].open_force_n.expect("rigid");
    assert!(open(1) > 1.1 * open(0), "{} and {}: the width is part of the score", open(1), open(0));
    let tally = &c.tallies[0];
    assert!(tally.within_tolerance && tally.failures > 0);
    assert_eq!(tally.removed, 0, "judged by one tolerance: {}", c.summary);
    assert!(tally.after > 0.95 * tally.before, "judged by one tolerance: {}", c.summary);
    // Without any tolerance the counts are there too.
    assert!(!c.tallies[1].within_tolerance && c.summary.contains("Without any tolerance"), "{}", c.summary);
    let raw = Options { forces: Forces::AsReturned, ..Options::default() };
    let raw = compare(&data.clone().into(), &[base, loose], &raw, &()).expect("compared");
    let counts = |t: &stickslip_analysis::compare::document::Tally| [t.failures, t.removed, t.new];
    assert_eq!(counts(&raw.tallies[0]), counts(&c.tallies[1]), "the same both ways");
}

#[test]
fn a_failure_that_grows_is_called_larger() {
    let data = pushes(3, Nuisance::PAPER);
    let c =
        compare(&data.clone().into(), &[named("wrong", 0.3), named("worse", 0.22)], &Options::default(), &())
            .expect("compared");
    let push = c
        .changes
        .iter()
        .find(|c| c.place.channel == "pusher_fx_n" && c.place.phase == Phase::Sliding)
        .expect("pusher force");
    assert_eq!(push.fate, Fate::Larger);
    assert_eq!(stickslip_report::compare::fate_words(push.fate), "larger, still fails");
}

#[test]
fn the_residual_keeps_its_noise_where_the_error_is_within_the_tolerance() {
    let data = pushes(4, Nuisance::PAPER);
    let c =
        compare(&data.clone().into(), &[named("right", 0.4)], &Options::default(), &()).expect("compared");
    let row = c.models[0]
        .errors
        .iter()
        .find(|r| r.place.channel == "object_y_m" && r.place.phase == Phase::Sliding)
        .expect("a row");
    // Nothing moves across the push: 0.03 mm of noise, within 0.05 mm of tolerance in the mean.
    assert!((row.residual.rms / 3e-5 - 1.0).abs() < 0.3, "{:?}", row.residual);
    assert!(row.residual.multiples.is_some_and(|m| (0.7..1.6).contains(&m)), "{:?}", row.residual);
    assert!(row.error.rms < 0.2 * row.residual.rms, "{:?}", row.error);
}

#[test]
fn a_tare_takes_a_sensor_offset_out_but_not_a_wrong_grip() {
    let mut data = pushes(2, Nuisance::NONE);
    for sample in data.trials.iter_mut().flat_map(|t| &mut t.samples) {
        // An offset of the pusher, and both fingers 1 N more than commanded.
        if let Some(w) = &mut sample.pusher_wrench {
            w.force_n[0] += 0.5;
        }
        let [one, two] = &mut sample.finger;
        if let (Some(one), Some(two)) = (one, two) {
            one.force_n[1] -= 1.0;
            two.force_n[1] += 1.0;
        }
    }
    let c = compare(&data.clone().into(), &[named("m", 0.4)], &Options::default(), &()).expect("compared");
    let rows = &c.models[0].errors;
    let row = |channel: &str, phase: Phase| {
        rows.iter().find(|r| r.place.channel == channel && r.place.phase == phase).expect("a row")
    };
    let pusher = row("pusher_fx_n", Phase::BeforeContact);
    assert!(pusher.residual.mean.abs() < 1e-6 && (pusher.bias_with_offset + 0.5).abs() < 0.05);
    // Modelled less measured: finger 1 presses along -Y.
    assert!((row("finger1_fy_n", Phase::Sliding).residual.mean - 1.0).abs() < 0.05);
    assert!((row("finger2_fy_n", Phase::Sliding).residual.mean + 1.0).abs() < 0.05);
    let grip = c.models[0].offsets.grip.expect("both fingers are measured");
    assert!((grip.mean_n - 1.0).abs() < 0.05 && !grip.taken_out);

    let raw = Options { tare: Tare::None, ..Options::default() };
    let c = compare(&data.clone().into(), &[named("m", 0.4)], &raw, &()).expect("compared");
    let pusher = c.models[0].errors.iter().find(|r| r.place == pusher.place).expect("a row");
    assert!((pusher.residual.mean + 0.5).abs() < 0.05);
}

#[test]
fn equal_conditions_without_different_runs_are_no_repetitions() {
    let info = |run, grip_n| TrialInfo { run, grip_n, ..TrialInfo::default() };
    let infos = [
        info(Some(1), Some(20.0)),
        info(Some(2), Some(20.0)),
        info(Some(1), Some(22.0)),
        info(None, None),
        info(None, None),
        info(Some(2), Some(20.0)),
    ];
    assert_eq!(conditions(&infos), [vec![0, 1], vec![2], vec![3], vec![4], vec![5]]);
}

#[test]
fn held_out_conditions_are_whole_and_spread() {
    let data = pushes(3, Nuisance::PAPER);
    let infos: Vec<_> = data.trials.iter().map(|t| t.info.clone()).collect();
    assert_eq!(conditions(&infos).len(), 2);
    let mask = HeldOut::Share(0.5).mask(&infos).expect("one of two");
    assert_eq!(mask.iter().filter(|h| **h).count(), 3);
    assert!(mask[..3].iter().all(|h| *h == mask[0]) && mask[3..].iter().all(|h| *h == mask[3]));
    assert!(
        HeldOut::Trials(vec!["nobody".into()]).mask(&infos).expect_err("no such trial").contains("nobody")
    );
    assert!("1.5".parse::<HeldOut>().is_err());
}

#[test]
fn the_json_document_keeps_its_keys() {
    let data = pushes(2, Nuisance::PAPER);
    let c = compare(&data.clone().into(), &[named("m", 0.4)], &Options::default(), &()).expect("compared");
    let json = serde_json::to_value(&c).expect("JSON");
    assert_eq!(json["schema"], "stickslip-compare/2");
    let keys = |v: &serde_json::Value| -> Vec<String> {
        v.as_object().expect("an object").keys().cloned().collect()
    };
    assert_eq!(
        keys(&json),
        ["changes", "data", "models", "notes", "schema", "skipped", "summary", "tallies"]
    );
    let row = &json["models"][0]["errors"][0];
    let expected = [
        "bias_with_offset",
        "channel",
        "duration_s",
        "error",
        "fails",
        "lack_of_fit",
        "noise_floor",
        "noise_source",
        "phase",
        "primitive",
        "residual",
        "rms_with_offset",
        "sustained",
        "trials",
        "unit",
    ];
    assert_eq!(keys(row), expected);
    assert_eq!(keys(&row["residual"]), ["largest", "mean", "multiples", "rms"]);
    assert!(NAMES.contains(&row["channel"].as_str().expect("a name")));
}

#[test]
fn the_page_holds_its_figures_and_needs_nothing_from_elsewhere() {
    let data = pushes(2, Nuisance::PAPER);
    let c = compare(&data.clone().into(), &[named("a", 0.3), named("b", 0.4)], &Options::default(), &())
        .expect("compared");
    let page = stickslip_report::compare::page(&c, "stickslip diagnose x");
    // Both overlaid trials show every measured channel: those of the fingers share axes.
    let json = page
        .split_once("<script type=\"application/json\">")
        .and_then(|(_, rest)| rest.split_once("</script>"));
    let shown: serde_json::Value = serde_json::from_str(json.expect("traces").0).expect("JSON");
    let lines = |run: &serde_json::Value| -> usize {
        let plots = run["v"].as_array().expect("plots").iter();
        plots.map(|lines| lines.as_array().expect("lines").iter().filter(|l| l.is_object()).count()).sum()
    };
    let runs = shown["runs"].as_array().expect("runs");
    assert!(
        runs.len() >= 2 && runs.iter().all(|r| lines(r) >= 3 * COUNT),
        "{:?}",
        runs.iter().map(lines).collect::<Vec<_>>()
    );
    let words = crate::pages::words(&page);
    for outside in ["http", "src=", "@import", "url(", "NaN"] {
        assert!(!words.contains(outside), "{outside}");
    }
    let first = page.split("<h2>").next().expect("a first screen");
    for sentence in c.summary.split_inclusive(". ").map(str::trim) {
        assert!(first.contains(&stickslip_report::html::escape(sentence)), "{sentence}");
    }
    assert!(
        first.contains("class=\"bars\"") && first.contains("stickslip diagnose x"),
        "a picture and the next command"
    );
    assert!(words.contains("Before and after") && words.contains("worst trial"));
}

#[test]
fn a_replay_is_the_same_every_time_and_a_changed_bit_is_found() {
    let data = pushes(1, Nuisance::PAPER);
    let trial: &Trial = &data.trials[0];
    let run = || {
        replay::replay(&data.description, trial, &default_model(), Limits::default(), 0).expect("replayed")
    };
    let (a, b) = (run(), run());
    assert_eq!(a.hash, b.hash);
    let mut logged: Vec<(usize, Prediction)> = a.predictions.iter().copied().enumerate().collect();
    assert_eq!(replay::first_difference(&logged, &b.predictions), None);
    logged[7].1.sag_m = f32::from_bits(logged[7].1.sag_m.to_bits() ^ 1);
    assert_eq!(replay::first_difference(&logged, &b.predictions).map(|d| d.tick), Some(7));
    let slips = replay::spans(
        &trial.samples.iter().map(|s| s.t_s).collect::<Vec<_>>(),
        &a.predictions,
        &replay::FLAGS,
        |p| p.flags,
    );
    assert!(slips.iter().any(|s| s.flag == "slip, finger 1"), "{slips:?}");
}

#[test]
fn the_plan_of_a_push_is_rest_push_rest() {
    let data = pushes(1, Nuisance::PAPER);
    let plan = replay::plan_for(&data.trials[0]);
    let speeds: Vec<f32> =
        plan.segments.iter().map(|s| s.velocity_m_s.iter().map(|v| v * v).sum::<f32>().sqrt()).collect();
    let fastest = speeds.iter().copied().fold(0.0, f32::max);
    assert!((fastest - 0.02).abs() < 0.002, "{speeds:?}");
    let length: f32 = plan.segments.iter().map(|s| s.duration_s).sum();
    let samples = &data.trials[0].samples;
    assert!((f64::from(length) - (samples[samples.len() - 1].t_s - samples[0].t_s)).abs() < 1e-3);
}
