//! Clocks that are found from the data: recordings whose offset is known.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stickslip_data::import::recording::{Import, import};

const MAPPING: &str = concat!(
    r#"format = "stickslip-mapping/1"
[trials]
pattern = '^(?<object>obj4)_r(?<run>\d)$'
constants = { primitive = "linear_push" }
"#,
    rig!(),
    r#"[[streams]]
name = "ft"
file = "{trial}_ft.csv"
time = { column = "t" }
[streams.pusher]
force = ["fx", "fy", "fz"]
acts_on = "object"
[[streams]]
name = "mocap"
file = "{trial}_mocap.csv"
time = { column = "t", clock = "estimated" }
[streams.object]
position = ["ox", "oy", "oz"]
roll_pitch_yaw = ["oa", "ob", "oc"]
[streams.gripper]
position = ["gx", "gy", "gz"]
roll_pitch_yaw = ["ga", "gb", "gc"]
"#
);

/// When the object touches, by the forces' clock, s.
const CONTACT_S: f64 = 0.8;

/// A push: the gripper moves at 20 mm/s from 0.3 s on; from the contact on the force rises with the pads' deformation
/// up to sliding, and the object lags behind the gripper. 1 kHz and 120 Hz, noise of both. The mocap's time is the
/// forces' less `offset_s`.
fn record(folder: &Path, run: usize, offset_s: f64, contact: bool) {
    let mut rng = ChaCha8Rng::seed_from_u64(run as u64);
    let mut noise = |sd: f64| sd * (0..12).map(|_| rng.random::<f64>() - 0.5).sum::<f64>();
    let lag = |t: f64| if contact { 0.02 * (t - CONTACT_S).max(0.0) } else { 0.0 };
    let mut force = String::from("t,fx,fy,fz\n");
    for k in 0..2000 {
        let t = 1e-3 * f64::from(k);
        // Sliding from 0.4 mm on.
        let f = -6.0 * (lag(t) / 4e-4).min(1.0);
        let _ = writeln!(force, "{t},{},{},{}", f + noise(0.02), noise(0.02), noise(0.02));
    }
    let mut poses = String::from("t,ox,oy,oz,oa,ob,oc,gx,gy,gz,ga,gb,gc\n");
    for k in 0..230 {
        let t = 0.005 + f64::from(k) / 120.0;
        let x = 0.02 * (t - 0.3).max(0.0);
        let mut row = format!("{}", t - offset_s);
        for place in [x - lag(t), 0.0, 0.5, 0.0, 0.0, 0.0, x, 0.0, 0.5, 0.0, 0.0, 0.0] {
            let _ = write!(row, ",{}", place + noise(2e-5));
        }
        let _ = writeln!(poses, "{row}");
    }
    fs::write(folder.join(format!("obj4_r{run}_ft.csv")), force).expect("written");
    fs::write(folder.join(format!("obj4_r{run}_mocap.csv")), poses).expect("written");
}

fn mapping(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("mapping.toml");
    fs::write(&path, text).expect("written");
    path
}

/// Time at which the object's way in the gripper of the imported trial passes 0.5 mm, s.
fn passes_s(import: &Import, trial: usize) -> f64 {
    let samples = &import.dataset.trials[trial].samples;
    let way = |s: &stickslip_data::Sample| {
        Some(s.gripper?.position_m[0] - s.object?.position_m[0]).filter(|way| *way > 5e-4)
    };
    samples.iter().find(|s| way(s).is_some()).expect("it slides").t_s
}

#[test]
fn devices_that_run_on_have_one_offset_that_all_trials_tell_within_its_interval() {
    let folder = tempfile::tempdir().expect("folder");
    let truth_s = -86_123.456_7;
    (1..=5).for_each(|run| record(folder.path(), run, truth_s, true));
    let import = import(&mapping(folder.path(), MAPPING)).expect("imports");
    assert!(import.refused.is_empty(), "{:?}", import.refused);
    assert_eq!(import.offsets.len(), 5);
    for offset in &import.offsets {
        assert_eq!((offset.trials, offset.stream.as_str()), (5, "mocap"));
        let error_s = offset.offset_s - truth_s;
        assert!(error_s.abs() <= offset.uncertainty_s, "{error_s} of {}", offset.uncertainty_s);
        assert!(offset.uncertainty_s < 4e-3, "{}", offset.uncertainty_s);
        let [own_s, half_s] = offset.own_s.expect("every trial has a contact");
        assert!((own_s - truth_s).abs() <= 1.5 * half_s, "{} of {half_s}", own_s - truth_s);
        assert!(!offset.force.is_empty() && !offset.way.is_empty());
    }
    // 25 ms of sliding at 20 mm/s make half a millimetre; the trial's own time begins with its second stream.
    let begins_s = 0.005;
    let passes = passes_s(&import, 0) + begins_s;
    assert!((passes - (CONTACT_S + 0.025)).abs() < 0.013, "{passes}");
}

#[test]
fn devices_that_are_started_anew_have_an_offset_in_each_trial() {
    let folder = tempfile::tempdir().expect("folder");
    let truth_s = [3.0, -0.2, 7.5];
    (1..).zip(truth_s).for_each(|(run, offset_s)| record(folder.path(), run, offset_s, true));
    let import = import(&mapping(folder.path(), MAPPING)).expect("imports");
    for (offset, truth_s) in import.offsets.iter().zip(truth_s) {
        assert_eq!(offset.trials, 1);
        let error_s = offset.offset_s - truth_s;
        assert!(error_s.abs() <= 1.5 * offset.uncertainty_s, "{error_s} of {}", offset.uncertainty_s);
    }
}

#[test]
fn one_trial_of_five_whose_clock_differs_does_not_move_the_others() {
    let folder = tempfile::tempdir().expect("folder");
    for run in 1..=5 {
        record(folder.path(), run, if run == 2 { 4.05 } else { 4.0 }, true);
    }
    let import = import(&mapping(folder.path(), MAPPING)).expect("imports");
    let one = &import.offsets[0];
    assert_eq!(one.trials, 4);
    assert!((one.offset_s - 4.0).abs() <= one.uncertainty_s.max(2e-3), "{one:?}");
    // What the stray one says by itself is told beside.
    let stray = import.offsets[1].own_s.expect("it has a contact");
    assert!((stray[0] - 4.05).abs() < 0.01 && import.offsets[1].offset_s == one.offset_s);
}

#[test]
fn a_trial_without_a_contact_takes_the_clock_of_the_others_or_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    (1..=3).for_each(|run| record(folder.path(), run, 4.0, run > 1));
    let path = mapping(folder.path(), MAPPING);
    let import = import(&path).expect("imports");
    assert_eq!(import.dataset.trials.len(), 3, "{:?}", import.refused);
    let without = &import.offsets[0];
    assert_eq!((without.own_s, without.trials), (None, 2));
    assert!((without.offset_s - 4.0).abs() <= without.uncertainty_s);

    let alone = tempfile::tempdir().expect("folder");
    record(alone.path(), 1, 4.0, false);
    let why = stickslip_data::import::recording::import(&mapping(alone.path(), MAPPING));
    let why = why.expect_err("nothing tells the clocks apart").to_string();
    assert!(why.contains("estimated") && why.contains("does not rise"), "{why}");
}

#[test]
fn a_clock_that_nothing_can_tell_is_refused_with_what_it_needs() {
    let folder = tempfile::tempdir().expect("folder");
    record(folder.path(), 1, 0.0, true);
    for (from, to, words) in [
        ("time = { column = \"t\" }", "time = { column = \"t\", clock = \"estimated\" }", "first stream"),
        ("[streams.gripper]", "[streams.pusher_pose]", "object and gripper by the other"),
    ] {
        assert!(MAPPING.contains(from), "{from}");
        let path = mapping(folder.path(), &MAPPING.replace(from, to));
        let why = import(&path).expect_err("refused").to_string();
        assert!(why.contains(words), "{words:?} is not in {why}");
    }
}
