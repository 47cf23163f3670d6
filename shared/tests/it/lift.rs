//! Holding, lifting and losing an object.
//!
//! A grasp of two fingers with friction mu and grip N bears a load of `2 mu N`: weight and,
//! while the gripper accelerates upwards by `a`, `m a` more. Beyond that the object slides
//! down with the acceleration that is left.

use crate::common::*;
use crate::on_both_formulations;
use nalgebra::UnitQuaternion;
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::model::*;
use stickslip_shared::real::Vec3;

const WEIGHT_N: f64 = 0.2005 * G;

fn raise(
    by: Formulation,
    mu: f64,
    grip_n: f64,
    acceleration: f64,
    seconds: f64,
    each: impl FnMut(&Seen<'_, f64>),
) {
    let play = Play {
        scene: gripped(obj4(), None),
        model: hard_by(by, mu, 0.0, 0.0),
        gripper: &|t| pose(at(0.0, 0.0, 0.5 * acceleration * t * t), UnitQuaternion::identity()),
        pusher: None,
        object: pose(Vec3::zeros(), UnitQuaternion::identity()),
        grip_n,
        seconds,
    };
    play.run(each);
}

on_both_formulations! {
    a_grasp_holds_up_to_twice_mu_times_grip_and_no_more,
    a_lost_object_falls_with_the_acceleration_that_friction_leaves,
    utilisation_is_load_over_capacity,
    an_object_gripped_off_centre_turns_once_its_moment_beats_torsional_friction,
    lifting_from_a_table_moves_the_weight_from_table_to_fingers,
}

fn a_grasp_holds_up_to_twice_mu_times_grip_and_no_more(by: Formulation) {
    let mu = 0.3;
    for acceleration in [0.0, 3.0] {
        let load_n = 0.2005 * (G + acceleration);
        for (grip_n, holds) in [(1.02 * load_n / (2.0 * mu), true), (0.98 * load_n / (2.0 * mu), false)] {
            let mut fall_m = 0.0;
            raise(by, mu, grip_n, acceleration, 0.6, |s| {
                assert_eq!(s.out.status, SolveStatus::Solved);
                assert!(s.imbalance_n.norm() < 1e-6);
                fall_m = -s.state.position_m.z;
            });
            assert_eq!(fall_m < 1e-5, holds, "grip {grip_n}: fell {fall_m} m");
        }
    }
}

fn a_lost_object_falls_with_the_acceleration_that_friction_leaves(by: Formulation) {
    let (mu, grip_n) = (0.2, 2.0);
    let a = G - 2.0 * mu * grip_n / 0.2005;
    // As long as the pads are on the face.
    raise(by, mu, grip_n, 0.0, 0.036, |s| {
        // Semi-implicit Euler: a t (t + dt) / 2.
        let expected = 0.5 * a * s.t_s * (s.t_s + DT_S);
        assert!((-s.state.position_m.z - expected).abs() < 0.01 * expected + 1e-6);
    });
}

fn utilisation_is_load_over_capacity(by: Formulation) {
    for grip_n in [10.0, 20.0] {
        let mut used = [0.0; 2];
        raise(by, 0.4, grip_n, 0.0, 0.5, |s| used = s.out.utilisation);
        let expected = WEIGHT_N / (2.0 * 0.4 * grip_n);
        assert!(used.iter().all(|u| (u - expected).abs() < 0.01 * expected), "{used:?} {expected}");
    }
}

fn an_object_gripped_off_centre_turns_once_its_moment_beats_torsional_friction(by: Formulation) {
    // The centre of mass is at `arm` from the fingers' axis: two discs bear 4/3 mu N a.
    let (mu, grip_n, arm) = (0.4, 10.0, 0.03);
    let turned = |grip_n: f64| {
        let play = Play {
            scene: gripped(obj4(), None),
            model: hard_by(by, mu, 0.0, 0.0),
            gripper: &|_| pose(Vec3::zeros(), UnitQuaternion::identity()),
            pusher: None,
            object: pose(at(arm, 0.0, 0.0), UnitQuaternion::identity()),
            grip_n,
            seconds: 0.3,
        };
        let mut angle = 0.0;
        play.run(|s| angle = s.world.rotation.angle());
        angle
    };
    let torsion_nm = 4.0 / 3.0 * mu * grip_n * 0.01;
    assert!(torsion_nm > 0.8 * WEIGHT_N * arm);
    // Force and moment together need more than the moment alone.
    let need = |share: f64| share * WEIGHT_N * arm / (4.0 / 3.0 * mu * 0.01);
    assert!(turned(need(1.1)) < 1e-3, "{}", turned(need(1.1)));
    assert!(turned(need(0.9)) > 0.05, "{}", turned(need(0.9)));
}

fn lifting_from_a_table_moves_the_weight_from_table_to_fingers(by: Formulation) {
    let mut scene = gripped(obj4(), None);
    scene.support = Some(SupportContact::Patch);
    let play = Play {
        scene,
        model: hard_by(by, 0.4, 0.0, 0.3),
        gripper: &|t| {
            pose(at(0.0, 0.0, if t > 0.5 { 0.01 * (t - 0.5) } else { 0.0 }), UnitQuaternion::identity())
        },
        pusher: None,
        object: pose(Vec3::zeros(), UnitQuaternion::identity()),
        grip_n: 20.0,
        seconds: 1.0,
    };
    let mut end: (f64, f64, f64) = (0.0, 0.0, 0.0);
    play.run(|s: &Seen<f64>| {
        let fingers: f64 = s.out.reading.finger[0][2] + s.out.reading.finger[1][2];
        let table: f64 = s.out.normal_n[3];
        assert!(s.imbalance_n.norm() < 1e-6);
        if s.t_s > 0.02 && s.t_s < 0.49 {
            assert!((fingers + table - WEIGHT_N).abs() < 1e-3, "{fingers} {table}");
            assert!(table > 0.0);
        }
        end = (fingers, table, s.world.position_m.z);
    });
    assert!((end.0 - WEIGHT_N).abs() < 0.01 && end.1 == 0.0, "{end:?}");
    assert!((end.2 - 0.005).abs() < 1e-4, "{end:?}");
}
