//! Commands that speak of the same thing print the same number.

use stickslip_analysis::calibrate::{Share, of_primitive};
use stickslip_analysis::compare::tare::Tare;
use stickslip_analysis::compare::{NamedModel, Options, compare};
use stickslip_analysis::evidence::conditions::{condition_of, conditions};
use stickslip_analysis::evidence::phases::Phase;
use stickslip_analysis::fit::campaign::Campaign;
use stickslip_analysis::model::file::{EffectEntry, ModelFile, default_model};
use stickslip_analysis::{add, calibrate, check, refit};
use stickslip_data::{Dataset, Index, Trial, TrialInfo, write};
use stickslip_rig::objects::{bench, trimmed};
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, simulate};

/// Pushes at two grips with two sets of pads (a column that the format does not name), three runs
/// each, and a remark that differs in every trial.
fn pushes() -> Dataset {
    let description = trimmed(bench("pushes"), &["linear_push"], &["obj4"]);
    let mut reality = Reality::draw(&description, Nuisance::PAPER, 5);
    (reality.mu_finger, reality.mu_pusher) = (0.4, 0.25);
    let setup = Setup { description: description.clone(), reality, step_s: STEP_S };
    let mut trials = Vec::new();
    for pads in ["soft", "hard"] {
        for grip_n in [20.0, 35.0] {
            let mut condition = Condition::new(Primitive::LinearPush, "obj4");
            condition.label = format!("{pads}-g{grip_n}");
            (condition.grip_n, condition.speed_m_s, condition.travel) = (grip_n, 0.02, 0.006);
            for run in 0..3 {
                let mut trial = simulate(&setup, &condition, run, 5).expect("a trial");
                trial.info.extra.insert("pads".into(), pads.into());
                trial.info.extra.insert("remark".into(), format!("at {}", trials.len()));
                trials.push(trial);
            }
        }
    }
    Dataset { folder: "pushes".into(), description, trials }
}

#[test]
fn conditions_and_repetitions_are_the_same_in_every_command() {
    let data = pushes();
    let infos: Vec<TrialInfo> = data.trials.iter().map(|t| t.info.clone()).collect();
    // Pads are a condition, a remark is none.
    assert_eq!(conditions(&infos).iter().map(Vec::len).collect::<Vec<_>>(), [3, 3, 3, 3]);

    let folder = tempfile::tempdir().expect("a folder");
    write(&data, folder.path()).expect("written");
    let report = check(&Index::open(folder.path()).expect("read"), &());
    assert_eq!((report.repeated_groups, report.repeated_trials), (4, 12));

    let model = NamedModel::own("m", "test", default_model());
    let compared = compare(&data.clone().into(), &[model], &Options::default(), &()).expect("compared");
    assert_eq!((compared.data.conditions, compared.data.repeated_conditions), (4, 4));
    let campaign = Campaign::new(&data, &default_model());
    assert_eq!((campaign.conditions, campaign.repeated()), (4, 12));
    let of: Vec<usize> = compared.models[0].trials.iter().map(|t| t.condition).collect();
    assert_eq!(of, condition_of(&infos));
    assert_eq!(of, campaign.runs.iter().map(|r| r.condition).collect::<Vec<_>>());

    // Calibration takes a trial of each condition before a second of any.
    let trials: Vec<(usize, Trial)> = data.trials.iter().cloned().enumerate().collect();
    let share = Share { share: 0.3, fewest: 4 };
    let found =
        of_primitive(&data.description, "linear_push", &trials, &default_model(), share).expect("calibrated");
    let mut taken: Vec<usize> = found
        .calibration_trials
        .iter()
        .map(|id| of[infos.iter().position(|i| i.trial == *id).expect("a trial")])
        .collect();
    taken.sort_unstable();
    assert_eq!(taken, [0, 1, 2, 3]);
}

#[test]
fn the_noise_floor_of_forces_before_contact_is_the_same_in_check_and_compare() {
    let data = pushes();
    let folder = tempfile::tempdir().expect("a folder");
    write(&data, folder.path()).expect("written");
    let report = check(&Index::open(folder.path()).expect("read"), &());
    let options = Options { tare: Tare::None, ..Options::default() };
    let model = NamedModel::own("m", "test", default_model());
    let compared = compare(&data.clone().into(), &[model], &options, &()).expect("compared");
    let mut seen = 0;
    let rows = compared.models[0].errors.iter().filter(|r| r.place.phase == Phase::BeforeContact);
    // Rotations differ: `check` counts them from one noisy sample, `compare` from the mean of the rest.
    for row in rows.filter(|r| r.unit.starts_with('N')) {
        let channel = report.channels.iter().find(|c| c.channel == row.place.channel).expect("the channel");
        let (Some(one), Some(other)) = (channel.floor[0], row.noise_floor) else { continue };
        seen += 1;
        // Contact is found by two averages of the same force: some samples more or less.
        assert!((one / other - 1.0).abs() < 0.05, "{}: {one} and {other}", row.place.channel);
    }
    assert!(seen == 18, "{seen} channels");
}

#[test]
fn friction_of_add_and_refit_is_that_of_calibrate_on_the_new_model() {
    let data = pushes();
    let calibrated =
        |file: &ModelFile| calibrate(&data, file, &Default::default(), &()).expect("calibrated").model;
    let base = calibrated(&ModelFile::new(default_model().base, default_model().friction));
    assert!((base.friction.finger / 0.4 - 1.0).abs() < 0.02, "calibrate: {}", base.friction.finger);
    // The same to all digits that anybody reads: a solver starts elsewhere.
    let same = |one: &ModelFile, other: &ModelFile| {
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-6;
        let (a, b) = (one.friction, other.friction);
        assert!(
            near(a.finger, b.finger) && near(a.pusher, b.pusher) && near(a.support, b.support),
            "{a:?} {b:?}"
        );
        let intervals = one.friction_intervals.iter().zip(&other.friction_intervals);
        assert!(intervals.clone().all(|(a, b)| a.0 == b.0 && near(a.1[0], b.1[0]) && near(a.1[1], b.1[1])));
        assert_eq!(one.friction_intervals.len(), other.friction_intervals.len());
    };
    same(&refit(&data, &base, &()).expect("fitted").model, &base);

    // Nothing in these pushes determines it, and nothing said that it was: it must not move at all.
    let mut file = base;
    file.friction.pusher = 0.6;
    let effect = EffectEntry {
        id: "finger_friction_mismatch".into(),
        values: vec![0.3],
        intervals: Default::default(),
        formula: None,
    };
    let added = add(&data, &file, &[effect], &()).expect("fitted").model;
    assert_eq!(added.friction.pusher, 0.6, "a coefficient that is not fitted stays exactly");
    same(&calibrated(&added), &added);
}
