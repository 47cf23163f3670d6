//! The compliant base model: known deflections, and stability at 250 Hz.

use crate::common::*;
use nalgebra::UnitQuaternion;
use stickslip_shared::cone::SolveStatus;
use stickslip_shared::model::*;
use stickslip_shared::real::Vec3;

const WEIGHT_N: f64 = 0.2005 * G;

fn soft(mu: f64, normal_n_m: f64, tangential_n_m: f64, damping_s: f64) -> Model<f64> {
    Model { base: Base::Soft { normal_n_m, tangential_n_m, damping_s }, ..hard(mu, 0.25, 0.0) }
}

fn hold(model: Model<f64>, grip_n: f64, seconds: f64, each: impl FnMut(&Seen<'_, f64>)) {
    let play = Play {
        scene: gripped(obj4(), None),
        model,
        gripper: &|_| pose(Vec3::zeros(), UnitQuaternion::identity()),
        pusher: None,
        object: pose(Vec3::zeros(), UnitQuaternion::identity()),
        grip_n,
        seconds,
    };
    play.run(each);
}

#[test]
fn a_held_object_hangs_by_its_weight_over_both_tangential_springs() {
    for (k, damping) in [(1e4, 0.02), (1e5, 0.01), (1e6, 0.005)] {
        let mut end = (0.0, 0.0);
        hold(soft(0.4, 3.0 * k, k, damping), 20.0, 1.0, |s| end = (-s.state.position_m.z, s.state.jaw_m));
        let expected = WEIGHT_N / (2.0 * k);
        assert!((end.0 - expected).abs() < 0.01 * expected, "{} {expected}", end.0);
        let pressed = 20.0 / (3.0 * k);
        assert!((-end.1 - pressed).abs() < 0.01 * pressed, "{} {pressed}", end.1);
    }
}

#[test]
fn before_sliding_the_push_force_rises_along_the_springs_in_series() {
    // Fingers' two tangential springs in series with the pusher's normal spring.
    let k = 2e4;
    let series = 1.0 / (1.0 / (2.0 * k) + 1.0 / k);
    let mut seen = Vec::new();
    linear_push(soft(0.4, k, k, 0.0), 20.0, 0.010, 0.0, 0.1, |s| {
        seen.push((0.010 * s.t_s - 0.0005, s.out.reading.pusher[0]));
    });
    let loading: Vec<_> = seen.iter().filter(|(x, f)| *x > 1e-4 && *f < 6.0).collect();
    assert!(loading.len() > 5);
    for (x, f) in loading {
        assert!((f - series * x).abs() < 0.15 * series * x + 0.1, "{x} m: {f} N, expected {}", series * x);
    }
}

#[test]
fn shear_on_a_pad_that_is_pressed_in_does_not_twist_the_finger() {
    // Pressed in by 2 mm: about the pad itself, 5 N of shear would read as 10 N mm.
    let mut largest = (0.0_f64, 0.0_f64);
    linear_push(soft(0.4, 1e4, 1e5, 0.01), 20.0, 0.010, 0.0, 1.0, |s| {
        for w in s.out.reading.finger {
            largest = (largest.0.max(w[0].abs()), largest.1.max(w[5].abs()));
        }
    });
    assert!(largest.0 > 4.0 && largest.1 < 5e-4, "{largest:?}");
}

#[test]
fn steps_of_4_ms_stay_stable_from_rubber_foam_to_steel() {
    // 20 N press the softest in by 2 mm, the stiffest by 0.2 micrometres.
    for k in [1e4, 1e5, 1e6, 1e7, 1e8] {
        for damping in [0.0, 0.002, 0.02, 0.2] {
            let mut late = Vec::new();
            linear_push(soft(0.3, k, k, damping), 20.0, 0.010, 0.0, 2.0, |s| {
                assert_eq!(
                    s.out.status,
                    SolveStatus::Solved,
                    "k {k} damping {damping}: {}",
                    s.out.residual_n
                );
                if s.t_s > 1.6 {
                    late.push(s.out.reading.pusher[0]);
                }
            });
            let mean = late.iter().sum::<f64>() / late.len() as f64;
            let spread = late.iter().map(|f| (f - mean).abs()).fold(0.0, f64::max);
            assert!(
                mean > 10.0 && mean < 12.5 && spread < 0.5,
                "k {k} damping {damping}: {mean} +- {spread}"
            );
        }
    }
}

#[test]
fn a_soft_model_comes_to_the_hard_one_as_it_stiffens() {
    let mut rigid = Vec::new();
    linear_push(hard(0.3, 0.25, 0.0), 20.0, 0.010, 0.0, 1.0, |s| rigid.push(s.out.reading.pusher[0]));
    // Impulse by which the push force differs: what the springs take up before anything slides.
    let off_n_s = [1e4, 1e5, 1e7].map(|stiffness_n_m| {
        let mut pushed = Vec::new();
        linear_push(soft(0.3, stiffness_n_m, stiffness_n_m, 0.0), 20.0, 0.010, 0.0, 1.0, |s| {
            pushed.push(s.out.reading.pusher[0]);
        });
        assert_eq!(pushed.len(), rigid.len());
        pushed.iter().zip(&rigid).map(|(soft, hard): (&f64, &f64)| (soft - hard).abs() * DT_S).sum::<f64>()
    });
    println!("{off_n_s:?}");
    assert!(off_n_s[0] > 5.0 * off_n_s[1] && off_n_s[1] > 0.0 && off_n_s[2] < 1e-9, "{off_n_s:?}");
}

#[test]
fn the_documented_default_pad_deflects_a_tenth_of_a_millimetre_and_settles_in_a_tenth_of_a_second() {
    let base = Base::rubber_pad();
    let mut late = Vec::new();
    hold(Model { base, ..hard(0.4, 0.25, 0.0) }, 20.0, 0.5, |s| late.push((s.t_s, s.state.position_m.z)));
    let end = late.last().unwrap().1;
    assert!(late.iter().filter(|(t, _)| *t > 0.1).all(|(_, z)| (z - end).abs() < 1e-7));
    let Base::Soft { normal_n_m, .. } = base else { unreachable!() };
    assert!((20.0 / normal_n_m - 1e-4).abs() < 1e-9);
}
