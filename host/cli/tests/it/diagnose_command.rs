//! The way from a diagnosis to a better model, as a user types it: a formula as an effect, files
//! and pages that are written, names that are not known, data from which nothing can be concluded.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde_json::Value;
use stickslip_data::{Dataset, write};
use stickslip_rig::objects::bench;
use stickslip_rig::plan::{PlanName, conditions};
use stickslip_rig::{Nuisance, Reality, STEP_S, Setup, simulate};
use tempfile::TempDir;

use crate::common::push;
use crate::documents::{document, stickslip};
use crate::pages::check;

const SEED: u64 = 11;
/// A push of the demonstration.
const TRIAL: &str = "linear_push-obj4-g20-v10-s0-r1";
const OWN: &str = r#"format = "stickslip-model/1"
base = "hard"
[friction]
finger = 0.38
pusher = 0.22
support = 0.3
[[effects]]
id = "formula"
name = "weak_jaw"
target = "grip"
expression = "1 - a"
parameters = { a = { value = 0.1, low = 0, high = 0.6, unit = "1" } }
"#;

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")
}

/// Four conditions, each pushed twice by a gripper that loses three tenths of its grip; and a model
/// with a formula for that.
pub fn weak_grip() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let made = || {
        let folder = pushed(&["grip_force_loss=0.3"], 4);
        std::fs::write(folder.path().join("own.toml"), OWN).expect("written");
        folder
    };
    FOLDER.get_or_init(made).path()
}

/// About so many conditions, each pushed twice on a rig with `effects`.
fn pushed(effects: &[&str], conditions_about: usize) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let description = bench("weak grip");
    let mut reality = Reality::draw(&description, Nuisance::PAPER, SEED);
    reality.effects = effects.iter().map(|e| e.parse().expect("an effect")).collect();
    let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
    let all = conditions(PlanName::PushSmall, &[], SEED, 1.0);
    let some = all.iter().step_by(all.len().div_ceil(conditions_about));
    let trials =
        some.flat_map(|c| (1..=2).map(|run| simulate(&setup, c, run, SEED).expect("a trial"))).collect();
    write(&Dataset { folder: "weak".into(), description, trials }, folder.path()).expect("written");
    folder
}

/// What `diagnose` prints of it. Beside the data lie the model that is named, the page and its figures.
pub fn weak_grip_diagnosed() -> &'static str {
    static SAID: OnceLock<String> = OnceLock::new();
    SAID.get_or_init(|| {
        let words = ["diagnose", ".", "--out", "named.toml", "--html", "page.html", "--figures", "figures"];
        let output = stickslip().current_dir(weak_grip()).args(words).output().expect("run");
        let text = String::from_utf8(output.stdout).expect("text");
        assert!(output.status.success(), "{text}");
        text
    })
}

fn json(folder: &Path, words: &[&str]) -> Value {
    let output = stickslip().current_dir(folder).args(words).arg("--json").output().expect("run");
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    document(words[0], &output.stdout)
}

/// What the command says on stderr as it refuses.
fn refused(folder: &Path, words: &[&str]) -> String {
    let output = stickslip().current_dir(folder).args(words).output().expect("run");
    assert!(!output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stdout));
    String::from_utf8(output.stderr).expect("text")
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_formula_is_added_refitted_calibrated_compared_and_separated_like_an_effect() {
    let folder = weak_grip();
    let added = json(folder, &["add", ".", "weak_jaw", "--model", "own.toml", "--out", "better.toml"]);
    assert_eq!(added["schema"], "stickslip-add/1");
    let strength = |document: &Value| -> f64 {
        let all = document["parameters"].as_array().expect("a list");
        let a = all.iter().find(|p| p["name"] == "weak_jaw.a").expect("fitted");
        assert!(a["low"].as_f64() < a["high"].as_f64(), "{a}");
        a["value"].as_f64().expect("a number")
    };
    assert!((strength(&added) - 0.3).abs() < 0.02, "{added}");
    let refitted = json(folder, &["refit", ".", "--model", "better.toml", "--out", "refitted.toml"]);
    assert_eq!(refitted["schema"], "stickslip-refit/1");
    assert!((strength(&refitted) - 0.3).abs() < 0.02, "{refitted}");
    // Friction alone: the formula stays as it was fitted.
    json(folder, &["calibrate", ".", "--model", "better.toml", "--out", "calibrated.toml"]);
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).expect("written");
    let value = text("better.toml").lines().find(|l| l.starts_with("parameters")).map(str::to_owned);
    assert!(value.is_some_and(|line| text("calibrated.toml").contains(&line)));
    // It is part of the model now: nothing is left to find, and it cannot be added twice.
    let after = json(folder, &["diagnose", ".", "--model", "better.toml"]);
    assert_eq!(after["effects"], serde_json::json!([]), "{}", after["summary"]);
    assert!(after["parameters"]["weak_jaw.a"]["value"].is_number());
    let again = refused(folder, &["add", ".", "weak_jaw", "--model", "better.toml", "--out", "x.toml"]);
    assert!(again.contains("already has weak_jaw") && again.contains("stickslip refit"), "{again}");
    let words = ["suggest", ".", "--model", "own.toml", "--between", "weak_jaw", "--between", "sensor_gain"];
    let between = json(folder, &words);
    assert_eq!(between["schema"], "stickslip-suggest/1");
    let mut pair: Vec<&str> =
        between["between"].as_array().expect("two").iter().filter_map(Value::as_str).collect();
    pair.sort_unstable();
    assert_eq!(pair, ["sensor_gain", "weak_jaw"]);
    let plan = json(folder, &[words.as_slice(), &["--runs", "3"]].concat())["plan"].clone();
    let told: Vec<f64> = plan["trials"]
        .as_array()
        .expect("trials")
        .iter()
        .map(|t| t["information_bits"].as_f64().expect("bits"))
        .collect();
    assert!(told.len() == 3 && told.is_sorted(), "each trial adds: {plan}");
    let open = plan["open_bits"].as_f64().expect("bits");
    assert!((open - 1.0).abs() < 1e-12 && told[2] <= open, "two that are equally likely: {plan}");
}

#[test]
fn data_come_first_and_the_old_option_is_understood() {
    let (_kept, folder) = push(|description| description);
    let old = json(&folder, &["add", "grip_force_loss", "--fit", ".", "--out", "old.toml"]);
    let new = json(&folder, &["add", ".", "grip_force_loss", "--out", "new.toml"]);
    assert_eq!(old["parameters"], new["parameters"]);
    let wrong = refused(&folder, &["add", "grip_force_loss", "--out", "x.toml"]);
    assert!(wrong.contains("the data set comes first"), "{wrong}");
}

#[test]
fn a_wrong_model_is_refitted_to_a_push_and_trials_are_suggested_from_the_file_that_is_written() {
    let (_kept, folder) = push(|description| description);
    // A gripper that loses 3 N, which this one does not.
    let wrong = "format = \"stickslip-model/1\"\nbase = \"hard\"\n[friction]\nfinger = 0.35\npusher = 0.25\n\
                 support = 0.3\n[[effects]]\nid = \"grip_force_loss\"\nfraction = 0.0\noffset_n = 3.0\n";
    std::fs::write(folder.join("wrong.toml"), wrong).expect("written");
    let refitted = json(&folder, &["refit", ".", "--model", "wrong.toml", "--out", "refitted.toml"]);
    let value = |name: &str| -> f64 {
        let all = refitted["parameters"].as_array().expect("a list");
        all.iter().find(|p| p["name"] == name).and_then(|p| p["value"].as_f64()).expect("fitted")
    };
    assert!(value("grip_force_loss.offset_n").abs() < 0.2, "{refitted}");
    // As `add` finds it from the default model: 0.401.
    assert!((value("friction.finger") / 0.401 - 1.0).abs() < 0.02, "{refitted}");
    let suggest = ["suggest", ".", "--model", "refitted.toml", "--between", "sensor_gain", "--between"];
    let between = json(&folder, &[&suggest[..], &["finger_friction_mismatch"]].concat());
    let first = &between["experiments"][0];
    assert!(first["information_bits"].as_f64().is_some_and(|bits| bits > 0.0 && bits <= 1.0), "{between}");
    let in_model = refused(&folder, &[&suggest[..], &["grip_force_loss"]].concat());
    assert!(in_model.contains("already has grip_force_loss"), "{in_model}");
}

#[test]
fn a_diagnosis_writes_the_named_model_and_a_page_and_says_what_comes_next() {
    let folder = weak_grip();
    let text = weak_grip_diagnosed();
    let next = "stickslip compare . --model named.toml";
    assert!(text.contains(&format!("Next:\n  {next}")), "{text}");
    assert!(
        !text.contains("finger_difference") && text.contains("finger 1 less finger 2, force y"),
        "{text}"
    );
    let named = std::fs::read_to_string(folder.join("named.toml")).expect("written");
    assert!(named.contains("id = \"grip_force_loss\"") && named.contains("intervals"), "{named}");
    // It is a model as every command reads it.
    json(folder, &["calibrate", ".", "--model", "named.toml"]);
    let page = std::fs::read_to_string(folder.join("page.html")).expect("written");
    assert!(check("diagnose", &page) > 5, "a heat map");
    let first = page.split("<h2>").next().expect("a first screen");
    assert!(first.contains("the grip that acts is below the commanded one"), "plain words");
    assert!(first.contains("class=\"bars\"") && first.contains(next), "a picture and the next command");
    for told in
        ["share of the command that is lost", "Townsend and Salisbury", "finger 1 less finger 2, force y"]
    {
        assert!(page.contains(told), "{told}");
    }
    // Its signature beside that of the data: as bars, and over one run.
    let card = page.split("<article").nth(1).expect("a card");
    for told in [
        "what the data show that the model lacks",
        "what the effect changes",
        "The same in one run",
        "On the robot: the fingers press less than was commanded",
    ] {
        assert!(card.contains(told), "{told}");
    }
    for raw in ["finger_sum", "finger_difference", "_nm<", "http", "src=", "url(", "NaN"] {
        assert!(!crate::pages::words(&page).contains(raw), "{raw}");
    }
}

#[test]
#[ignore = "long: make test-host-rest"]
fn an_object_that_is_seen_late_is_measured_by_check_and_named_with_that_delay_beside_what_else_is_missing() {
    const LATE_S: f64 = 0.03;
    let folder = pushed(&["mocap_latency=0.03", "grip_force_loss=0.3"], 8);
    let output = stickslip().current_dir(folder.path()).args(["check", ".", "--json"]).output().expect("run");
    let said: Value = serde_json::from_slice(&output.stdout).expect("a document");
    let measured_s = said["object_delay"]["late_s"].as_f64().expect("measured");
    assert!((measured_s - LATE_S).abs() < 0.002, "{measured_s} s");
    let causes = said["findings"].as_array().expect("a list").len();
    assert!(!output.status.success() && causes == 1, "{}", said["findings"]);
    let said = json(folder.path(), &["diagnose", "."]);
    let named: Vec<&str> =
        said["effects"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert!(named.contains(&"mocap_latency") && named.contains(&"grip_force_loss"), "{named:?}");
    let of = |what: &str| said["parameters"]["mocap_latency.latency_s"][what].as_f64().expect("an interval");
    assert!(
        of("low") < LATE_S && LATE_S < of("high") && of("high") - of("low") < 0.01,
        "{}",
        said["parameters"]
    );
}

#[test]
fn three_conditions_are_inconclusive_whoever_asks_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let demo = demo().display().to_string();
    let words = ["diagnose", &demo, "--out", "better.toml", "--html", "page.html"];
    let report = json(folder.path(), &words);
    assert_eq!(report["schema"], "stickslip-diagnose/1");
    assert_eq!(report["verdict"], "inconclusive");
    assert!(report["reason"].as_str().is_some_and(|r| r.contains("3 different condition")), "{report}");
    assert!(report["would_tell"].as_str().is_some_and(|r| r.contains("run 1 more condition")), "{report}");
    assert!(!folder.path().join("better.toml").exists());
    let page = std::fs::read_to_string(folder.path().join("page.html")).expect("written");
    assert!(check("diagnose", &page) > 5, "a heat map");
    assert!(page.contains("What would decide"));
}

#[test]
fn a_name_that_is_not_known_is_refused_before_any_data_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for words in [
        ["suggest", "nowhere", "--between", "grip_forc_loss", "--between", "sensor_gain"].as_slice(),
        &["add", "nowhere", "grip_forc_loss", "--out", "x.toml"],
        &["effects", "grip_forc_loss"],
    ] {
        let error = refused(at, words);
        assert!(error.contains("did you mean grip_force_loss"), "{words:?}: {error}");
    }
    let twice = ["suggest", "nowhere", "--between", "sensor_gain", "--between", "sensor_gain"];
    assert!(refused(at, &twice).contains("sensor_gain cannot be distinguished from itself"));
}

#[test]
fn every_effect_can_be_looked_up() {
    let here = Path::new(".");
    let list = json(here, &["effects"]);
    assert_eq!(list["schema"], "stickslip-effects/1");
    let all = list["results"].as_array().expect("a list");
    assert_eq!(all.len(), stickslip_shared::effects::REGISTRY.len());
    for effect in all {
        let id = effect["id"].as_str().expect("an id");
        let words = ["what", "in_data", "source"].map(|key| effect[key].as_str().unwrap_or_default());
        assert!(words.iter().all(|w| !w.is_empty()), "{effect}");
        let output = stickslip().args(["effects", id]).output().expect("run");
        let text = String::from_utf8(output.stdout).expect("text");
        assert!(words.iter().all(|w| text.contains(w)), "{text}");
        for p in effect["parameters"].as_array().expect("a list") {
            assert!(text.contains(p["name"].as_str().expect("a name")), "{text}");
            assert!(p["low"].as_f64() < p["high"].as_f64() && p["unit"].is_string(), "{p}");
        }
        assert!(text.contains(&format!("stickslip add DATA {id}")), "{text}");
    }
}

#[test]
fn effects_page_has_the_words_and_the_numbers_of_the_effects() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/effects.md");
    let page = std::fs::read_to_string(page).expect("read").to_lowercase();
    for info in stickslip_shared::effects::REGISTRY {
        let section = page.split(&format!("## `{}`\n", info.id)).nth(1).unwrap_or_default();
        let section = section.split("\n## ").next().unwrap_or_default();
        let rows = info.parameters.iter().map(|p| format!("| `{}` | {} |", p.name, p.unit));
        let words = [info.summary, info.signature, info.on_robot, info.source].map(str::to_owned);
        for text in words.into_iter().chain(rows).chain(info.parameters.iter().map(|p| p.what.to_owned())) {
            assert!(section.contains(&text.to_lowercase()), "{}: {text}", info.id);
        }
        for p in info.parameters {
            let row =
                section.lines().find(|l| l.starts_with(&format!("| `{}` |", p.name))).unwrap_or_default();
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            let numbers = cells[3..6].iter().flat_map(|c| c.split(" to ")).map(|x| x.parse::<f64>());
            let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().expect(row);
            assert_eq!(numbers, [p.typical, p.neutral, p.low, p.high], "{}: {row}", info.id);
        }
    }
}

#[test]
fn under_each_result_stands_the_command_that_comes_next() {
    let (_kept, folder) = push(|description| description);
    std::fs::write(folder.join("own.toml"), OWN).expect("written");
    let trial = ["compare", ".", "--trial", TRIAL, "--model", "own.toml"];
    for (words, next) in [
        (["check", "."].as_slice(), "calibrate . --out model.toml"),
        (&["calibrate", ".", "--out", "model x.toml"], "diagnose . --model 'model x.toml'"),
        (&trial, "diagnose . --model own.toml"),
        (
            &["add", ".", "weak_jaw", "--model", "own.toml", "--out", "n.toml"],
            "compare . --model own.toml --model n.toml",
        ),
    ] {
        let output = stickslip().current_dir(&folder).args(words).output().expect("run");
        let text = String::from_utf8(output.stdout).expect("text");
        assert!(text.ends_with(&format!("\nNext:\n  stickslip {next}\n")), "{words:?}: {text}");
    }
}

#[test]
fn flags_that_did_nothing_are_gone() {
    for flag in ["--all", "--tare"] {
        let demo = demo().display().to_string();
        assert!(refused(Path::new("."), &["compare", &demo, flag]).contains("unexpected argument"));
    }
}

#[test]
fn plots_can_be_had_as_columns() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = folder.path().join("own.toml");
    std::fs::write(&model, OWN).expect("written");
    let demo = demo().display().to_string();
    let trial = TRIAL;
    json(folder.path(), &["replay", &demo, "--trial", trial, "--series", "replay.csv"]);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("written");
    let csv = read("replay.csv");
    let header: Vec<&str> = csv.lines().next().expect("a header").split(',').collect();
    assert_eq!(header[..2], ["trial", "t_s"]);
    for column in [
        "measured_finger1_fx_n",
        "modelled_pusher_fx_n",
        "predicted_sag_m",
        "predicted_finger_0_model_utilisation",
    ] {
        assert!(header.contains(&column), "{column} in {header:?}");
    }
    let samples =
        std::fs::read_to_string(Path::new(&demo).join(format!("trials/{trial}.csv"))).expect("a trial");
    assert_eq!(csv.lines().count(), samples.lines().count());
    // The measured column is the recorded one.
    let column = |text: &str, name: &str| -> Vec<f64> {
        let at = text.lines().next().and_then(|h| h.split(',').position(|c| c == name)).expect("the column");
        text.lines()
            .skip(1)
            .map(|l| l.split(',').nth(at).and_then(|c| c.parse().ok()).unwrap_or(f64::NAN))
            .collect()
    };
    let (written, recorded) = (column(&csv, "measured_finger1_fx_n"), column(&samples, "finger1_fx_n"));
    assert!(written.iter().zip(&recorded).all(|(a, b)| a == b || (a.is_nan() && b.is_nan())));
    let words = ["compare", &demo, "--trial", trial, "--model", "own.toml", "--model", "own.toml"];
    json(folder.path(), &[&words[..], &["--series", "compare.csv"]].concat());
    assert!(read("compare.csv").starts_with("trial,t_s,measured_object_x_m"));
    // Without a model it is the one that the comparison calibrates.
    json(folder.path(), &["compare", &demo, "--trial", trial, "--series", "calibrated.csv"]);
    let base = read("calibrated.csv");
    assert!(base.lines().next().is_some_and(|h| h.contains("modelled_pusher_fx_n")), "{}", &base[..200]);
    json(folder.path(), &["replay", &demo, "--trial", trial, "--series", "replay.parquet"]);
    let parquet = std::fs::read(folder.path().join("replay.parquet")).expect("written");
    assert!(parquet.starts_with(b"PAR1") && parquet.ends_with(b"PAR1"));
    let ending = refused(folder.path(), &["replay", &demo, "--series", "replay.txt"]);
    assert!(ending.contains(".csv or .parquet"), "{ending}");
}

#[test]
#[ignore = "long: make test-host-rest"]
fn what_add_writes_on_the_demonstrations_bench_leaves_none_of_the_failures_that_compare_shows_without_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (bench, base, better) = (path("bench"), path("base.toml"), path("better.toml"));
    let hidden = "finger_friction_mismatch";
    for command in [
        vec!["rig", "--plan", "push-small", "--seed", "11", "--hidden", hidden, "--out", &bench],
        vec!["calibrate", &bench, "--out", &base],
        vec!["add", &bench, hidden, "--model", &base, "--out", &better],
    ] {
        stickslip().args(command).assert().success();
    }
    let compared = stickslip()
        .args(["--json", "compare", &bench, "--model", &base, "--model", &better])
        .output()
        .expect("run");
    let tally = &document("compare", &compared.stdout)["tallies"][0];
    assert!(tally["failures"].as_u64() > Some(10) && tally["removed"] == tally["failures"], "{tally}");
    assert!(tally["new"] == 0 && tally["after"].as_f64() < Some(1.0), "{tally}");
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_gain_that_is_too_small_for_a_name_is_mentioned_as_itself_or_as_the_lost_grip_that_it_looks_like() {
    let folder = tempfile::tempdir().expect("a folder");
    let bench = folder.path().join("bench").display().to_string();
    let hidden = "sensor_gain=0.006";
    let rig = ["rig", "--plan", "push-small", "--seed", "31", "--hidden", hidden, "--out", &bench];
    stickslip().args(rig).assert().success();
    let output = stickslip().args(["--json", "diagnose", &bench]).output().expect("run");
    let report = document("diagnose", &output.stdout);
    assert_eq!(report["verdict"], "nothing_missing", "{report}");
    let weaker = report["weaker"].as_array().expect("effects that are mentioned");
    let after = report["error"]["after"].as_f64().expect("an error");
    let id = |c: &serde_json::Value| c["id"].as_str().unwrap_or_default().to_owned();
    assert!(
        weaker.iter().any(|c| ["sensor_gain", "grip_force_loss"].contains(&id(c).as_str())),
        "{weaker:?}"
    );
    for c in weaker {
        assert!(
            c["held_out_error"].as_f64() < Some(0.9 * after) && c["p_value"].as_f64() < Some(1e-3),
            "{c}"
        );
    }
}
