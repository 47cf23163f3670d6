//! Pads that reach over the edge of the face that they press.

use stickslip_analysis::evidence::overhang::{overhang_m, shifts_m};
use stickslip_analysis::run::simulate::{Prepared, prepare};
use stickslip_rig::objects::bench;
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, run};

/// A push of an object 25 mm wide between pads of 20 mm.
fn pushed(slope_rad: f64, travel: f64) -> Prepared {
    let description = bench("overhang");
    let reality = Reality::draw(&description, Nuisance::PAPER, 3);
    let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
    let condition =
        Condition { slope_rad, speed_m_s: 0.04, travel, ..Condition::new(Primitive::LinearPush, "obj4") };
    let trial = run(&setup, &condition, 0, 3).expect("suits the rig").trial;
    prepare(&description, &trial, 0).expect("prepares")
}

#[test]
fn a_pad_reaches_over_the_edge_by_what_the_object_slid_beyond_its_margin() {
    assert_eq!(overhang_m(&pushed(0.0, 0.006)), Some(0.0));
    let prepared = pushed(0.6, 0.02);
    let across_m = prepared.measured.iter().map(|row| row[2].abs()).fold(0.0, f64::max);
    let over_m = overhang_m(&prepared).expect("round pads");
    assert!(across_m > 0.005, "{across_m}");
    // A turn of the object by some degrees and the directions looked at change little of it.
    assert!((over_m - (across_m + 0.01 - 0.0125)).abs() < 3e-4, "{over_m} for {across_m}");
}

#[test]
fn what_lies_on_the_face_is_a_disc_less_a_segment_and_presses_at_its_centroid() {
    assert!(shifts_m(&pushed(0.0, 0.006)).is_none());
    let prepared = pushed(0.6, 0.02);
    let shifts = shifts_m(&prepared).expect("over the edge");
    let (row, [first, second]) = (prepared.measured.last().expect("samples"), shifts[shifts.len() - 1]);
    // Disc of radius 10 mm, whose middle is this far from the edge.
    let (radius, from_edge) = (0.01_f64, 0.0125 - row[2].abs());
    let half_chord = (radius * radius - from_edge * from_edge).sqrt();
    let segment = radius * radius * (from_edge / radius).acos() - from_edge * half_chord;
    let centroid = 2.0 / 3.0 * half_chord.powi(3) / (std::f64::consts::PI * radius * radius - segment);
    for shift in [first, second] {
        // Towards the object's middle, which is where it went; a turn by some degrees changes little of it.
        assert!((shift.norm() - centroid).abs() < 0.1 * centroid, "{shift} for {centroid}");
        assert!(shift.z * row[2] > 0.0 && shift.x.abs() < 0.3 * shift.z.abs(), "{shift} for {}", row[2]);
        assert!(shift.y.abs() < 0.02 * shift.norm(), "along the face: {shift}");
    }
}
