//! Published recordings, in `../shared/data` beside the repository: physics of what comes out of their import.

use std::path::Path;

use stickslip_data::import::cmu_push::{self, Options, Support};
use stickslip_data::import::tribometer;
use stickslip_data::{read, write};

/// A file of `../shared/data`, looked for beside the repository and beside its worktrees.
fn raw(name: &str) -> String {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    ["../shared/data", "../../shared/data"]
        .iter()
        .map(|folder| repository.join(folder).join(name))
        .find_map(|path| std::fs::read_to_string(path).ok())
        .unwrap_or_else(|| panic!("shared/data/{name} is not beside the repository"))
}

fn cmu(name: &str, support: Support) -> cmu_push::Import {
    let options = Options { support, tip_radius_m: 0.0 };
    cmu_push::import(&raw(&format!("cmu_push_black/{name}")), name, &options).expect("imported")
}

#[test]
#[ignore = "needs ../shared/data: make published"]
fn real_pushes_obey_physics_after_the_import() {
    for (name, support) in [
        ("30_90_30_30_30_90__exp_08_11_50_mixed.txt", None),
        ("patch__exp_08_18_1435_50.txt", Some(Support::Patch)),
    ] {
        let named = Support::from_name(name).expect("the name tells the support");
        assert!(support.is_none_or(|support| support == named));
        let import = cmu(name, named);
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
#[ignore = "needs ../shared/data: make published"]
fn every_layout_of_feet_is_read_from_the_files_name_and_its_pushes_do_work() {
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
        // Imported as the whole face these are the same pushes.
        for told in [support, Support::Patch] {
            let import = cmu(name, told);
            let v = &import.verification;
            assert_eq!((v.pushes, v.positive_work, v.start_outside), (50, 50, 50), "{name}");
            assert_eq!(import.bad_rows, [], "{name}");
        }
    }
}

#[test]
#[ignore = "needs ../shared/data: make published"]
fn the_real_tribometer_record_slides_with_friction_along_the_counterface() {
    let text = raw("tribometer_200hz/test_data_2.txt");
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
