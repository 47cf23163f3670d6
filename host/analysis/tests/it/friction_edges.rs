//! Fits past the edge at which a contact lets go: pushes up and down a slope, on a plate whose friction just slides.

use stickslip_analysis::diagnose::select::hold_out;
use stickslip_analysis::fit::campaign::Campaign;
use stickslip_analysis::fit::problem::Problem;
use stickslip_analysis::fit::{
    Estimate, FOLDS, Options, across_edges, base_parameters, calibrate, gls, solve,
};
use stickslip_analysis::model::candidate::CandidateEffect;
use stickslip_analysis::model::file::default_model;
use stickslip_data::Dataset;
use stickslip_rig::plan::{self, PlanName};
use stickslip_rig::{Condition, Reality, STEP_S, Setup, objects, simulate};
use stickslip_shared::model::Model;

const MU_FINGER: f64 = 0.38;
const MU_PUSHER: f64 = 0.22;
/// Gauss-Newton steps.
const STEPS: usize = 8;

/// Friction of a plate that holds in all of them.
const MU_HOLDS: f64 = 0.6;

/// Pushes at one speed with Coulomb friction and nothing hidden.
fn pushes(mu_pusher: f64) -> Dataset {
    let description = objects::trimmed(objects::bench("pushes"), &["linear_push"], &["obj4"]);
    let reality = Reality::ideal(MU_FINGER, mu_pusher);
    let setup = Setup { reality, description: description.clone(), step_s: STEP_S };
    let mut conditions = plan::conditions(PlanName::PushSmall, &[], 1, 0.0);
    conditions.truncate(9);
    let run = |c: &Condition| simulate(&setup, c, 1, 1).expect("suits the rig");
    Dataset { description, trials: conditions.iter().map(run).collect(), folder: Default::default() }
}

/// `model` with stiff contacts: a rigid grasp that sticks leaves its forces open. The rig's plate bears with 4 x 4 equal points,
/// which is an even face with a third of its stiffness at the rim.
fn stiff(model: &Model<f64>) -> Model<f64> {
    let compliance =
        CandidateEffect::listed().into_iter().find(|t| t.info.role.is_compliance()).expect("listed");
    let mut parameters = [0.0; stickslip_shared::effects::MAX_PARAMETERS];
    parameters[..6].copy_from_slice(&[1e-6, 1e-6, 1e-6, 0.0, 0.0, 1.0 / 3.0]);
    compliance.on(model, parameters)
}

/// Pushes with a plate that slides, and a model of them with another friction of the plate.
fn sliding(mu_pusher: f64) -> (Campaign, Model<f64>) {
    let start = default_model();
    let mut model = stiff(&start);
    (model.friction.finger, model.friction.pusher) = (MU_FINGER, mu_pusher);
    (Campaign::new(&pushes(MU_PUSHER), &start), model)
}

#[test]
fn a_fit_that_starts_with_a_plate_that_holds_finds_the_friction_with_which_it_slides() {
    let (campaign, model) = sliding(1.0);
    let free = base_parameters(&campaign);
    let problem = Problem::new(&campaign, &model);
    let on_the_plateau = solve(&problem, &model, &free, STEPS);
    let pusher = on_the_plateau.model.friction.pusher;
    assert!(pusher > 0.5, "least squares crosses the edge by itself: {pusher}");
    let found = across_edges(&problem, on_the_plateau.clone(), &free, STEPS);
    assert!(found.loss.1 < on_the_plateau.loss.1);
    let friction = found.model.friction;
    assert!((friction.pusher / MU_PUSHER - 1.0).abs() < 0.1, "{friction:?}");
    assert!((friction.finger / MU_FINGER - 1.0).abs() < 0.05, "{friction:?}");
}

#[test]
fn friction_of_a_plate_that_holds_has_a_lower_bound_only_and_of_one_that_slides_two() {
    let of = |mu_pusher: f64| {
        let data = pushes(mu_pusher);
        let start = default_model();
        let campaign = Campaign::new(&data, &start);
        let model = stiff(&start);
        let fit = calibrate(&campaign, &model, &base_parameters(&campaign), &Options::default());
        let fit = fit.expect("trials can be simulated");
        let of_name = |name: &str| fit.estimates.iter().find(|e| e.name == name).expect("fitted").clone();
        [of_name("friction.finger"), of_name("friction.pusher")]
    };
    let holds = |e: &Estimate, truth: f64| !(e.low > truth) && !(e.high < truth);
    let [finger, pusher] = of(MU_PUSHER);
    assert!(holds(&finger, MU_FINGER) && finger.high < 1.1 * finger.low, "{finger:?}");
    assert!(holds(&pusher, MU_PUSHER) && pusher.high < 1.1 * pusher.low, "{pusher:?}");
    let [finger, pusher] = of(MU_HOLDS);
    assert!(holds(&finger, MU_FINGER), "{finger:?}");
    assert!(pusher.low > 0.05 && pusher.low < MU_HOLDS && pusher.high.is_nan(), "{pusher:?}");
}

#[test]
fn a_held_out_condition_whose_sensitivity_is_far_off_is_simulated_and_the_others_follow_theirs() {
    let (campaign, model) = sliding(0.27);
    let free = base_parameters(&campaign);
    let problem = Problem::new(&campaign, &model);
    let mut solution = solve(&problem, &model, &free, STEPS);
    // As across an edge: in the first group friction of the plate changes the features by far more than it does.
    solution.columns[1][0].iter_mut().for_each(|x| *x *= 1e4);
    solution.grams = problem.grams(&solution.residual, &solution.columns);
    let held = hold_out(&problem, solution.clone(), free.clone());
    let folds = gls::fold_solutions(&solution.grams, &solution.priors(&problem, &free, 0), FOLDS);
    for (place, group) in problem.groups.iter().enumerate() {
        let condition = campaign.groups[*group].condition;
        let x = &folds[gls::fold(condition, FOLDS)];
        let (steps, offsets) = x.as_slice().split_at(free.len());
        let mut there = solution.model.clone();
        free.iter().zip(steps).for_each(|(f, step)| f.set(&mut there, f.get(&solution.model) + step));
        let predicted = problem.predict_of(&there, &[*group]).remove(0);
        let residual = problem.targets[*group].iter().zip(&predicted).map(|(t, p)| t - p).collect();
        let left = problem.without_offsets_at(place, &residual, offsets);
        let simulated = problem.whiteners[*group].square(&left);
        let linear = gls::loss(&solution.grams[place], x);
        let expected = if place == 0 { simulated } else { linear };
        assert!((held.loss[condition] / expected - 1.0).abs() < 1e-6, "{condition}: {expected}");
        assert!(place > 0 || linear > 10.0 * simulated, "{linear} {simulated}");
    }
}
