//! Recordings as laboratories have them, through a mapping file.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use stickslip_data::import::recording::{Import, guess, import};
use stickslip_data::{Dataset, Sample, TrialInfo};

/// What acts on the object from finger 1 at `t`, gripper axes about the patch: N, N m.
pub fn wrench(t: f64) -> (Vector3<f64>, Vector3<f64>) {
    let force = Vector3::new(2.0 * t, -20.0 - 0.5 * (3.0 * t).sin(), 1.0 + 0.3 * (2.0 * t).cos());
    (force, Vector3::new(0.01 * t, 0.02 * (2.0 * t).sin(), -0.005))
}

/// Where the object is at `t`, our world.
pub fn object(t: f64) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(0.01 * t, 0.002 * (2.0 * t).sin(), 0.5 - 0.005 * t * t),
        UnitQuaternion::from_euler_angles(0.1 * t, 0.3, -0.2 * t),
    )
}

/// A force sensor's file: 1 kHz, `;`, microseconds since boot, N mm, reaction signs, its x along our -z,
/// its y along our x, its z along our -y.
fn force_file(trials: &[(f64, f64)], number_trials: bool) -> String {
    let mut text = String::from("t_us;F1x;F1y;F1z;T1x;T1y;T1z;trial_no\n");
    for (number, (from, to)) in (1..).zip(trials) {
        let rows = ((to - from) * 1000.0).round() as usize;
        for row in 0..=rows {
            let t = from + row as f64 * 1e-3;
            let (force, torque) = wrench(t);
            let (force, torque) = (-force, -torque * 1e3);
            let number = if number_trials { number } else { 0 };
            let _ = writeln!(
                text,
                "{:.0};{};{};{};{};{};{};{number}",
                7.0e9 + t * 1e6,
                -force.z,
                force.x,
                -force.y,
                -torque.z,
                torque.x,
                -torque.y
            );
        }
    }
    text
}

/// A motion capture's file: 120 Hz, mm, y up, x, y, z, w, its own clock in ms; the tracked body sits 20 mm
/// above the object's centre along its own y, and its axes are x, y up, z.
fn capture_file(from: f64, to: f64) -> String {
    let mut text = String::from("Time (ms),Block X,Block Y,Block Z,Block QX,Block QY,Block QZ,Block QW\n");
    let world = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    // Ours from theirs: x = x, y = -z, z = y.
    let body = Isometry3::from_parts(Translation3::new(0.0, -0.02, 0.0), world.inverse());
    let rows = ((to - from) * 120.0).floor() as usize;
    for row in 0..=rows {
        let t = from + row as f64 / 120.0;
        let recorded =
            Isometry3::from_parts(Translation3::identity(), world.inverse()) * object(t) * body.inverse();
        let p = recorded.translation.vector * 1e3;
        let q = recorded.rotation.quaternion();
        let stamp = 1e3 * (t - from) + 5.0;
        let _ = writeln!(text, "{stamp},{},{},{},{},{},{},{}", p.x, p.y, p.z, q.i, q.j, q.k, q.w);
    }
    text
}

const STREAMS: &str = r#"
[[streams]]
name = "ft"
file = "{trial}_ft.csv"
time = { column = "t_us", unit = "us" }
[streams.finger1]
force = ["F1x", "F1y", "F1z"]
torque = ["T1x", "T1y", "T1z"]
torque_unit = "N mm"
acts_on = "finger"
axes = ["y", "-z", "-x"]

[[streams]]
name = "mocap"
file = "{trial}_mocap.csv"
time = { column = "Time (ms)", unit = "ms", clock = "starts_together" }
[streams.object]
position = ["Block X", "Block Y", "Block Z"]
unit = "mm"
quaternion_wxyz = ["Block QW", "Block QX", "Block QY", "Block QZ"]
world_axes = ["x", "-z", "y"]
body_axes = ["x", "-z", "y"]
body_origin_m = [0.0, -0.02, 0.0]

[fixed.gripper]
position_m = [0.0, 0.0, 0.5]
"#;

pub fn mapping(trials: &str, streams: &str) -> String {
    format!("format = \"stickslip-mapping/1\"\n[trials]\n{trials}\n{}\n{streams}", rig!())
}

pub fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, text).expect("written");
    path
}

const NAMES: &str = "pattern = '^(?<object>obj\\d)_g(?<grip_n>\\d+)_v(?<speed_m_s>\\d+)_r(?<run>\\d)$'\n\
    units = { speed_m_s = \"mm/s\" }\nconstants = { primitive = \"linear_push\" }";

fn laboratory(folder: &Path) -> PathBuf {
    for run in 1..=2 {
        write(folder, &format!("obj4_g20_v10_r{run}_ft.csv"), &force_file(&[(0.0, 1.5)], false));
        write(folder, &format!("obj4_g20_v10_r{run}_mocap.csv"), &capture_file(0.0, 1.5));
    }
    write(folder, "mapping.toml", &mapping(NAMES, STREAMS))
}

/// Largest errors of force (N), torque (N m), position (m), angle (rad) against the truth; rows with a pose.
pub fn errors(samples: &[Sample], start: f64) -> ([f64; 4], usize) {
    let mut worst = [0.0_f64; 4];
    let mut poses = 0;
    for sample in samples {
        let t = start + sample.t_s;
        if let Some(measured) = sample.finger[0] {
            let (force, torque) = wrench(t);
            worst[0] = worst[0].max((Vector3::from(measured.force_n) - force).norm());
            worst[1] = worst[1].max((Vector3::from(measured.torque_nm) - torque).norm());
        }
        if let Some(measured) = sample.object {
            poses += 1;
            let [w, x, y, z] = measured.quaternion;
            let rotation = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
            let truth = object(t);
            worst[2] = worst[2].max((Vector3::from(measured.position_m) - truth.translation.vector).norm());
            worst[3] = worst[3].max(truth.rotation.angle_to(&rotation));
        }
    }
    (worst, poses)
}

#[test]
fn files_in_other_units_axes_signs_rates_and_clocks_become_the_truth_that_they_were_made_from() {
    let folder = tempfile::tempdir().expect("folder");
    let Import { dataset, signals, refused, bad_rows, .. } =
        import(&laboratory(folder.path())).expect("imports");
    assert!(refused.is_empty() && bad_rows.is_empty(), "{refused:?} {bad_rows:?}");
    assert_eq!(dataset.trials.len(), 2);
    let trial = &dataset.trials[0];
    let TrialInfo { trial: name, object, primitive, grip_n, speed_m_s, run, .. } = &trial.info;
    assert_eq!(
        (name.as_str(), object.as_str(), primitive.as_str()),
        ("obj4_g20_v10_r1", "obj4", "linear_push")
    );
    assert_eq!((*grip_n, *speed_m_s, *run), (Some(20.0), Some(0.01), Some(1)));
    let (worst, poses) = errors(&trial.samples, 0.0);
    // Straight lines over 4 ms of signals that bend by 5 N/s².
    assert!(worst[0] < 1e-4 && worst[1] < 1e-6, "{worst:?}");
    assert!(worst[2] < 1e-6 && worst[3] < 1e-5, "{worst:?}");
    // 1.5 s at 120 Hz on a base of 250 Hz: each sample one cell, no cell without a sample.
    assert!((175..=181).contains(&poses), "{poses}");
    assert!(trial.samples.iter().all(|sample| sample.gripper.is_some()));
    let signal = signals.iter().find(|signal| signal.signal == "object").expect("listed");
    assert!((signal.rate_hz - 120.0).abs() < 0.1 && (signal.filled - 0.48).abs() < 0.01, "{signal:?}");
}

#[test]
fn trials_follow_each_other_as_they_were_recorded_where_a_clock_ran_on_and_as_their_names_where_not() {
    let folder = tempfile::tempdir().expect("folder");
    let mapping = laboratory(folder.path());
    let order = |import: &Import| -> Vec<i64> {
        import.dataset.trials.iter().filter_map(|trial| trial.info.run).collect()
    };
    // Both begin at the same reading of the clock.
    let imported = import(&mapping).expect("imports");
    assert_eq!((order(&imported), imported.in_time_order), (vec![1, 2], false));
    write(folder.path(), "obj4_g20_v10_r1_ft.csv", &force_file(&[(60.0, 61.5)], false));
    let imported = import(&mapping).expect("imports");
    assert_eq!((order(&imported), imported.in_time_order), (vec![2, 1], true));
}

#[test]
fn one_recording_is_cut_into_its_trials_by_a_column_or_by_times_in_a_table() {
    let folder = tempfile::tempdir().expect("folder");
    let streams = STREAMS.split("[[streams]]").take(2).collect::<Vec<_>>().join("[[streams]]");
    let streams = streams.replace("{trial}_ft.csv", "all_ft.csv");
    write(folder.path(), "all_ft.csv", &force_file(&[(0.0, 0.5), (2.0, 2.8)], true));
    let constants = "constants = { object = \"obj4\", primitive = \"linear_push\" }\ncut_by = \"trial_no\"";
    let path = write(folder.path(), "column.toml", &mapping(constants, &streams));
    let cut = import(&path).expect("by column");
    let names: Vec<&str> = cut.dataset.trials.iter().map(|trial| trial.info.trial.as_str()).collect();
    assert_eq!(names, ["1", "2"]);
    let (worst, _) = errors(&cut.dataset.trials[1].samples, 2.0);
    assert!(worst[0] < 2e-3, "{worst:?}");
    // Microseconds since boot: the table's times are those of the recording's clock.
    write(
        folder.path(),
        "trials.csv",
        "trial,object,primitive,grip_n,start_s,end_s\na,obj4,linear_push,20,7000,7000.5\nb,obj4,linear_push,20,7002,7002.8\n\
         c,obj4,linear_push,20,7003,\n",
    );
    let path = write(folder.path(), "table.toml", &mapping("table = \"trials.csv\"", &streams));
    let table = import(&path).expect("by table");
    assert_eq!(table.dataset.trials.len(), 2);
    assert_eq!(table.dataset.trials[1].samples, cut.dataset.trials[1].samples);
    assert!(
        table.refused[0].contains("trial c") && table.refused[0].contains("end_s"),
        "{:?}",
        table.refused
    );
}

#[test]
fn one_recording_is_cut_into_its_trials_by_the_motion_of_the_gripper_between_rests() {
    let folder = tempfile::tempdir().expect("folder");
    // Motions of 0.5 s at 20 mm/s, 30 um of noise; between the second and the third are 0.3 s.
    let moved = |t: f64| -> f64 { [1.0, 4.0, 4.8, 7.0].map(|from| (t - from).clamp(0.0, 0.5)).iter().sum() };
    let mut text = String::from("t,x,y,z,qw,qx,qy,qz,fx,fy,fz\n");
    for k in 0..2500 {
        let t = f64::from(k) * 0.004;
        let noise = 3e-5 * (f64::from(k) * 12.9898).sin();
        let _ = writeln!(text, "{t},{},0,{noise},1,0,0,0,0,-20,0", 0.02 * moved(t) + noise);
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
[streams.gripper]
position = ["x", "y", "z"]
quaternion_wxyz = ["qw", "qx", "qy", "qz"]
"#;
    let cut = |by: &str| {
        let trials = format!(
            "constants = {{ object = \"obj4\", primitive = \"lift\", grip_n = 20.0 }}\ncut_by_motion = {by}"
        );
        import(&write(folder.path(), "m.toml", &mapping(&trials, stream)))
    };
    let import = cut("{ rest_s = 0.5 }").expect("by motion");
    let lasts = |trial: &stickslip_data::Trial| trial.samples.last().map_or(0.0, |sample| sample.t_s);
    let lengths: Vec<f64> = import.dataset.trials.iter().map(lasts).collect();
    let names: Vec<&str> = import.dataset.trials.iter().map(|trial| trial.info.trial.as_str()).collect();
    assert_eq!(names, ["1", "2", "3"]);
    // With half of the rest at either end, to the time over which is averaged.
    for (length, moving) in lengths.iter().zip([0.5, 1.3, 0.5]) {
        assert!((length - moving - 0.5).abs() < 0.2, "{lengths:?}");
    }
    assert_eq!(cut("{ rest_s = 0.2 }").expect("by shorter rests").dataset.trials.len(), 4);
    for (by, words) in [
        ("{ speed_m_s = 0.1 }", "the gripper never moves faster than 0.1 m/s"),
        ("{ rest_s = 0 }", "must be above 0"),
        ("{ rests_s = 1 }", "did you mean `rest_s`"),
        ("{}\ncut_by = \"x\"", "one of them"),
    ] {
        let why = cut(by).expect_err("refused").to_string();
        assert!(why.contains(words), "{words} is not in {why}");
    }
}

#[test]
fn what_is_wrong_is_named_with_the_way_out() {
    let folder = tempfile::tempdir().expect("folder");
    laboratory(folder.path());
    let refusal = |from: &str, to: &str| -> String {
        let text = mapping(NAMES, STREAMS);
        assert!(text.contains(from), "{from}");
        let path = write(folder.path(), "wrong.toml", &text.replace(from, to));
        match import(&path) {
            Ok(import) => import.refused.join("; "),
            Err(error) => error.to_string(),
        }
    };
    for (from, to, words) in [
        ("torque_unit", "torque_units", vec!["torque_units", "did you mean `torque_unit`", "line 31"]),
        ("stickslip-mapping/1", "stickslip-mapping/9", vec!["stickslip-mapping/1"]),
        ("\"N mm\"", "\"Nmmm\"", vec!["streams.ft.finger1", "Nmmm", "N mm"]),
        ("\"F1y\"", "\"Fly\"", vec!["_ft.csv", "no column \"Fly\"", "F1y"]),
        ("[\"y\", \"-z\", \"-x\"]", "[\"y\", \"z\", \"-x\"]", vec!["left-handed"]),
        (
            "clock = \"starts_together\"",
            "clock = \"shared\"",
            vec!["never run at the same time", "starts_together"],
        ),
        ("{trial}_mocap.csv", "{trial}_camera.csv", vec!["streams.mocap.file", "no file matches"]),
        ("(?<object>obj\\d)", "(?<object>obj[5-9])", vec!["does not match", "obj4_g20_v10_r1"]),
        ("?<speed_m_s>", "?<speed_ms>", vec!["speed_ms", "did you mean speed_m_s"]),
        ("acts_on = \"finger\"\n", "", vec!["acts_on", "missing"]),
        ("acts_on = \"finger\"\n", "acts_on = \"fingr\"\n", vec!["fingr", "did you mean `finger`"]),
        ("diameter_m", "diametre_m", vec!["[dataset].fingers.diameter_m", "missing"]),
    ] {
        let refused = refusal(from, to);
        for word in words {
            assert!(refused.contains(word), "{from} -> {to}: {word:?} is not in: {refused}");
        }
    }
}

#[test]
fn a_bad_row_is_reported_with_its_line_and_a_trial_without_its_file_is_listed() {
    let folder = tempfile::tempdir().expect("folder");
    let path = laboratory(folder.path());
    let file = folder.path().join("obj4_g20_v10_r1_ft.csv");
    let text = fs::read_to_string(&file).expect("read");
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines[10] = lines[10].replacen(';', ";err", 1);
    lines[20] = lines[19].clone();
    fs::write(&file, lines.join("\n")).expect("written");
    fs::remove_file(folder.path().join("obj4_g20_v10_r2_mocap.csv")).expect("removed");
    let import = import(&path).expect("the rest imports");
    let bad: Vec<(usize, &str)> =
        import.bad_rows.iter().map(|(_, row)| (row.line, row.reason.as_str())).collect();
    assert_eq!(bad.len(), 2, "{bad:?}");
    assert!(bad[0].0 == 11 && bad[0].1.contains("not a number"), "{bad:?}");
    assert!(bad[1].0 == 21 && bad[1].1.contains("time does not rise"), "{bad:?}");
    assert!(
        import.refused[0].contains("obj4_g20_v10_r2") && import.refused[0].contains("mocap"),
        "{:?}",
        import.refused
    );
    assert_eq!(import.dataset.trials.len(), 1);
}

#[test]
fn a_tare_takes_off_a_constant_offset_of_the_sensor() {
    let folder = tempfile::tempdir().expect("folder");
    write(folder.path(), "a.csv", "t,fx,fy,fz\n0,1,2,3\n0.004,1,2,3\n0.008,1,2,3\n0.012,5,2,3\n");
    let streams = "[[streams]]\nname = \"ft\"\nfile = \"a.csv\"\ntime = { column = \"t\" }\n[streams.finger1]\n\
        force = [\"fx\", \"fy\", \"fz\"]\nacts_on = \"object\"\ntare_s = [0.0, 0.008]\n";
    let constants = "constants = { object = \"obj4\", primitive = \"linear_push\" }";
    let import = import(&write(folder.path(), "m.toml", &mapping(constants, streams))).expect("imports");
    let last = import.dataset.trials[0].samples.last().and_then(|sample| sample.finger[0]).expect("measured");
    assert_eq!(last.force_n, [4.0, 0.0, 0.0]);
    assert_eq!(import.tares[0].2[..3], [1.0, 2.0, 3.0]);
}

#[test]
fn the_mapping_that_is_guessed_for_the_format_s_own_columns_imports_the_same_samples() {
    let folder = tempfile::tempdir().expect("folder");
    let made = import(&laboratory(folder.path())).expect("imports").dataset;
    let mut trial = made.trials[0].clone();
    for sample in &mut trial.samples {
        // Where the pose was not measured, the guess cannot know either: all rows have one here.
        sample.object = Some(stickslip_data::import::recording::frames::pose(&object(sample.t_s)));
        sample.pusher_wrench = sample.finger[0];
        sample.finger[1] = sample.finger[0];
    }
    let one = Dataset { trials: vec![trial.clone()], ..made };
    let out = folder.path().join("one");
    stickslip_data::write(&one, &out).expect("written");
    let table = out.join("trials/obj4_g20_v10_r1.csv");
    let text = guess::guess(&[(&table, &table)]).expect("guessed");
    let path = write(folder.path(), "guessed.toml", &text);
    let again = import(&path).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let differs = |a: &Sample, b: &Sample| {
        let close = |a: [f64; 3], b: [f64; 3]| (Vector3::from(a) - Vector3::from(b)).norm() < 1e-9;
        let wrenches = [0, 1].into_iter().all(|finger| match (a.finger[finger], b.finger[finger]) {
            (Some(a), Some(b)) => close(a.force_n, b.force_n) && close(a.torque_nm, b.torque_nm),
            _ => false,
        });
        let poses = [(a.object, b.object), (a.gripper, b.gripper)]
            .iter()
            .all(|pair| matches!(pair, (Some(a), Some(b)) if close(a.position_m, b.position_m)));
        !(wrenches && poses && a.pusher_wrench.is_some() && (a.t_s - b.t_s).abs() < 1e-9)
    };
    let read = &again.dataset.trials[0].samples;
    assert_eq!(read.len(), trial.samples.len());
    let wrong = trial.samples.iter().zip(read).find(|(a, b)| differs(a, b));
    assert!(wrong.is_none(), "{wrong:?}\n{text}");
}

#[test]
fn of_two_devices_files_the_guess_finds_the_trial_s_name_the_clocks_units_and_who_is_who() {
    let folder = tempfile::tempdir().expect("folder");
    laboratory(folder.path());
    let file = |name: &str| folder.path().join(format!("obj4_g20_v10_r1_{name}.csv"));
    let (force, capture) = (file("ft"), file("mocap"));
    let text = guess::guess(&[
        (&force, Path::new("obj4_g20_v10_r1_ft.csv")),
        (&capture, Path::new("obj4_g20_v10_r1_mocap.csv")),
    ])
    .expect("guessed");
    for words in [
        "file = \"{trial}_ft.csv\"",
        "name = \"mocap\"",
        "time = { column = \"t_us\", unit = \"us\" }",
        "time = { column = \"Time (ms)\", unit = \"ms\", clock = \"estimated\" }",
        r"pattern = '^(?<object>[^_]+)_g(?<grip_n>-?\d+(?:\.\d+)?)_v(?<speed_m_s>-?\d+(?:\.\d+)?)_r(?<run>-?\d+(?:\.\d+)?)$'",
        "units = { speed_m_s = \"mm/s\" }",
        "id = \"obj4\"",
        "[streams.finger1]",
        "torque_unit = \"N mm\"",
        "[streams.object]",
        "unit = \"mm\"",
        "quaternion_wxyz = [\"Block QW\", \"Block QX\", \"Block QY\", \"Block QZ\"]",
        "# not used: trial_no",
    ] {
        assert!(text.contains(words), "{words} is not in:\n{text}");
    }
}

#[test]
fn a_file_that_is_no_table_of_numbers_is_refused_without_its_bytes_and_with_the_first_reason() {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("obj4_g20_v10_r1_ft.csv");
    let path = laboratory(folder.path());
    let text = fs::read_to_string(&file).expect("read");
    let (header, rows) = text.split_once('\n').expect("a header");
    let words = rows.lines().map(|row| row.replace(';', ";x") + "\n").collect::<String>();
    for (bytes, new, why) in [
        (b"PK\x03\x04\x14\0\x1b[31m\0\0\n".to_vec(), "this is no text", "this is no text"),
        (format!("{header}\n{words}").into_bytes(), "", "refused); the first: "),
        (b"notes,of\nthe,day\n".to_vec(), "no cell below notes, of is a number", "no column"),
    ] {
        fs::write(&file, &bytes).expect("written");
        let refused = import(&path).expect("the other trial imports").refused.join("; ");
        assert!(refused.contains(why) && !refused.contains('\u{1b}'), "{refused}");
        let guessed = guess::guess(&[(&file, Path::new("ft.csv"))]);
        let told = guessed.err().map_or_else(String::new, |error| error.to_string());
        assert!(told.contains(new) && told.is_empty() == new.is_empty(), "{told}");
    }
}

/// A force file of 250 Hz whose stamps count from 1970, in nanoseconds or in seconds with all their digits.
fn since_1970(first_ns: i64, rows: i64, unit: &str) -> String {
    let mut text = String::from("t;F1x;F1y;F1z\n");
    for row in 0..rows {
        let ns = first_ns + 4_000_000 * row;
        let stamp = match unit {
            "ns" => ns.to_string(),
            _ => format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000),
        };
        let _ = writeln!(text, "{stamp};{row};-20;0");
    }
    text
}

#[test]
fn every_row_of_a_recording_at_the_base_s_rate_is_kept_whatever_its_clock_counts_from() {
    let streams = |unit: &str| {
        format!(
            "[[streams]]\nname = \"ft\"\nfile = \"{{trial}}.csv\"\ntime = {{ column = \"t\", unit = \"{unit}\" }}\n\
             [streams.finger1]\nforce = [\"F1x\", \"F1y\", \"F1z\"]\nacts_on = \"object\"\n\
             [fixed.gripper]\nposition_m = [0.0, 0.0, 0.5]\n"
        )
    };
    let constants = "constants = { object = \"obj4\", primitive = \"linear_push\" }";
    let rows = 500;
    for unit in ["s", "ns"] {
        let folder = tempfile::tempdir().expect("folder");
        let path = write(folder.path(), "mapping.toml", &mapping(constants, &streams(unit)));
        for k in 0..20 {
            // A stamp that an `f64` of seconds rounds by up to 0.12 us.
            let first_ns = 1_732_732_800_000_000_000 + 60_000_000_000 * k + 123_456_789 * (k + 1);
            write(folder.path(), &format!("t{k:02}.csv"), &since_1970(first_ns, rows, unit));
        }
        let imported = import(&path).expect("imports");
        assert!(imported.refused.is_empty() && imported.in_time_order, "{:?}", imported.refused);
        assert_eq!(imported.dataset.trials.len(), 20);
        for trial in &imported.dataset.trials {
            let forces: Vec<f64> =
                trial.samples.iter().filter_map(|s| s.finger[0].map(|w| w.force_n[0])).collect();
            assert_eq!(forces.len(), rows as usize, "{unit}: {}", trial.info.trial);
            // Each row is one of the base: nothing is interpolated.
            let whole = forces.iter().zip(0..).all(|(x, row)| *x == f64::from(row));
            assert!(whole, "{unit}: {}", trial.info.trial);
        }
    }
}
