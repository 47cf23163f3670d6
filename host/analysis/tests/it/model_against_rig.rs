//! Two formulations that share no code must agree where nothing is hidden: the cone model
//! at 4 ms against springs and bristles at 40 microseconds.

use stickslip_analysis::channels::{NAMES, Quantity, quantity};
use stickslip_analysis::run::simulate::prepare;
use stickslip_rig::{Condition, Primitive, Reality, STEP_S, Setup, objects, run};
use stickslip_shared::model::{Base, Friction, Model};

/// Worst disagreement over the second half of a noise-free trial, for each kind of channel,
/// relative to the largest signal of that kind.
fn disagreement(primitive: Primitive, object: &str, mu: f64, mu_below: f64, grip_n: f64) -> [f64; 4] {
    let description = objects::bench("ideal");
    let setup = Setup { description: description.clone(), reality: Reality::ideal(mu, 0.25), step_s: STEP_S };
    let mut condition = Condition::new(primitive, object);
    condition.grip_n = grip_n;
    let outcome = run(&setup, &condition, 1, 7).expect("the rig runs");
    let prepared = prepare(&description, &outcome.trial, 0).expect("the trial is complete");
    let model = Model::base(Base::Hard, Friction { finger: mu, pusher: 0.25, support: mu_below });
    let modelled = prepared.simulate(&model);
    assert_eq!(modelled.unsolved, 0);
    let mut worst = [0.0f64; 4];
    // What is small for each kind, m, rad, N, N m.
    let mut scale = [1e-3f64, 1e-2, 1.0, 1e-2];
    for (k, (seen, said)) in prepared.measured.iter().zip(&modelled.signals).enumerate() {
        for channel in 0..NAMES.len() {
            let kind = match quantity(channel) {
                Quantity::Position => 0,
                Quantity::Rotation => 1,
                Quantity::Force => 2,
                Quantity::Torque => 3,
            };
            let error = (seen[channel] - said[channel]).abs();
            if error.is_finite() {
                scale[kind] = scale[kind].max(seen[channel].abs());
                if k >= prepared.t_s.len() / 2 {
                    worst[kind] = worst[kind].max(error);
                }
            }
        }
    }
    std::array::from_fn(|k| worst[k] / scale[k])
}

#[test]
fn linear_push_with_sag_agrees_in_forces_motion_and_pitch() {
    let [position, rotation, force, torque] = disagreement(Primitive::LinearPush, "obj4", 0.15, 0.3, 20.0);
    assert!(position < 0.01, "position {position}");
    assert!(rotation < 0.10, "rotation {rotation}");
    assert!(force < 0.003, "force {force}");
    assert!(torque < 0.01, "torque {torque}");
}

#[test]
fn rolling_splits_the_push_force_equally_between_the_fingers_in_both() {
    let [_, rotation, force, _] = disagreement(Primitive::Roll, "obj1", 0.4, 2.5, 5.0);
    assert!(rotation < 0.001, "rotation {rotation}");
    assert!(force < 0.01, "force {force}");
}

#[test]
fn pivoting_agrees_in_motion_and_torque() {
    let [position, rotation, force, torque] = disagreement(Primitive::Pivot, "obj4", 0.4, 0.3, 20.0);
    assert!(position < 0.01, "position {position}");
    assert!(rotation < 0.02, "rotation {rotation}");
    assert!(force < 0.01, "force {force}");
    assert!(torque < 0.01, "torque {torque}");
}

#[test]
fn a_lifted_object_hangs_on_both_fingers_equally_in_both() {
    let [position, _, force, _] = disagreement(Primitive::Lift, "obj4", 0.4, 0.3, 20.0);
    assert!(position < 0.01, "position {position}");
    assert!(force < 0.005, "force {force}");
}
