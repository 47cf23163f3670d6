//! `predictor.toml`: what it may say, what it is refused for and where, and what its numbers do.

use crate::lifts::lift;
use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::replay::{feed, hash, run, run_tuned};
use stickslip_analysis::tuning::{Parameter, changed, default_file, parse, tables};
use stickslip_data::{Description, Trial};
use stickslip_rig::Scenario;
use stickslip_shared::predictor::{Checked, Limits, Prediction, flags};

/// Every number: its table, and what is said of it.
fn all() -> Vec<(String, Parameter)> {
    let each = tables().into_iter();
    each.flat_map(|t| t.parameters.into_iter().map(move |p| (t.table.clone(), p))).collect()
}

/// A file that sets one number, all of its places.
fn setting(table: &str, p: &Parameter, value: &str) -> String {
    let value = match p.default.len() {
        1 => value.to_owned(),
        many => format!("[{}]", vec![value; many].join(", ")),
    };
    format!("# One number.\n[{table}]\n{} = {value}\n", p.name)
}

fn refusal(text: &str) -> String {
    parse(text, "predictor.toml").expect_err(text).to_string()
}

#[test]
fn the_file_that_is_printed_is_complete_and_gives_the_defaults_back() {
    let text = default_file();
    let tuning = parse(&text, "predictor.toml").expect("it is sound");
    assert_eq!(tuning, Checked::default());
    for (table, p) in all() {
        assert!(text.contains(&format!("\n[{table}]\n")), "{table}");
        assert!(text.contains(&format!("\n{} = ", p.name)), "{}", p.name);
    }
    assert!(text.lines().all(|line| line.len() <= 120), "comments are wrapped");
    // Words of the declaration, once.
    assert!(
        text.contains("# Gain of the anchor, 1/s. Doubled: slow slides are lost in it twice as soon"),
        "{text}"
    );
    assert!(!text.contains("[`"), "links of the code");
}

#[test]
fn a_number_that_is_set_is_the_only_one_that_differs_and_the_rest_are_the_defaults() {
    for (table, p) in all() {
        let value = if p.default[0] == p.least { p.most } else { p.least };
        let value = if p.whole { value.to_string() } else { format!("{value:?}") };
        let text = setting(&table, &p, &value);
        let tuning = parse(&text, "predictor.toml").unwrap_or_else(|why| panic!("{text}{why}"));
        let changed = changed(&tuning);
        let [only] = changed.as_slice() else { panic!("{text}{changed:?}") };
        assert_eq!(only.key, format!("{table}.{}", p.name));
        assert_eq!(only.default, p.default);
        assert!(
            only.value.iter().all(|v| v.to_string() == value.parse::<f64>().expect("a number").to_string())
        );
    }
    for empty in ["", "[observer]\n", "# Nothing yet.\n[observer.motion.hold]\n"] {
        assert_eq!(parse(empty, "predictor.toml").expect("sound"), Checked::default());
    }
}

#[test]
fn every_number_is_refused_with_its_place_where_it_is_none_or_beyond_its_bounds() {
    for (table, p) in all() {
        let beyond = if p.whole { (p.most + 1.0).to_string() } else { format!("{:?}", p.most * 1.01) };
        let mut wrong =
            vec!["nan".to_owned(), "inf".into(), "-inf".into(), "-1".into(), beyond, "\"1\"".into()];
        wrong.extend(["true".to_owned(), "1979-05-27".to_owned()]);
        if p.least > 0.0 {
            wrong.push(if p.whole { (p.least - 1.0).to_string() } else { format!("{:?}", p.least * 0.99) });
        }
        if p.whole {
            wrong.push(format!("{:?}", p.default[0]));
        }
        for value in wrong {
            let text = setting(&table, &p, &value);
            let why = refusal(&text);
            let key = format!("{table}.{}", p.name);
            let column = p.name.len() + 4;
            assert!(why.starts_with(&format!("predictor.toml:3:{column}: {key} ")), "{text}{why}");
            assert!(why.contains("must"), "{why}");
        }
    }
}

#[test]
fn a_key_that_is_none_is_refused_with_the_one_that_was_meant() {
    let cases = [
        (
            "[observer.motion]\nnoise = 1e-4\n",
            "predictor.toml:2:1: `noise` is not known in [observer.motion]",
        ),
        (
            "[observer.motion]\nnoize_m = 1e-4\n",
            "`noize_m` is not known in [observer.motion]; did you mean `noise_m`?",
        ),
        (
            "[observr.motion]\nnoise_m = 1e-4\n",
            "predictor.toml:1:2: `observr` is not known; did you mean `observer`?",
        ),
        ("[observer.motoin]\n", "`motoin` is not known in [observer]; did you mean `motion`?"),
        ("[predictor]\nlively = 3\n", "`lively` is not known in [predictor]; it belongs to [health]"),
        ("[predictor]\nnothing_like_it = 3\n", "`stickslip predictor` lists all"),
        ("[health]\nstuck = 3\nstuck = 4\n", "duplicate key"),
        ("observer = 3\n", "observer is a table: write [observer]"),
        (
            "[track.path]\nfree_gains = 0.2\n",
            "predictor.toml:2:14: track.path.free_gains must be a list of 2 numbers",
        ),
        ("[track.path]\nfree_gains = [0.2]\n", "must be 2 numbers, and has 1"),
        ("[health\n", "predictor.toml:1:"),
    ];
    for (text, told) in cases {
        let why = refusal(text);
        assert!(why.contains(told), "{text}{why}");
    }
}

fn predicted((description, trial): &(Description, Trial), file: &str) -> Vec<Prediction> {
    let tuning = parse(file, "predictor.toml").expect("sound");
    let feed = feed(description, trial).expect("a scene");
    run_tuned(&feed, &default_model(), Limits::default(), &tuning, 0, |_| ()).expect("accepted").predictions
}

/// Index of the first sample with one of the flags.
fn first(predictions: &[Prediction], bits: u32) -> usize {
    predictions.iter().position(|p| p.flags & bits != 0).expect("flagged")
}

const SLIP: u32 = flags::SLIP_1 | flags::SLIP_2;
const AHEAD: u32 = flags::SLIP_AHEAD_1 | flags::SLIP_AHEAD_2;

#[test]
fn without_a_file_and_with_a_complete_one_the_predictions_are_the_same_bits() {
    let trial = lift(Scenario::SuddenLoad { force_n: [0.0, 0.0, -4.0], at_s: 2.1 });
    let feed = feed(&trial.0, &trial.1).expect("a scene");
    let without = run(&feed, &default_model(), Limits::default(), 0, |_| ()).expect("accepted");
    for file in ["", &default_file()] {
        assert_eq!(hash(&predicted(&trial, file)), without.hash);
    }
}

#[test]
fn with_twice_the_deviations_a_sudden_slip_is_seen_later_and_is_seen() {
    // Friction bears 4.1 N, the load and the weight are 4.4 N: it gains 1.5 m/s2, and is a tenth of a millimetre away after 12 ms.
    let trial = lift(Scenario::SuddenLoad { force_n: [0.0, 0.0, -2.4], at_s: 2.1 });
    let file = "[observer.motion]\nhold.sigmas = 11\nat_limit.sigmas = 9.4\nfall.sigmas = 7\n";
    let (before, after) = (first(&predicted(&trial, ""), SLIP), first(&predicted(&trial, file), SLIP));
    assert!(after > before && after <= before + 5, "sample {before}, then {after}");
}

#[test]
fn with_twice_the_spread_of_the_told_friction_a_grip_that_decays_is_warned_of_earlier() {
    let trial = lift(Scenario::DecayingGrip { share: 0.3, from_s: 1.3, until_s: 2.3 });
    let file = "[observer.friction]\nspread_told = 0.24\n";
    let (before, after) = (first(&predicted(&trial, ""), AHEAD), first(&predicted(&trial, file), AHEAD));
    assert!(after + 10 < before, "sample {before}, then {after}");
}
