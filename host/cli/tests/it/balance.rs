//! The balance of measured forces, the tare and the noise floor on data whose truth is known.

use std::collections::BTreeMap;

use nalgebra::{UnitQuaternion, Vector3};
use stickslip_analysis::evidence::balance::{NotChecked, balance};
use stickslip_analysis::evidence::offsets::at_rest;
use stickslip_analysis::evidence::stages::{Stage, stages};
use stickslip_data::{
    ContactSpec, Dataset, Description, FORMAT, ObjectSpec, Pose, Sample, Sensors, Trial, TrialInfo, Wrench,
    WrenchSensor, write,
};

use crate::documents::{document, stickslip};

const PUSH_N: f64 = 6.0;
const MASS_KG: f64 = 0.2005;

fn description() -> Description {
    let sensor = |force_uncertainty_n| WrenchSensor {
        force_noise_n: 0.02,
        force_uncertainty_n,
        ..WrenchSensor::default()
    };
    let contact = |kind: &str| ContactSpec { contact: kind.to_owned(), ..ContactSpec::default() };
    Description {
        format: FORMAT.to_owned(),
        name: "balance".to_owned(),
        sample_rate_hz: 250.0,
        gravity_m_s2: [0.0, 0.0, -9.81],
        objects: vec![ObjectSpec {
            id: "obj4".to_owned(),
            shape: "prism".to_owned(),
            length_m: Some(0.1),
            side_m: Some(0.025),
            across_flats_m: None,
            vertices_m: None,
            height_m: None,
            mass_kg: MASS_KG,
            inertia_kg_m2: None,
        }],
        fingers: Some(contact("point")),
        pushers: BTreeMap::from([("linear_push".to_owned(), contact("plane"))]),
        supports: BTreeMap::new(),
        sensors: Sensors { finger: sensor(0.25), pusher: sensor(0.75), ..Sensors::default() },
    }
}

/// A slow push along -X with a gripper that is turned and keeps turning slowly, and `offset_n`
/// on finger 1 (gripper axes). The noise is a fixed pattern of 0.01 N; `run` shifts it.
fn trial(offset_n: [f64; 3], run: i64) -> Trial {
    let samples = (0..500_i64)
        .map(|k| {
            let t_s = k as f64 * 0.004;
            let turn = UnitQuaternion::from_euler_angles(0.3, 0.2 + 0.05 * t_s, 0.7);
            let push = if k < 100 { 0.0 } else { PUSH_N };
            let carried = turn.inverse() * Vector3::new(push, 0.0, 9.81 * MASS_KG);
            let grip = Vector3::new(0.0, 20.0, 0.0);
            let noise = 0.01 * (((k * 7 + run * 3) % 11) as f64 - 5.0) / 5.0;
            let force = |force: Vector3<f64>| {
                let force_n = (force.add_scalar(noise)).into();
                Some(Wrench { force_n, torque_nm: [0.0; 3] })
            };
            let q = turn.quaternion();
            let pose = Pose { position_m: [0.0, 0.0, -0.01 * t_s], quaternion: [q.w, q.i, q.j, q.k] };
            Sample {
                t_s,
                grip_cmd_n: Some(20.0),
                gripper: Some(pose),
                object: Some(pose),
                pusher: None,
                finger: [force(0.5 * carried - grip + Vector3::from(offset_n)), force(0.5 * carried + grip)],
                pusher_wrench: force(Vector3::new(-push, 0.0, 0.0)),
            }
        })
        .collect();
    let info = TrialInfo {
        trial: format!("t{run}"),
        file: format!("trials/t{run}.csv"),
        object: "obj4".to_owned(),
        primitive: "linear_push".to_owned(),
        grip_n: Some(20.0),
        run: Some(run),
        ..TrialInfo::default()
    };
    Trial { info, samples }
}

#[test]
fn measured_forces_of_a_slow_push_balance_before_and_after_contact() {
    let trial = trial([0.0; 3], 1);
    let stages = stages(&trial);
    assert_eq!(stages.contact, Some(100));
    let balances = balance(&description(), &trial, &stages).expect("all is measured");
    let of: Vec<Stage> = balances.iter().map(|balance| balance.stage).collect();
    assert!(of.contains(&Stage::BeforeContact) && of.contains(&Stage::Pushed), "{of:?}");
    for balance in balances {
        assert!(!balance.fails(), "{balance:?}");
        assert!(balance.sum_n.iter().all(|sum| sum.abs() < 0.03), "{balance:?}");
        assert_eq!(balance.bound_n, 1.25);
    }
}

#[test]
fn an_offset_beyond_the_sensors_uncertainty_is_a_sensor_problem_and_the_rest_before_contact_shows_it() {
    let offset_n = [2.0, -0.5, 0.3];
    let mut trial = trial(offset_n, 1);
    let stages = stages(&trial);
    let failing = balance(&description(), &trial, &stages).expect("measured");
    assert!(failing.iter().all(|balance| balance.fails()), "{failing:?}");
    let found = at_rest(&description(), &trial, &stages).expect("there is a phase before contact");
    for (sum, true_offset) in found.fingers_sum_n.iter().zip(offset_n) {
        assert!((sum - true_offset).abs() < 0.01, "{found:?}");
    }
    assert!(found.pusher_n.expect("measured").iter().all(|force| force.abs() < 0.005), "{found:?}");
    for sample in &mut trial.samples {
        let force = &mut sample.finger[0].as_mut().expect("measured").force_n;
        force.iter_mut().zip(found.fingers_sum_n).for_each(|(f, sum)| *f -= sum);
    }
    let balanced = balance(&description(), &trial, &stages).expect("measured");
    assert!(balanced.iter().all(|balance| !balance.fails()), "{balanced:?}");
}

#[test]
fn what_is_not_measured_is_not_balanced() {
    let mut on_table = description();
    let patch = ContactSpec { contact: "patch".to_owned(), ..ContactSpec::default() };
    on_table.supports.insert("linear_push".to_owned(), patch);
    let mut trial = trial([0.0; 3], 1);
    let found = stages(&trial);
    assert_eq!(balance(&on_table, &trial, &found), Err(NotChecked::SupportNotMeasured));
    assert_eq!(at_rest(&on_table, &trial, &found), None);
    for sample in &mut trial.samples {
        sample.finger[1] = None;
    }
    assert_eq!(balance(&description(), &trial, &found), Err(NotChecked::FingersNotMeasured));
}

#[test]
fn sensors_that_stand_turned_are_suspected_where_that_balances_the_forces_and_a_diagnosis_may_follow() {
    let folder = tempfile::tempdir().expect("folder");
    // Finger 1 about the gripper's Z: a share of the grip shows along the push.
    let mut trials: Vec<Trial> = (1..=3).map(|run| trial([0.0; 3], run)).collect();
    for sample in trials.iter_mut().flat_map(|trial| &mut trial.samples) {
        for (k, wrench) in sample.finger.iter_mut().enumerate() {
            let force = &mut wrench.as_mut().expect("measured").force_n;
            let turn = if k == 0 { Vector3::new(0.0, 0.0, 0.12) } else { Vector3::zeros() };
            *force = (Vector3::from(*force) + turn.cross(&Vector3::from(*force))).into();
        }
    }
    let data = Dataset { folder: folder.path().to_owned(), description: description(), trials };
    write(&data, folder.path()).expect("written");
    let output = stickslip().args(["--json", "check"]).arg(folder.path()).output().expect("run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report = document("check", &output.stdout);
    assert_eq!(report["findings"].as_array().map(Vec::len), Some(0), "{}", report["findings"]);
    assert_eq!(report["balance"]["failing"], 3);
    let first = &report["suspects"][0];
    let turned: Vec<f64> = (0..3).filter_map(|k| first["fault"]["turned"][k].as_f64()).collect();
    assert_eq!(first["effect"], "sensor_misalignment");
    // By which of two fingers with the same load, a balance cannot tell: of finger 2 it is the other way.
    let about_z = if first["sensor"] == "finger 1" { turned[2] } else { -turned[2] };
    assert!((about_z - 0.12).abs() < 0.02, "{first}");
    let human = stickslip().arg("check").arg(folder.path()).assert().success();
    let text = String::from_utf8_lossy(&human.get_output().stdout).into_owned();
    assert!(text.contains("finger 1 turned by") && text.contains("stickslip calibrate"), "{text}");
}

#[test]
fn check_fails_on_forces_that_never_balance_and_on_refusals_and_reports_the_rest() {
    let folder = tempfile::tempdir().expect("folder");
    let trials = vec![trial([2.0, 0.0, 0.0], 1), trial([2.0, 0.0, 0.0], 2)];
    let data = Dataset { folder: folder.path().to_owned(), description: description(), trials };
    write(&data, folder.path()).expect("written");
    let human = stickslip().arg("check").arg(folder.path()).assert().code(1);
    let text = String::from_utf8_lossy(&human.get_output().stdout).into_owned();
    for part in ["2 trials, 1000 samples", "2 trials in 1 groups", "FORCES DO NOT BALANCE in 2 of 2"] {
        assert!(text.contains(part), "{part} missing in\n{text}");
    }
    assert!(!text.contains("No errors."), "{text}");
    let json = stickslip().args(["check", "--json"]).arg(folder.path()).assert().code(1);
    let report = document("check", &json.get_output().stdout);
    assert_eq!(report["balance"]["failing"], 2);
    let floor = report["channels"][6]["floor"][1].as_f64().expect("repeated: a floor");
    assert!(floor > 0.001 && floor < 0.02, "{floor}");

    // One bad trial: reported, the other still there, exit code 1.
    std::fs::write(folder.path().join("trials/t1.csv"), "t_s\n0\nx\n1\n").expect("written");
    let json = stickslip().args(["check", "--json"]).arg(folder.path()).assert().code(1);
    let report = document("check", &json.get_output().stdout);
    assert_eq!(
        (&report["trials"], &report["channels"][6]["floor"][1]),
        (&1.into(), &serde_json::Value::Null)
    );
    let error = report["errors"][0].as_str().expect("told");
    assert!(error.contains("t1.csv, line 3, column t_s, value \"x\""), "{error}");
}

#[test]
fn a_data_set_without_repetition_says_that_it_has_no_noise_floor() {
    let folder = tempfile::tempdir().expect("folder");
    let data = Dataset {
        folder: folder.path().to_owned(),
        description: description(),
        trials: vec![trial([0.0; 3], 1)],
    };
    write(&data, folder.path()).expect("written");
    let human = stickslip().arg("check").arg(folder.path()).assert().success();
    let text = String::from_utf8_lossy(&human.get_output().stdout).into_owned();
    assert!(text.contains("repetitions: none, so there is no noise floor"), "{text}");
}

#[test]
fn a_missing_data_set_and_wrong_usage_are_told_apart_by_the_exit_code() {
    let missing = stickslip().args(["check", "/no/such/data"]).assert().code(1);
    let text = String::from_utf8_lossy(&missing.get_output().stderr).into_owned();
    assert!(text.starts_with("error: /no/such/data/dataset.toml: the file is missing"), "{text}");
    stickslip().arg("check").assert().code(2);
}

#[test]
fn true_forces_of_the_rig_balance_and_its_hidden_sensor_errors_are_what_the_rest_before_contact_shows() {
    use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, objects, run};
    let description = objects::bench("balance");
    for primitive in [Primitive::LinearPush, Primitive::Pivot] {
        let condition = Condition { speed_m_s: 0.02, ..Condition::new(primitive, "obj4") };
        let ideal =
            Setup { description: description.clone(), reality: Reality::ideal(0.4, 0.25), step_s: STEP_S };
        let trial = run(&ideal, &condition, 1, 3).expect("suits the rig").trial;
        let found = stages(&trial);
        for balance in balance(&description, &trial, &found).expect("all is measured") {
            assert!(balance.sum_n.iter().all(|sum| sum.abs() < 0.05), "{primitive:?}: {balance:?}");
        }
    }
    let condition = Condition { speed_m_s: 0.02, ..Condition::new(Primitive::LinearPush, "obj4") };
    let reality = Reality::draw(&description, Nuisance::PAPER, 5);
    let [finger1, finger2, pusher] = reality.bias;
    let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
    let trial = run(&setup, &condition, 1, 3).expect("suits the rig").trial;
    let found = stages(&trial);
    let tare = at_rest(&description, &trial, &found).expect("there is a phase before contact");
    for axis in 0..3 {
        let sum = finger1[axis] + finger2[axis];
        assert!((tare.fingers_sum_n[axis] - sum).abs() < 0.03, "axis {axis}: {tare:?}, true {sum}");
        let measured = tare.pusher_n.expect("measured")[axis];
        assert!((measured - pusher[axis]).abs() < 0.03, "axis {axis}: {tare:?}, true {}", pusher[axis]);
    }
}
