//! Bad input of the lab's commands on data: each says what is wrong and what to do.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use predicates::str::contains;
use tempfile::TempDir;

fn lab() -> Command {
    Command::cargo_bin("stickslip-lab").expect("the binary")
}

/// A copy of one recorded push with its description, edited.
fn push(edit: impl Fn(String) -> String) -> (TempDir, PathBuf) {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("push");
    fs::create_dir_all(data.join("trials")).expect("a folder");
    let read = |name: &str| fs::read_to_string(demo.join(name)).expect("the demo data");
    fs::write(data.join("dataset.toml"), edit(read("dataset.toml"))).expect("written");
    let trials: Vec<String> = read("trials.csv").lines().take(2).map(str::to_owned).collect();
    fs::write(data.join("trials.csv"), trials.join("\n") + "\n").expect("written");
    let name = "trials/linear_push-obj4-g20-v10-s0-r1.csv";
    fs::copy(demo.join(name), data.join(name)).expect("copied");
    (folder, data)
}

#[test]
fn an_object_without_mass_is_refused_by_grid_and_mujoco() {
    for (from, to) in [
        ("mass_kg = 0.2005", ""),
        ("mass_kg = 0.2005", "mass_kg = 0"),
        ("mass_kg = 0.2005", "mass_kg = -0.2"),
    ] {
        let (_folder, data) = push(|text| text.replace(from, to));
        for command in ["grid", "mujoco"] {
            lab().arg(command).arg(&data).assert().failure().stderr(contains("mass_kg"));
        }
    }
}

#[test]
fn without_the_wheel_mujoco_says_how_to_get_it_and_still_exports() {
    let (folder, data) = push(|text| text);
    let nowhere = folder.path().join("python");
    let command = || {
        let mut command = lab();
        command.env("STICKSLIP_MUJOCO_PYTHON", &nowhere).arg("mujoco").arg(&data);
        command
    };
    command().assert().failure().stderr(contains("make mujoco-setup"));
    let out = folder.path().join("mjcf");
    command().arg("--export").arg(&out).assert().success();
    assert_eq!(fs::read_dir(&out).expect("the folder").count(), 2);
}
