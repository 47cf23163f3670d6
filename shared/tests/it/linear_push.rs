//! The paper's linear push against figures that follow from the balance of forces, and
//! against references made before this code (`docs/accuracy`).

use crate::common::*;
use crate::on_both_formulations;
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::model::Formulation;

const WEIGHT_N: f64 = 0.2005 * G;

on_both_formulations! {
    the_push_force_balances_finger_friction_and_weight_within_one_percent_on_every_slope,
    forces_and_momentum_balance_in_every_step,
    nothing_moves_across_the_push_and_nothing_rolls_or_yaws,
    the_sag_is_that_of_the_exact_cone,
    a_tighter_grip_sags_less,
    before_the_pusher_touches_the_object_does_not_move_in_the_grasp,
    pushing_speed_changes_neither_force_nor_path,
    single_precision_gives_the_same_push,
}

fn the_push_force_balances_finger_friction_and_weight_within_one_percent_on_every_slope(by: Formulation) {
    for mu in [0.15, 0.25, 0.4, 0.5] {
        for grip_n in [20.0, 35.0] {
            for slope_deg in [-20.0f64, -10.0, 0.0, 10.0, 20.0] {
                let slope = slope_deg.to_radians();
                let mut forces = (0.0, 0.0, 0.0);
                linear_push::<f64>(hard_by(by, mu, 0.25, 0.0), grip_n, 0.010, slope, 1.2, |s| {
                    assert_eq!(s.out.status, SolveStatus::Solved);
                    let world = s.out.reading.pusher;
                    let f = s.axes.inverse_transform_vector(&at(world[0], world[1], world[2]));
                    let slip = s.state.velocity;
                    forces = (f.x, f.y, slip[0] / (slip[0].hypot(slip[2])));
                });
                // Friction on both fingers opposes sliding; its part along the push is the
                // cosine of the slip's inclination. Uphill the weight helps the sliding.
                let expected = 2.0 * mu * grip_n * forces.2 - WEIGHT_N * slope.sin();
                let error = (forces.0 - expected).abs();
                assert!(
                    error < 0.01 * expected,
                    "mu {mu} N {grip_n} slope {slope_deg}: {} {expected}",
                    forces.0
                );
                assert!(forces.1.abs() < 1e-3, "a force across the push: {}", forces.1);
            }
        }
    }
}

fn forces_and_momentum_balance_in_every_step(by: Formulation) {
    for slope in [-0.3, 0.0, 0.3] {
        linear_push::<f64>(hard_by(by, 0.4, 0.25, 0.0), 20.0, 0.025, slope, 1.0, |s| {
            assert!(s.imbalance_n.norm() < 1e-6, "{} at {}", s.imbalance_n, s.t_s);
        });
    }
}

fn nothing_moves_across_the_push_and_nothing_rolls_or_yaws(by: Formulation) {
    linear_push::<f64>(hard_by(by, 0.3, 0.25, 0.0), 20.0, 0.015, 0.0, 1.5, |s| {
        assert!(s.state.position_m.y.abs() < 1e-9);
        let q = s.state.rotation.quaternion();
        assert!(q.i.abs() < 1e-9 && q.k.abs() < 1e-9);
    });
}

fn the_sag_is_that_of_the_exact_cone(by: Formulation) {
    // MuJoCo's elliptic cone, well tuned, gives 1.57 mm on this scene; fixed pyramids give
    // anything between 0 and 12 mm.
    let end = linear_push::<f64>(hard_by(by, 0.15, 0.25, 0.0), 20.0, 0.010, 0.0, 1.5, |_| {});
    let sag_mm = -end.position_m.z * 1e3;
    assert!((sag_mm - 1.57).abs() < 0.157, "{sag_mm}");
}

fn a_tighter_grip_sags_less(by: Formulation) {
    let sag = |grip_n| {
        -linear_push::<f64>(hard_by(by, 0.15, 0.25, 0.0), grip_n, 0.010, 0.0, 1.5, |_| {}).position_m.z
    };
    let sags = [20.0, 22.0, 25.0, 27.0, 30.0, 35.0].map(sag);
    assert!(sags.windows(2).all(|w| w[1] <= w[0] + 1e-9), "{sags:?}");
}

fn before_the_pusher_touches_the_object_does_not_move_in_the_grasp(by: Formulation) {
    // The gap is 0.5 mm: 50 ms at 10 mm/s.
    linear_push::<f64>(hard_by(by, 0.15, 0.25, 0.0), 20.0, 0.010, 0.0, 0.048, |s| {
        assert!(s.state.position_m.norm() < 5e-7, "{} m at {} s", s.state.position_m.norm(), s.t_s);
    });
}

fn pushing_speed_changes_neither_force_nor_path(by: Formulation) {
    // Same distance at 10 and at 25 mm/s.
    let run = |speed: f64| {
        let mut force = 0.0;
        let end = linear_push::<f64>(hard_by(by, 0.15, 0.25, 0.0), 20.0, speed, 0.0, 0.0125 / speed, |s| {
            force = s.out.reading.pusher[0]
        });
        (force, -end.position_m.z)
    };
    let (slow, fast) = (run(0.010), run(0.025));
    assert!((slow.0 - fast.0).abs() < 0.01 * slow.0, "{slow:?} {fast:?}");
    assert!((slow.1 - fast.1).abs() < 0.1 * slow.1, "{slow:?} {fast:?}");
}

fn single_precision_gives_the_same_push(by: Formulation) {
    for mu in [0.15, 0.4] {
        let mut wide = Vec::new();
        let a = linear_push::<f64>(hard_by(by, mu, 0.25, 0.0), 20.0, 0.010, 0.0, 1.5, |s| {
            wide.push(s.out.reading.pusher[0]);
        });
        let mut narrow = Vec::new();
        let b = linear_push::<f32>(hard_by(by, mu, 0.25, 0.0), 20.0, 0.010, 0.0, 1.5, |s| {
            assert_eq!(s.out.status, SolveStatus::Solved);
            narrow.push(f64::from(s.out.reading.pusher[0]));
        });
        assert!((a.position_m.z - f64::from(b.position_m.z)).abs() < 2e-5);
        // Away from the onset, where one step more or less of gap decides.
        for (k, (w, n)) in wide.iter().zip(&narrow).enumerate().skip(30) {
            assert!((w - n).abs() < 0.02, "step {k}: {w} {n}");
        }
    }
}
