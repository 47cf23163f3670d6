//! Groups of repeated trials in a fit.

use std::path::Path;

use stickslip_analysis::fit::campaign::Campaign;
use stickslip_analysis::fit::problem::Problem;
use stickslip_analysis::model::file::default_model;
use stickslip_data::Dataset;

/// Pushes of the demonstration, repeated to groups of three near each other.
fn repeated() -> Dataset {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/demo");
    let mut data = stickslip_data::read(&demo).expect("the demo");
    let pushes: Vec<_> = data.trials.drain(..).filter(|t| t.info.primitive == "linear_push").collect();
    for block in 0..8 {
        for (k, trial) in pushes.iter().enumerate() {
            let mut trial = trial.clone();
            trial.info.trial = format!("b{block}r{k}");
            trial.info.run = Some((3 * block + k) as i64);
            data.trials.push(trial);
        }
    }
    data
}

/// The grip is lost: from the middle on the object lies a metre below.
fn lose(data: &mut Dataset, trial: usize) {
    let samples = &mut data.trials[trial].samples;
    let half = samples.len() / 2;
    for sample in &mut samples[half..] {
        sample.object.as_mut().expect("a pose").position_m[2] -= 1.0;
        sample.finger.iter_mut().flatten().for_each(|wrench| wrench.force_n = [0.0; 3]);
    }
}

#[test]
fn a_group_whose_first_run_fails_keeps_the_others_and_loses_that_run_alone() {
    let mut data = repeated();
    let model = default_model();
    let sound = Campaign::new(&data, &model);
    let group = sound.groups.iter().position(|g| g.runs.len() > 2 && g.runs[0] > 0).expect("a group");
    let runs = sound.groups[group].runs.clone();
    lose(&mut data, runs[0]);
    let campaign = Campaign::new(&data, &model);
    let problem = Problem::new(&campaign, &model);
    assert_eq!(problem.failed, [runs[0]]);
    assert_eq!(problem.groups.len(), campaign.groups.len(), "no group is lost");
    assert_eq!(problem.stands[group], runs[1]);
    let left_out: Vec<String> = problem.left_out().into_iter().map(|one| one.trial).collect();
    assert_eq!(left_out, [data.trials[runs[0]].info.trial.clone()]);
    assert_eq!(problem.trials(), data.trials.len() - 1);
    // The group says what it says without that run.
    let mut without = data.clone();
    without.trials.remove(runs[0]);
    let without = Campaign::new(&without, &model);
    let other = Problem::new(&without, &model);
    let place =
        without.groups.iter().position(|g| g.runs.contains(&runs[0])).expect("the group of the second run");
    let (a, b) = (&problem.targets[group], &other.targets[place]);
    let known: Vec<(f64, f64)> =
        a.iter().zip(b).map(|(a, b)| (*a, *b)).filter(|(a, b)| a.is_finite() && b.is_finite()).collect();
    assert!(known.len() > 100, "{}", known.len());
    if without.groups[place].runs.len() == runs.len() - 1 {
        assert!(known.iter().all(|(a, b)| (a - b).abs() < 1e-9), "the targets differ");
    }
}

#[test]
fn a_group_of_which_no_run_is_left_loses_no_other_group_of_its_condition() {
    let mut data = repeated();
    let model = default_model();
    let runs = Campaign::new(&data, &model).groups[0].runs.clone();
    runs.iter().for_each(|run| lose(&mut data, *run));
    let campaign = Campaign::new(&data, &model);
    let problem = Problem::new(&campaign, &model);
    assert_eq!(problem.failed, runs);
    assert_eq!(problem.groups, (1..campaign.groups.len()).collect::<Vec<_>>());
    // What is simulated for the others is one of theirs.
    assert!(problem.stands.iter().all(|run| !runs.contains(run)), "{:?}", problem.stands);
    assert_eq!(problem.left_out().len(), runs.len());
}
