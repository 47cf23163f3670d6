//! Commands that speak of the same thing print the same number.

use std::sync::OnceLock;

use stickslip_analysis::calibrate::{Coefficient, Share, of_primitive};
use stickslip_analysis::channels::NAMES;
use stickslip_analysis::check::Report;
use stickslip_analysis::compare::document::Comparison;
use stickslip_analysis::compare::tare::Tare;
use stickslip_analysis::compare::{NamedModel, Options, compare};
use stickslip_analysis::evidence::conditions::{condition_of, conditions};
use stickslip_analysis::evidence::phases::Phase;
use stickslip_analysis::evidence::stages::stages;
use stickslip_analysis::fit::campaign::Campaign;
use stickslip_analysis::fit::phases::bins;
use stickslip_analysis::model::file::{EffectEntry, ModelFile, default_model};
use stickslip_analysis::{add, calibrate, check, diagnose, refit};
use stickslip_data::{Dataset, Index, Trial, TrialInfo, write};
use stickslip_rig::objects::{bench, trimmed};
use stickslip_rig::{Condition, Nuisance, Primitive, Reality, STEP_S, Setup, simulate};

/// Pushes, and what `check` and `compare` say of them.
struct Made {
    data: Dataset,
    report: Report,
    compared: Comparison,
}

fn made() -> &'static Made {
    static MADE: OnceLock<Made> = OnceLock::new();
    MADE.get_or_init(|| {
        let data = pushes();
        let folder = tempfile::tempdir().expect("a folder");
        write(&data, folder.path()).expect("written");
        let report = check(&Index::open(folder.path()).expect("read"), &());
        let options = Options { tare: Tare::None, ..Options::default() };
        let model = NamedModel::own("m", "test", default_model());
        let compared = compare(&data.clone().into(), &[model], &options, &()).expect("compared");
        Made { data, report, compared }
    })
}

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
    let Made { data, report, compared } = made();
    let infos: Vec<TrialInfo> = data.trials.iter().map(|t| t.info.clone()).collect();
    // Pads are a condition, a remark is none.
    assert_eq!(conditions(&infos).iter().map(Vec::len).collect::<Vec<_>>(), [3, 3, 3, 3]);

    assert_eq!((report.repeated_groups, report.repeated_trials), (4, 12));
    assert_eq!((compared.data.conditions, compared.data.repeated_conditions), (4, 4));
    let campaign = Campaign::new(data, &default_model());
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
    let Made { report, compared, .. } = made();
    let mut seen = 0;
    let rows = compared.models[0].errors.iter().filter(|r| r.place.phase == Phase::BeforeContact);
    // Rotations differ: `check` counts them from the mean of 50 ms, `compare` from that of all the rest.
    for row in rows.filter(|r| r.unit.starts_with('N')) {
        let channel = report.channels.iter().find(|c| c.channel == row.place.channel).expect("the channel");
        let (Some(one), Some(other)) = (channel.floor[0], row.noise_floor) else { continue };
        seen += 1;
        assert!((one / other - 1.0).abs() < 1e-9, "{}: {one} and {other}", row.place.channel);
    }
    assert!(seen == 18, "{seen} channels");
}

/// No report but that of `compare` says when the contact begins: the others are held by what they find it with.
#[test]
fn the_contact_that_compare_reports_is_that_of_the_stages_and_within_three_samples_of_the_features() {
    let Made { data, compared, .. } = made();
    let campaign = Campaign::new(data, &default_model());
    for ((trial, row), run) in data.trials.iter().zip(&compared.models[0].trials).zip(&campaign.runs) {
        let contact = stages(trial).contact.expect("found");
        let by_stages_s = trial.samples[contact].t_s;
        let in_compare_s = row.phases["before_contact"][1];
        assert_eq!(by_stages_s, in_compare_s, "{}", trial.info.trial);
        // Features begin at the model's touch, up to three samples from the measured one.
        let simulated = run.prepared.simulate_every(&default_model(), 2);
        let first = bins(&run.prepared, &simulated).0.iter().position(|b| b.is_some_and(|b| b > 0));
        let model_s = trial.samples[first.expect("touches")].t_s;
        assert!((model_s - in_compare_s).abs() < 0.0125, "{model_s} and {in_compare_s}");
    }
}

#[test]
fn sensor_offsets_are_the_same_in_check_calibrate_and_compare() {
    let Made { data, report, compared } = made();
    let of_model = &compared.models[0];
    let calibrated = calibrate(
        data,
        &ModelFile::new(default_model().base, default_model().friction),
        &calibrate::Options { share: Share::of(1.0), primitive: None, pads: false },
        &(),
    )
    .expect("calibrated");
    let in_calibrate = calibrated.primitives[0].offsets;
    let in_check = report.balance.tare.as_ref().expect("a rest before contact");
    let in_compare = |k: usize| {
        let channel = of_model.offsets.channels.iter().find(|c| c.channel == NAMES[k]);
        channel.map_or(f64::NAN, |c| c.mean)
    };
    // Friction of the run and the mean or the median of twelve trials: their errors scatter by 0.01 N.
    for axis in 0..3 {
        let sums = [
            in_check.fingers_sum_n[axis],
            in_compare(6 + axis) + in_compare(12 + axis),
            in_calibrate[6 + axis] + in_calibrate[12 + axis],
        ];
        let pushers =
            [in_check.pusher_n.expect("measured")[axis], in_compare(18 + axis), in_calibrate[18 + axis]];
        for found in [sums, pushers] {
            assert!(found.iter().all(|x| (x - found[0]).abs() < 0.01), "axis {axis}: {found:?}");
        }
    }
}

#[test]
#[ignore = "long: make test-host-rest"]
fn friction_of_add_and_refit_is_that_of_calibrate_on_the_new_model() {
    let mut data = made().data.clone();
    // One set of pads will do: six pushes.
    data.trials.truncate(6);
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

/// The finger's coefficient by `calibrate` with all trials.
fn friction_by_calibrate(data: &Dataset) -> calibrate::Estimate {
    let options = calibrate::Options { share: Share::of(1.0), primitive: None, pads: false };
    let mut report = calibrate(data, &ModelFile::default(), &options, &()).expect("calibrated");
    let estimates = report.primitives.remove(0).estimates;
    estimates.into_iter().find(|e| e.coefficient == Coefficient::Finger).expect("there are fingers")
}

#[test]
fn friction_of_compare_without_a_model_is_that_of_calibrate_on_a_trial_of_each_condition() {
    let mut data = made().data.clone();
    // One set of pads will do: six pushes.
    data.trials.truncate(6);
    let compared = compare(&data.clone().into(), &[], &Options::default(), &()).expect("compared");
    let own = compared.calibrated.expect("no model was given").model.friction.finger;
    let mut run = 0..;
    data.trials.retain(|_| run.next().is_some_and(|run| run % 3 == 0));
    assert_eq!(own, friction_by_calibrate(&data).value);
}

#[test]
#[ignore = "long: make test-host-rest"]
fn friction_of_diagnose_is_within_two_per_cent_and_the_interval_of_that_of_calibrate() {
    let data = &made().data;
    let report = diagnose(data, &ModelFile::default().to_model(), &[], &()).expect("diagnosed");
    let (one, other) = (report.model.friction.finger, friction_by_calibrate(data));
    // Two sets of signals: windows of the motion there, all phases here (0.397 and 0.403; the truth is 0.4).
    assert!((one / other.value - 1.0).abs() < 0.02, "{one} and {}", other.value);
    assert!(other.low.is_some_and(|low| low < one) && other.high.is_some_and(|high| one < high), "{one}");
    assert!((one / 0.4 - 1.0).abs() < 0.02 && (other.value / 0.4 - 1.0).abs() < 0.02);
}
