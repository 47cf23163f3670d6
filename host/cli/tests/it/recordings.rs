//! From a laboratory's file to a checked data set, as a new user does it.

use std::fs;
use std::path::{Path, PathBuf};

fn stickslip(args: &[&str], folder: &Path) -> (bool, String) {
    let output = crate::documents::stickslip().args(args).current_dir(folder).output().expect("runs");
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8_lossy(&text).into_owned())
}

/// A push of the demonstration as a laboratory's file, and the mapping that `new` guesses, corrected where it
/// says CHECK.
fn laboratory(folder: &Path) -> PathBuf {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../data/demo/trials/linear_push-obj4-g20-v10-s0-r1.csv");
    fs::copy(demo, folder.join("push_1.csv")).expect("copied");
    let (fine, said) = stickslip(&["new", "push_1.csv", "--out", "mapping.toml"], folder);
    assert!(
        fine && said.contains("CHECK") && said.contains("stickslip import recording mapping.toml"),
        "{said}"
    );
    let path = folder.join("mapping.toml");
    let text = fs::read_to_string(&path).expect("written");
    let place = "[fixed.pusher]\nposition_m = [";
    assert!(text.contains(&format!("{place}0.0, 0.0, 0.0]   # CHECK")), "{text}");
    let text = text.replace("mass_kg = 0.2 ", "mass_kg = 0.2005 ");
    let text = text.replace(&format!("{place}0.0,"), &format!("{place}-0.0503,"));
    fs::write(&path, text).expect("written");
    path
}

#[test]
fn a_guessed_and_corrected_mapping_imports_a_push_that_calibrates_and_is_never_written_over() {
    let folder = tempfile::tempdir().expect("folder");
    laboratory(folder.path());
    let (fine, said) = stickslip(&["import", "recording", "mapping.toml", "--out", "data"], folder.path());
    assert!(fine && said.contains("What was assumed") && said.contains("1 trials, 501 samples"), "{said}");
    let (fine, said) = stickslip(&["check", "data"], folder.path());
    assert!(fine && said.contains("No errors."), "{said}");
    let (fine, said) = stickslip(&["simulate", "data", "--out", "predicted"], folder.path());
    assert!(fine && said.contains("1 trials, 501 samples"), "{said}");
    let (fine, said) = stickslip(&["import", "recording", "mapping.toml", "--out", "data"], folder.path());
    assert!(!fine && said.contains("has content"), "{said}");
    let left: Vec<String> = fs::read_dir(folder.path())
        .expect("listed")
        .filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()))
        .filter(|name| name.contains("partial"))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn of_one_file_alone_the_mapping_is_written_to_mapping_toml_here_and_never_over_one_that_is_there() {
    let folder = tempfile::tempdir().expect("folder");
    laboratory(folder.path());
    let mine = fs::read_to_string(folder.path().join("mapping.toml")).expect("written");
    let (fine, said) = stickslip(&["new", "push_1.csv"], folder.path());
    assert!(!fine && said.contains("mapping.toml: cannot be made") && said.contains("--out"), "{said}");
    assert_eq!(fs::read_to_string(folder.path().join("mapping.toml")).expect("still there"), mine);
    fs::remove_file(folder.path().join("mapping.toml")).expect("removed");
    let (fine, said) = stickslip(&["new", "push_1.csv"], folder.path());
    assert!(fine && said.contains("mapping written to mapping.toml"), "{said}");
    let text = fs::read_to_string(folder.path().join("mapping.toml")).expect("written");
    assert!(text.contains("file = \"push_1.csv\""), "{text}");
}

#[test]
fn a_recording_that_is_imported_without_a_mapping_is_answered_with_the_command_that_begins_one() {
    let folder = tempfile::tempdir().expect("folder");
    laboratory(folder.path());
    let (fine, said) = stickslip(&["import", "recording", "push_1.csv", "--out", "data"], folder.path());
    assert!(!fine && said.contains("`stickslip new push_1.csv --out mapping.toml`"), "{said}");
    assert!(!folder.path().join("data").exists());
}

#[test]
fn the_page_of_an_import_draws_the_axes_of_world_gripper_and_object_and_where_a_sensor_sits() {
    let folder = tempfile::tempdir().expect("folder");
    let mapping = laboratory(folder.path());
    let page = || {
        let out = format!("data{}", fs::read_dir(folder.path()).expect("listed").count());
        stickslip(
            &["import", "recording", "mapping.toml", "--out", &out, "--html", "page.html"],
            folder.path(),
        );
        fs::read_to_string(folder.path().join("page.html")).expect("written")
    };
    let names = |page: &str, name: &str| page.matches(&format!(">{name}</text>")).count();
    // Three views, each with its own picture.
    let aligned = page();
    let of = ["world", "gripper", "object", "sensor"].map(|name| names(&aligned, name));
    assert_eq!(of, [3, 3, 3, 0]);
    let text = fs::read_to_string(&mapping).expect("written");
    let (before, finger) = text.split_once("[streams.finger1]").expect("a finger");
    let lever = finger.replacen("# origin_m = [0.0, 0.0, 0.0]", "origin_m = [0.0, 0.03, 0.0]", 1);
    fs::write(&mapping, format!("{before}[streams.finger1]{lever}")).expect("written");
    let placed = page();
    assert_eq!(names(&placed, "sensor"), 3);
    assert_eq!(placed.matches("stroke-dasharray=\"3 3\"").count(), 3);
}

#[test]
fn an_import_tells_that_no_model_can_run_along_pushes_whose_pusher_has_no_place_and_where_to_give_it() {
    let folder = tempfile::tempdir().expect("folder");
    let mapping = laboratory(folder.path());
    let text = fs::read_to_string(&mapping).expect("written");
    let lines = text.lines().filter(|l| !l.starts_with("[fixed.pusher]") && !l.contains("-0.0503"));
    fs::write(&mapping, lines.collect::<Vec<_>>().join("\n")).expect("written");
    let (fine, said) = stickslip(&["import", "recording", "mapping.toml", "--out", "data"], folder.path());
    assert!(fine && said.contains("1 of 1 trials is left out") && said.contains("[fixed.pusher]"), "{said}");
}

#[test]
fn wrong_signs_and_units_in_a_mapping_are_physics_errors() {
    let folder = tempfile::tempdir().expect("folder");
    let mapping = laboratory(folder.path());
    let text = fs::read_to_string(&mapping).expect("written");
    for (number, (from, to, word)) in [
        ("acts_on = \"object\"   # CHECK: or \"finger\"", "acts_on = \"finger\" #", "finger"),
        // Torques then exceed what the force can have on a pad.
        ("force_unit = \"N\"", "force_unit = \"mN\"", "no pad of this size"),
    ]
    .into_iter()
    .enumerate()
    {
        assert!(text.contains(from), "{from}");
        fs::write(&mapping, text.replace(from, to)).expect("written");
        let out = format!("data{number}");
        let (fine, said) = stickslip(&["import", "recording", "mapping.toml", "--out", &out], folder.path());
        assert!(!fine && said.contains("physics") && said.contains(word), "{from}: {said}");
    }
}
