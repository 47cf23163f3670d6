//! Calibration and force bands on small data sets of the rig, whose truth is known.

use std::path::Path;

use stickslip_analysis::calibrate::{Coefficient, Remark, Share, of_primitive};
use stickslip_analysis::evidence::force_bands::bands;
use stickslip_analysis::model::file::ModelFile;
use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::simulate::prepare;
use stickslip_data::{Pose, Trial};
use stickslip_rig::{self, Condition, Nuisance, Primitive, Reality, STEP_S, Setup, objects};

fn setup(mu_finger: f64, mu_pusher: f64) -> Setup {
    let reality = Reality::ideal(mu_finger, mu_pusher);
    Setup { description: objects::bench("test"), reality, step_s: STEP_S }
}

fn pushes(setup: &Setup) -> Vec<(usize, Trial)> {
    let conditions = [20.0, 27.0, 35.0].map(|grip_n| Condition {
        grip_n,
        label: format!("push-{grip_n}"),
        ..Condition::new(Primitive::LinearPush, "obj4")
    });
    conditions.iter().map(|c| stickslip_rig::simulate(setup, c, 1, 1).unwrap()).enumerate().collect()
}

#[test]
fn calibration_finds_the_finger_friction_of_the_rig_within_its_interval_or_two_percent() {
    let setup = setup(0.45, 0.25);
    let trials = pushes(&setup);
    let result =
        of_primitive(&setup.description, "linear_push", &trials, &default_model(), Share::of(0.5)).unwrap();
    let finger = result.estimates.iter().find(|e| e.coefficient == Coefficient::Finger).unwrap();
    assert!(finger.determined);
    assert!((finger.value / 0.45 - 1.0).abs() < 0.02, "{finger:?}");
}

#[test]
fn where_nothing_slides_friction_is_only_bounded_and_that_is_said() {
    // The object is carried without touching anything: the recording ends before contact.
    let setup = setup(0.45, 0.25);
    let mut trials = pushes(&setup);
    for (_, t) in &mut trials {
        t.samples.truncate(60);
    }
    let result =
        of_primitive(&setup.description, "linear_push", &trials, &default_model(), Share::of(0.5)).unwrap();
    assert!(result.remarks.iter().any(|r| matches!(r, Remark::NothingSlides { .. })), "{:?}", result.remarks);
    assert!(result.estimates.iter().all(|e| !e.determined), "{:?}", result.estimates);
}

#[test]
fn sticking_fingers_leave_newtons_open_and_sliding_ones_leave_little() {
    let setup = setup(0.4, 0.25);
    let (at, trial) = pushes(&setup).swap_remove(0);
    let prepared = prepare(&setup.description, &trial, at).unwrap();
    let (rest, sliding) = (20, prepared.t_s.len() / 2);
    let simulated = prepared.simulate(&default_model()).signals;
    let found = bands(&prepared, &default_model(), &[rest, sliding]);
    for (sample, band) in &found {
        for c in 6..24 {
            let value = simulated[*sample][c];
            assert!(
                band[c].0 <= value + 1e-6 && value <= band[c].1 + 1e-6,
                "channel {c}: {value} {:?}",
                band[c]
            );
        }
    }
    let width = |k: usize| found[k].1[6].1 - found[k].1[6].0;
    // At rest: anything up to friction of both pads, less what the weight takes.
    assert!(width(0) > 10.0, "{}", width(0));
    assert!(width(1) < 1.5, "{}", width(1));
}

#[test]
#[ignore = "long: make test-host-rest"]
fn data_of_several_primitives_get_a_model_each_and_one_of_the_best_determined_friction() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let run = |arguments: &[&std::ffi::OsStr]| {
        assert_cmd::Command::cargo_bin("stickslip").unwrap().args(arguments).assert().success();
    };
    run(&["rig".as_ref(), "--plan".as_ref(), "demo".as_ref(), "--out".as_ref(), at("data").as_os_str()]);
    run(&["calibrate".as_ref(), at("data").as_os_str(), "--out".as_ref(), at("model.toml").as_os_str()]);
    let friction = |name: &str| ModelFile::read(&at(name)).unwrap().friction;
    let each = ["linear_push", "pivot", "roll"].map(|p| friction(&format!("model-{p}.toml")).finger);
    assert!(each.contains(&friction("model.toml").finger), "{each:?}");
}

#[test]
#[ignore = "long: make test-host-rest"]
fn a_platform_that_holds_whatever_its_friction_is_bounded_below_and_gets_a_value_near_that_bound() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let data = stickslip_data::read(&folder).unwrap();
    let rolls: Vec<(usize, Trial)> =
        data.trials.into_iter().enumerate().filter(|(_, t)| t.info.primitive == "roll").collect();
    let found = of_primitive(&data.description, "roll", &rolls, &default_model(), Share::of(1.0)).unwrap();
    let support = found.estimates.iter().find(|e| e.coefficient == Coefficient::Support).unwrap();
    assert!(!support.determined && support.high.is_none(), "{support:?}");
    let low = support.low.unwrap();
    // By statics the rolling object needs 0.96 of its platform: all above fit alike.
    assert!(low < 1.0 && low <= support.value && support.value < 2.0, "{support:?}");
    assert_eq!(found.model.friction.support, support.value);
}

/// Poses of a motion capture slower than the forces, straight between its frames.
fn captured(trial: &Trial, rate_hz: f64) -> Trial {
    let mut seen = trial.clone();
    let end_s = trial.samples.last().map_or(0.0, |s| s.t_s);
    let at = |t: f64| ((t * 250.0).round() as usize).min(trial.samples.len() - 1);
    for s in &mut seen.samples {
        let frame = (s.t_s * rate_hz).floor();
        let (t0, t1) = (frame / rate_hz, (frame + 1.0) / rate_hz);
        let share = ((s.t_s - t0) / (t1 - t0)).clamp(0.0, 1.0);
        let (a, b) = (&trial.samples[at(t0.min(end_s))], &trial.samples[at(t1.min(end_s))]);
        let mixed = |a: Option<Pose>, b: Option<Pose>| {
            let (a, b) = (a?, b?);
            let mix = |x: f64, y: f64| x + (y - x) * share;
            let quaternion: [f64; 4] = std::array::from_fn(|k| mix(a.quaternion[k], b.quaternion[k]));
            let norm = quaternion.iter().map(|q| q * q).sum::<f64>().sqrt();
            Some(Pose {
                position_m: std::array::from_fn(|k| mix(a.position_m[k], b.position_m[k])),
                quaternion: quaternion.map(|q| q / norm),
            })
        };
        (s.gripper, s.object) = (mixed(a.gripper, b.gripper), mixed(a.object, b.object));
    }
    seen
}

#[test]
#[ignore = "long: make test-host-rest"]
fn motion_capture_from_60_hz_on_gives_the_friction_that_the_full_rate_gives() {
    let description = objects::bench("captured");
    let drawn = Reality::draw(&description, Nuisance::PAPER, 3);
    let reality = Reality { mu_finger: 0.42, mu_pusher: 0.25, ..drawn };
    let setup = Setup { description, reality, step_s: STEP_S };
    let trials = pushes(&setup);
    let friction = |trials: &[(usize, Trial)]| {
        let found = of_primitive(&setup.description, "linear_push", trials, &default_model(), Share::of(1.0))
            .unwrap();
        let finger = found.estimates.iter().find(|e| e.coefficient == Coefficient::Finger).cloned();
        let finger = finger.unwrap();
        assert!(finger.determined, "{finger:?}, {:?}", found.remarks);
        finger.value
    };
    let whole = friction(&trials);
    for rate_hz in [120.0, 60.0] {
        let slow: Vec<(usize, Trial)> = trials.iter().map(|(at, t)| (*at, captured(t, rate_hz))).collect();
        let found = friction(&slow);
        assert!((found / whole - 1.0).abs() < 0.02, "{rate_hz} Hz: {found}, at 250 Hz {whole}");
    }
}
