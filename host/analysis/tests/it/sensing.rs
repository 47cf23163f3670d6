//! What force sensors do, from features in place of simulations.

use std::path::Path;

use stickslip_analysis::fit::campaign::Campaign;
use stickslip_analysis::fit::phases::{BINS, PEAK};
use stickslip_analysis::fit::problem::Problem;
use stickslip_analysis::fit::sensing;
use stickslip_analysis::model::candidate::CandidateEffect;
use stickslip_analysis::model::file::default_model;
use stickslip_shared::effects::MAX_PARAMETERS;

#[test]
fn what_sensors_do_to_features_is_what_a_simulation_with_them_shows() {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let data = stickslip_data::read(&demo).expect("the demo");
    let model = default_model();
    let campaign = Campaign::new(&data, &model);
    let problem = Problem::new(&campaign, &model);
    let plain = problem.predict(&model);
    let mut seen = 0;
    for trial in CandidateEffect::listed().iter().filter(|t| t.info.role.is_sensing()) {
        let mut parameters = [0.0; MAX_PARAMETERS];
        for (k, (to, of)) in parameters.iter_mut().zip(trial.info.parameters).enumerate() {
            *to = of.typical * (1.0 + k as f64 / 10.0);
        }
        let with = trial.on(&model, parameters);
        let effect = with.effects.last().expect("the effect");
        let simulated = problem.predict(&with);
        for (simulated, plain) in simulated.iter().zip(&plain) {
            let shown = sensing::shown(effect, plain);
            for f in (0..plain.len()).filter(|f| plain[*f].is_finite() && f % BINS != PEAK) {
                let change = simulated[f] - plain[f];
                let close = (change - shown[f]).abs() <= 1e-9 + 1e-6 * change.abs();
                assert!(close, "{} feature {f}: {change} by simulation, {}", trial.info.id, shown[f]);
                seen += usize::from(change.abs() > 1e-6);
            }
        }
        // And from one strength to another: to first order in the strength.
        let moved = sensing::moved(&simulated, &with, &trial.on(&model, parameters.map(|p| 1.1 * p)));
        let target = problem.predict(&trial.on(&model, parameters.map(|p| 1.1 * p)));
        for ((moved, target), simulated) in moved.iter().zip(&target).zip(&simulated) {
            for f in (0..moved.len()).filter(|f| target[*f].is_finite() && f % BINS != PEAK) {
                let change = (target[f] - simulated[f]).abs();
                assert!((moved[f] - target[f]).abs() <= 1e-6 + 0.2 * change, "{} feature {f}", trial.info.id);
            }
        }
    }
    assert!(seen > 1000, "{seen}");
}
