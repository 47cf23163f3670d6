//! Each effect against a case whose answer is known in closed form.
//!
//! Above 600 lines: a law is a test or two, and all share the push that they are seen in.

use crate::scenes::*;
use stickslip_shared::contact::{Body, Contact, Contacts, SLOTS, find, spread};
use stickslip_shared::effects::{
    Effect, FrictionLaw, Law, MAX_PARAMETERS, MEMORY, Reading, Slip, StepContext, law,
};
use stickslip_shared::model::{FingerContact, Friction};
use stickslip_shared::real::{Rotation, Vec3};
use stickslip_shared::step::{Drive, State, step};

const N: f64 = 20.0;
const MU: f64 = 0.4;

fn close(a: f64, b: f64, share: f64) {
    assert!((a - b).abs() <= share * b.abs().max(1e-3), "{a} is not {b} within {share}");
}

/// Parameters of an effect, the rest zero.
fn with_zeros<const N: usize>(parameters: [f64; N]) -> [f64; MAX_PARAMETERS] {
    core::array::from_fn(|k| parameters.get(k).copied().unwrap_or(0.0))
}

/// The same with an object so light that its inertia does not show at first contact.
fn light_push(speed_m_s: f64) -> Run<f64> {
    let mut run = pure_push(speed_m_s);
    let object = &mut run.scene.object;
    object.mass_kg *= 1e-3;
    object.inertia_kg_m2 = object.inertia_kg_m2.map(|row| row.map(|x| x * 1e-3));
    run
}

/// Push force at the end of a slide without weight.
fn push_force(run: &Run<f64>) -> f64 {
    run.play().last().reading.pusher[0]
}

/// Where a push was at its end, gripper and pusher at rest from there.
fn stopped(run: &Run<f64>, end: &State<f64, SLOTS>) -> (State<f64, SLOTS>, Drive<f64>) {
    let (mut state, mut drive) = (end.clone(), run.drive);
    drive.carrier_m_s = Vec3::zeros();
    let plate = drive.pusher.as_mut().unwrap();
    plate.position_m += plate.velocity_m_s * (drive.dt_s * run.steps as f64);
    plate.velocity_m_s = Vec3::zeros();
    state.absolute_m_s = Vec3::zeros();
    (state, drive)
}

#[test]
fn the_pure_push_needs_twice_mu_n() {
    close(push_force(&pure_push::<f64>(0.01)), 2.0 * MU * N, 1e-6);
}

#[test]
fn static_friction_shows_a_peak_of_the_excess_before_sliding() {
    let record = light_push(0.05).with("static_friction", &[0.2, 0.002]).play();
    close(record.peak(0), 2.0 * MU * N * 1.2, 1e-3);
    close(record.last().reading.pusher[0], 2.0 * MU * N, 1e-3);
}

#[test]
fn viscous_friction_adds_viscosity_times_speed() {
    for v in [0.005, 0.02] {
        let force = push_force(&pure_push::<f64>(v).with("viscous_friction", &[2.0, 0.0]));
        close(force, 2.0 * N * (MU + 2.0 * v), 1e-4);
    }
}

#[test]
fn dwell_strengthening_raises_the_peak_with_the_logarithm_of_rest() {
    // The gap of half a millimetre lasts 0.1 s at 5 mm/s and 0.025 s at 20 mm/s.
    for (v, rest) in [(0.005, 0.1), (0.02, 0.025)] {
        let peak = light_push(v).with("dwell_strengthening", &[0.2, 0.05, 1e-6]).play().peak(0);
        let expected = 2.0 * MU * N * (1.0 + 0.2 * (1.0_f64 + rest / 0.05).ln());
        // Rest counts in steps of 4 ms.
        close(peak, expected, 0.02);
    }
}

#[test]
fn sliding_renews_a_contact_and_is_stronger_where_it_is_slow() {
    // Steady sliding has the age that the renewal distance takes.
    for v in [0.002, 0.05] {
        let force =
            light_push(v).with("dwell_strengthening", &[0.2, 0.01, 1e-4]).play().last().reading.pusher[0];
        close(force, 2.0 * MU * N * (1.0 + 0.2 * (1.0_f64 + 1e-4 / v / 0.01).ln()), 2e-3);
    }
}

#[test]
fn load_dependent_friction_is_a_power_of_the_load() {
    for grip in [10.0, 20.0, 40.0] {
        let mut run = pure_push::<f64>(0.01).with("load_dependent_friction", &[0.3]);
        run.drive.grip_n = grip;
        close(push_force(&run), 2.0 * MU * grip * (grip / 20.0_f64).powf(-0.3), 1e-4);
    }
}

/// Friction of a contact of the nominal coefficient with `body`, loaded by 5 N and sliding at 2 mm/s.
fn friction_at(body: Body, context: &StepContext<f64>, effect: &Effect<f64>) -> f64 {
    let slip = Slip {
        share: 1.0,
        body,
        patch_m: [0.0; 2],
        object_m: Default::default(),
        load_n: 5.0,
        patch_load_n: 5.0,
        speed_m_s: 2e-3,
        distance_m: 0.01,
        rest_s: 0.0,
    };
    let mut found = FrictionLaw { mu: [MU; 2], adhesion_n: 0.0, viscosity_s_m: 0.0 };
    law::<f64>(effect.code).unwrap().friction(&effect.parameters, context, &[1.0; MEMORY], &slip, &mut found);
    found.mu[0] * (1.0 + found.viscosity_s_m)
}

#[test]
fn a_law_of_the_pads_friction_is_the_pushers_by_the_share_that_is_told() {
    let gripped = at_rest_context(0.004);
    let lying = StepContext { fingers: None, ..gripped };
    for id in ["static_friction", "viscous_friction", "dwell_strengthening", "load_dependent_friction"] {
        let with = |elsewhere: f64| {
            let mut effect = Effect::<f64>::typical(id).unwrap();
            let at = effect.info().unwrap().parameters.iter().position(|p| p.name == "elsewhere").unwrap();
            effect.parameters[at] = elsewhere;
            effect
        };
        let whole = friction_at(Body::Finger1, &gripped, &with(0.0));
        assert!((whole - MU).abs() > 1e-3, "{id} shows at a fingertip");
        for body in [Body::Pusher, Body::Support] {
            assert_eq!(friction_at(body, &gripped, &with(0.0)), MU, "{id}");
            assert_eq!(friction_at(body, &gripped, &with(1.0)), whole, "{id}");
            let half = friction_at(body, &gripped, &with(0.5));
            assert!(
                (half - MU).abs() > 0.4 * (whole - MU).abs() && (half - whole).abs() > 1e-4,
                "{id}: {half}"
            );
        }
        assert_eq!(friction_at(Body::Support, &lying, &with(0.0)), whole, "{id} where nothing is gripped");
    }
}

#[test]
fn anisotropic_friction_pushes_with_the_root_of_the_ratio_along_x() {
    let force = push_force(&pure_push::<f64>(0.01).with("anisotropic_friction", &[1.44]));
    close(force, 2.0 * MU * N * 1.2, 1e-4);
}

#[test]
fn finger_friction_mismatch_splits_the_push_unevenly_and_keeps_its_sum() {
    let record = pure_push::<f64>(0.01).with("finger_friction_mismatch", &[0.2]).play();
    let [a, b] = record.last().reading.finger.map(|w| w[0]);
    close(a / b, 1.2 / 0.8, 0.01);
    close(-(a + b), 2.0 * MU * N, 0.01);
}

#[test]
fn wear_drift_changes_friction_in_proportion_to_the_trial() {
    let mut run = pure_push::<f64>(0.01).with("wear_drift", &[-0.001]);
    run.drive.trial = 150.0;
    close(push_force(&run), 2.0 * MU * N * 0.85, 1e-4);
}

#[test]
fn contact_compliance_sags_by_weight_over_two_springs_and_closes_by_the_grip() {
    let run = hold::<f64>().with("contact_compliance", &[1e-4, 1e-5]);
    let state = run.play().state;
    close(-state.position_m.z, 0.2005 * 9.81 / 2.0 * (1e-4 + 1e-7), 1e-3);
    close(-state.jaw_m, N * (1e-5 + 1e-7), 1e-3);
}

#[test]
fn the_pressure_of_sheared_pads_goes_along_with_the_object_and_its_moments_balance() {
    let compliance_m_n = 1e-4;
    let weight_n = 0.2005 * 9.81;
    for carry in [0.0, 0.5, 1.0, -1.0] {
        let parameters = [compliance_m_n, 1e-5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, carry];
        let run = hold::<f64>().with("contact_compliance", &parameters);
        let played = run.play();
        let [one, two] = played.last().reading.finger;
        // The object hangs lower than its fingers by what the pads are sheared, and the grip presses there: `r x f`.
        let sag_m = 0.5 * weight_n * (compliance_m_n + 1e-7);
        close(one[3] + 1.0, 1.0 + carry * sag_m * one[1], 1e-5);
        close(two[3] + 1.0, 1.0 + carry * sag_m * two[1], 1e-5);
        // Both grip at one height: nothing turns.
        assert!(played.state.rotation.angle() < 1e-6, "{carry}: {} rad", played.state.rotation.angle());
        close(one[2] + two[2], weight_n, 1e-6);
    }
}

#[test]
fn a_pusher_gives_way_by_its_compliance_times_the_push() {
    let at = |compliance_m_n: f64| {
        let run = light_push(0.01).with("contact_compliance", &[0.0, 0.0, compliance_m_n]);
        let record = run.play();
        (record.state.position_m.x, record.last().reading.pusher[0])
    };
    let ((stiff_m, force_n), (soft_m, soft_n)) = (at(0.0), at(1e-5));
    close(soft_n, force_n, 1e-3);
    close(stiff_m - soft_m, force_n * 1e-5, 1e-3);
}

#[test]
fn a_plate_gives_way_along_its_face_by_its_shear_more_than_into_it() {
    let compliance_m_n = 1e-5;
    // What a plate that moves along its face moves for each newton, the object's own turn included.
    let along_m_n = |shear: f64| {
        let parameters = [0.0, 0.0, compliance_m_n, 0.0, 0.0, 0.0, 0.0, shear];
        let mut run = light_push(0.002).with("contact_compliance", &parameters);
        run.model.friction.pusher = 0.5;
        let (mut state, mut drive) = stopped(&run, &run.play().state);
        // Fingers that hold the object.
        drive.grip_n = 5.0 * N;
        let mut pusher_z_n = |speed_m_s: f64| {
            let mut last_n = 0.0;
            for k in 0..40 {
                let plate = drive.pusher.as_mut().unwrap();
                plate.velocity_m_s = Vec3::new(0.0, 0.0, if k < 25 { speed_m_s } else { 0.0 });
                last_n = step(&run.scene, &run.model, &mut state, &drive).reading.pusher[2];
                let plate = drive.pusher.as_mut().unwrap();
                plate.position_m += plate.velocity_m_s * drive.dt_s;
            }
            last_n
        };
        let before_n = pusher_z_n(0.0);
        let after_n = pusher_z_n(1e-4);
        1e-4 * 25.0 * drive.dt_s / (after_n - before_n)
    };
    for shear in [0.4, 2.0] {
        close((along_m_n(shear) - along_m_n(0.0)) / compliance_m_n, shear, 0.05);
    }
}

#[test]
fn a_push_on_pads_whose_parts_slip_one_after_another_follows_dahls_law() {
    let (compliance_m_n, limit_n) = (2e-4, 2.0 * MU * N);
    let reach_m = MU * N * compliance_m_n;
    for microslip in [0.0, 0.3, 0.6, 1.0] {
        let mut run = light_push(0.005).with("contact_compliance", &[compliance_m_n, 0.0, 0.0, microslip]);
        run.steps = 600;
        let (mut before_m, mut seen) = (0.0, 0);
        for output in run.play().outputs.iter().skip(9).step_by(10) {
            let (at_m, force_n) = (output.reading.position_m.x, output.reading.pusher[0]);
            let s = at_m / reach_m;
            let share = if microslip == 0.0 { s } else { (1.0 - (-microslip * s).exp()) / microslip };
            assert!(
                (force_n / limit_n - share.min(1.0)).abs() < 0.02,
                "{microslip}: {force_n} N at {s} of the reach"
            );
            seen += usize::from(at_m > before_m && share < 0.95);
            before_m = at_m;
        }
        assert!(seen > 5, "{microslip}: it loads over many steps");
    }
}

#[test]
fn pads_that_stiffen_move_before_they_slide_by_their_compliance_at_the_grip() {
    let compliance_m_n = 1e-4;
    let pushed_n_m = |grip_n: f64, stiffening: f64| {
        let mut run =
            light_push(0.005).with("contact_compliance", &[compliance_m_n, 0.0, 0.0, 0.0, stiffening]);
        run.drive.grip_n = grip_n;
        run.steps = 30;
        let played = run.play();
        played.last().reading.pusher[0] / played.last().reading.position_m.x
    };
    for stiffening in [0.0, 1.0 / 3.0, 1.0] {
        for grip_n in [5.0, 20.0, 60.0] {
            // Two pads.
            let stiffness_n_m = 2.0 / compliance_m_n * (grip_n / 20.0_f64).powf(stiffening);
            close(pushed_n_m(grip_n, stiffening), stiffness_n_m, 0.01);
        }
    }
}

#[test]
fn pads_that_are_pressed_harder_keep_their_shear_force_and_lose_it_in_proportion_as_they_are_relieved() {
    for stiffening in [1.0 / 3.0, 1.0] {
        let mut run = light_push(0.002).with("contact_compliance", &[1e-4, 0.0, 0.0, 0.0, stiffening]);
        // Ten steps after half a millimetre of gap.
        run.steps = 73;
        let moved = run.play();
        let (mut state, mut drive) = stopped(&run, &moved.state);
        let mut at_grip = |grip_n: f64| {
            let from_n = drive.grip_n;
            let mut last_n = 0.0;
            // In small steps, and some at rest.
            for k in 1..=60 {
                drive.grip_n = from_n + (grip_n - from_n) * f64::from(k.min(40)) / 40.0;
                last_n = step(&run.scene, &run.model, &mut state, &drive).reading.pusher[0];
            }
            last_n
        };
        let start_n = at_grip(20.0);
        assert!(start_n > 1.0, "{start_n}");
        let ratio = 0.5_f64.powf(stiffening);
        close(at_grip(40.0), start_n, 0.02);
        // The stretch is that of the stiffest: at 20 N it is held with less force than it was loaded with.
        close(at_grip(20.0), start_n * ratio, 0.02);
        close(at_grip(40.0), start_n * ratio, 0.02);
        close(at_grip(10.0), start_n * ratio.powi(3), 0.02);
    }
}

#[test]
fn a_push_that_ends_is_held_by_pads_whose_parts_slip_at_the_force_that_it_ended_at() {
    for (compliance_m_n, microslip) in [(2e-4, 0.6), (2e-4, 1.0), (1e-6, 1.0)] {
        let mut run = light_push(0.002).with("contact_compliance", &[compliance_m_n, 0.0, 0.0, microslip]);
        run.steps = 300;
        let moved = run.play();
        let (mut state, drive) = stopped(&run, &moved.state);
        let mut force_n = 0.0;
        for _ in 0..50 {
            force_n = step(&run.scene, &run.model, &mut state, &drive).reading.pusher[0];
        }
        close(force_n, moved.last().reading.pusher[0], 0.02);
    }
}

#[test]
fn a_push_that_slows_down_loses_no_force_to_pads_whose_parts_slip() {
    // Six steps to a reach, stopped where the pads bear most but not all of what friction does.
    let mut run = light_push(0.02).with("contact_compliance", &[2e-4, 0.0, 0.0, 1.0]);
    let step_m = 0.02 * run.drive.dt_s;
    run.model.effects[0].parameters[0] = 6.0 * step_m / (MU * N);
    run.steps = 24;
    let moved = run.play();
    let (mut state, mut drive) = (moved.state.clone(), run.drive);
    let (carrier_m_s, plate_m_s) = (drive.carrier_m_s, drive.pusher.unwrap().velocity_m_s);
    let plate = drive.pusher.as_mut().unwrap();
    plate.position_m += plate_m_s * (drive.dt_s * run.steps as f64);
    let force_n = moved.last().reading.pusher[0];
    assert!(force_n < 0.97 * 2.0 * MU * N && force_n > 0.85 * 2.0 * MU * N, "{force_n} N");
    let mut held_n = force_n;
    for left in (0..10).rev().map(|k| f64::from(k) / 10.0) {
        drive.carrier_m_s = carrier_m_s * left;
        let plate = drive.pusher.as_mut().unwrap();
        plate.velocity_m_s = plate_m_s * left;
        held_n = step(&run.scene, &run.model, &mut state, &drive).reading.pusher[0];
        let plate = drive.pusher.as_mut().unwrap();
        plate.position_m += plate.velocity_m_s * drive.dt_s;
    }
    assert!(held_n > force_n, "{held_n} N of {force_n}");
}

const HALF_M: f64 = 0.0125;
const LOAD_N: f64 = 20.0;
const FACE_N_M: f64 = 1e6;

/// A face of 25 mm on a plane, pressed by `deepest_m` and tilted along the object's Y (1) or Z (2), `rim` of its stiffness at its
/// ends along Z: force and moment of the points that stand for it, over 20 N and over them on half of the side.
fn pressed(axis: usize, rim: f64, (tilt, deepest_m): (f64, f64)) -> (f64, f64) {
    let run = push::<f64>(0.0);
    let state = State::held(&run.scene, &run.model, &run.drive, Vec3::zeros(), run.rotation);
    let mut contacts = Contacts::<f64, SLOTS>::new();
    find(&run.scene, &run.model, &state, &run.drive, &mut contacts);
    for c in contacts.iter_mut().filter(|c| c.body == Body::Pusher) {
        (c.profile, c.normal_n_m) = (Some(rim), FACE_N_M);
        c.gap_m = tilt * (HALF_M - c.lever_m[axis]) - deepest_m;
    }
    assert_eq!(spread(&mut contacts, LOAD_N), 0);
    let points: Vec<_> = contacts.iter().filter(|c| c.body == Body::Pusher).collect();
    assert_eq!(points.len(), 8);
    points.iter().fold((0.0, 0.0), |(force_n, moment_nm), c| {
        let n = (-FACE_N_M * c.share * c.gap_m).max(0.0);
        (force_n + n / LOAD_N, moment_nm + n * c.lever_m[axis] / (LOAD_N * HALF_M))
    })
}

/// Tilt and depth with which an even foundation bears 20 N at `off` of half of its side: where all of it touches (off below a
/// third) and where it does in part.
fn winkler(off: f64) -> (f64, f64) {
    if off < 1.0 / 3.0 {
        let tilt = 3.0 * LOAD_N * off / (FACE_N_M * HALF_M);
        (tilt, LOAD_N / FACE_N_M + tilt * HALF_M)
    } else {
        let tilt = 4.0 * LOAD_N / (9.0 * FACE_N_M * HALF_M * (1.0 - off) * (1.0 - off));
        (tilt, tilt * 3.0 * HALF_M * (1.0 - off))
    }
}

#[test]
fn a_face_that_bears_evenly_stands_against_turning_either_way_as_winklers_foundation_does() {
    let near = |axis: usize, off: f64, share: f64| {
        let (force, moment) = pressed(axis, 0.0, winkler(off));
        let off_by = (force - 1.0).abs().max((moment - off).abs());
        assert!(off_by <= share, "axis {axis}, {off}: {force}, {moment}");
    };
    for axis in [1, 2] {
        for off in [0.0, 0.2, 1.0 / 3.0, 0.5, 0.7, 7.0 / 9.0] {
            near(axis, off, 1e-9);
        }
    }
    near(1, 0.86, 1e-9);
    // What touches on less than a third along Z bears on the points of a third.
    near(2, 0.86, 0.05);
    near(2, 0.9, 0.1);
}

#[test]
fn a_hollow_face_bears_with_two_springs_at_its_ends_beside_a_foundation() {
    for rim in [0.2, 1.0 / 3.0, 0.8, 1.0] {
        for touches in [0.4, 0.6, 0.9] {
            // Of the side: force over `k r`, and its distance from the end.
            let (even, ends) = ((1.0 - rim) * touches * touches / 2.0, rim * touches / 2.0);
            let rise_m = LOAD_N / (FACE_N_M * (even + ends));
            let from_end = even * (touches / 3.0) / (even + ends);
            let (force, moment) = pressed(2, rim, (rise_m / (2.0 * HALF_M), rise_m * touches));
            assert!((force - 1.0).abs() < 1e-9 && (moment - (1.0 - 2.0 * from_end)).abs() < 1e-9);
        }
        // All of it touches: a third of even springs' moment, all of that of springs at the ends.
        let tilt = 2e-4;
        let (force, moment) = pressed(2, rim, (tilt, LOAD_N / FACE_N_M + tilt * HALF_M));
        let stands = FACE_N_M * HALF_M * HALF_M * ((1.0 - rim) / 3.0 + rim);
        assert!((force - 1.0).abs() < 1e-9);
        assert!((moment - tilt * stands / (LOAD_N * HALF_M)).abs() < 1e-9, "{rim}: {moment}");
    }
}

/// Radius and tangential stiffness of a pad.
const RADIUS_M: f64 = 0.01;
const PAD_N_M: f64 = 1e5;

#[test]
fn a_disc_pad_resists_turning_by_its_ratio_and_shifts_and_presses_as_without() {
    let mut run = spin::<f64>(FingerContact::Disc { diameter_m: 2.0 * RADIUS_M });
    // The face is seen tilted: the gap is linear over it.
    run.rotation = Rotation::from_scaled_axis(Vec3::new(0.02, 0.0, -0.03));
    let state = State::held(&run.scene, &run.model, &run.drive, Vec3::zeros(), run.rotation);
    let mut ring = Contacts::<f64, SLOTS>::new();
    find(&run.scene, &run.model, &state, &run.drive, &mut ring);
    for ratio in [0.5, 0.64, 0.776, 0.95] {
        let mut contacts = ring.clone();
        for c in &mut contacts {
            (c.profile, c.tangential_n_m) = (Some(ratio), PAD_N_M);
        }
        assert_eq!(spread(&mut contacts, 0.0), 0);
        for body in [Body::Finger1, Body::Finger2] {
            let of_body = |all: &Contacts<f64, SLOTS>, of: &dyn Fn(&Contact<f64>) -> f64| -> f64 {
                all.iter().filter(|c| c.body == body).map(of).sum()
            };
            let sum = |of: &dyn Fn(&Contact<f64>) -> f64| of_body(&contacts, of);
            let r2 = |c: &Contact<f64>| c.patch_m[0].powi(2) + c.patch_m[1].powi(2);
            close(sum(&|c| c.share), 1.0, 1e-12);
            close(sum(&|c| c.share * c.tangential_n_m), PAD_N_M, 1e-12);
            close(sum(&|c| c.share * c.tangential_n_m * r2(c)), ratio * PAD_N_M * RADIUS_M * RADIUS_M, 1e-9);
            close(sum(&|c| c.share * r2(c).sqrt()), 2.0 / 3.0 * RADIUS_M, 1e-9);
            for k in [0, 1] {
                assert!(sum(&|c| c.share * c.tangential_n_m * c.patch_m[k]).abs() < 1e-9, "no coupling");
                let tilts = |c: &Contact<f64>| c.share * c.gap_m * c.patch_m[k];
                close(sum(&tilts), 1.135 * of_body(&ring, &tilts), 1e-3);
            }
        }
    }
}

/// What the points of `body` resist a shift by `shift_m` beside a turn by one radian with, along it, for a load and a coefficient of one.
fn resists(contacts: &Contacts<f64, SLOTS>, body: Body, shift_m: Vec3<f64>) -> f64 {
    let of_body = || contacts.iter().filter(|c| c.body == body);
    let middle = of_body().fold(Vec3::zeros(), |sum, c| sum + c.lever_m * c.share);
    let along = |c: &Contact<f64>| {
        let slides = shift_m + Vec3::y().cross(&(c.lever_m - middle));
        c.share * slides.dot(&shift_m) / (slides.norm() * shift_m.norm())
    };
    of_body().map(along).sum()
}

#[test]
fn pads_that_turn_while_they_shift_slowly_resist_it_alike_whichever_way_it_goes() {
    let run = spin::<f64>(FingerContact::Disc { diameter_m: 2.0 * RADIUS_M });
    let state = State::held(&run.scene, &run.model, &run.drive, Vec3::zeros(), run.rotation);
    let mut ring = Contacts::<f64, SLOTS>::new();
    find(&run.scene, &run.model, &state, &run.drive, &mut ring);
    let shift_m = RADIUS_M / 8.0;
    let ways = || {
        let angle = |k: i32| f64::from(k) * std::f64::consts::PI / 8.0;
        (0..16).map(move |k| Vec3::new(angle(k).cos(), 0.0, angle(k).sin()) * shift_m)
    };
    // A disc's, by integration over rings and angles.
    let (mut disc, mut weights) = (0.0, 0.0);
    for k in 0..4000 {
        let r_m = RADIUS_M * (f64::from(k % 40) + 0.5) / 40.0;
        let angle = f64::from(k / 40) * std::f64::consts::TAU / 100.0;
        let slides = Vec3::x() * shift_m + Vec3::y().cross(&(Vec3::new(angle.cos(), 0.0, angle.sin()) * r_m));
        disc += r_m * slides.x / slides.norm();
        weights += r_m;
    }
    disc /= weights;
    for ratio in [0.5, 0.776, -0.776] {
        let mut contacts = ring.clone();
        contacts.iter_mut().for_each(|c| (c.profile, c.tangential_n_m) = (Some(ratio), PAD_N_M));
        assert_eq!(spread(&mut contacts, 0.0), 0);
        let of = |body: Body| ways().map(|way| resists(&contacts, body, way)).collect::<Vec<f64>>();
        let (one, other) = (of(Body::Finger1), of(Body::Finger2));
        let (least, most) = one.iter().fold((1.0_f64, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
        assert!(most > 1.1 * least, "one pad's three outer points do not: {least} to {most}");
        for (a, b) in one.iter().zip(&other) {
            let both = 0.5 * (a + b);
            close(both, 0.5 * (one[0] + other[0]), 0.01);
            // Few points resist it less.
            close(both, disc, 0.16);
        }
    }
}

#[test]
fn torsional_friction_of_a_disc_is_the_same_however_its_stiffness_is_spread() {
    for ratio in [0.0, 0.3, 0.5, 0.776, 0.95, 2.0] {
        let run = spin::<f64>(FingerContact::Disc { diameter_m: 0.02 });
        let run = run.with("contact_compliance", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, ratio]);
        close(run.play().outputs[0].reading.finger[0][4].abs(), MU * N * 0.02 / 3.0, 1e-3);
    }
}

fn torsion(fingers: FingerContact<f64>, change_m: f64) -> f64 {
    spin(fingers).with("torsional_friction", &[change_m]).play().outputs[0].reading.finger[0][4].abs()
}

#[test]
fn torsional_friction_is_mu_n_times_the_changed_radius() {
    let disc = FingerContact::Disc { diameter_m: 0.02 };
    for change in [-0.002, 0.0, 0.003] {
        close(torsion(disc, change), MU * N * (0.02 / 3.0 + change), 1e-3);
    }
}

#[test]
fn torsional_friction_gives_a_point_contact_torsion() {
    assert!(torsion(FingerContact::Point, 0.0) < 1e-9);
    close(torsion(FingerContact::Point, 0.004), MU * N * 0.004, 1e-3);
}

#[test]
fn pressure_offset_shows_the_grip_times_the_offset_as_torques() {
    let mut run = hold::<f64>().with("pressure_offset", &[0.002, 0.001]);
    run.scene.gravity_m_s2 = [0.0; 3];
    // Finger 1 presses towards -Y: (dx, 0, dz) x (0, -N, 0) = (dz N, 0, -dx N).
    let w = run.play().last().reading.finger[0];
    close(w[3], 0.001 * N, 1e-3);
    close(w[5], -0.002 * N, 1e-3);
}

#[test]
fn face_tilt_helps_the_slide_as_a_wedge_does() {
    let slope = 0.05_f64;
    let force = push_force(&pure_push::<f64>(0.01).with("face_tilt", &[slope, 0.0]));
    // The grip acts along the face's normal: pads that swivel with the face.
    let (s, c) = slope.sin_cos();
    close(force, 2.0 * N * (MU * c - s), 1e-3);
}

#[test]
fn face_tilt_changes_friction_in_proportion_to_the_place_on_the_object() {
    let record = pure_push::<f64>(0.01).with("face_tilt", &[0.0, 10.0]).play();
    // The pads' place on the object is minus the object's place in the gripper.
    let x = -record.state.position_m.x;
    close(record.last().reading.pusher[0], 2.0 * MU * N * (1.0 + 10.0 * x), 2e-3);
}

#[test]
fn face_tilt_raises_the_grip_in_proportion_to_the_way_along_the_object() {
    let record = pure_push::<f64>(0.01).with("face_tilt", &[0.0, 0.0, 500.0]).play();
    let x = -record.state.position_m.x;
    close(record.last().normal_n[0], N + 500.0 * x, 2e-3);
}

#[test]
fn a_jaw_that_stiffens_with_its_load_raises_the_grip_by_a_share_of_it() {
    let record = pure_push::<f64>(0.01).with("face_tilt", &[0.0, 0.0, 0.0, 0.0, -18.0]).play();
    let x = -record.state.position_m.x;
    close(record.last().normal_n[0], N * (1.0 - 18.0 * x), 2e-3);
}

#[test]
fn a_jaw_that_gives_way_late_presses_harder_in_proportion_to_the_speed_of_opening() {
    let record = pure_push::<f64>(0.01).with("face_tilt", &[0.0, 0.0, 500.0, 0.1]).play();
    let x = -record.state.position_m.x;
    // The object slides towards +X of the gripper, the pads towards -X of the object.
    close(record.last().normal_n[0], N + 500.0 * (x - 0.1 * 0.01), 2e-3);
}

/// Centre of pressure and standard deviation about it of a strip of half length `half_m` on springs that press
/// only, tilted so far that its moment would be `moment_nm` if all of them touched; by bisection over the depth.
fn strip_on_springs(moment_nm: f64, load_n: f64, half_m: f64) -> (f64, f64) {
    let points: Vec<f64> = (0..20_001).map(|k| half_m * (k as f64 / 10_000.0 - 1.0)).collect();
    // Unit springs: the sum of x^2 is the stiffness against turning.
    let slope = moment_nm / points.iter().map(|x| x * x).sum::<f64>();
    let sums = |depth: f64| {
        points.iter().fold((0.0, 0.0, 0.0), |(force, moment, second), x| {
            let f = (depth + slope * x).max(0.0);
            (force + f, moment + f * x, second + f * x * x)
        })
    };
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if sums(middle).0 < load_n { low = middle } else { high = middle }
    }
    let (_, moment, second) = sums(low);
    (moment / load_n, (second / load_n - (moment / load_n).powi(2)).sqrt())
}

#[test]
fn a_wedge_under_pads_that_cannot_turn_moves_and_narrows_the_pressure_as_a_strip_on_springs() {
    let along = |run: &Run<f64>| -> Vec<f64> {
        let record = run.play();
        record.last().contacts.iter().filter(|c| c.body == Body::Finger1).map(|c| c.object_m.x).collect()
    };
    let spread = |x: &[f64]| {
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt()
    };
    let mut run = hold::<f64>();
    run.scene.gravity_m_s2 = [0.0; 3];
    let flat = spread(&along(&run));
    for moment_nm in [0.02, 0.06, -0.06, 0.1, 0.3, -1.0] {
        let wedge = run.clone().with("face_tilt", &[0.0, 0.0, 0.0, 0.0, 0.0, moment_nm]);
        let (middle, wide) = strip_on_springs(moment_nm, N, 0.01);
        close(wedge.play().last().reading.finger[0][5], -N * middle, 2e-3);
        close(spread(&along(&wedge)) / flat, wide / (0.01 / 3.0_f64.sqrt()), 2e-3);
    }
}

#[test]
fn pads_set_up_flat_on_a_wedge_are_pressed_off_their_middle_by_what_the_object_turned_since() {
    let disc = FingerContact::Disc { diameter_m: 0.02 };
    let run = spin::<f64>(disc);
    let (law, moment_nm) = (law::<f64>(11).unwrap(), 0.03);
    let start = Rotation::from_scaled_axis(Vec3::new(0.0, 0.2, 0.0));
    let middle = |contacts: &Contacts<f64, SLOTS>, body: Body| {
        let of_body = contacts.iter().filter(|c| c.body == body);
        of_body.fold(Vec3::zeros(), |sum, c| sum + c.lever_m * c.share)
    };
    for (set_up, turned_rad) in [(1.0, 0.0), (1.0, 0.5), (1.0, -0.9), (0.0, 0.5), (0.4, 0.5)] {
        let parameters = with_zeros([0.0, 0.0, 0.0, 0.0, 0.0, moment_nm, set_up]);
        let (mut context, mut memory) = (at_rest_context(0.004), [0.0; MEMORY]);
        context.rotation = start;
        law.grip(&parameters, &context, &mut memory, &mut 20.0);
        context.rotation = Rotation::from_scaled_axis(Vec3::new(0.0, turned_rad, 0.0)) * start;
        law.grip(&parameters, &context, &mut memory, &mut 20.0);
        let state = State::held(&run.scene, &run.model, &run.drive, Vec3::zeros(), context.rotation);
        let mut flat = Contacts::<f64, SLOTS>::new();
        find(&run.scene, &run.model, &state, &run.drive, &mut flat);
        let mut pressed = flat.clone();
        pressed.iter_mut().for_each(|c| law.contact(&parameters, &context, &memory, c));
        for body in [Body::Finger1, Body::Finger2] {
            let moved = middle(&pressed, body) - middle(&flat, body);
            let rises = context.rotation * Vec3::x() - start * Vec3::x() * set_up;
            let expected = rises * (moment_nm / N);
            assert!((moved - expected).norm() < 1e-9, "{set_up} {turned_rad} {body:?}: {moved} {expected}");
        }
        if set_up == 1.0 {
            let size_m = (middle(&pressed, Body::Finger1) - middle(&flat, Body::Finger1)).norm();
            let chord: f64 = 2.0 * (0.5 * f64::abs(turned_rad)).sin();
            assert!((size_m - moment_nm / N * chord).abs() < 1e-9, "2 M sin(b / 2) over the grip");
        }
    }
}

#[test]
fn face_waviness_lets_the_grip_follow_the_height() {
    let (wavelength, phase, grip) = (0.008, 0.3, 2.0);
    let record = pure_push::<f64>(0.01).with("face_waviness", &[0.0, wavelength, phase, grip]).play();
    let angle = |x: f64| std::f64::consts::TAU * x / wavelength + phase;
    let x = -record.state.position_m.x;
    close(record.last().normal_n[0], N + grip * (angle(0.0).cos() - angle(x).cos()), 1e-2);
}

#[test]
fn a_wave_of_the_grip_is_there_from_the_start_by_the_share_that_goes_by_the_place_on_the_object() {
    let (wavelength, phase, grip) = (0.008, 0.3, 2.0);
    for at_middle in [0.0, 0.4, 1.0] {
        let parameters = [0.0, wavelength, phase, grip, 0.0, at_middle];
        let record = pure_push::<f64>(0.01).with("face_waviness", &parameters).play();
        let angle = |x: f64| std::f64::consts::TAU * x / wavelength + phase;
        let x = -record.state.position_m.x;
        let rises = (1.0 - at_middle) * angle(0.0).cos() - angle(x).cos();
        close(record.last().normal_n[0], N + grip * rises, 1e-2);
    }
}

#[test]
fn face_waviness_follows_the_sine_of_the_place() {
    let (a, wavelength, phase) = (0.1, 0.008, 0.3);
    let record = pure_push::<f64>(0.01).with("face_waviness", &[a, wavelength, phase]).play();
    // Friction of a step goes by the place at its beginning.
    let x = -(record.state.position_m.x - 0.01 * 0.004);
    let factor = 1.0 + a * (std::f64::consts::TAU * x / wavelength + phase).sin();
    close(record.last().reading.pusher[0], 2.0 * MU * N * factor, 2e-3);
}

#[test]
fn plate_tilt_turns_the_frictionless_push_by_its_angles() {
    let record = pure_push::<f64>(0.01).with("plate_tilt", &[0.01, 0.02]).play();
    let f = record.last().reading.pusher;
    close(f[1] / f[0], 0.02, 1e-3);
    close(-f[2] / f[0], 0.01, 1e-3);
}

#[test]
fn adhesion_adds_to_the_load_of_the_friction_bound() {
    close(push_force(&pure_push::<f64>(0.01).with("adhesion", &[3.0])), 2.0 * MU * (N + 3.0), 1e-4);
}

#[test]
fn grip_force_loss_presses_with_what_is_left() {
    let record = hold::<f64>().with("grip_force_loss", &[0.1, 1.5]).play();
    close(record.last().normal_n[0], N * 0.9 - 1.5, 1e-6);
}

#[test]
fn grip_force_lag_settles_at_the_drop_in_steady_sliding() {
    let record = pure_push::<f64>(0.01).with("grip_force_lag", &[0.12, 0.05]).play();
    close(record.last().normal_n[0], N * (1.0 - 0.12 * 0.01 / 0.011), 1e-3);
}

#[test]
fn a_sharp_grip_force_lag_drops_all_above_its_knee_and_nothing_below() {
    let pressed = |knee_m_s: f64| {
        let with = [0.12, 0.05, knee_m_s, 8.0];
        pure_push::<f64>(0.01).with("grip_force_lag", &with).play().last().normal_n[0]
    };
    close(pressed(0.005), N * (1.0 - 0.12 * 256.0 / 257.0), 1e-3);
    close(pressed(0.01), N * (1.0 - 0.12 / 2.0), 1e-3);
    assert!(pressed(0.05) > 0.999 * N);
}

#[test]
fn grip_lost_by_the_metre_of_slip_stays_lost_at_rest() {
    let law: &dyn Law<f64> = stickslip_shared::effects::law(16).unwrap();
    let lost_after = |drop: f64, drop_1_m: f64| {
        let parameters = with_zeros([drop, 0.05, 1e-3, 1.0, drop_1_m]);
        let mut memory = [0.0; MEMORY];
        let mut context = at_rest_context(0.001);
        let mut step = |speed_m_s: f64| {
            context.slip_speed_m_s = [speed_m_s; 4];
            context.slip_m = context.slip_m.map(|d| d + speed_m_s * 0.001);
            let mut grip_n = N;
            law.grip(&parameters, &context, &mut memory, &mut grip_n);
            1.0 - grip_n / N
        };
        let slid = (0..1000).map(|_| step(0.01)).last().unwrap();
        let rested = (0..1000).map(|_| step(0.0)).last().unwrap();
        [slid, rested]
    };
    // 10 mm at 14 a metre; while sliding it trails by the 0.5 mm of a time constant.
    let [slid, rested] = lost_after(0.0, 14.0);
    close(slid, 0.14 - 14.0 * 0.01 * 0.05, 1e-6);
    close(rested, 0.14, 1e-6);
    let [slid, rested] = lost_after(0.12, 0.0);
    close(slid, 0.12 * 0.01 / 0.011, 1e-6);
    assert!(rested < 1e-6, "what goes with the speed comes back");
}

#[test]
fn mass_error_shows_as_weight_and_its_offset_as_moment() {
    let w = hold::<f64>().with("mass_error", &[0.25, 0.004]).play().last().reading.finger;
    let weight = 0.2005 * 1.25 * 9.81;
    close(w[0][2] + w[1][2], weight, 1e-3);
    // Weight at +x turns about +Y; the fingers answer with the opposite moment.
    close(-(w[0][4] + w[1][4]), 0.004 * weight, 0.01);
}

#[test]
fn external_force_is_borne_by_the_fingers_with_its_moment() {
    let (pull, arm) = ([0.3, 0.0, -0.5], 0.04);
    let force = with_zeros([pull[0], pull[1], pull[2], 0.0, arm]);
    let w = hold::<f64>().with("external_force", &force[..5]).play().last().reading.finger;
    close(w[0][0] + w[1][0], -pull[0], 1e-3);
    close(w[0][2] + w[1][2], 0.2005 * 9.81 - pull[2], 1e-3);
    // A pull down at +x turns about +Y; the fingers answer with the opposite moment.
    close(-(w[0][4] + w[1][4]), -arm * pull[2], 0.01);
}

#[test]
fn a_spring_from_the_room_pushes_back_by_its_stiffness_times_the_way() {
    // The gripper stands, and the plate moves the object through it.
    let mut run = light_push(0.01);
    run.drive.carrier_m_s = Vec3::zeros();
    let plain = run.play().last().reading.pusher[0];
    let sprung = run.with("external_force", &[0.0, 0.0, 0.0, 50.0]).play();
    let way = sprung.state.position_m.x;
    assert!(way > 5e-3, "{way} m");
    close(sprung.last().reading.pusher[0] - plain, 50.0 * way, 0.01);
}

#[test]
fn a_spring_from_the_room_does_nothing_to_an_object_that_stands_in_it() {
    // The gripper slides along an object that a plate holds; before, it carries it over the gap of half a millimetre.
    let run = light_push(0.01);
    let plain = run.play().last().reading.pusher[0];
    let sprung = run.with("external_force", &[0.0, 0.0, 0.0, 50.0]).play().last().reading.pusher[0];
    // ... to within the way of a step.
    close(plain - sprung, 50.0 * 0.5e-3, 0.1);
}

#[test]
fn gravity_tilt_pulls_sideways_with_the_sine_of_the_angle() {
    let w = hold::<f64>().with("gravity_tilt", &[0.0, 0.05]).play().last().reading.finger;
    close(w[0][0] + w[1][0], 0.2005 * 9.81 * 0.05_f64.atan().sin(), 1e-3);
}

#[test]
fn rolling_resistance_slows_a_free_cylinder_by_two_thirds_of_g_arm_over_radius() {
    let run = roll::<f64>();
    let free = run.play().state.absolute_m_s.y;
    let slowed = run.clone().with("rolling_resistance", &[0.0005]).play().state.absolute_m_s.y;
    let time = run.steps as f64 * 0.004;
    // 15 N mm would build up over 1.15 degrees: a few steps at 10 rad/s.
    close(free - slowed, 2.0 / 3.0 * 9.81 * 0.0005 / 0.02 * time, 0.02);
}

#[test]
fn sensor_bias_adds_each_of_its_constants_to_its_own_channel() {
    let plain = push::<f64>(0.01).play();
    let biases: [f64; 18] = core::array::from_fn(|k| 0.01 * (k + 1) as f64);
    let run = push::<f64>(0.01).with("sensor_bias", &biases).play();
    let channels = |reading: &Reading<f64>| {
        let [finger1, finger2] = reading.finger;
        [finger1, finger2, reading.pusher].concat()
    };
    let (with, without) = (channels(&run.last().reading), channels(&plain.last().reading));
    for ((with, without), bias) in with.iter().zip(&without).zip(biases) {
        assert!((with - without - bias).abs() < 1e-12);
    }
}

#[test]
fn sensor_gain_scales_fingers_and_pusher() {
    let plain = push::<f64>(0.01).play();
    let run = push::<f64>(0.01).with("sensor_gain", &[0.05, 0.02, -0.1]).play();
    close(run.last().reading.finger[0][1], 1.05 * plain.last().reading.finger[0][1], 1e-12);
    close(run.last().reading.finger[1][1], 1.02 * plain.last().reading.finger[1][1], 1e-12);
    close(run.last().reading.pusher[0], 0.9 * plain.last().reading.pusher[0], 1e-12);
}

#[test]
fn sensor_misalignment_turns_the_push_into_the_channels_across() {
    let plain = pure_push::<f64>(0.01).play().last().reading.pusher;
    let mut turn = [0.0; 9];
    (turn[7], turn[8]) = (0.03, 0.02);
    let turned = pure_push::<f64>(0.01).with("sensor_misalignment", &turn).play();
    let w = turned.last().reading.pusher;
    // About Y: x goes to -z; about Z: x goes to y.
    close(w[2] - plain[2], -0.03 * plain[0], 1e-6);
    close(w[1] - plain[1], 0.02 * plain[0], 1e-6);
}

#[test]
fn a_finger_sensor_turned_about_gripper_z_shows_a_share_of_the_grip_along_the_slide() {
    let mut run = hold::<f64>();
    run.scene.gravity_m_s2 = [0.0; 3];
    let plain = run.play().last().reading.finger;
    let turned = run.with("sensor_misalignment", &[0.0, 0.0, 0.03, 0.0, 0.0, -0.02]).play();
    for ((w, plain), angle) in turned.last().reading.finger.iter().zip(plain).zip([0.03, -0.02]) {
        close(plain[1].abs(), N, 1e-6);
        close(w[0] - plain[0], -angle * plain[1], 1e-6);
    }
}

#[test]
fn sensor_crosstalk_leaks_its_share_of_the_grip_into_every_channel_across_it() {
    // By channel: X, Z (shares), torques about X, Y, Z (m).
    let shares = [[0.02, -0.01, 0.0004, 0.0005, -0.0002], [0.03, 0.01, -0.0003, 0.0006, 0.0001]];
    let parameters: Vec<f64> = (0..10).map(|k| shares[k % 2][k / 2]).collect();
    let mut run = hold::<f64>().with("sensor_crosstalk", &parameters);
    run.scene.gravity_m_s2 = [0.0; 3];
    let shown = run.play().last().reading.finger;
    for (w, shares) in shown.iter().zip(shares) {
        for (channel, share) in [0, 2, 3, 4, 5].into_iter().zip(shares) {
            close(w[channel], share * N, 1e-3);
        }
    }
}

#[test]
fn mocap_latency_trails_by_speed_times_latency() {
    // Before contact the object moves with the gripper, at -50 mm/s.
    let mut run = pure_push::<f64>(0.05).with("mocap_latency", &[0.02]);
    run.steps = 1;
    close(run.play().last().reading.position_m.x, 0.05 * 0.02, 1e-6);
}

#[test]
fn grip_force_lag_follows_a_step_of_the_command_with_its_time_constant() {
    let mut run = hold::<f64>();
    run.model.friction = Friction { finger: 0.4, pusher: 0.25, support: 0.3 };
    let effect = Effect::<f64> { code: 16, parameters: with_zeros([0.0, 0.1]) };
    let law: &dyn Law<f64> = stickslip_shared::effects::law(effect.code).unwrap();
    // A context from the definition of the scene: at rest.
    let context = at_rest_context(0.001);
    let mut memory = [0.0; MEMORY];
    let mut grip = 20.0;
    law.grip(&effect.parameters, &context, &mut memory, &mut grip);
    assert_eq!(grip, 20.0);
    let mut last = 0.0;
    for _ in 0..100 {
        last = 30.0;
        law.grip(&effect.parameters, &context, &mut memory, &mut last);
    }
    // One time constant after the step: 1 - 1/e of it is done.
    close(last, 30.0 - 10.0 * (-1.0_f64).exp(), 0.005);
}
