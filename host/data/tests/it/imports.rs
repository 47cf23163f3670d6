//! Imports of real data: physics of what comes out, and damage to what goes in.
//!
//! Reads `../shared/data` beside the repository where it is; says so where it is not.

use std::path::{Path, PathBuf};

use stickslip_data::import::cmu_push::{self, Options, Support};
use stickslip_data::import::tribometer;
use stickslip_data::{read, write};

/// A file of `shared/data`, looked for beside the repository and beside its worktrees.
fn raw(name: &str) -> Option<String> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let found = ["../shared/data", "../../shared/data"]
        .iter()
        .map(|folder| -> PathBuf { repository.join(folder).join(name) })
        .find_map(|path| std::fs::read_to_string(path).ok());
    if found.is_none() {
        println!("not run: shared/data/{name} is not there");
    }
    found
}

fn cmu(name: &str, support: Support) -> Option<cmu_push::Import> {
    let text = raw(&format!("cmu_push_black/{name}"))?;
    let options = Options { support, tip_radius_m: 0.0 };
    Some(cmu_push::import(&text, name, &options).expect("imported"))
}

#[test]
fn real_pushes_obey_physics_after_the_import() {
    for (name, support) in [
        ("30_90_30_30_30_90__exp_08_11_50_mixed.txt", None),
        ("patch__exp_08_18_1435_50.txt", Some(Support::Patch)),
    ] {
        let named = Support::from_name(name).expect("the name tells the support");
        assert!(support.is_none_or(|support| support == named));
        let Some(import) = cmu(name, named) else { return };
        assert_eq!(import.bad_rows, []);
        let v = &import.verification;
        assert_eq!(v.pushes, 50);
        assert_eq!(v.positive_work, 50, "the pusher drives the object, not the reverse");
        assert_eq!(v.start_outside, 50);
        assert!(v.start_distance_m > 0.001 && v.start_distance_m < 0.003, "{v:?}");
        // The recorded point lies on the edge at the end: median within 0.1 mm, spread by mocap.
        let [median, rms] = v.end_distance_m;
        assert!(median.abs() < 1e-4 && rms < 1e-3, "{v:?}");
        // One friction cone: no contact of plastic or metal holds beyond mu = 1.
        assert!(v.force_angle_rad[1] < 35f64.to_radians(), "{v:?}");
        assert!(v.force_angle_rad[2] < 45f64.to_radians(), "{v:?}");
        // Sliding takes at most the friction of pure translation, break-away 1.17 to 1.35 of it.
        let [_, _, most] = v.sliding_force_n;
        assert!(most < 1.3 * 4.2 && v.sliding_force_share < 1.0, "{v:?}");
        assert!((1.1..1.4).contains(&v.peak_share), "{v:?}");

        let folder = tempfile::tempdir().expect("folder");
        write(&import.dataset, folder.path()).expect("written");
        let back = read(folder.path()).expect("what was imported reads strictly");
        assert_eq!(back.trials.len(), 50);
        for trial in &back.trials {
            let known: Vec<usize> =
                (0..trial.samples.len()).filter(|at| trial.samples[*at].object.is_some()).collect();
            assert_eq!(known, [0, trial.samples.len() - 1], "object only before and after");
            let wrench = trial.samples[0].pusher_wrench.expect("measured");
            assert!(wrench.force_n[2].is_nan() && wrench.torque_nm.iter().all(|t| t.is_nan()));
        }
    }
}

#[test]
fn every_layout_of_feet_is_told_by_the_files_name_and_its_pushes_do_work() {
    for (name, third) in [
        ("10_130_10_10_10_130__exp_08_17_50.txt", Some([-0.04, 0.08])),
        ("10_90_10_10_30_130__exp_08_15_50.txt", Some([-0.04, 0.08])),
        ("30_63.33_43.33_30_43.33_63.33__exp_08_17_50.txt", Some([-0.00667, 0.01333])),
        ("30_90_30_30_30_90__exp_08_11_50_mixed.txt", Some([-0.02, 0.04])),
        ("patch__exp_08_18_1435_50.txt", None),
    ] {
        let support = Support::from_name(name).expect("the name tells the support");
        match (&support, third) {
            (Support::Points(feet), Some(expected)) => {
                assert_eq!(feet.len(), 3);
                assert!((0..2).all(|k| (feet[2][k] - expected[k]).abs() < 1e-5), "{feet:?}");
            }
            (Support::Patch, None) => {}
            other => panic!("{name}: {other:?}"),
        }
        // Told as the face it is the same pushes.
        for told in [support, Support::Patch] {
            let Some(import) = cmu(name, told) else { return };
            let v = &import.verification;
            assert_eq!((v.pushes, v.positive_work, v.start_outside), (50, 50, 50), "{name}");
            assert_eq!(import.bad_rows, [], "{name}");
        }
    }
}

#[test]
fn support_points_are_counted_from_the_right_corner() {
    let expected = [[-0.02, -0.02], [0.04, -0.02], [-0.02, 0.04]];
    let Some(Support::Points(points)) = Support::from_name("30_90_30_30_30_90") else {
        panic!("the folder's name tells three points")
    };
    for (point, expected) in points.iter().zip(expected) {
        assert!((point[0] - expected[0]).abs() < 1e-12 && (point[1] - expected[1]).abs() < 1e-12);
    }
    assert_eq!(Support::from_name("exp_08_11_50_mixed.txt"), None);
}

/// A push along +X against the leg x = 0, from the authors' layout.
const PUSH: &str = "1\n\
    500 100 10 1 0 0 0\n\
    502 100 10 1 0 0 0\n\
    4\n\
    10.00 0.00 0.00\n\
    10.01 -1.4142135623730951 -1.4142135623730951\n\
    10.02 -1.4142135623730951 -1.4142135623730951\n\
    10.03 -1.4142135623730951 -1.4142135623730951\n\
    2\n\
    10.00 499 150 20 1 0 0 0\n\
    10.04 503 150 20 1 0 0 0\n";

#[test]
fn a_push_along_x_gives_a_force_along_x_at_interpolated_poses() {
    let options = Options { support: Support::Patch, tip_radius_m: 0.0 };
    let import = cmu_push::import(PUSH, "one", &options).expect("imported");
    let samples = &import.dataset.trials[0].samples;
    let force = samples[1].pusher_wrench.expect("measured").force_n;
    assert!((force[0] - 2.0).abs() < 1e-12 && force[1].abs() < 1e-12, "{force:?}");
    let pusher = samples[1].pusher.expect("known");
    assert!((pusher.position_m[0] - 0.5).abs() < 1e-9, "a quarter of 4 mm after 499 mm");
    let object = samples[0].object.expect("known");
    assert!((object.position_m[0] - 0.55).abs() < 1e-12 && (object.position_m[1] - 0.15).abs() < 1e-12);
    // +X of the pusher is the inward normal of the leg at x = 0.
    let [w, _, _, z] = pusher.quaternion;
    assert!((2.0 * z.atan2(w)).abs() < 1e-12);
    assert_eq!(import.dataset.trials[0].info.extra["edge"], "leg_y");
    assert_eq!(import.verification.positive_work, 1);
}

#[test]
fn rows_that_cannot_be_parsed_are_counted_with_their_line() {
    let options = Options { support: Support::Patch, tip_radius_m: 0.0 };
    let damaged = PUSH.replace("10.02 -1.4142135623730951", "10.02 force");
    let import = cmu_push::import(&damaged, "one", &options).expect("the rest is kept");
    assert_eq!(import.bad_rows.len(), 1);
    assert_eq!(import.bad_rows[0].line, 7);
    assert_eq!(import.dataset.trials[0].samples.len(), 3);
    let cut = &PUSH[..PUSH.len() - 60];
    assert!(cmu_push::import(cut, "one", &options).is_err(), "no complete push");
    let error = cmu_push::import("a b c", "one", &options).expect_err("no counts");
    assert!(error.to_string().contains("line 1"), "{error}");

    let text = "Time [s]\tNormal [uN]\tPosition [mm]\tFriction [uN]\n0\t1\t2\t3\n0.005\tx\t2\t3\n0.01\t1\t2\n0.005\t1\t2\t3\n-1\t1\t2\t3\n";
    let import = tribometer::import(text, "t").expect("two good rows");
    let lines: Vec<usize> = import.bad_rows.iter().map(|row| row.line).collect();
    assert_eq!(lines, [3, 4, 6]);
    assert_eq!(import.verification.samples, 2);
    assert!(tribometer::import("nothing", "t").is_err());
}

#[test]
fn the_real_tribometer_record_slides_with_friction_along_the_counterface() {
    let Some(text) = raw("tribometer_200hz/test_data_2.txt") else { return };
    let import = tribometer::import(&text, "test_data_2").expect("imported");
    let v = &import.verification;
    assert_eq!((v.samples, import.bad_rows.len()), (42_579, 0));
    assert!((v.normal_force_n - 5.0).abs() < 0.01, "{v:?}");
    assert!((v.stroke_m - 0.24e-3).abs() < 0.01e-3 && (v.speed_m_s - 0.25e-3).abs() < 0.01e-3, "{v:?}");
    assert!((0.44..0.50).contains(&v.friction_share[1]), "{v:?}");
    assert!(v.dragging > 0.99, "{v:?}");
    let folder = tempfile::tempdir().expect("folder");
    write(&import.dataset, folder.path()).expect("written");
    assert_eq!(read(folder.path()).expect("reads strictly").trials[0].samples.len(), 42_579);
}
