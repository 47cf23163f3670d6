//! `stickslip board`: each command against the firmware in QEMU, one unit for several of them, at a serial port. `make hil`
//! builds the firmware with sensors simulated and names it in `STICKSLIP_REHEARSAL`, the product's in `STICKSLIP_FIRMWARE`.

#[path = "it/port.rs"]
mod port;

use std::path::Path;

use assert_cmd::assert::Assert;
use port::Port;
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;

fn named(variable: &str) -> String {
    std::env::var(variable).unwrap_or_else(|_| panic!("{variable} is not set; run `make hil`"))
}

/// A unit to name to the commands; one that was started ends when dropped.
struct Unit {
    _started: Option<Port>,
    device: String,
}

impl Unit {
    /// One that begins anew with each command, in time with this machine's clock: no tick is late.
    fn anew(variable: &str) -> Self {
        Self { _started: None, device: format!("qemu:{}", named(variable)) }
    }

    /// One for all commands, at a serial port.
    fn start(variable: &str) -> Self {
        let (port, device) = Port::open(named(variable));
        Self { _started: Some(port), device }
    }

    fn board(&self, arguments: &[&str]) -> Assert {
        let mut command = assert_cmd::Command::cargo_bin("stickslip").expect("the program");
        command.arg("board").args(arguments).args(["--device", &self.device]).assert()
    }

    /// The document of a command that must succeed.
    fn document(&self, arguments: &[&str]) -> Value {
        let arguments: Vec<&str> = arguments.iter().copied().chain(["--json"]).collect();
        let assert = self.board(&arguments).success();
        serde_json::from_slice(&assert.get_output().stdout).expect("one document")
    }
}

fn data() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo").display().to_string()
}

/// A file of matrices: N and N m a count.
fn matrices(folder: &Path, entry: f64) -> String {
    let row = |k: usize| {
        let numbers = (0..6).map(|j| if j == k { format!("{entry:?}") } else { "0.0".into() });
        format!("[{}]", numbers.collect::<Vec<_>>().join(", "))
    };
    let rows = (0..6).map(row).collect::<Vec<_>>().join(", ");
    let text: String = [1, 2].map(|k| format!("[[finger]]\nnumber = {k}\nmatrix = [{rows}]\n")).concat();
    let file = folder.join(format!("matrices-{entry}.toml"));
    std::fs::write(&file, text).expect("written");
    file.display().to_string()
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_tare_is_what_the_board_says_its_sensors_gave_or_its_refusal() {
    let unit = Unit::start("STICKSLIP_REHEARSAL");
    // Without sensors there is nothing to tare.
    unit.board(&["tare"])
        .failure()
        .stderr(contains("finger 1 has no sensor: `stickslip board sensors` assigns one"));
    unit.board(&["sensors", "--finger1", "gauges", "--finger2", "gauges"])
        .success()
        .stdout(contains("sensors assigned"));
    let told = unit.document(&["tare"]);
    assert_eq!(told["tared"], true, "{told}");
    for finger in 0..2 {
        for channel in 0..6 {
            // The program's channels alternate around these (firmware/src/bin/rehearsal.rs).
            let (offset, given) =
                (told["offsets"][finger][channel].as_f64(), 2000.5 + 10.0 * (6 * finger + channel) as f64);
            assert!(offset.is_some_and(|offset| (offset - given).abs() < 0.1), "{finger} {channel}: {told}");
        }
    }
    unit.board(&["tare"])
        .success()
        .stdout(contains("finger 1: no load is 2000.").and(contains("finger 2: no load is 2060.")));
    // A sensor that is not there gives no readings: no tare, and that is said.
    unit.board(&["sensors", "--finger1", "gauges", "--finger2", "can"]).success();
    unit.board(&["tare"])
        .failure()
        .stderr(contains("finger 2").and(contains("no half second of readings")))
        .stdout(contains("finger 1: no load is 2000."));
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn what_a_unit_is_given_over_the_line_it_has_and_tells() {
    let unit = Unit::start("STICKSLIP_REHEARSAL");
    let folder = tempfile::tempdir().expect("a folder");
    unit.board(&["info"])
        .success()
        .stdout(contains("mps2-an386").and(contains("mode Safe")).and(contains("its clock:")));
    let loaded = unit.document(&["load", &data()]);
    assert!(loaded["bytes"].as_u64().is_some_and(|bytes| (100..1536).contains(&bytes)), "{loaded}");
    let told = unit.document(&["info"]);
    assert_eq!((&told["info"]["mode"], &told["info"]["boots"]), (&"Ready".into(), &1.into()), "{told}");
    assert!(told["clock"]["uncertainty_s"].as_f64().is_some_and(|s| s > 0.0 && s < 1.0), "{told}");
    unit.board(&["sensors", "--finger1", "gauges", "--finger2", "gauges"]).success();
    unit.board(&["calibrate", &matrices(folder.path(), 0.01)]).success().stdout(contains("2 matrices"));
    unit.board(&["calibrate", &matrices(folder.path(), 0.0)])
        .failure()
        .stderr(contains("the matrix of finger 1 is singular"));
    // With sensors and matrices a run on them can be stored, which is refused without.
    unit.board(&["sensors", "--finger1", "can", "--finger2", "gauges"]).success();
    unit.board(&["store", "--start"]).failure().stderr(contains("the sensor of finger 1 has no matrix"));
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_self_test_holds_every_check_on_a_sound_unit_and_a_log_has_what_the_unit_reported() {
    let unit = Unit::anew("STICKSLIP_FIRMWARE");
    let told = unit.document(&["selftest"]);
    assert_eq!(told["failed"], 0, "{told}");
    assert!(told["checks"].as_array().is_some_and(|checks| checks.len() >= 9), "{told}");
    unit.board(&["selftest"]).success().stdout(contains("ok   it ticks").and(contains("FAIL").not()));
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("unit.mcap");
    let told = unit.document(&["log", &file.display().to_string(), "--seconds", "1"]);
    let reports = told["reports"].as_u64().expect("a count");
    assert!(reports >= 5, "{told}");
    let kept = stickslip_device::log::read(&file).expect("a log");
    assert_eq!((kept.records.len() as u64, kept.lost.len()), (reports, 0));
    unit.board(&["log", "/no/such/folder/unit.mcap"]).failure().stderr(contains("/no/such/folder"));
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_stream_by_this_machines_clock_says_what_the_board_was_told_and_predicts_the_hosts_bits() {
    let device = format!("qemu:{}", named("STICKSLIP_FIRMWARE"));
    let stream = |more: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("stickslip").expect("the program");
        command.args(["stream", &data(), "--clock", "--device", &device]).args(more).assert()
    };
    stream(&[]).success().stdout(
        contains("clock sent to the board:").and(contains("samples came too late to be measurements")),
    );
    let told: Value =
        serde_json::from_slice(&stream(&["--json"]).success().get_output().stdout).expect("one document");
    assert!(told["clock"]["uncertainty_s"].as_f64().is_some_and(|s| s > 0.0), "{told}");
    assert!(told["compared"].as_u64().is_some_and(|n| n > 0) && told["equal"] == told["compared"], "{told}");
    stream(&["--line-faults", "1"]).failure().stderr(contains("cannot be used with"));
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn a_recording_that_ctrl_c_ends_says_so_and_its_log_has_the_index_that_viewers_need() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let device = format!("qemu:{}", named("STICKSLIP_FIRMWARE"));
    let child = std::process::Command::new(assert_cmd::cargo::cargo_bin("stickslip"))
        .args(["stream", &data(), "--clock", "--device", &device, "--log", &file.display().to_string()])
        .stderr(std::process::Stdio::piped())
        .stdout(std::process::Stdio::null())
        .spawn()
        .expect("started");
    // More than the header: records come.
    let recorded = || std::fs::metadata(&file).is_ok_and(|file| file.len() > 6_000);
    while !recorded() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.is_ok_and(|status| status.success()));
    let ended = child.wait_with_output().expect("ended");
    let said = String::from_utf8(ended.stderr).expect("text");
    assert_eq!(ended.status.code(), Some(1), "{said}");
    assert!(said.contains("interrupted; ") && said.contains("run.mcap holds what came until then"), "{said}");
    // An index stands before the magic bytes at the end.
    assert!(std::fs::read(&file).expect("read").ends_with(b"\x89MCAP0\r\n"));
    let kept = stickslip_device::log::read(&file).expect("a log");
    assert!(!kept.records.is_empty() && kept.lost.is_empty(), "{:?}", kept.lost);
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn monitor_streams_a_trial_to_a_board_in_qemu_and_sees_what_a_replay_sees() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("run.mcap").display().to_string();
    let of = |words: &[&str]| {
        assert_cmd::Command::cargo_bin("stickslip").expect("the program").args(words).assert().success()
    };
    let document = |words: &[&str]| -> Value {
        serde_json::from_slice(&of(words).get_output().stdout).expect("one document")
    };
    of(&["replay", &data(), "--log", &log]);
    let expected = document(&["--json", "monitor", "--device", &format!("replay:{log}"), "--speed", "1000"]);
    let names = |told: &Value| -> Vec<String> {
        let alarms = told["alarms"].as_array().expect("alarms").iter();
        alarms.map(|alarm| alarm["what"].to_string()).collect()
    };
    assert!(!names(&expected).is_empty(), "{expected}");
    let device = Unit::anew("STICKSLIP_FIRMWARE").device;
    let watch = ["monitor", "--device", &device, "--data", &data()];
    let told = document(&[&["--json"], &watch[..]].concat());
    assert_eq!(told["predictions"], expected["predictions"], "{told}");
    assert_eq!(names(&told), names(&expected));
    assert_eq!(told["line"]["reports_lost"], 0, "{told}");
    of(&[&watch[..], &["--plain"]].concat()).stdout(
        contains("of friction").and(contains("ALARM")).and(contains("slip ahead, finger 1, foreseen in")),
    );
}

#[test]
#[ignore = "needs the firmware: make hil"]
fn monitor_of_a_board_at_a_serial_port_that_runs_nothing_hears_it_and_ends_when_its_time_is_over() {
    let unit = Unit::start("STICKSLIP_FIRMWARE");
    let mut command = assert_cmd::Command::cargo_bin("stickslip").expect("the program");
    let watched =
        command.args(["--json", "monitor", "--device", &unit.device, "--seconds", "2"]).assert().success();
    let told: Value = serde_json::from_slice(&watched.get_output().stdout).expect("one document");
    assert_eq!((&told["predictions"], &told["alarms_counted"]), (&0.into(), &0.into()), "{told}");
    // A board without a run reports ten times a second.
    assert!(told["line"]["reports_per_s"].as_f64().is_some_and(|rate| rate > 1.0), "{told}");
}
