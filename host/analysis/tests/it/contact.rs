//! Contact and sensor offsets against the rig's truth.

use stickslip_analysis::evidence::offsets::at_rest;
use stickslip_analysis::evidence::phases::{Phase, split};
use stickslip_analysis::evidence::stages::stages;
use stickslip_analysis::model::file::default_model;
use stickslip_analysis::run::simulate::prepare;
use stickslip_rig::objects::bench;
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, run};

#[test]
fn contact_is_found_at_its_true_sample_or_the_next_and_offsets_within_two_hundredths_of_a_newton() {
    let description = bench("contact");
    for (primitive, speed_m_s, seed) in [
        (Primitive::LinearPush, 0.01, 1),
        (Primitive::LinearPush, 0.06, 2),
        (Primitive::Pivot, 0.02, 3),
        (Primitive::PlanarPush, 0.02, 4),
    ] {
        let reality = Reality::draw(&description, Nuisance::PAPER, seed);
        let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
        let condition = Condition { speed_m_s, travel: 0.006, ..Condition::new(primitive, "obj4") };
        let outcome = run(&setup, &condition, 1, seed).expect("suits the rig");
        let touches = |force: &[f64; 6]| force[..3].iter().any(|f| f.abs() > 1e-3);
        let truth = outcome.exact.iter().position(|e| touches(&e.pusher)).expect("it touches");
        let found = stages(&outcome.trial);
        let contact = found.contact.expect("found");
        assert!((truth..=truth + 1).contains(&contact), "{primitive:?} {seed}: {contact}, true {truth}");
        // With a model the same.
        let prepared = prepare(&description, &outcome.trial, 0).expect("a scene");
        let simulated = prepared.simulate_every(&default_model(), 8);
        let phases = split(&prepared, &simulated, &[0.0; 24]);
        assert_eq!(phases.range(Phase::BeforeContact).end, contact);

        let bias = outcome.truth.sensors.bias;
        let Some(offsets) = at_rest(&description, &outcome.trial, &found) else {
            assert_eq!(primitive, Primitive::PlanarPush, "only what stands on a table has none");
            continue;
        };
        for axis in 0..3 {
            let sum = bias[0][axis] + bias[1][axis];
            assert!((offsets.fingers_sum_n[axis] - sum).abs() < 0.02, "{offsets:?}, true {bias:?}");
            let pusher = offsets.pusher_n.expect("measured")[axis];
            assert!((pusher - bias[2][axis]).abs() < 0.02, "{offsets:?}, true {bias:?}");
        }
    }
}
