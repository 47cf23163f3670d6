//! Pivoting about the fingers against a line.
//!
//! The gripper turns about the axis through its fingertips while a fixed edge holds the
//! object. The object stays where it is; both discs spin on it. By Coulomb each disc of
//! radius a then bears `2/3 mu N a` about its normal, and the edge, at distance `d` from the
//! axis, the rest.

use crate::common::*;
use crate::on_both_formulations;
use stickslip_shared::model::*;
use stickslip_shared::real::Vec3;
use stickslip_shared::step::State;

/// The gripper pitches about its Y axis at `rate`; a vertical edge (along Y, the gripper's
/// axis) stands at the object's -X end and pushes upwards from below at `arm_m`.
fn pivot(
    model: Model<f64>,
    grip_n: f64,
    rate_rad_s: f64,
    arm_m: f64,
    seconds: f64,
    each: impl FnMut(&Seen<'_, f64>),
) -> State<f64, { stickslip_shared::contact::SLOTS }> {
    // Pusher +X (its normal) is world up, its Y is world Y.
    let up = turn([0.0, 1.0, 0.0], -core::f64::consts::FRAC_PI_2);
    let play = Play {
        scene: gripped(obj4(), Some(PusherContact::Line { length_m: 0.028 })),
        model,
        gripper: &|t| pose(Vec3::zeros(), turn([0.0, 1.0, 0.0], -rate_rad_s * t)),
        pusher: Some(&|_| pose(at(-arm_m, 0.0, -0.0125), up)),
        object: pose(Vec3::zeros(), turn([0.0, 1.0, 0.0], 0.0)),
        grip_n,
        seconds,
    };
    play.run(each)
}

on_both_formulations! {
    the_object_stays_put_but_for_the_drift_that_the_edge_force_explains,
    each_finger_bears_the_torsional_friction_of_a_uniform_disc,
    the_edge_bears_the_moment_of_both_fingers,
    torque_grows_with_grip_and_not_with_the_turning_rate,
}

fn the_object_stays_put_but_for_the_drift_that_the_edge_force_explains(by: Formulation) {
    // The edge carries the moment of both fingers, 4/3 mu N a, over its arm; what that
    // exceeds the weight by loads the fingers. A ring of radius r that spins under a small
    // force f drifts by 2 r f / (mu N) for each radian.
    let (mu, grip_n, a) = (0.4, 20.0, 0.01);
    for (rate, arm_m) in [(0.0436, 0.03), (0.1745, 0.03), (0.349, 0.03), (0.1745, 0.045)] {
        let mut last = None;
        pivot(hard_by(by, mu, 0.25, 0.0), grip_n, rate, arm_m, 1.0 / rate, |s| last = Some(s.world));
        let world = last.unwrap();
        let excess_n = 4.0 / 3.0 * mu * grip_n * a / arm_m - 0.2005 * G;
        let drift_m = 2.0 * (2.0 / 3.0 * a) * (0.5 * excess_n) / (mu * grip_n);
        assert!((world.position_m.z - drift_m).abs() < 0.2 * drift_m, "{} {drift_m}", world.position_m.z);
        // Pyramids: a tenth more, within what their friction may lack.
        let stays_m = if by == Formulation::Cone { 5e-4 } else { 5.5e-4 };
        assert!(world.position_m.xy().norm() < stays_m, "{}", world.position_m);
        // The edge does not follow: the object turns about it by the drift over the arm.
        assert!(world.rotation.angle() < 1.1 * drift_m / arm_m, "{}", world.rotation.angle());
    }
}

fn each_finger_bears_the_torsional_friction_of_a_uniform_disc(by: Formulation) {
    for (mu, grip_n) in [(0.35, 20.0), (0.5, 35.0)] {
        let expected = 2.0 / 3.0 * mu * grip_n * 0.01;
        let mut seen = 0;
        pivot(hard_by(by, mu, 0.25, 0.0), grip_n, 0.1745, 0.03, 2.0, |s| {
            if s.t_s < 0.5 {
                return;
            }
            seen += 1;
            for finger in s.out.reading.finger {
                // Some of the friction carries the force of the edge.
                let torque = finger[4].abs();
                assert!(torque < 1.001 * expected && torque > 0.85 * expected, "{torque} {expected}");
            }
        });
        assert!(seen > 300);
    }
}

fn the_edge_bears_the_moment_of_both_fingers(by: Formulation) {
    for arm_m in [0.02, 0.03, 0.045] {
        pivot(hard_by(by, 0.4, 0.25, 0.0), 20.0, 0.1745, arm_m, 1.5, |s| {
            if s.t_s < 0.3 {
                return;
            }
            // Moments about the axis through the fingers (the object's centre is on it).
            let fingers = s.out.reading.finger[0][4] + s.out.reading.finger[1][4];
            let f = s.out.reading.pusher;
            let edge = -0.0125 * f[0] + arm_m * f[2];
            assert!((fingers + edge).abs() < 0.02 * fingers.abs(), "{fingers} {edge}");
            assert!(s.imbalance_n.norm() < 1e-6);
        });
    }
}

fn torque_grows_with_grip_and_not_with_the_turning_rate(by: Formulation) {
    let torque = |grip, rate: f64| {
        let mut t = 0.0;
        pivot(hard_by(by, 0.4, 0.25, 0.0), grip, rate, 0.03, 0.35 / rate, |s| {
            t = s.out.reading.finger[0][4].abs()
        });
        t
    };
    let (loose, tight) = (torque(20.0, 0.1745), torque(35.0, 0.1745));
    assert!((tight / loose - 1.75).abs() < 0.06, "{loose} {tight}");
    let (slow, fast) = (torque(20.0, 0.0436), torque(20.0, 0.349));
    assert!((slow - fast).abs() < 0.01 * slow, "{slow} {fast}");
}
