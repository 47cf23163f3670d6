//! The synthetic reality obeys mechanics: balances, limits with known answers, dissipation.

use stickslip_data::Sample;
use stickslip_rig::{
    Condition, Exact, Nuisance, Outcome, Primitive, Reality, STEP_S, Scenario, Setup, objects, run, simulate,
};

const GRAVITY_M_S2: f64 = 9.81;

fn bench(mu_finger: f64, mu_pusher: f64) -> Setup {
    Setup {
        description: objects::bench("test"),
        reality: Reality::ideal(mu_finger, mu_pusher),
        step_s: STEP_S,
    }
}

fn push(grip_n: f64) -> Condition {
    Condition { grip_n, ..Condition::new(Primitive::LinearPush, "obj4") }
}

fn measure(setup: &Setup, condition: &Condition) -> Outcome {
    run(setup, condition, 1, 11).expect("the condition suits the rig")
}

/// The last sample before the motion ends.
fn sliding(outcome: &Outcome) -> &Exact {
    &outcome.exact[outcome.exact.len() - 90]
}

fn rotate(q: [f64; 4], v: [f64; 3]) -> nalgebra::Vector3<f64> {
    let q = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]));
    q * nalgebra::Vector3::from(v)
}

#[test]
fn at_rest_and_in_slow_motion_all_forces_and_the_weight_sum_to_zero() {
    let setup = bench(0.3, 0.25);
    for (primitive, object, mass_kg) in [
        (Primitive::LinearPush, "obj4", 0.2005),
        (Primitive::LinearPush, "obj3", 0.145),
        (Primitive::Pivot, "obj5", 0.0938),
        (Primitive::Roll, "obj1", 0.158),
        (Primitive::PlanarPush, "tri", 1.2),
    ] {
        let grip_n = if primitive == Primitive::Roll { 5.0 } else { 20.0 };
        let outcome = measure(&setup, &Condition { grip_n, ..Condition::new(primitive, object) });
        for sample in [&outcome.exact[20], sliding(&outcome), outcome.exact.last().unwrap()] {
            let mut sum = nalgebra::Vector3::new(0.0, 0.0, -mass_kg * GRAVITY_M_S2);
            for finger in &sample.finger {
                sum += rotate(sample.gripper.1, [finger[0], finger[1], finger[2]]);
            }
            sum += nalgebra::Vector3::new(sample.pusher[0], sample.pusher[1], sample.pusher[2]);
            sum += nalgebra::Vector3::from(sample.support);
            assert!(sum.norm() < 0.02, "{primitive:?} at {} s: {sum:?}", sample.t_s);
        }
    }
}

#[test]
fn torques_about_the_object_balance_while_it_is_pushed() {
    let outcome = measure(&bench(0.15, 0.25), &push(20.0));
    let sample = sliding(&outcome);
    let com = nalgebra::Vector3::from(sample.object.0);
    let gripper = nalgebra::Vector3::from(sample.gripper.0);
    let mut sum = nalgebra::Vector3::zeros();
    for (finger, sign) in sample.finger.iter().zip([1.0, -1.0]) {
        let patch = gripper + nalgebra::Vector3::new(0.0, sign * 0.0125, 0.0);
        let force = nalgebra::Vector3::new(finger[0], finger[1], finger[2]);
        sum += nalgebra::Vector3::new(finger[3], finger[4], finger[5]) + (patch - com).cross(&force);
    }
    let plate = nalgebra::Vector3::from(outcome.trial.info.pusher.unwrap().position_m);
    let force = nalgebra::Vector3::new(sample.pusher[0], sample.pusher[1], sample.pusher[2]);
    let torque = nalgebra::Vector3::new(sample.pusher[3], sample.pusher[4], sample.pusher[5]);
    sum += torque + (plate - com).cross(&force);
    assert!(sum.norm() < 2e-4, "{sum:?}");
}

#[test]
fn the_push_force_is_two_mu_n_less_what_the_pusher_carries() {
    for (mu, grip_n) in [(0.15, 20.0), (0.3, 20.0), (0.4, 20.0), (0.4, 35.0)] {
        let outcome = measure(&bench(mu, 0.25), &push(grip_n));
        let sample = sliding(&outcome);
        // Both patches are at their limit; across the push they carry what the pusher does not.
        let across_n = 0.2005 * GRAVITY_M_S2 - sample.pusher[2];
        let analytic_n = ((2.0 * mu * grip_n).powi(2) - across_n.powi(2)).sqrt();
        let error = sample.pusher[0] / analytic_n - 1.0;
        assert!(error.abs() < 0.01, "mu {mu}, {grip_n} N: {} N, {analytic_n} N", sample.pusher[0]);
    }
}

#[test]
fn the_papers_scene_gives_six_newtons_and_the_exact_cones_sag() {
    let outcome = measure(&bench(0.15, 0.25), &push(20.0));
    let push_n = sliding(&outcome).pusher[0];
    let sag_m = outcome.exact[0].object.0[2] - outcome.exact.last().unwrap().object.0[2];
    assert!((5.8..6.05).contains(&push_n), "{push_n} N");
    // Exact cone: 1.6 mm with rigid contacts; the pads' compliance adds a few per cent.
    assert!((1.4e-3..1.85e-3).contains(&sag_m), "{sag_m} m");
    let across_m = outcome.exact.iter().map(|s| s.object.0[1].abs()).fold(0.0, f64::max);
    assert!(across_m < 1e-6, "{across_m} m");
}

#[test]
fn sag_vanishes_with_a_firm_grip_and_speed_does_not_matter() {
    let setup = bench(0.4, 0.25);
    let sag = |c: &Condition| {
        let outcome = measure(&setup, c);
        outcome.exact[0].object.0[2] - outcome.exact.last().unwrap().object.0[2]
    };
    assert!(sag(&push(25.0)) < 2e-4);
    let slow = measure(&setup, &push(25.0));
    let fast = measure(&setup, &Condition { speed_m_s: 0.025, ..push(25.0) });
    let (slow, fast) = (sliding(&slow).pusher[0], sliding(&fast).pusher[0]);
    assert!((slow / fast - 1.0).abs() < 0.01, "{slow} N, {fast} N");
}

#[test]
fn halving_the_step_changes_nothing_and_stiffer_contacts_little() {
    let condition = push(20.0);
    let with = |step_s: f64, stiffness_n_m: f64| {
        let mut setup = Setup { step_s, ..bench(0.15, 0.25) };
        setup.reality.stiffness_n_m = stiffness_n_m;
        let outcome = measure(&setup, &condition);
        let sag = outcome.exact[0].object.0[2] - outcome.exact.last().unwrap().object.0[2];
        (sliding(&outcome).pusher[0], sag)
    };
    let (force, sag) = with(STEP_S, 1e6);
    let (finer_force, finer_sag) = with(STEP_S / 2.0, 1e6);
    assert!((finer_force / force - 1.0).abs() < 1e-3 && (finer_sag / sag - 1.0).abs() < 5e-3);
    let (stiff_force, stiff_sag) = with(STEP_S / 4.0, 4e6);
    assert!((stiff_force / force - 1.0).abs() < 2e-3 && (stiff_sag / sag - 1.0).abs() < 0.05);
}

#[test]
fn an_object_held_on_its_patches_does_not_turn_until_their_torsional_limit() {
    // Limit of two uniform discs: 2 (2/3) mu N R = 0.107 N m at mu 0.4, 20 N, R 10 mm.
    let turn = |torque_nm: f64| {
        let setup = bench(0.4, 0.25);
        let arm_m = 0.05;
        let load = Scenario::SuddenLoad { force_n: [0.0, 0.0, 0.0], at_s: 0.5 };
        let mut condition = Condition { scenario: load, ..Condition::new(Primitive::Lift, "obj4") };
        condition.grip_n = 20.0;
        condition.hold_s = 0.5;
        condition.speed_m_s = 0.1;
        // The weight itself turns the object where its centre is off the grasp.
        let offset_m = torque_nm / (0.2005 * GRAVITY_M_S2);
        assert!(offset_m < arm_m + 0.01);
        condition.scenario = Scenario::OffCentre { offset_m };
        let outcome = measure(&setup, &condition);
        let q = outcome.exact.last().unwrap().object.1;
        2.0 * q[2].abs().asin()
    };
    assert!(turn(0.09) < 5e-3, "{}", turn(0.09));
    assert!(turn(0.115) > 0.05, "{}", turn(0.115));
}

#[test]
fn while_pivoting_the_object_stays_and_the_pads_give_their_torsional_friction() {
    let setup = bench(0.4, 0.25);
    let condition =
        Condition { pusher_offset_m: 0.02, travel: 0.4, ..Condition::new(Primitive::Pivot, "obj4") };
    let outcome = measure(&setup, &condition);
    let first = &outcome.exact[outcome.exact.len() / 3];
    let sample = sliding(&outcome);
    let pitch = |s: &Exact| 2.0 * (s.object.1[2] / s.object.1[0]).atan();
    let gripper = 2.0 * (sample.gripper.1[2] / sample.gripper.1[0]).atan();
    assert!(gripper > 0.35, "{gripper}");
    assert!((pitch(sample) - pitch(first)).abs() < 0.05 * gripper);
    for finger in sample.finger {
        let limit = 2.0 / 3.0 * 0.4 * 20.0 * 0.01;
        assert!((finger[4] / limit - 1.0).abs() < 0.06, "{} N m of {limit}", finger[4]);
    }
    assert!(sample.pusher[4].abs() < 1e-3, "an edge has no torque along itself");
}

#[test]
fn rolling_splits_the_push_force_equally_between_the_fingers() {
    let condition = Condition { grip_n: 4.0, ..Condition::new(Primitive::Roll, "obj1") };
    let outcome = measure(&bench(0.4, 0.25), &condition);
    let sample = sliding(&outcome);
    // Without slip on the platform both pads slide, so it pushes back with 2 mu N.
    let push_n = -sample.pusher[1];
    assert!((push_n - 2.0 * 0.4 * 4.0).abs() < 0.05, "{push_n} N");
    assert!((-sample.finger[0][1] - (4.0 - push_n / 2.0)).abs() < 0.02);
    assert!((sample.finger[1][1] - (4.0 + push_n / 2.0)).abs() < 0.02);
    let turned = 2.0 * (sample.object.1[1] / sample.object.1[0]).atan();
    let rolled = sample.object.0[1] / 0.0125;
    assert!((turned + rolled).abs() < 0.01 * rolled, "{turned} rad, {rolled} rad");
}

#[test]
fn rolling_needs_a_light_grip_and_the_high_friction_the_paper_found() {
    let turned = |mu_platform: f64, grip_n: f64| {
        let condition = Condition { grip_n, ..Condition::new(Primitive::Roll, "obj1") };
        let mut setup = bench(0.4, 0.25);
        setup.reality.mu_platform = mu_platform;
        let outcome = measure(&setup, &condition);
        let q = outcome.exact.last().unwrap().object.1;
        (2.0 * (q[1] / q[0]).atan()).abs()
    };
    // The front pad, which is relieved by half the push, slips at a push of 2 mu N / (1 + mu);
    // the platform, loaded by the weight alone, gives way before at mu_p m g. So the grip must
    // stay below 6.8 N (paper: 5 N) at mu_p 2.5, and below 2.7 N on an ordinary platform.
    assert!(turned(2.5, 4.5) > 1.1, "{}", turned(2.5, 4.5));
    assert!(turned(2.5, 7.5) < 0.1, "{}", turned(2.5, 7.5));
    assert!(turned(1.0, 3.0) < 0.1, "{}", turned(1.0, 3.0));
}

#[test]
fn a_weak_grip_drops_the_object_and_a_firm_one_holds_it() {
    let lift = |grip_n: f64| {
        let condition = Condition { grip_n, speed_m_s: 0.06, ..Condition::new(Primitive::Lift, "obj4") };
        let outcome = measure(&bench(0.4, 0.25), &condition);
        let last = outcome.exact.last().unwrap();
        last.gripper.0[2] - last.object.0[2]
    };
    // 2 mu N = m g at 2.46 N, and the lift's start needs a tenth more.
    assert!(lift(2.3) > 0.02, "{}", lift(2.3));
    assert!(lift(3.0) < 1e-4, "{}", lift(3.0));
}

#[test]
fn sliding_over_the_table_costs_mu_m_g_and_never_gains_energy() {
    let mut setup = bench(0.4, 0.0);
    setup.reality.mu_support = 0.3;
    let condition = Condition { speed_m_s: 0.02, ..Condition::new(Primitive::PlanarPush, "obj4") };
    let outcome = measure(&setup, &condition);
    // Rectangle pushed at the middle of its long side: straight, force mu m g.
    let expected = 0.3 * 0.2005 * GRAVITY_M_S2;
    let sample = sliding(&outcome);
    assert!((sample.pusher[1] / expected - 1.0).abs() < 0.02, "{} N, {expected} N", sample.pusher[1]);
    let mut input_j = 0.0;
    for pair in outcome.exact.windows(2) {
        let moved = pair[1].object.0[1] - pair[0].object.0[1];
        input_j += 0.5 * (pair[0].pusher[1] + pair[1].pusher[1]) * moved;
        assert!(pair[1].kinetic_j < 1e-4);
    }
    let travelled = outcome.exact.last().unwrap().object.0[1];
    assert!((input_j / (expected * travelled) - 1.0).abs() < 0.05, "{input_j} J");
}

#[test]
fn impossible_conditions_are_refused_with_their_value() {
    let setup = bench(0.4, 0.25);
    let refused = |c: Condition| run(&setup, &c, 1, 1).expect_err("must be refused");
    assert!(refused(push(f64::NAN)).contains("grip_n is NaN"));
    assert!(refused(Condition { speed_m_s: 0.0, ..push(20.0) }).contains("speed is 0"));
    assert!(refused(Condition { object: "obj9".into(), ..push(20.0) }).contains("obj9"));
    assert!(refused(Condition::new(Primitive::Roll, "obj4")).contains("cylinder"));
    assert!(refused(Condition::new(Primitive::LinearPush, "tri")).contains("polygon"));
    let far = Condition { pusher_offset_m: 0.06, ..Condition::new(Primitive::Pivot, "obj4") };
    assert!(refused(far).contains("0.06"));
}

#[test]
fn a_creeping_pad_lets_the_object_down_at_its_rate_and_play_delays_the_push() {
    use stickslip_rig::{HiddenEffect, Kind};
    let condition = Condition {
        grip_n: 10.0,
        hold_s: 3.0,
        speed_m_s: 0.06,
        scenario: Scenario::SoftCreep { rate_m_n_s: 2e-4 },
        ..Condition::new(Primitive::Lift, "obj4")
    };
    let outcome = measure(&bench(0.4, 0.25), &condition);
    let sag = |s: &Exact| s.gripper.0[2] - s.object.0[2];
    let (a, b) = (&outcome.exact[400], &outcome.exact[900]);
    let rate = (sag(b) - sag(a)) / (b.t_s - a.t_s);
    let expected = 2e-4 * 0.2005 * GRAVITY_M_S2 / 2.0;
    assert!((rate / expected - 1.0).abs() < 0.02, "{rate} m/s, {expected} m/s");

    let onset = |backlash_m: f64| {
        let mut setup = bench(0.4, 0.25);
        setup.reality.effects = vec![HiddenEffect { kind: Kind::Backlash, strength: backlash_m }];
        let outcome = measure(&setup, &push(20.0));
        outcome.exact.iter().find(|s| s.pusher[0] > 10.0).map_or(f64::NAN, |s| s.t_s)
    };
    // 1 mm of play, half of it ahead, is run through at 10 mm/s.
    let delay = onset(1e-3) - onset(0.0);
    assert!((0.03..0.07).contains(&delay), "{delay} s");
}

#[test]
fn a_dropped_cylinder_comes_to_rest_on_the_table() {
    let condition = Condition { grip_n: 1.0, ..Condition::new(Primitive::Lift, "obj3") };
    let outcome = measure(&bench(0.4, 0.25), &condition);
    let last = outcome.exact.last().unwrap();
    assert!((last.object.0[2] - 0.0125).abs() < 1e-4, "{:?}", last.object.0);
    assert!((last.support[2] - 0.145 * GRAVITY_M_S2).abs() < 0.05);
}

#[test]
fn a_drifting_sensor_departs_in_proportion_to_time_and_stays_within_its_share() {
    let bench = objects::bench("test");
    let readings = |drift: f64| {
        let nuisance = Nuisance { drift, ..Nuisance::PAPER };
        let reality = Reality::draw(&bench, nuisance, 7);
        let setup = Setup { description: bench.clone(), reality, step_s: STEP_S };
        simulate(&setup, &push(20.0), 1, 11).expect("the condition suits the rig").samples
    };
    let (still, drifting) = (readings(0.0), readings(6.0));
    let departs = |i: usize| {
        let force = |samples: &[Sample]| samples[i].finger[0].expect("finger 1 is measured").force_n[1];
        force(&drifting) - force(&still)
    };
    let last = still.len() - 1;
    let share = 6.0 * bench.sensors.finger.force_uncertainty_n * still[last].t_s / 60.0;
    assert!(departs(0).abs() < 1e-3 && departs(last).abs() > 1e-2 * share && departs(last).abs() <= share);
    assert!(
        (departs(last / 2) - departs(last) / 2.0).abs() < 1e-3,
        "{} {}",
        departs(last / 2),
        departs(last)
    );
}
