//! Imports of published recordings: layouts, and damage to what goes in. The recordings themselves are in [`published`].

use stickslip_data::import::cmu_push::{self, Options, Support};
use stickslip_data::import::tribometer;

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
