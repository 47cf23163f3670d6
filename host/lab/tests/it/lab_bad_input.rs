//! Bad input of the lab's commands on data: each says what is wrong and what to do.

use std::fs;

use assert_cmd::Command;
use predicates::str::contains;

use crate::common::push;

fn lab() -> Command {
    Command::cargo_bin("stickslip-lab").expect("the binary")
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
