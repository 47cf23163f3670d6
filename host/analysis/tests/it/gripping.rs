//! What closing a grasp leaves, which is no finding: how two fingers share a load, pads off square, and where they press.

use std::path::Path;

use nalgebra::Vector3;
use stickslip_analysis::fit::campaign::Campaign;
use stickslip_analysis::fit::constants::{OFFSETS, OPPOSED, ORIGINS, shifts};
use stickslip_analysis::fit::features::{FEATURES, Features};
use stickslip_analysis::fit::phases::{BINS, PEAK};
use stickslip_analysis::fit::{closing, constants, sharing};
use stickslip_analysis::model::candidate::CandidateEffect;
use stickslip_analysis::model::file::default_model;
use stickslip_data::{Dataset, read};
use stickslip_shared::effects::MAX_PARAMETERS;
use stickslip_shared::effects::contact_compliance::tangential_m_n;
use stickslip_shared::model::{FingerContact, Model};

fn demonstration() -> Dataset {
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")).expect("the demo")
}

fn diameter_m(campaign: &Campaign) -> f64 {
    match campaign.runs[0].prepared.scene.fingers {
        Some(FingerContact::Disc { diameter_m }) => diameter_m,
        _ => panic!("discs"),
    }
}

/// The model as given on pads of this compliance along their faces.
fn on_pads(compliance_m_n: f64) -> Model<f64> {
    let pads = CandidateEffect::listed().into_iter().find(|c| c.info.role.is_compliance()).expect("listed");
    let mut parameters = [0.0; MAX_PARAMETERS];
    parameters[..3].fill(compliance_m_n);
    pads.on(&default_model(), parameters)
}

#[test]
fn a_load_that_two_fingers_share_in_any_way_at_rest_is_open_with_the_moments_that_balance_it_and_nothing_else_is()
 {
    let campaign = Campaign::new(&demonstration(), &default_model());
    for run in &campaign.runs {
        let shared = sharing::directions(run);
        assert_eq!(shared.len(), 2, "across the grip's axis, along X and Z");
        let scene = &run.prepared.scene;
        let half_m = scene.object.shape.reach(&(run.prepared.start.rotation.inverse() * Vector3::y()));
        for (direction, (force, torque)) in shared.iter().zip([(12, 11), (14, 9)]) {
            let at_rest = |channel: usize| direction[channel * BINS];
            // Finger 1 at +Y bears half of the difference more, finger 2 half of it less.
            let mut more_n = Vector3::zeros();
            more_n[force - 12] = 0.5 * at_rest(force);
            let arm_m = Vector3::new(0.0, half_m, 0.0);
            let couple_nm = arm_m.cross(&more_n) + (-arm_m).cross(&-more_n);
            let pads_nm = Vector3::from_fn(|k, _| at_rest(9 + k));
            assert!((couple_nm + pads_nm).norm() < 1e-12, "{couple_nm} and {pads_nm}");
            // All of a share may be that of half the weight.
            assert!((at_rest(force) / (0.5 * scene.object.mass_kg * 9.81) - 1.0).abs() < 0.01);
            let moves = |f: &usize| direction[*f] != 0.0;
            let rest: Vec<usize> = (0..direction.len()).filter(moves).collect();
            assert_eq!(rest, [torque * BINS, force * BINS]);
        }
    }
}

#[test]
fn pads_off_square_press_against_each_other_by_their_stiffness_against_turning_times_half_a_milliradian() {
    let campaign = Campaign::new(&demonstration(), &default_model());
    let radius_m = 0.5 * diameter_m(&campaign);
    let grip_n = campaign.runs.iter().map(|r| r.prepared.grip_n()).fold(f64::INFINITY, f64::min);
    for compliance_m_n in [2e-6, 1e-4] {
        let model = on_pads(compliance_m_n);
        let prior = constants::prior(&campaign, &model);
        // A disc on springs has K a^2 / 4; half of the difference of two is less by the root of two.
        let stiffness_nm_rad = 0.25 * radius_m.powi(2) / tangential_m_n(&model.effects[0].parameters, grip_n);
        let opposed_nm = stiffness_nm_rad * 5e-4 / 2.0_f64.sqrt();
        for of in OPPOSED {
            assert!((prior.precision[of].powf(-0.5) / opposed_nm - 1.0).abs() < 1e-9);
            assert!((prior.bound[of] / opposed_nm - 3.0).abs() < 1e-9);
        }
    }
    // However stiff: no more than lifts a pad off on one side.
    let stiffest = constants::prior(&campaign, &on_pads(1e-9));
    assert!(stiffest.bound[OPPOSED.start] <= 3.0 * 0.25 * grip_n * radius_m);
    // Equal and opposite: nothing in the sum of the fingers.
    for (of, channel) in [(OPPOSED.start, 15), (OPPOSED.start + 1, 17)] {
        assert_eq!(shifts(of), [(channel, 2.0)]);
    }
}

#[test]
fn a_sensors_origin_is_known_to_a_tenth_of_a_millimetre_and_a_pads_middle_to_a_hundredth_of_its_diameter() {
    let campaign = Campaign::new(&demonstration(), &default_model());
    let beside_m = 0.01 * diameter_m(&campaign);
    let prior = constants::prior(&campaign, &default_model());
    let is = |of: usize, sd: f64| {
        assert!((prior.precision[of].powf(-0.5) / sd - 1.0).abs() < 1e-9, "{of}");
        assert!((prior.bound[of] / sd - 3.0).abs() < 1e-9, "{of}");
    };
    // A finger's origin along its face is that of its sensor and of its pad.
    ORIGINS
        .zip([beside_m, 0.0, beside_m, beside_m, 0.0, beside_m, 0.0, 0.0, 0.0])
        .for_each(|(of, pad_m)| is(of, pad_m.hypot(1e-4)));
}

/// Wrench of each sensor (finger 1, finger 2, pusher) in the rest before, from features.
fn wrenches(features: &Features) -> [(Vector3<f64>, Vector3<f64>); 3] {
    let at = |first: usize| Vector3::from_fn(|k, _| features[(first + k) * BINS]);
    let finger = |sign: f64, first: usize| 0.5 * (at(first) + sign * at(first + 6));
    [(finger(1.0, 6), finger(1.0, 9)), (finger(-1.0, 6), finger(-1.0, 9)), (at(18), at(21))]
}

#[test]
fn a_sensor_whose_origin_is_off_shows_the_same_wrench_about_another_point() {
    // Some wrench in each channel, and no change of it.
    let measured: Features = (0..FEATURES).map(|f| 1.0 + ((f / BINS) as f64 * 0.7).sin()).collect();
    let columns = constants::columns(&measured);
    assert_eq!(columns.len(), OFFSETS);
    let before = wrenches(&measured);
    for k in 0..9 {
        let (sensor, mut d) = (k / 3, Vector3::zeros());
        d[k % 3] = 1.0;
        for (of, (force_n, torque_nm)) in wrenches(&columns[ORIGINS.start + k]).iter().enumerate() {
            let expected = if of == sensor { -d.cross(&before[of].0) } else { Vector3::zeros() };
            assert!(force_n.norm() < 1e-12 && (torque_nm - expected).norm() < 1e-12, "origin {k} {of}");
        }
    }
}

#[test]
fn the_middle_of_a_pads_pressure_moves_by_a_hundredth_of_its_diameter_from_grasp_to_grasp_and_stays_while_it_holds()
 {
    let campaign = Campaign::new(&demonstration(), &default_model());
    for run in &campaign.runs {
        let moment_nm = 0.01 * diameter_m(&campaign) * run.prepared.grip_n();
        let directions = closing::directions(run);
        assert_eq!(directions.len(), 4, "two fingers, two axes along their faces");
        for direction in &directions {
            for (channel, of_it) in direction.chunks(BINS).enumerate() {
                let torque_along_face = matches!(channel, 9 | 11 | 15 | 17);
                let moves = of_it[0] != 0.0;
                assert!(torque_along_face || !moves, "{channel}");
                assert!(!moves || (of_it[0].abs() / moment_nm - 1.0).abs() < 1e-9);
                assert!(of_it[..PEAK].iter().all(|x| *x == of_it[0]) && of_it[PEAK] == 0.0);
            }
        }
    }
}
