//! Bad input of the bench's commands: each is told what is wrong and what to do, and none
//! of them ends in a panic or a number that looks right.

use std::fs;

use predicates::str::contains;

use crate::common::push;
use crate::documents::stickslip;

#[test]
fn impossible_values_of_a_plan_are_refused_with_option_value_and_range() {
    let out = tempfile::tempdir().expect("a folder");
    for (option, value, told) in [
        ("--mu-finger", "-0.1", "give a number from 0 to 10"),
        ("--mu-pusher", "NaN", "give a number from 0 to 10"),
        ("--run-variation", "0.9", "give a number from 0 to 0.3"),
        ("--noise-scale", "-1", "give a number from 0 to 1000"),
        ("--runs", "0", "give at least 1"),
        ("--objects", "obj9", "the rig has obj1"),
        ("--hidden", "no_such_effect", "no_such_effect"),
    ] {
        stickslip()
            .args(["rig", "--out"])
            .arg(out.path().join("data"))
            .arg(format!("{option}={value}"))
            .assert()
            .failure()
            .stderr(contains(told));
        assert!(!out.path().join("data").exists(), "{option}: nothing is written");
    }
}

#[test]
fn an_object_without_mass_is_refused_by_every_command_of_the_bench() {
    for (from, to, told) in [
        ("mass_kg = 0.2005", "", "mass_kg"),
        ("mass_kg = 0.2005", "mass_kg = 0", "mass_kg"),
        ("mass_kg = 0.2005", "mass_kg = -0.2", "mass_kg"),
    ] {
        let (_folder, data) = push(|text| text.replace(from, to));
        for command in ["calibrate", "compare", "check"] {
            stickslip().arg(command).arg(&data).assert().failure().stderr(contains(told));
        }
    }
}

#[test]
fn a_data_set_without_repetition_is_compared_and_its_missing_noise_floor_is_told() {
    let (_folder, data) = push(|text| text);
    stickslip()
        .arg("compare")
        .arg(&data)
        .assert()
        .success()
        .stdout(contains("No condition was run more than once"));
}

#[test]
fn calibration_data_in_which_nothing_slides_only_bound_friction_and_say_so() {
    let (_folder, data) = push(|text| text);
    let table = data.join("trials/linear_push-obj4-g20-v10-s0-r1.csv");
    let text = fs::read_to_string(&table).expect("the table");
    // Rest, and the way to the plate.
    let short: Vec<&str> = text.lines().take(60).collect();
    fs::write(&table, short.join("\n") + "\n").expect("written");
    stickslip()
        .arg("calibrate")
        .arg(&data)
        .assert()
        .success()
        .stdout(contains("nothing slides in the grasp: finger friction is only bounded"));
}
