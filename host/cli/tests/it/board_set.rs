//! `stickslip board set` and `calibrate`: what is wrong with command line and files is said before a board is looked for.

use std::fs;

use predicates::prelude::*;
use predicates::str::contains;

use crate::documents::stickslip;

const NO_BOARD: [&str; 2] = ["--device", "serial:/dev/no-such-port"];

#[test]
fn numbers_beyond_their_limits_are_refused_by_option_value_and_limits_without_a_board() {
    for (options, said) in [
        (&["--grip", "501"][..], "--grip: Grip is 501, allowed is 0 to 500"),
        (&["--grip", "-1"], "--grip: Grip is -1, allowed is 0 to 500"),
        (&["--grip", "NaN"], "--grip: Grip is NaN, allowed is 0 to 500"),
        (&["--grip-least", "50", "--grip-most", "40"], "GripMost is 40, allowed is 50 to 500"),
        (&["--grip-most", "inf"], "GripMost is inf, allowed is 0 to 500"),
        (&["--grip-rise", "0"], "GripRate is 0, allowed is 0.001 to 100000"),
        (&["--grip-fall", "-5"], "GripRate is -5, allowed is 0.001 to 100000"),
        (&["--store"], "nothing to set: give --unit, --grip"),
    ] {
        let assert = stickslip().args(["board", "set"]).args(options).args(NO_BOARD).assert().failure();
        assert.stderr(contains(said).and(contains("no-such-port").not()));
    }
    // What is no number at all is refused by the command line.
    for option in ["--unit=-7", "--unit=seven", "--grip=firm"] {
        let name = option.split('=').next().unwrap_or_default();
        stickslip().args(["board", "set", option]).args(NO_BOARD).assert().code(2).stderr(contains(name));
    }
}

#[test]
fn a_file_of_poses_that_is_none_is_refused_by_name_and_a_sound_one_gets_as_far_as_the_board() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("grasp.toml");
    let pose =
        |x: &str, w: &str| format!("position_m = [{x}, 0.0, 0.2]\nquaternion = [{w}, 0.0, 0.0, 0.0]\n");
    let text = |x: &str, w: &str| format!("[gripper]\n{}[object]\n{}", pose("0.3", "1.0"), pose(x, w));
    let set = || {
        let mut command = stickslip();
        command.args(["board", "set", "--grasp"]).arg(&file).args(NO_BOARD);
        command
    };
    set().assert().failure().stderr(contains("grasp.toml"));
    for (text, said) in [
        (text("nan", "1.0"), "Position is NaN"),
        (text("101.0", "1.0"), "Position is 101, allowed is -100 to 100"),
        (text("0.3", "0.5"), "Quaternion is 0.25, allowed is 0.99 to 1.01"),
        (text("0.3", "1.0").replace("[object]", "[objekt]"), "objekt"),
        (text("0.3", "1.0").replace("0.2]", "0.2, 4.0]"), "position_m"),
    ] {
        fs::write(&file, text).expect("written");
        set()
            .assert()
            .failure()
            .stderr(contains("grasp.toml").and(contains(said)).and(contains("no-such-port").not()));
    }
    set().arg("--no-grasp").assert().code(2).stderr(contains("--no-grasp"));
    fs::write(&file, text("0.3", "1.0")).expect("written");
    set().args(["--unit", "7", "--grip", "20"]).assert().failure().stderr(contains("/dev/no-such-port"));
}

#[test]
fn a_file_of_matrices_that_are_none_is_refused_in_words_that_say_which_finger_and_why() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("matrices.toml");
    let matrix = |entry: &dyn Fn(usize, usize) -> String| {
        let row = |i| (0..6).map(|j| entry(i, j)).collect::<Vec<_>>().join(", ");
        (0..6).map(|i| format!("[{}]", row(i))).collect::<Vec<_>>().join(", ")
    };
    let diagonal = |of: &str| matrix(&|i, j| if i == j { of.to_owned() } else { "0.0".to_owned() });
    let ones = matrix(&|_, _| "1.0".to_owned());
    for (number, matrix, said) in [
        (1, ones, "finger 1: the matrix of finger 1 is singular: six readings would not give six components"),
        (2, diagonal("nan"), "finger 2: Calibration is NaN, allowed is -1000 to 1000"),
        (3, diagonal("1.0"), "finger number 3; there are 1 and 2"),
        // Sound: it gets as far as the board.
        (1, diagonal("1.0"), "/dev/no-such-port"),
    ] {
        fs::write(&file, format!("[[finger]]\nnumber = {number}\nmatrix = [{matrix}]\n")).expect("written");
        let assert = stickslip().args(["board", "calibrate"]).arg(&file).args(NO_BOARD).assert().failure();
        assert.stderr(contains(said).and(contains("Singular").not()).and(contains("OutOfRange").not()));
    }
}
