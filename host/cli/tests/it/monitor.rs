//! `stickslip monitor` over a log that `replay` wrote, without a terminal.

use crate::common::push;
use crate::documents::{document, stickslip};

#[test]
fn a_log_is_watched_in_lines_with_its_alarms_and_as_one_document() {
    let (_keep, data) = push(|text| text);
    let replay =
        stickslip().current_dir(&data).args(["replay", ".", "--log", "run.mcap"]).output().expect("run");
    assert!(replay.status.success(), "{}", String::from_utf8_lossy(&replay.stderr));
    let watch = ["monitor", "--device", "replay:run.mcap", "--speed", "1000"];

    let lines = stickslip().current_dir(&data).args(watch).output().expect("run");
    assert!(lines.status.success(), "{}", String::from_utf8_lossy(&lines.stderr));
    let text = String::from_utf8_lossy(&lines.stdout);
    assert_eq!(text.lines().filter(|line| line.contains("of friction")).count(), 3, "{text}");
    assert!(text.contains("ALARM") && text.contains("slip ahead, finger 1, foreseen in"), "{text}");

    let json = stickslip().current_dir(&data).arg("--json").args(watch).output().expect("run");
    let told = document("monitor", &json.stdout);
    assert_eq!(told["predictions"], 501);
    assert_eq!(told["alarms"].as_array().expect("alarms").len() as u64, told["alarms_counted"]);
}

#[test]
fn board_monitor_is_monitor_on_the_boards_device() {
    let (_keep, data) = push(|text| text);
    let replay =
        stickslip().current_dir(&data).args(["replay", ".", "--log", "run.mcap"]).output().expect("run");
    assert!(replay.status.success(), "{}", String::from_utf8_lossy(&replay.stderr));
    let told = |words: &[&str]| {
        let watch = ["--device", "replay:run.mcap", "--seconds", "60"];
        let json =
            stickslip().current_dir(&data).arg("--json").args(words).args(watch).output().expect("run");
        document(&words.join(" "), &json.stdout)
    };
    let (own, board) = (told(&["monitor"]), told(&["board", "monitor"]));
    assert_eq!(own["predictions"], 501);
    for part in ["predictions", "alarms_counted", "alarms"] {
        assert_eq!(own[part], board[part], "{part}");
    }
}

#[test]
fn a_bus_is_heard_and_sent_nothing() {
    let words = ["monitor", "--device", "can:no-such-can", "--plain"];
    let output = stickslip().args(words).output().expect("run");
    let text = String::from_utf8_lossy(&output.stderr);
    let way_out = text.contains("ip link set no-such-can up") || text.contains("modprobe can-raw");
    assert!(!output.status.success() && text.contains("no-such-can") && way_out, "{text}");
    let output = stickslip().args(words).args(["--data", "data/demo"]).output().expect("run");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && text.contains("a bus takes no trial"), "{text}");
}

#[test]
fn what_cannot_be_watched_says_what_can() {
    let foxglove =
        if cfg!(feature = "foxglove") { "127.0.0.1:8765" } else { "cargo install --path host/cli" };
    for (words, part) in [
        (["--device", "can:"], "can:can0"),
        (["--device", "replay:no.mcap"], "no.mcap"),
        (["--speed", "0"], "0.01 to 1000"),
        (["--foxglove", "here"], foxglove),
    ] {
        let output = stickslip().arg("monitor").args(words).output().expect("run");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && text.contains(part), "{words:?}: {text}");
    }
}
