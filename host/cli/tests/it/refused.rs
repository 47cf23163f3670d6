//! What was refused is listed and the exit code is 1, in every command that reads data; and no
//! command writes over data unasked.

use std::fs;
use std::path::{Path, PathBuf};

use predicates::prelude::*;
use predicates::str::contains;
use tempfile::TempDir;

use crate::documents::stickslip;

/// The demonstration's push, once whole and once cut within a row.
fn with_a_cut_trial() -> (TempDir, PathBuf) {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    fs::create_dir_all(data.join("trials")).expect("a folder");
    let read = |name: &str| fs::read_to_string(demo.join(name)).expect("the demo data");
    fs::write(data.join("dataset.toml"), read("dataset.toml")).expect("written");
    let list = read("trials.csv");
    let (header, row) = list.split_once('\n').expect("rows");
    let row = row.lines().find(|row| row.starts_with("linear_push")).expect("a push");
    let (id, rest) = row.split_once(',').expect("cells");
    let rest = rest.split_once(',').expect("cells").1;
    fs::write(data.join("trials.csv"), format!("{header}\nwhole,,{rest}\ncut,,{rest}\n")).expect("written");
    let table = read(&format!("trials/{id}.csv"));
    fs::write(data.join("trials/whole.csv"), &table).expect("written");
    let end = table.len() * 9 / 10;
    let end = table[..end].rfind(',').expect("a row");
    fs::write(data.join("trials/cut.csv"), &table[..end]).expect("written");
    (folder, data)
}

#[test]
fn a_cut_trial_is_listed_and_the_exit_code_is_1_in_every_command() {
    let (folder, data) = with_a_cut_trial();
    let out = folder.path().join("model.toml");
    let model = out.as_os_str();
    for arguments in [
        vec!["check".as_ref()],
        vec!["calibrate".as_ref(), "--out".as_ref(), model],
        vec!["compare".as_ref()],
        vec!["score".as_ref()],
        vec!["replay".as_ref(), "--trial".as_ref(), "cut".as_ref()],
        vec!["diagnose".as_ref()],
    ] {
        let assert = stickslip().args(&arguments).arg(&data).assert().code(1);
        let said = assert.get_output();
        let both =
            [&said.stdout, &said.stderr].map(|text| String::from_utf8_lossy(text).into_owned()).concat();
        assert!(both.contains("cut.csv, line"), "{arguments:?}: {both}");
    }
    assert!(out.exists(), "the rest was used");
    let said = stickslip().args(["score", "--json"]).arg(&data).assert().code(1);
    let document: serde_json::Value = serde_json::from_slice(&said.get_output().stdout).expect("a document");
    assert_eq!(document["trials"], 2, "the rest was scored");
    assert_eq!(document["refused"].as_array().map(Vec::len), Some(1), "{}", document["refused"]);
}

/// The demonstration's push, once whole and once without the object's pose in its first half.
fn with_a_trial_without_a_start() -> (TempDir, PathBuf) {
    let (folder, data) = with_a_cut_trial();
    let whole = fs::read_to_string(data.join("trials/whole.csv")).expect("the push");
    let half = whole.lines().count() / 2;
    let object: Vec<bool> =
        whole.lines().next().expect("a header").split(',').map(|c| c.starts_with("object_")).collect();
    let without = |line: &str| {
        let cells = line.split(',').zip(&object).map(|(cell, of_object)| if *of_object { "" } else { cell });
        cells.collect::<Vec<_>>().join(",")
    };
    let lines = whole.lines().enumerate();
    let blind: Vec<String> =
        lines.map(|(k, line)| if (1..half).contains(&k) { without(line) } else { line.to_owned() }).collect();
    fs::write(data.join("trials/cut.csv"), blind.join("\n") + "\n").expect("written");
    (folder, data)
}

#[test]
fn trials_that_no_model_can_be_run_along_are_told_in_the_first_lines_and_on_the_first_screen() {
    let (folder, data) = with_a_trial_without_a_start();
    let told = "1 of 2 trials is left out: the object's pose is not known at the start";
    for command in ["check", "calibrate", "compare", "diagnose"] {
        let said = stickslip().arg(command).arg(&data).assert().success();
        let text = String::from_utf8_lossy(&said.get_output().stdout).into_owned();
        let first: Vec<&str> = text.lines().take(4).collect();
        assert!(first.iter().any(|line| line.starts_with(told)), "{command}: {text}");
        if command != "calibrate" {
            let page = folder.path().join("page.html");
            stickslip().arg(command).arg(&data).arg("--html").arg(&page).assert().success();
            let html = fs::read_to_string(&page).expect("a page");
            let (first_screen, _) = html.split_once("class=\"next\"").unwrap_or((&html, ""));
            assert!(first_screen.contains("1 of 2 trials is left out"), "{command}");
            assert!(first_screen.contains("trial cut: the object"), "{command}");
        }
    }
    let said = stickslip().args(["diagnose", "--json"]).arg(&data).assert().success();
    let document: serde_json::Value = serde_json::from_slice(&said.get_output().stdout).expect("a document");
    assert_eq!(document["left_out"][0]["trial"], "cut");
    assert_eq!(document["trials"], 1);
}

#[test]
fn fits_and_suggestions_tell_the_trials_that_they_leave_out_before_their_results() {
    let (folder, data) = with_a_trial_without_a_start();
    let (model, out) = (folder.path().join("model.toml"), folder.path().join("out.toml"));
    stickslip().arg("calibrate").arg(&data).arg("--out").arg(&model).assert().success();
    let words = |of: &[&str]| -> Vec<String> { of.iter().map(ToString::to_string).collect() };
    let [data, model, out] = [&data, &model, &out].map(|path| path.to_str().expect("a path"));
    for command in [
        words(&["add", data, "sensor_gain", "--model", model, "--out", out]),
        words(&["refit", data, "--model", model, "--out", out]),
        words(&[
            "suggest",
            data,
            "--model",
            model,
            "--between",
            "sensor_gain",
            "--between",
            "grip_force_loss",
        ]),
    ] {
        let said = stickslip().args(&command).assert().success();
        let text = String::from_utf8_lossy(&said.get_output().stdout).into_owned();
        let told = "1 of 2 trials is left out: the object's pose is not known at the start";
        assert!(text.lines().take(2).any(|line| line.starts_with(told)), "{command:?}: {text}");
        let said = stickslip().args(&command).arg("--json").assert().success();
        let document: serde_json::Value =
            serde_json::from_slice(&said.get_output().stdout).expect("a document");
        assert_eq!(document["left_out"][0]["trial"], "cut", "{command:?}");
        assert_eq!(document["trials"], 1, "{command:?}");
    }
}

#[test]
fn a_data_set_is_not_overwritten_unless_that_is_asked_for() {
    let (_folder, data) = with_a_cut_trial();
    let list = || fs::read_to_string(data.join("trials.csv")).expect("the list");
    let before = list();
    let rig = || {
        let mut command = stickslip();
        command.args(["rig", "--plan", "demo", "--out"]).arg(&data);
        command
    };
    rig().assert().code(1).stderr(contains("there is a data set already").and(contains("--force")));
    assert_eq!(list(), before);
    // What fails in the middle leaves the old set as it was, and nothing of the new one.
    let names = || {
        let mut names: Vec<_> =
            fs::read_dir(&data).expect("listed").flatten().map(|entry| entry.file_name()).collect();
        names.sort();
        names
    };
    fs::write(data.join("notes.txt"), "mine").expect("written");
    let there = names();
    let key = data.with_file_name("key");
    fs::create_dir(&key).expect("a folder where the key would be");
    rig().arg("--force").arg("--key").arg(&key).assert().code(1).stderr(contains("writing the key"));
    assert_eq!((list(), names()), (before.clone(), there.clone()));
    assert!(data.join("trials/whole.csv").exists());
    rig().arg("--force").assert().success();
    assert_ne!(list(), before);
    assert_eq!(names(), there, "other files stay");
    assert!(!data.join("trials/whole.csv").exists(), "no table is left that no list names");
    stickslip().arg("check").arg(&data).assert().success();
}

#[test]
fn a_rig_that_is_stopped_leaves_no_data_set_and_what_it_left_is_removed_by_the_next() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = || {
        let entries = fs::read_dir(folder.path()).expect("listed").flatten();
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect::<Vec<_>>()
    };
    let data = folder.path().join("data");
    let mut running = std::process::Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(["rig", "--plan", "paper", "--out"])
        .arg(&data)
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("starts");
    while names().is_empty() {
        assert!(running.try_wait().expect("asked").is_none(), "it ended before it wrote");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    running.kill().expect("killed");
    running.wait().expect("gone");
    let left = names();
    assert!(!data.exists() && left.len() == 1 && left[0].ends_with(".partial"), "{left:?}");
    stickslip().args(["rig", "--plan", "demo", "--out"]).arg(&data).assert().success();
    assert_eq!(names(), ["data"]);
}

#[test]
fn every_command_warns_of_sensors_about_which_nothing_is_stated() {
    let (_folder, data) = with_a_cut_trial();
    let toml = fs::read_to_string(data.join("dataset.toml")).expect("the description");
    let toml = toml.split("[sensors").next().expect("a start").to_owned();
    fs::write(data.join("dataset.toml"), toml).expect("written");
    for command in ["check", "compare", "score", "replay"] {
        let assert = stickslip().arg(command).arg(&data).assert();
        let said = assert.get_output();
        let both =
            [&said.stdout, &said.stderr].map(|text| String::from_utf8_lossy(text).into_owned()).concat();
        assert!(both.contains("SENSOR UNCERTAINTY NOT STATED"), "{command}: {both}");
    }
}
