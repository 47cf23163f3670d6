//! `simulate`: a data set of what a model predicts.

use std::path::Path;

use nalgebra::Vector3;
use stickslip_analysis::evidence::carried;
use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::simulate::{Carried, prepare};
use stickslip_analysis::simulate;
use stickslip_data::{Index, TableFormat};
use stickslip_rig::objects::bench;
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, run};
use stickslip_shared::effects::Effect;

#[test]
fn what_a_model_predicts_is_a_data_set_that_the_same_model_predicts_again() {
    let mut few =
        Index::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")).expect("the demo");
    few.trials.truncate(3);
    let folder = tempfile::tempdir().expect("folder");
    let model = default_model();
    for tables in [TableFormat::Csv, TableFormat::Parquet] {
        let out = folder.path().join(format!("{tables:?}"));
        let report = simulate(&few, &model, &out, tables, &()).expect("simulated");
        assert_eq!((report.trials, report.refused.len()), (3, 0));
        let predicted = Index::open(&out).expect("reads");
        for (ordinal, info) in predicted.trials.iter().enumerate() {
            let trial = predicted.read_trial(info).expect("reads");
            let prepared = prepare(&predicted.description, &trial, ordinal).expect("prepares");
            let again = prepared.simulate(&model);
            // Motion of gripper and pusher is smoothed once more: that alone may differ.
            for (at, (row, measured)) in again.signals.iter().zip(&prepared.measured).enumerate() {
                for (channel, (a, b)) in row.iter().zip(measured).enumerate() {
                    let bound = match channel {
                        0..3 => 2e-5,
                        3..6 => 5e-4,
                        // While contact is made, a micrometre of path is a force.
                        _ if at < 50 => continue,
                        k if k % 6 < 3 => 0.25,
                        _ => 5e-3,
                    };
                    assert!((a - b).abs() <= bound, "{} row {at}, channel {channel}: {a} {b}", info.trial);
                }
            }
        }
    }
}

#[test]
fn a_pose_that_is_late_shows_where_the_object_was_though_it_has_been_stopped_since() {
    const LATE: usize = 12;
    let demo = Index::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")).expect("the demo");
    let info = demo.trials.iter().find(|t| t.primitive == "linear_push").expect("a push");
    let trial = demo.read_trial(info).expect("reads");
    let prepared = prepare(&demo.description, &trial, 0).expect("prepares");
    let (now, mut model) = (prepared.simulate(&default_model()), default_model());
    let mut latency = Effect::neutral("mocap_latency").expect("listed");
    latency.parameters[0] = LATE as f64 * 0.004;
    model.effects.push(latency).expect("room");
    let late = prepared.simulate(&model);
    let mut most_m: f64 = 0.0;
    for at in LATE..now.signals.len() {
        let [shown, was] = [(at, &late.signals[at]), (at - LATE, &now.signals[at - LATE])]
            .map(|(k, row)| prepared.world_pose(k, row));
        assert!((shown.position_m - was.position_m).norm() < 1e-6, "row {at}");
        assert!(shown.rotation.angle_to(&was.rotation) < 1e-5, "row {at}");
        assert_eq!(late.signals[at][6..], now.signals[at][6..], "no force is late");
        most_m = most_m.max((late.signals[at][0] - now.signals[at][0]).abs());
    }
    assert!(most_m > 1e-4, "{most_m}");
}

#[test]
fn fingers_carry_at_rest_what_they_were_measured_to_and_all_of_the_weight_once_lifted() {
    let description = bench("lifts");
    let mut reality = Reality::draw(&description, Nuisance::PAPER, 5);
    reality.stiffness_n_m = 3e4;
    let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
    let condition =
        Condition { grip_n: 20.0, speed_m_s: 0.01, travel: 0.006, ..Condition::new(Primitive::Lift, "obj4") };
    let trial = run(&setup, &condition, 0, 5).expect("suits the rig").trial;
    let measured = prepare(&description, &trial, 0).expect("prepares");
    let weight_n = 9.81 * measured.scene.object.mass_kg;
    let mut soft = default_model();
    let mut pads = Effect::typical("contact_compliance").expect("listed");
    pads.parameters[0] = 1.0 / 3e4;
    soft.effects.push(pads).expect("room");
    for model in [default_model(), soft] {
        for share in [0.0, 0.4, 1.0] {
            let of =
                measured.carrying(Carried { up_n: share * weight_n, side_n: 0.0 }).simulate(&model).signals;
            let carried_n = |row: &[f64]| row[8] + row[14];
            let (first_n, last_n) = (carried_n(&of[0]), carried_n(&of[of.len() - 1]));
            assert!((first_n / weight_n - share).abs() < 0.03, "{first_n} N of {share} of {weight_n} N");
            assert!((last_n / weight_n - 1.0).abs() < 0.05, "{last_n} N of {weight_n} N");
        }
    }
    // Of the measurement: the mean of what both fingers' sensors show before anything moves.
    let rest = measured.measured.iter().take(10).map(|row| row[8] + row[14]).sum::<f64>() / 10.0;
    let carried_n = carried::measured(&measured).expect("something lies under it").up_n;
    assert!((carried_n - rest.clamp(0.0, weight_n)).abs() < 0.05, "{carried_n} N, measured {rest} N");
}

#[test]
fn fingers_that_hold_an_object_on_an_edge_carry_at_rest_what_they_were_measured_to_and_the_edge_the_rest() {
    let description = bench("pivots");
    let mut reality = Reality::draw(&description, Nuisance::PAPER, 5);
    reality.stiffness_n_m = 3e4;
    let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
    let condition =
        Condition { grip_n: 20.0, speed_rad_s: 0.2, travel: 0.1, ..Condition::new(Primitive::Pivot, "obj4") };
    let trial = run(&setup, &condition, 0, 5).expect("suits the rig").trial;
    let measured = prepare(&description, &trial, 0).expect("prepares");
    assert!(measured.pusher_touches(1e-4) && !measured.rests());
    let weight_n = 9.81 * measured.scene.object.mass_kg;
    let (up, side) = (measured.up().expect("gravity"), measured.side().expect("level grip"));
    // As soft as silicone, too: there the object swings by 0.1 rad about its grasp where the edge lets it.
    for pads_n_m in [3e4, 5e3] {
        let mut soft = default_model();
        let mut pads = Effect::typical("contact_compliance").expect("listed");
        pads.parameters[0] = 1.0 / pads_n_m;
        soft.effects.push(pads).expect("room");
        // Less than none: they press it onto the edge. To the side as far as friction of the edge bears (0.25).
        for (share, side_n) in [(-0.5, 0.1), (0.0, 0.0), (0.4, 0.0), (0.4, -0.1), (0.9, 0.0), (1.0, 0.0)] {
            let side_n = side_n * weight_n;
            let carried = Carried { up_n: share * weight_n, side_n };
            let rows = measured.carrying(carried).simulate(&soft).signals;
            for row in &rows[..8] {
                let force = |k: usize| Vector3::from_row_slice(&row[k..k + 3]);
                let (fingers, edge_n) = (force(6) + force(12), force(18));
                let bears = (up.dot(&fingers), side.dot(&fingers));
                let off_n = (bears.0 - carried.up_n).abs().max((bears.1 - side_n).abs());
                assert!(
                    off_n < 0.03 * weight_n,
                    "{pads_n_m} N/m: {bears:?} N for {carried:?} of {weight_n} N"
                );
                let sum_n = bears.0 + edge_n.z - weight_n;
                assert!(sum_n.abs() < 0.02 * weight_n, "{bears:?} N and {edge_n} N");
            }
            let moved =
                |of: std::ops::Range<usize>| of.map(|k| (rows[7][k] - rows[0][k]).abs()).fold(0.0, f64::max);
            let (moved_m, turned_rad) = (moved(0..3), moved(3..6));
            let most_m = 4e-6 + 0.02 * weight_n / (2.0 * pads_n_m);
            assert!(
                moved_m < most_m && turned_rad < 3e-4,
                "{pads_n_m} N/m, {carried:?}: {moved_m} m, {turned_rad} rad"
            );
        }
        // Of whom nothing is measured pads carry what they grasped.
        let rows = measured.simulate(&soft).signals;
        assert!(rows[7][20] < 0.05 * weight_n, "{} N of {weight_n} N on the edge", rows[7][20]);
    }
}
