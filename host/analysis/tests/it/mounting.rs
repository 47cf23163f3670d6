//! Pushers that are not quite square, the points of pads and how evenly they press: how far features follow, and what is no
//! finding.

use std::path::Path;

use stickslip_analysis::diagnose::ordinary::{is_ordinary_in, mounted};
use stickslip_analysis::diagnose::select::{Held, hold_out};
use stickslip_analysis::fit::campaign::Campaign;
use stickslip_analysis::fit::features::Features;
use stickslip_analysis::fit::free::{Free, base_parameters};
use stickslip_analysis::fit::phases::{BINS, LAST};
use stickslip_analysis::fit::problem::Problem;
use stickslip_analysis::fit::uneven::UNEVEN;
use stickslip_analysis::fit::{alignment, edges, points, solve, uneven};
use stickslip_analysis::model::candidate::CandidateEffect;
use stickslip_analysis::model::file::default_model;
use stickslip_data::{Dataset, read};
use stickslip_shared::effects::MAX_PARAMETERS;
use stickslip_shared::model::{FingerContact, Model, PusherContact};

fn demonstration() -> Dataset {
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo")).expect("the demo")
}

/// `model` with effect `id`, whose first parameters are `first`.
fn with(model: &Model<f64>, id: &str, first: &[f64]) -> (Model<f64>, CandidateEffect) {
    let effect = CandidateEffect::listed().into_iter().find(|c| c.info.id == id).expect("listed");
    let mut parameters = [0.0; MAX_PARAMETERS];
    parameters[..first.len()].copy_from_slice(first);
    (effect.on(model, parameters), effect)
}

/// Pads of 500 N/mm and a plate of 1000, with torsion of their own.
fn on_pads() -> Model<f64> {
    with(&default_model(), "contact_compliance", &[2e-6, 1e-6, 1e-6, 0.3, 0.3, 0.3, 0.6]).0
}

/// Largest change of a channel over all bins.
fn most(direction: &Features, channel: usize) -> f64 {
    let of = &direction[channel * BINS..(channel + 1) * BINS];
    of.iter().filter(|x| x.is_finite()).fold(0.0, |most: f64, x| most.max(x.abs()))
}

#[test]
fn a_face_on_a_stiff_plate_follows_two_tenths_of_a_milliradian_and_a_tip_none() {
    let campaign = Campaign::new(&demonstration(), &default_model());
    let model = on_pads();
    for run in &campaign.runs {
        let directions = alignment::directions(run, &model);
        match run.prepared.scene.pusher {
            Some(PusherContact::Plane) => {
                assert_eq!(directions.len(), 2);
                // The face is pressed at its rim, and friction holds what turns: far more than the share of the push, 4 mN
                // of 20 N, that the angle turns aside.
                let forces_n = directions.iter().flat_map(|d| (6..9).map(|channel| most(d, channel)));
                let most_n = forces_n.fold(0.0, f64::max);
                assert!(most_n > 0.05, "{most_n}");
            }
            Some(PusherContact::Line { .. }) => assert_eq!(directions.len(), 1),
            _ => assert!(directions.is_empty()),
        }
    }
}

#[test]
fn points_of_pads_count_only_where_they_stand_for_a_disc_and_shift_what_is_between_the_fingers() {
    let campaign = Campaign::new(&demonstration(), &default_model());
    let run = campaign.runs.iter().find(|r| r.info.trial.starts_with("pivot")).expect("a pivot");
    let (hard, soft) = (default_model(), on_pads());
    let simulated = |model: &Model<f64>| run.prepared.simulate_every(model, run.stride);
    let here = |model: &Model<f64>| run.bins.modelled(&simulated(model));
    assert!(points::directions(run, &hard, &here(&hard)).is_empty());
    let [direction] = &points::directions(run, &soft, &here(&soft))[..] else { panic!("one") };
    let finite = direction.iter().filter(|x| x.is_finite());
    assert!(
        finite.clone().count() > 0 && finite.clone().all(|x| x.abs() < 1.0),
        "newtons, metres, newton metres"
    );
    assert!(edges::directions(run, &simulated(&soft), &here(&soft)).is_empty());
}

#[test]
fn a_pad_that_presses_unevenly_bears_a_shift_beside_its_turn_as_one_whose_friction_differs_along_and_across()
{
    let campaign = Campaign::new(&demonstration(), &default_model());
    let model = on_pads();
    let mut compared = 0;
    for run in &campaign.runs {
        let simulated = run.prepared.simulate_every(&model, run.stride);
        let here = run.bins.modelled(&simulated);
        let directions = uneven::directions(run, &model, &simulated, &here);
        if run.info.primitive != "pivot" {
            // What slides straight turns a little at most: the push itself does not show how its pad presses.
            let push = directions.iter().map(|d| most(d, 6)).fold(0.0, f64::max);
            assert!(push < 0.01 * most(&here, 6), "{}: {push}", run.info.trial);
            continue;
        }
        // By an integral over the disc: friction that differs by the factor 1 + e beside a fast turn resists a shift as a
        // pressure does that differs by (1 + e)^1.5.
        let ratio = (1.0 + UNEVEN).powf(1.0 / 1.5);
        let (across, _) = with(&model, "anisotropic_friction", &[ratio]);
        let across = run.bins.modelled(&run.prepared.simulate_every(&across, run.stride));
        let across: Features = across.iter().zip(&here).map(|(a, h)| a - h).collect();
        // Friction turns with the object, pressure with the pads.
        for bin in 5..=LAST {
            let (sin, cos) = (2.0 * here[4 * BINS + bin]).sin_cos();
            let [along, diagonal] = [0, 1].map(|way| directions[way][6 * BINS + bin]);
            let (told, by_friction) = (cos * along - sin * diagonal, across[6 * BINS + bin]);
            assert!((told / by_friction - 1.0).abs() < 0.2, "{}: {told}, {by_friction} N", run.info.trial);
        }
        compared += 1;
    }
    assert!(compared > 0);
}

/// The fit of `model` on `problem` with effect `id` beside it as it is.
fn beside(problem: &Problem, model: &Model<f64>, id: &str, first: &[f64]) -> Held {
    let (model, effect) = with(model, id, first);
    let mut free = base_parameters(problem.campaign);
    free.extend(Free::of_effect(effect.info, model.effects.len() - 1));
    hold_out(problem, solve(problem, &model, &free, 0), free)
}

#[test]
fn a_plate_off_by_a_third_of_a_milliradian_is_ordinary_and_one_off_by_a_degree_is_a_finding() {
    let campaign = Campaign::new(&demonstration(), &default_model());
    let model = on_pads();
    let problem = Problem::new(&campaign, &model);
    let tilted = |angle_rad: f64| beside(&problem, &model, "plate_tilt", &[angle_rad]);
    let ordinary = |angle_rad: f64, id: &str| is_ordinary_in(&problem, &tilted(angle_rad), id);
    assert!(ordinary(3e-4, "plate_tilt") && !ordinary(0.0175, "plate_tilt"));
    let words = mounted(&problem, &tilted(3e-4));
    assert!(words.len() == 1 && words[0].starts_with("plate_tilt of up to 0.30 mrad"), "{words:?}");
    assert!(mounted(&problem, &tilted(0.0175)).is_empty());
    assert!(!ordinary(0.0, "mass_error"), "no other effect has a size that any rig has");
}

#[test]
fn a_pressure_off_the_middle_by_a_fiftieth_of_the_pad_is_ordinary_and_one_off_by_a_tenth_is_a_finding() {
    let campaign = Campaign::new(&demonstration(), &default_model());
    let Some(FingerContact::Disc { diameter_m }) = campaign.runs[0].prepared.scene.fingers else {
        panic!("the demo has discs")
    };
    let model = on_pads();
    let problem = Problem::new(&campaign, &model);
    let off =
        |share: f64| beside(&problem, &model, "pressure_offset", &[share * diameter_m, -share * diameter_m]);
    assert!(is_ordinary_in(&problem, &off(0.02), "pressure_offset"));
    assert!(!is_ordinary_in(&problem, &off(0.1), "pressure_offset"));
    let words = mounted(&problem, &off(0.02));
    assert!(words.len() == 1 && words[0].contains("pads may press off their middle"), "{words:?}");
    assert!(mounted(&problem, &off(0.1)).is_empty());
}
