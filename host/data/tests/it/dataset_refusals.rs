//! Everything that the format's page refuses is refused, with file, line and column.

use std::fs;
use std::path::Path;

use stickslip_data::{DatasetError, Line, Problem, read, read_lenient};
use tempfile::TempDir;

const TOML: &str = r#"format = "stickslip-dataset/1"
name = "two trials"
sample_rate_hz = 250
gravity_m_s2 = [0, 0, -9.81]
my_own_key = "kept out of the way"

[[objects]]
id = "obj4"
shape = "prism"
length_m = 0.1
side_m = 0.025
mass_kg = 0.2005

[fingers]
contact = "disc"
diameter_m = 0.02

[pushers.linear_push]
contact = "plane"

[sensors.finger]
force_noise_n = 0.02
"#;

const TRIALS: &str = "trial,file,object,primitive,grip_n,speed_m_s,run,operator\n\
    a,trials/a.csv,obj4,linear_push,20,0.01,1,Ann\n\
    b,trials/b.csv,obj4,linear_push,20,0.01,2,\n";

const TABLE: &str = "t_s,grip_cmd_n,object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz,finger1_fx_n,temperature\n\
    0,20,0,0,0,1,0,0,0,0.5,21\n\
    0.004,20,,,,,,,,,21\n\
    0.008,20,0,0,0,1.005,0,0,0,0.5,21\n";

/// A good data set with `edit` applied to one file.
fn folder(edit: impl Fn(&str, &str) -> Option<String>) -> TempDir {
    let folder = TempDir::new().expect("temporary folder");
    fs::create_dir(folder.path().join("trials")).expect("folder");
    for (name, text) in
        [("dataset.toml", TOML), ("trials.csv", TRIALS), ("trials/a.csv", TABLE), ("trials/b.csv", TABLE)]
    {
        let text = edit(name, text).unwrap_or_else(|| text.to_owned());
        if text != "(missing)" {
            fs::write(folder.path().join(name), text).expect("written");
        }
    }
    folder
}

/// Replaces `from` by `to` in `file` and gives the refusal.
fn refusal(file: &str, from: &str, to: &str) -> DatasetError {
    let folder = folder(|name, text| {
        (name == file).then(|| {
            assert!(text.contains(from), "{file} has no {from}");
            text.replacen(from, to, 1)
        })
    });
    let error = read(folder.path()).expect_err("must be refused");
    assert_eq!(error.place.file, folder.path().join(file), "{error}");
    error
}

fn assert_place(error: &DatasetError, line: u64, column: &str, value: Option<&str>) {
    assert_eq!(error.place.line, Some(Line::Text(line)), "{error}");
    assert_eq!(error.place.column.as_deref(), Some(column), "{error}");
    assert_eq!(error.place.value.as_deref(), value, "{error}");
    let text = error.to_string();
    assert!(text.contains(&format!("line {line}, column {column}")), "{text}");
}

#[test]
fn the_good_data_set_reads_with_its_unknown_keys_and_columns() {
    let folder = folder(|_, _| None);
    let reading = read_lenient(folder.path()).expect("readable");
    assert_eq!(reading.errors, []);
    // As text: a component that was not measured is NaN, which equals nothing.
    let strict = read(folder.path()).expect("readable");
    assert_eq!(format!("{:?}", reading.dataset), format!("{strict:?}"));
    let trial = &reading.dataset.trials[0];
    assert_eq!(trial.info.extra.get("operator").map(String::as_str), Some("Ann"));
    assert_eq!(trial.samples.len(), 3);
    assert_eq!(trial.samples[1].object, None, "empty cells are not measured");
    let object = trial.samples[2].object.expect("measured");
    assert_eq!(object.quaternion, [1.0, 0.0, 0.0, 0.0], "normalised");
    let wrench = trial.samples[0].finger[0].expect("measured in part");
    assert_eq!(wrench.force_n[0], 0.5);
    assert!(wrench.force_n[1].is_nan() && wrench.torque_nm.iter().all(|t| t.is_nan()));
    let warnings: Vec<String> = reading.warnings.iter().map(|w| w.text.clone()).collect();
    assert!(warnings.iter().any(|text| text.contains("my_own_key")), "{warnings:?}");
    assert!(warnings.iter().any(|text| text.contains("temperature")), "{warnings:?}");
    assert_eq!(reading.warnings.iter().map(|w| w.files).max(), Some(2), "joined over trials");
}

#[test]
fn an_unknown_format_is_refused_before_anything_else() {
    let error = refusal("dataset.toml", "stickslip-dataset/1", "stickslip-dataset/2");
    assert_eq!(error.problem, Problem::UnknownFormat);
    assert_place(&error, 1, "format", Some("stickslip-dataset/2"));
}

#[test]
fn a_missing_file_is_named() {
    for missing in ["dataset.toml", "trials.csv", "trials/b.csv"] {
        let folder = folder(|name, _| (name == missing).then(|| "(missing)".to_owned()));
        let error = read(folder.path()).expect_err("must be refused");
        assert!(matches!(error.problem, Problem::MissingFile(_)), "{error}");
        assert_eq!(error.place.file, folder.path().join(missing));
    }
    let error = read(Path::new("/no/such/folder")).expect_err("must be refused");
    assert!(error.to_string().starts_with("/no/such/folder/dataset.toml: the file is missing"));
}

#[test]
fn a_number_that_does_not_parse_or_is_not_finite_is_refused() {
    for (text, problem) in [
        ("abc", Problem::NotANumber),
        ("0,5", Problem::Csv(String::new())),
        ("NaN", Problem::NonFinite),
        ("-inf", Problem::NonFinite),
        ("1e999", Problem::NonFinite),
    ] {
        let error = refusal("trials/b.csv", "1.005,0,0,0,0.5", &format!("1.005,0,0,0,{text}"));
        assert_eq!(std::mem::discriminant(&error.problem), std::mem::discriminant(&problem), "{error}");
        if text != "0,5" {
            assert_place(&error, 4, "finger1_fx_n", Some(text));
        }
    }
    let error = refusal("trials.csv", "20,0.01,2", "20,fast,2");
    assert_place(&error, 3, "speed_m_s", Some("fast"));
    let error = refusal("trials.csv", "20,0.01,2", "20,0.01,1.5");
    assert_eq!(error.problem, Problem::NotAnInteger);
    assert_place(&error, 3, "run", Some("1.5"));
    let error = refusal("dataset.toml", "[0, 0, -9.81]", "[0, 0, nan]");
    assert_eq!(error.problem, Problem::NonFinite);
    assert_place(&error, 4, "gravity_m_s2[2]", Some("nan"));
    for (given, said) in
        [("[0, 0, -9.81, 4]", "4 number(s) where 3 are needed"), ("[0, -9.81]", "2 number(s)")]
    {
        let error = refusal("dataset.toml", "[0, 0, -9.81]", given);
        assert_eq!(error.place.line, Some(Line::Text(4)), "{error}");
        assert!(error.to_string().contains(said), "{error}");
    }
    let error = refusal("dataset.toml", "length_m = 0.1", "length_m = \"long\"");
    assert_eq!(error.place.line, Some(Line::Text(10)), "{error}");
    assert_eq!(error.place.column.as_deref(), Some("12"), "{error}");
    let error = refusal("dataset.toml", "name = \"two trials\"", "name = two trials");
    assert_eq!(error.place.line, Some(Line::Text(2)), "{error}");
}

#[test]
fn line_numbers_hold_with_crlf_blank_lines_and_a_byte_order_mark() {
    let folder = folder(|name, text| {
        (name == "trials/a.csv").then(|| {
            let text = text.replace("\n", "\r\n\r\n").replace("1.005", "x");
            format!("\u{feff}{text}")
        })
    });
    let error = read(folder.path()).expect_err("must be refused");
    assert_place(&error, 7, "object_qw", Some("x"));
}

#[test]
fn time_that_goes_backwards_or_stands_still_is_refused() {
    for (time, previous_s) in [("0.003", 0.004), ("0.004", 0.004)] {
        let error = refusal("trials/a.csv", "0.008,", &format!("{time},"));
        assert_eq!(error.problem, Problem::TimeNotRising { previous_s });
        assert_place(&error, 4, "t_s", Some(time));
    }
    let error = refusal("trials/a.csv", "0.008,", ",");
    assert_place(&error, 4, "t_s", None);
}

#[test]
fn a_quaternion_off_by_more_than_one_per_cent_is_refused() {
    let error = refusal("trials/a.csv", "1.005", "1.02");
    assert!(matches!(error.problem, Problem::QuaternionNorm { norm } if norm == 1.02));
    assert_place(&error, 4, "object_qw", Some("1.02"));
}

#[test]
fn an_object_that_the_description_lacks_is_refused_with_those_it_has() {
    let error = refusal("trials.csv", "b,trials/b.csv,obj4", "b,trials/b.csv,obj9");
    assert_place(&error, 3, "object", Some("obj9"));
    assert!(error.to_string().contains("obj4"), "{error}");
}

#[test]
fn a_negative_mass_length_or_grip_is_refused() {
    let error = refusal("dataset.toml", "mass_kg = 0.2005", "mass_kg = -0.2005");
    assert_eq!(error.problem, Problem::Negative("a mass"));
    assert_place(&error, 12, "objects[0].mass_kg", Some("-0.2005"));
    let error = refusal("dataset.toml", "side_m = 0.025", "side_m = -0.025");
    assert_place(&error, 11, "objects[0].side_m", Some("-0.025"));
    let error = refusal("dataset.toml", "diameter_m = 0.02", "diameter_m = -1");
    assert_place(&error, 16, "fingers.diameter_m", Some("-1"));
    let error = refusal("trials.csv", "linear_push,20,0.01,2", "linear_push,-20,0.01,2");
    assert_place(&error, 3, "grip_n", Some("-20"));
    let error = refusal("trials/a.csv", "0.008,20", "0.008,-20");
    assert_place(&error, 4, "grip_cmd_n", Some("-20"));
    let error = refusal("dataset.toml", "mass_kg = 0.2005", "mass_kg = 0");
    assert_eq!(error.problem, Problem::NotPositive("a mass"), "an object without mass");
}

#[test]
fn what_the_shape_or_contact_needs_must_be_there() {
    let error = refusal("dataset.toml", "side_m = 0.025", "");
    assert_place(&error, 7, "objects[0].side_m", None);
    let error = refusal("dataset.toml", "mass_kg = 0.2005", "");
    assert!(error.to_string().contains("`mass_kg` is missing"), "{error}");
    assert_eq!(error.place.line, Some(Line::Text(7)), "{error}");
    let error = refusal("dataset.toml", "\"prism\"", "\"sphere\"");
    assert_place(&error, 9, "objects[0].shape", Some("sphere"));
    let error = refusal("dataset.toml", "\"plane\"", "\"disc\"");
    assert_place(&error, 19, "pushers.linear_push.contact", Some("disc"));
    let error = refusal("trials/a.csv", "t_s", "time");
    assert_eq!(error.problem, Problem::MissingColumn);
    assert_place(&error, 1, "t_s", None);
    let error = refusal("trials/a.csv", "grip_cmd_n", "t_s");
    assert_eq!(error.problem, Problem::DuplicateColumn);
    let error = refusal("trials.csv", "b,trials", "a,trials");
    assert_eq!(error.problem, Problem::Duplicate);
    assert_place(&error, 3, "trial", Some("a"));
    let error = refusal("trials.csv", "trials/b.csv", "../b.csv");
    assert_eq!(error.problem, Problem::OutsideFolder);
}

#[test]
fn one_bad_trial_leaves_the_others() {
    let folder =
        folder(|name, text| (name == "trials/a.csv").then(|| text.replacen("0.004,20", "0.004,many", 1)));
    let reading = read_lenient(folder.path()).expect("the rest is kept");
    assert_eq!(reading.errors.len(), 1);
    assert_place(&reading.errors[0], 3, "grip_cmd_n", Some("many"));
    let kept: Vec<&str> = reading.dataset.trials.iter().map(|trial| trial.info.trial.as_str()).collect();
    assert_eq!(kept, ["b"]);
}

#[test]
fn the_good_rows_of_a_cut_file_are_kept_and_the_cut_is_told() {
    let folder = folder(|name, text| (name == "trials/a.csv").then(|| text[..text.len() - 20].to_owned()));
    let reading = read_lenient(folder.path()).expect("the rest is kept");
    assert_eq!(reading.dataset.trials.len(), 2);
    assert_eq!(reading.dataset.trials[0].samples.len(), 2);
    assert_eq!(reading.errors.len(), 1);
    assert_eq!(reading.errors[0].place.line, Some(Line::Text(4)));
    assert!(reading.errors[0].to_string().contains("cut here"));
    assert!(read(folder.path()).is_err(), "strict reading refuses");
}

#[test]
fn a_bad_row_of_trials_csv_leaves_the_other_trials() {
    let folder = folder(|name, text| {
        (name == "trials.csv").then(|| text.replacen("a,trials/a.csv,obj4", "a,trials/a.csv,x", 1))
    });
    let reading = read_lenient(folder.path()).expect("the rest is kept");
    assert_place(&reading.errors[0], 2, "object", Some("x"));
    assert_eq!(reading.dataset.trials.len(), 1);
}
