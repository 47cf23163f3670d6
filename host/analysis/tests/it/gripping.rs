//! What closing a grasp leaves, which is no finding: how two fingers share a load, pads off square, and where they press.

use std::path::Path;

use nalgebra::Vector3;
use stickslip_analysis::fit::campaign::Campaign;
use stickslip_analysis::fit::gls::{OFFSETS, SENSORS, shifts};
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
        for of in SENSORS..OFFSETS {
            assert!((prior.precision[of].powf(-0.5) / opposed_nm - 1.0).abs() < 1e-9);
            assert!((prior.bound[of] / opposed_nm - 3.0).abs() < 1e-9);
        }
    }
    // However stiff: no more than lifts a pad off on one side.
    let stiffest = constants::prior(&campaign, &on_pads(1e-9));
    assert!(stiffest.bound[SENSORS] <= 3.0 * 0.25 * grip_n * radius_m);
    // Equal and opposite: nothing in the sum of the fingers.
    for (of, channel) in [(SENSORS, 15), (SENSORS + 1, 17)] {
        assert_eq!(shifts(of), [(channel, 2.0)]);
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
