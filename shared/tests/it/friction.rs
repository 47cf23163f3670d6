//! Claims about the friction coefficient as a distribution, and the probability that a grasp holds.

use stickslip_shared::observer::friction::{Friction, Use};
use stickslip_shared::observer::{Observer, Seen};
use stickslip_shared::real::Vec3;

const DT: f32 = 0.004;
const TOLD: f32 = 0.4;

fn used(needed: f32, slip_s: Option<f32>) -> Use<f32> {
    Use { needed, noise: 0.002, slip_s, speed_m_s: 0.05, grip_holds: true, steered: false }
}

fn after(seconds: f32, needed: f32, slip_s: Option<f32>, mut friction: Friction<f32>) -> Friction<f32> {
    (0..(seconds / DT) as u32).for_each(|_| friction.learn(&used(needed, slip_s), DT));
    friction
}

#[test]
fn quantiles_are_those_of_the_log_logistic_distribution_about_the_told_value() {
    let friction = Friction::new(TOLD);
    assert_eq!(friction.estimate(), TOLD);
    // Its logarithm's standard deviation is 0.12: S(x) = 1 / (1 + (x / 0.4)^15.115).
    for (x, more) in [(0.30f32, 0.9873), (0.36, 0.8310), (0.44, 0.1914), (0.48, 0.0597)] {
        let p = friction.probability_of(x);
        assert!((p - more).abs() < 1e-3, "{x}: {p}");
    }
    assert!((friction.probability_of(friction.least()) - 0.9875).abs() < 1e-3);
    assert!((friction.probability_of(friction.likely()) - 0.92).abs() < 1e-3);
}

#[test]
fn what_was_held_cuts_the_distribution_off_and_leaves_its_proportions() {
    let prior = Friction::new(TOLD);
    let held = after(2.0, 0.38, Some(0.0), prior.clone());
    assert!((held.proven() - 0.38).abs() < 1e-3);
    assert_eq!(held.probability_of(0.379), 1.0);
    let expected = prior.probability_of(0.44) / prior.probability_of(0.38);
    assert!((held.probability_of(0.44) - expected).abs() < 0.01, "{}", held.probability_of(0.44));
    assert!(held.least() >= held.proven() && held.estimate() > TOLD, "{}", held.estimate());
}

#[test]
fn what_a_slip_told_is_narrow_at_first_and_widens_to_the_spread_of_the_told() {
    let slid = after(1.0, 0.3, Some(0.1), Friction::new(TOLD));
    let width = |f: &Friction<f32>| f.least() / f.estimate();
    assert!((slid.estimate() - 0.3).abs() < 0.005, "{}", slid.estimate());
    assert!((0.92..0.96).contains(&width(&slid)), "{}", width(&slid));
    // Ten minutes later it says nothing.
    let old = after(600.0, 0.1, None, slid);
    assert!((old.estimate() - TOLD).abs() < 1e-3 && (width(&old) - 0.75).abs() < 0.005, "{}", width(&old));
}

#[test]
fn a_rig_that_has_slid_in_many_grasps_knows_the_next_as_well_as_its_grasps_vary() {
    // 300 rigs, told wrongly by 9 %, whose grasps vary by 8 %: log-normal draws.
    let mut state = 1u64;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 40) as f32 + 0.5) / (1u64 << 24) as f32
    };
    let mut normal = move || (-2.0 * uniform().ln()).sqrt() * (core::f32::consts::TAU * uniform()).cos();
    let (mut enough, mut first, mut last) = ([0; 2], 0.0, 0.0);
    for _ in 0..300 {
        let of_rig = TOLD * (0.09 * normal()).exp();
        let mut friction = Friction::new(TOLD);
        for grasp in 0..12 {
            let of_grasp = of_rig * (0.08 * normal()).exp();
            if grasp == 0 || grasp == 11 {
                enough[usize::from(grasp == 11)] += u32::from(friction.least() < of_grasp);
                *(if grasp == 0 { &mut first } else { &mut last }) += friction.least() / of_rig / 300.0;
            }
            friction = after(0.2, of_grasp, Some(0.1), friction).regrasped();
        }
    }
    // Said is 98.75 %: 296 of 300.
    assert!(enough[0] >= 288 && enough[1] >= 288, "{enough:?}");
    assert!(last > first + 0.05, "{first} {last}");
}

#[test]
fn one_grasp_on_a_wet_patch_moves_the_next_less_than_as_many_told_percent_would() {
    let next =
        |slid_at: f32| after(0.2, slid_at, Some(0.1), Friction::new(TOLD)).regrasped().estimate() / TOLD;
    // Halfway between what was told and what was seen, ...
    assert!((0.93..0.96).contains(&next(0.9 * TOLD)), "{}", next(0.9 * TOLD));
    // ... and what cannot be the rig's is hardly believed.
    assert!(next(0.3 * TOLD) > 0.8, "{}", next(0.3 * TOLD));
}

#[test]
fn numbers_stay_finite_whatever_is_told_and_needed() {
    for told in [0.0f32, 1e-3, 0.4, 10.0] {
        for needed in [0.0f32, 0.2, 50.0] {
            for slip_s in [None, Some(0.0), Some(1.0)] {
                let f = after(1.0, needed, slip_s, Friction::new(told));
                let all = [f.estimate(), f.least(), f.likely(), f.assumed(), f.probability_of(needed)];
                assert!(all.iter().all(|x| x.is_finite() && *x >= 0.0), "{told}, {needed}: {all:?}");
                assert!(
                    f.least() <= f.estimate() && f.probability_of(needed) <= 1.0,
                    "{told}, {needed}: {all:?}"
                );
            }
        }
    }
}

/// Probability of holding, sample by sample, of a weight that is `ratio(t)` of the normal force; nobody sees the object.
fn holds(seconds: f32, ratio: impl Fn(f32) -> f32) -> Vec<f32> {
    let mut observer = Observer::new(TOLD);
    let none = [[0.0; 6]; 2];
    let still = Vec3::zeros();
    let of = (0..(seconds / DT) as u32).filter_map(|tick| {
        let each = 0.5 * 10.0 * ratio(tick as f32 * DT);
        let wrenches = [Some([0.0, -5.0, each, 0.0, 0.0, 0.0]), Some([0.0, 5.0, each, 0.0, 0.0, 0.0])];
        observer.tare(&[None; 2], &none, true);
        observer.observe(&Seen {
            wrenches: &wrenches,
            grip_n: 5.0,
            points_m: None,
            gripper_m_s: still,
            arm_m: 0.0,
            bearing_n: None,
            steered: false,
            accelerates: false,
            effects: 1.0,
            sliding: 1.0,
            dt_s: DT,
        });
        observer.holds(1.0, 0.1)
    });
    of.collect()
}

#[test]
fn a_quiet_grasp_holds_for_certain_and_one_whose_load_rises_does_the_less_the_nearer_it_is() {
    assert!(holds(2.0, |_| 0.2).iter().all(|p| *p > 0.999));
    let rising = holds(2.5, |t| 0.2 + 0.1 * (t - 0.5).max(0.0));
    let at = |s: f32| rising[((s - 0.13) / DT) as usize];
    assert!(at(0.4) > 0.999 && at(1.0) > 0.99, "{} {}", at(0.4), at(1.0));
    // At 0.38, with 0.39 to come within 0.1 s if it goes on.
    assert!((0.55..0.69).contains(&at(2.3)), "{}", at(2.3));
    // Less certain than by the load alone, whose least is what has come.
    assert!(at(2.3) < Friction::new(TOLD).probability_of(0.38));
}
