//! Oracles for whole trials: what is written obeys Newton and the friction of the pads.

use crate::common::clean;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use stickslip_second_rig::physics::record::{Record, Sample};
use stickslip_second_rig::scene::world;

fn run(set: &stickslip_second_rig::dataset::DataSet, i: usize) -> Record {
    world(&set.reality, &set.trials[i], set.seed).0.run()
}

/// Both fingers' forces in world axes.
fn fingers(s: &Sample) -> Vector3<f64> {
    s.gripper.rotation * (s.fingers[0].force + s.fingers[1].force)
}

#[test]
fn forces_and_weight_sum_to_mass_times_acceleration_in_every_sample() {
    for (family, seed) in [("bench-hard", 3), ("bench-lift", 5), ("bench-roll", 4), ("bench-planar", 6)] {
        let set = clean(family, seed, &[], 4);
        for i in 0..2 {
            let samples = run(&set, i).samples;
            // A gripper that turns does so by some tenths of a milliradian within the window.
            let fastest = samples.iter().map(|s| s.gripper.spin.norm()).fold(0.0, f64::max);
            let turn = fastest * set.reality.sensors.window_s;
            for s in samples.iter().skip(1) {
                let sum = fingers(s) + s.pusher_wrench.force + s.support_wrench.force + s.other_force;
                let gap = sum + Vector3::z() * (-9.81 * s.mass_kg) - s.acceleration * s.mass_kg;
                assert!(gap.norm() < 1e-6 + turn * fingers(s).norm(), "{family} {} s: {gap}", s.t_s);
            }
        }
    }
}

#[test]
fn knocks_pouring_and_shaking_balance_too() {
    let set = clean("grasp-soft", 8, &[], 44);
    for scenario in ["c", "d", "f"] {
        let i = set.trials.iter().position(|t| t.note["scenario"] == scenario).expect("a trial");
        for s in run(&set, i).samples.iter().skip(1) {
            let sum = fingers(s) + s.support_wrench.force + s.other_force;
            // The mass that is poured in grows within the window.
            let gap = sum + Vector3::z() * (-9.81 * s.mass_kg) - s.acceleration * s.mass_kg;
            assert!(gap.norm() < 0.01, "{scenario} {} s: {gap}", s.t_s);
        }
    }
}

#[test]
fn torques_about_the_centre_of_mass_sum_to_zero_in_slow_motion() {
    let mut set = clean("bench-hard", 3, &[], 60);
    // Lever arms are those at the sample: the window must be short.
    set.reality.sensors.window_s = 1e-4;
    for primitive in ["linear_push", "pivot"] {
        let i = set.trials.iter().position(|t| t.primitive == primitive).expect("a trial");
        let record = run(&set, i);
        let origin = record.samples[0].pusher.expect("a pusher").position;
        let half = 0.5 * set.reality.objects[set.trials[i].object].side_m;
        let mut worst = 0.0_f64;
        let calm = |s: &&Sample| s.acceleration.norm() < 2e-3;
        let half_way = record.samples.len() / 2;
        assert!(record.samples[half_way..].iter().filter(calm).count() > 20);
        for s in record.samples[half_way..].iter().filter(calm) {
            let centre = s.object.position;
            let mut sum = s.pusher_wrench.torque + (origin - centre).cross(&s.pusher_wrench.force);
            for (f, side) in [(0, 1.0), (1, -1.0)] {
                // The gripper's origin projected along its Y onto the object's side.
                let gripper = s.gripper;
                let y = gripper.rotation * Vector3::y();
                let face = s.object.rotation * Vector3::y();
                let on_face = s.object.position + face * (side * half);
                let along = face.dot(&(on_face - gripper.position)) / face.dot(&y);
                let patch = gripper.position + y * along;
                let force = gripper.rotation * s.fingers[f].force;
                sum += gripper.rotation * s.fingers[f].torque + (patch - centre).cross(&force);
            }
            worst = worst.max(sum.norm());
        }
        // The fingers alone exert some tens of newton millimetres.
        assert!(worst < 2e-4, "{primitive}: {worst} N m");
    }
}

#[test]
fn sliding_fingers_of_a_linear_push_carry_two_mu_n_and_the_plate_answers() {
    for family in ["bench-hard", "bench-creep"] {
        let pushes = |s: &u64| clean(family, *s, &[], 60).trials[2].primitive == "linear_push";
        let seed = (1..50).find(pushes).expect("a plan of pushes");
        let mut set = clean(family, seed, &[], 60);
        set.reality.pad.profile = stickslip_second_rig::physics::layout::Profile::Uniform;
        let mut checked = 0;
        for i in 0..set.trials.len() / 2 {
            let t = &set.trials[i];
            if t.primitive != "linear_push" || checked == 3 {
                continue;
            }
            checked += 1;
            let record = run(&set, i);
            let end = t.duration_s - set.bench.as_ref().map_or(0.0, |b| b.after_s + 2.0 * b.ramp_s) - 0.05;
            let s = record.samples.iter().rfind(|s| s.t_s < end).expect("a sample");
            let f = fingers(s);
            let limit = 2.0 * set.reality.finger.mu * t.grip_n;
            assert!((f.x.hypot(f.z) / limit - 1.0).abs() < 0.01, "{} N of {limit}", f.x.hypot(f.z));
            assert!((s.pusher_wrench.force.x + f.x).abs() < 0.05, "the plate balances the fingers");
            assert!(s.pusher_wrench.force.x > 0.5 * limit);
        }
        assert_eq!(checked, 3);
    }
}

#[test]
fn finger_1_presses_towards_minus_y_finger_2_towards_plus_y_and_both_with_the_grip() {
    let set = clean("bench-hard", 3, &[], 4);
    let record = run(&set, 0);
    let grip = set.trials[0].grip_n;
    for s in &record.samples {
        assert!((s.fingers[0].force.y + grip).abs() < 0.01 * grip, "{}", s.fingers[0].force.y);
        assert!((s.fingers[1].force.y - grip).abs() < 0.01 * grip, "{}", s.fingers[1].force.y);
    }
}

#[test]
fn at_rest_each_finger_carries_half_of_the_weight_and_sags_by_its_stiffness() {
    let mut set = clean("grasp-soft", 2, &[], 44);
    set.reality.pad.shear_per_load = false;
    set.reality.finger.kind = stickslip_second_rig::physics::friction::Kind::ElastoPlastic;
    // Far from slip, the rim included.
    set.reality.finger.mu *= 5.0;
    let i = set.trials.iter().position(|t| t.note["sub"] == "still").expect("a quiet hold");
    let record = run(&set, i);
    let s = record.samples.last().expect("a sample");
    let weight = set.reality.objects[set.trials[i].object].mass_kg * 9.81;
    for f in &s.fingers {
        assert!((f.force.z - 0.5 * weight).abs() < 0.01 * weight, "{} of {weight}", f.force.z);
    }
    let sag = set.trials[i].start.z - s.object.position.z;
    let expected = 0.5 * weight / set.reality.pad.shear_n_m;
    assert!((sag / expected - 1.0).abs() < 0.02, "{sag} against {expected}");
}

#[test]
fn half_the_time_step_changes_a_push_by_less_than_half_a_per_cent() {
    let set = clean("bench-medium", 9, &[], 4);
    let i = set.trials.iter().position(|t| t.primitive == "linear_push").unwrap_or(0);
    let (full, _) = world(&set.reality, &set.trials[i], set.seed);
    let mut half = full.clone();
    half.step_s = Some(0.5 * full.suitable_step_s());
    let (a, b) = (full.run(), half.run());
    let k = a.samples.len() * 2 / 3;
    let (a, b) = (fingers(&a.samples[k]), fingers(&b.samples[k]));
    assert!((a - b).norm() < 5e-3 * a.norm(), "{a} against {b}");
}

#[test]
fn quaternions_turn_the_gripper_about_plus_y_in_pivots() {
    let set = clean("bench-hard", 3, &[], 60);
    let i = set.trials.iter().position(|t| t.primitive == "pivot").expect("a pivot");
    let run = set.run_one(&set.trials[i]);
    let last = run.rows.last().expect("a row").gripper;
    let q = UnitQuaternion::new_normalize(Quaternion::new(last[3], last[4], last[5], last[6]));
    let angle = set.bench.as_ref().map_or(0.0, |b| b.angle_rad);
    assert!((q.scaled_axis() - Vector3::y() * angle).norm() < 1e-9);
}

#[test]
fn in_pure_spin_each_pad_carries_the_torque_of_the_disc_that_is_told_whatever_its_pressure() {
    use stickslip_second_rig::physics::layout::Profile;
    for profile in [Profile::Uniform, Profile::Hertz, Profile::Gaussian] {
        let mut set = clean("bench-hard", 3, &[], 60);
        set.reality.pad.profile = profile;
        let i = set.trials.iter().position(|t| t.primitive == "pivot").expect("a pivot");
        let t = &set.trials[i];
        let record = run(&set, i);
        let bench = set.bench.as_ref().expect("a bench");
        let end = t.duration_s - bench.after_s - 2.0 * bench.ramp_s;
        let s = record.samples.iter().rfind(|s| s.t_s < end).expect("a sample");
        let limit = 2.0 / 3.0 * set.reality.finger.mu * t.grip_n * set.reality.pad.radius_m;
        // The edge's force takes a part of the friction, so the torque is a little less.
        let share = s.fingers[0].torque.y.abs() / limit;
        assert!(share > 0.85 && share < 1.005, "{profile:?}: {share} of 2/3 mu N R");
    }
}
