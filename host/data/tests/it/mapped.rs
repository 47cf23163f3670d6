//! Keys and formats of mappings, each to the numbers that were written.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use stickslip_data::import::recording::{Import, guess, import};

use crate::recordings::{errors, mapping, object, wrench, write};

const TRIAL: &str = "constants = { object = \"obj4\", primitive = \"linear_push\" }";

/// Tables that another library wrote (`recorded/make_parquet.py`), with its usual compression and with Snappy.
const POLARS: &[u8] = include_bytes!("recorded/polars.parquet");
const POLARS_ZSTD: &[u8] = include_bytes!("recorded/polars_zstd.parquet");

const PARQUET_STREAM: &str = r#"
[[streams]]
name = "ft"
file = "ft.parquet"
time = { column = "t_us", unit = "us" }
[streams.finger1]
force = ["Fx", "Fy", "Fz"]
torque = ["Tx", "Ty", "Tz"]
torque_unit = "N mm"
acts_on = "object"
"#;

#[test]
fn a_parquet_file_of_another_library_is_read_to_the_numbers_that_were_written_and_guessed() {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("ft.parquet");
    fs::write(&file, POLARS).expect("written");
    let path = write(folder.path(), "m.toml", &mapping(TRIAL, PARQUET_STREAM));
    let Import { dataset, refused, bad_rows, .. } = import(&path).expect("imports");
    assert!(refused.is_empty() && bad_rows.is_empty(), "{refused:?} {bad_rows:?}");
    let samples = &dataset.trials[0].samples;
    assert_eq!(samples.len(), 50);
    for (k, sample) in (0..50).map(f64::from).zip(samples) {
        let measured = sample.finger[0].expect("measured");
        let off = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(off(sample.t_s, 0.004 * k) && off(measured.force_n[0], 0.25 * k), "{k}: {measured:?}");
        assert!(off(measured.force_n[1], -20.0), "{k}: {measured:?}");
        assert!(if k < 5.0 { measured.force_n[2].is_nan() } else { off(measured.force_n[2], 0.5) }, "{k}");
        assert!(off(measured.torque_nm[0], -1.25e-4) && off(measured.torque_nm[1], 1e-3 * k), "{k}");
    }
    let text = guess::guess(&[(&file, Path::new("ft.parquet"))]).expect("guessed");
    for words in [
        "file = \"ft.parquet\"",
        "time = { column = \"t_us\", unit = \"us\" }",
        "force = [\"Fx\", \"Fy\", \"Fz\"]",
    ] {
        assert!(text.contains(words), "{words} is not in:\n{text}");
    }
    let why = import(&write(folder.path(), "m.toml", &mapping(TRIAL, &PARQUET_STREAM.replace("Fx", "F_x"))))
        .expect_err("no such column")
        .to_string();
    assert!(why.contains("no column \"F_x\"; it has t_us, Fx, Fy"), "{why}");
}

#[test]
fn a_parquet_file_whose_compression_is_not_known_says_with_which_to_write_it() {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("ft.parquet");
    fs::write(&file, POLARS_ZSTD).expect("written");
    let path = write(folder.path(), "m.toml", &mapping(TRIAL, PARQUET_STREAM));
    let imported = import(&path).expect_err("refused").to_string();
    let guessed = guess::guess(&[(&file, Path::new("ft.parquet"))]).expect_err("refused").to_string();
    for why in [imported, guessed] {
        assert!(why.contains("zstd") && why.contains("compression=\"snappy\""), "{why}");
    }
}

/// kgf and kgf cm in axes that are turned by a quaternion, the sensor 30 mm above and 10 mm beside the patch.
const TURNED: [f64; 4] = [0.5, 0.5, -0.5, 0.5];
const ORIGIN_M: [f64; 3] = [0.01, 0.0, 0.03];
const KGF_N: f64 = 9.80665;
/// Our origin in the recording's world.
const SHIFT_M: [f64; 3] = [0.1, -0.2, 0.05];
/// The camera's clock is behind by this, s.
const BEHIND_S: f64 = 0.25;

fn quaternion([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z))
}

fn force_row(t: f64) -> String {
    let (force, torque) = wrench(t);
    // About the sensor's origin, on the finger, in the sensor's axes.
    let torque = torque - Vector3::from(ORIGIN_M).cross(&force);
    let into = quaternion(TURNED).inverse();
    let force = into * -force / KGF_N;
    let torque = into * -torque / (KGF_N * 1e-2);
    format!("{t},{},{},{},{},{},{}\n", force.x, force.y, force.z, torque.x, torque.y, torque.z)
}

fn pose_row(t: f64) -> String {
    let at = object(t).translation.vector - Vector3::from(SHIFT_M);
    // About the fixed x by the first angle, then y, then z: the angles of `object`, in degrees.
    let [roll, pitch, yaw] = [0.1 * t, 0.3, -0.2 * t].map(|angle| angle * 180.0 / PI);
    format!("{},{},{},{},{roll},{pitch},{yaw}\n", t - BEHIND_S, at.x * 1e2, at.y * 1e2, at.z * 1e2)
}

#[test]
fn kgf_a_lever_axes_as_a_quaternion_angles_in_degrees_and_an_offset_in_time_become_the_truth() {
    // What the rows below take for granted of the truth's angles.
    let about = |axis, angle: f64| UnitQuaternion::from_axis_angle(&axis, angle);
    let turned =
        about(Vector3::z_axis(), -0.2) * about(Vector3::y_axis(), 0.3) * about(Vector3::x_axis(), 0.1);
    assert!(turned.angle_to(&object(1.0).rotation) < 1e-12);

    let folder = tempfile::tempdir().expect("folder");
    let mut force = String::from("t,fx,fy,fz,mx,my,mz\n");
    let mut pose = String::from("t,x,y,z,roll,pitch,yaw\n");
    for k in 0..=250 {
        let t = f64::from(k) * 0.004;
        let _ = write!(force, "{}", force_row(t));
        let _ = write!(pose, "{}", pose_row(t));
    }
    write(folder.path(), "ft.csv", &force);
    write(folder.path(), "camera.csv", &pose);
    let streams = format!(
        r#"
[[streams]]
name = "ft"
file = "ft.csv"
time = {{ column = "t" }}
[streams.finger1]
force = ["fx", "fy", "fz"]
force_unit = "kgf"
torque = ["mx", "my", "mz"]
torque_unit = "kgf cm"
acts_on = "finger"
axes = {TURNED:?}
origin_m = {ORIGIN_M:?}

[[streams]]
name = "camera"
file = "camera.csv"
time = {{ column = "t", offset_s = {BEHIND_S} }}
[streams.object]
position = ["x", "y", "z"]
unit = "cm"
roll_pitch_yaw = ["roll", "pitch", "yaw"]
angle_unit = "deg"
world_shift_m = {SHIFT_M:?}
"#
    );
    let Import { dataset, refused, signals, .. } =
        import(&write(folder.path(), "m.toml", &mapping(TRIAL, &streams))).expect("imports");
    assert!(refused.is_empty(), "{refused:?}");
    let samples = &dataset.trials[0].samples;
    let (worst, poses) = errors(samples, 0.0);
    assert_eq!((samples.len(), poses), (251, 251));
    assert!(samples.iter().all(|sample| sample.finger[0].is_some()));
    assert!(worst[0] < 1e-9 && worst[1] < 1e-9 && worst[2] < 1e-9 && worst[3] < 1e-9, "{worst:?}");
    let said = &signals.iter().find(|signal| signal.signal == "finger1").expect("listed").frame;
    assert!(said.contains("quaternion") && said.contains("[0.01, 0.0, 0.03] m"), "{said}");
}

#[test]
fn a_recording_in_the_place_of_a_mapping_is_told_how_its_mapping_begins() {
    let folder = tempfile::tempdir().expect("folder");
    for name in ["run.mcap", "run.csv", "RUN.CSV", "run.parquet", "run.db3"] {
        let path = folder.path().join(name);
        fs::write(&path, [0x89, b'M', 0xC3]).expect("written");
        let why = import(&path).expect_err("refused").to_string();
        let begins = format!("`stickslip new {} --out mapping.toml`", path.display());
        assert!(why.contains("this is a recording") && why.contains(&begins), "{why}");
    }
    let bag = folder.path().join("bag");
    fs::create_dir(&bag).expect("a folder");
    fs::write(bag.join("bag_0.mcap"), "").expect("written");
    assert!(import(&bag).expect_err("refused").to_string().contains("this is a recording"));
    // One that is not there is that, whatever its name.
    let why = import(&folder.path().join("none.csv")).expect_err("refused").to_string();
    assert!(why.contains("cannot be read"), "{why}");
}

#[test]
fn conditions_are_read_from_columns_of_the_recording_where_these_have_one_value_in_a_trial() {
    let folder = tempfile::tempdir().expect("folder");
    let mut text = String::from("t,number,fx,fy,fz,grip_set,speed,tries\n");
    for k in 0..300 {
        // Three trials of a second; the grip changes within the third, and where nothing is recorded.
        let (number, t) = (k / 100 + 1, f64::from(k) * 0.01);
        let grip = match k {
            0..100 => "2".to_owned(),
            150..160 => String::new(),
            100..240 => "2.5".to_owned(),
            _ => "3".to_owned(),
        };
        let _ = writeln!(text, "{t},{number},0,-20,0,{grip},{},{number}", 5 * number);
    }
    write(folder.path(), "all.csv", &text);
    let stream = r#"
[[streams]]
name = "all"
file = "all.csv"
time = { column = "t" }
[streams.finger1]
force = ["fx", "fy", "fz"]
acts_on = "object"

[[streams]]
name = "again"
file = "all.csv"
time = { column = "t" }
"#;
    let with = |trials: &str| {
        let trials = format!(
            "cut_by = \"number\"\nconstants = {{ object = \"obj4\", primitive = \"linear_push\" }}\n{trials}"
        );
        import(&write(folder.path(), "m.toml", &mapping(&trials, stream)))
    };
    let found = with(
        "columns = { grip_n = \"grip_set\", speed_m_s = { stream = \"again\", column = \"speed\" }, run = \"tries\" }\n\
         units = { grip_n = \"kgf\", speed_m_s = \"mm/s\" }",
    )
    .expect("imports");
    let conditions: Vec<_> = found
        .dataset
        .trials
        .iter()
        .map(|trial| (trial.info.grip_n, trial.info.speed_m_s, trial.info.run))
        .collect();
    assert_eq!(
        conditions,
        [(Some(2.0 * KGF_N), Some(0.005), Some(1)), (Some(2.5 * KGF_N), Some(0.01), Some(2))]
    );
    let [why] = found.refused.as_slice() else { panic!("{:?}", found.refused) };
    for words in ["all.csv", "trial 3", "\"grip_set\"", "2.5 at first", "3 after 0.400 s", "trials.table"] {
        assert!(why.contains(words), "{words} is not in {why}");
    }
    for (trials, words) in [
        ("columns = { grip_n = \"grip\" }", "no column \"grip\""),
        ("columns = { grip_m = \"grip_set\" }", "did you mean grip_n?"),
        ("columns = { object = \"grip_set\" }", "no condition in numbers"),
        ("columns = { grip_n = { stream = \"agian\", column = \"grip_set\" } }", "did you mean again?"),
        ("columns = { grip_n = \"grip_set\" }\nunits = { grip_n = \"mm\" }", "unknown unit"),
        ("columns = { run = \"speed\", grip_n = \"fy\" }", "below zero"),
    ] {
        let why = with(trials).expect_err("refused").to_string();
        assert!(why.contains(words), "{words} is not in {why}");
    }
    // The same from files of one trial each, whose names give the grip already.
    write(folder.path(), "g20_a.csv", &text.lines().take(50).collect::<Vec<_>>().join("\n"));
    let one = stream.split("[[streams]]").take(2).collect::<Vec<_>>().join("[[streams]]");
    let one = one.replace("all.csv", "{trial}_a.csv");
    let of = |pattern: &str| {
        let trials = format!(
            "pattern = '{pattern}'\nconstants = {{ object = \"obj4\", primitive = \"linear_push\" }}\ncolumns = \
             {{ grip_n = \"grip_set\" }}"
        );
        import(&write(folder.path(), "m.toml", &mapping(&trials, &one)))
    };
    assert_eq!(of("^g.*$").expect("imports").dataset.trials[0].info.grip_n, Some(2.0));
    let why = of("^g(?<grip_n>.*)$").expect_err("twice").to_string();
    assert!(why.contains("g20_a.csv") && why.contains("in trials.columns and in the trial's name"), "{why}");
}

#[test]
fn roll_pitch_and_yaw_are_recognised_with_their_unit_by_name_or_by_size() {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("pose.csv");
    for (names, scale, unit) in [
        (["roll_deg", "pitch_deg", "yaw_deg"], 1.0, "\"deg\"\n"),
        (["roll_rad", "pitch_rad", "yaw_rad"], 1.0, "\"rad\"\n"),
        (["Roll (°)", "Pitch (°)", "Yaw (°)"], 1.0, "\"deg\"\n"),
        (["roll", "pitch", "yaw"], 90.0, "\"deg\"   # CHECK: guessed\n"),
        (["roll", "pitch", "yaw"], 3.0, "\"rad\"   # CHECK: guessed\n"),
    ] {
        let mut text = format!("t_s,x_m,y_m,z_m,{}\n", names.join(","));
        for k in 0..20 {
            let angle = scale * f64::from(k) / 19.0;
            let _ = writeln!(text, "{},0.1,0.2,0.3,{angle},0,{}", 0.01 * f64::from(k), -angle);
        }
        fs::write(&file, text).expect("written");
        let guessed = guess::guess(&[(&file, Path::new("pose.csv"))]).expect("guessed");
        let [roll, pitch, yaw] = names;
        let columns = format!("roll_pitch_yaw = [{roll:?}, {pitch:?}, {yaw:?}]");
        assert!(guessed.contains(&columns), "{columns} is not in:\n{guessed}");
        assert!(guessed.contains(&format!("angle_unit = {unit}")), "{unit} is not in:\n{guessed}");
        let read = import(&write(folder.path(), "m.toml", &guessed));
        assert!(read.is_ok(), "{:?}\n{guessed}", read.err());
    }
}
