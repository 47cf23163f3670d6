//! Pushes over a table whose poses are known before and after only, each at a place of its own: the hidden
//! truth is three feet under the object, in a simulator of bristles; what is told is a face, or the feet.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stickslip_analysis::diagnose;
use stickslip_analysis::diagnose::report::{Report, Verdict};
use stickslip_analysis::model::file::default_model;
use stickslip_data::{ContactSpec, Dataset, Description};
use stickslip_rig::plan::{self, PlanName};
use stickslip_rig::{Nuisance, Reality, STEP_S, Setup, objects, simulate};

/// Standard deviation of the load along X and Y over that of the face: feet at the corners of a triangle with
/// legs of 90 mm, under a face with legs of 120 mm.
const SPREAD: f64 = 1.5;
/// The frames of object and rod differ by so much at most, m.
const FRAMES_M: f64 = 5e-4;

fn described(contact: &str, points_m: Option<Vec<[f64; 2]>>) -> Description {
    let mut out = objects::trimmed(objects::bench("pushes"), &["planar_push"], &["tri"]);
    out.sample_rate_hz = 100.0;
    let contact = ContactSpec { contact: contact.into(), points_m, ..Default::default() };
    out.supports.insert("planar_push".into(), contact);
    out
}

fn feet() -> Description {
    described("points", Some(vec![[-0.03, -0.03], [0.06, -0.03], [-0.03, 0.06]]))
}

/// Pushes of the object on its feet, of which only `told` is said.
fn pushes(told: Description, seed: u64) -> Dataset {
    let truth = feet();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let setup = Setup {
        reality: Reality::draw(&truth, Nuisance::PAPER, seed),
        description: truth.clone(),
        step_s: STEP_S,
    };
    let trials = plan::conditions(PlanName::Planar, &[], seed, 0.0)
        .into_iter()
        .map(|mut condition| {
            (condition.travel, condition.rest_s) = (0.02, 0.3);
            condition.pusher_offset_m *= 5.0;
            let mut trial = simulate(&setup, &condition, 1, seed).expect("suits the rig");
            let shift = [(); 2].map(|()| rng.random_range(-FRAMES_M..FRAMES_M));
            let last = trial.samples.len() - 1;
            for (k, sample) in trial.samples.iter_mut().enumerate() {
                sample.object = sample.object.filter(|_| k == 0 || k == last);
                if let Some(pose) = &mut sample.object {
                    pose.position_m =
                        [pose.position_m[0] + shift[0], pose.position_m[1] + shift[1], pose.position_m[2]];
                }
            }
            trial
        })
        .collect();
    Dataset { description: told, trials, folder: Default::default() }
}

fn diagnosed(dataset: &Dataset) -> Report {
    diagnose(dataset, &default_model(), &[], &()).expect("diagnosed")
}

#[test]
#[ignore = "long: make test-host-rest"]
fn feet_that_are_told_as_a_face_are_a_load_that_is_spread_otherwise() {
    let report = diagnosed(&pushes(described("patch", None), 5));
    assert!(matches!(report.verdict, Verdict::Effect | Verdict::Ambiguous), "{}", report.summary);
    assert_eq!(report.effects.first(), Some(&"support_pressure"), "{}", report.summary);
    for axis in ["spread_x", "spread_y"] {
        let spread = 1.0 + report.parameters[&format!("support_pressure.{axis}")].value;
        assert!((spread / SPREAD - 1.0).abs() < 0.2, "{axis}: {spread} times the face's");
    }
}

#[test]
#[ignore = "long: make test-host-rest"]
fn nothing_is_said_about_the_support_whose_feet_are_told() {
    let report = diagnosed(&pushes(feet(), 6));
    assert!(!report.effects.contains(&"support_pressure"), "{}", report.summary);
}
