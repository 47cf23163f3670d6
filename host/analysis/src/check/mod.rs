//! What a data set holds and whether its measurements can be trusted, trial by trial: memory
//! for one group of repetitions at a time.

mod facts;
mod imbalance;
pub mod physics;
pub mod sensor_error;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use crate::channels::{self, COUNT, NAMES, Signals};
use crate::evidence::balance::{self, NotChecked, StageBalance};
use crate::evidence::conditions::conditions;
use crate::evidence::noise::{Course, Pool, white_noise};
use crate::evidence::offsets::{self, AtRest};
use crate::evidence::pose_clock::Delay;
use crate::evidence::sensors;
use crate::evidence::stages::{STAGES, Stage, Stages, stages};
use crate::evidence::statistics::median;
use crate::left_out::LeftOut;
use crate::progress::Progress;
use crate::run::simulate::prepare;
use facts::TrialFacts;
pub use facts::{Balance, StageSummary, TareSummary};
use physics::{Clocks, Finding, TrialPhysics};
use sensor_error::Suspect;
use stickslip_data::{Description, Index, Pose, Sample, Trial, TrialInfo, Warning, error::join_warnings};
use stickslip_shared::track::Pose as Placed;

/// Primitives whose intended motion the predictor knows.
const PRIMITIVES: [&str; 5] = ["linear_push", "pivot", "roll", "planar_push", "lift"];
/// Time steps above this many nominal periods are gaps.
const GAP_PERIODS: f64 = 1.5;

/// The answer of `stickslip check`.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Report {
    /// The data set's name.
    pub name: String,
    /// Trials read, with or without loss.
    pub trials: usize,
    /// Samples read.
    pub samples: usize,
    /// Trials of each object and primitive.
    pub primitives: Vec<PrimitiveCount>,
    /// Groups of trials that differ in `run` only.
    pub repeated_groups: usize,
    /// Trials in them.
    pub repeated_trials: usize,
    /// Nominal rate.
    pub nominal_rate_hz: f64,
    /// Rate by the median time step: least and greatest over the trials.
    pub rate_hz: [f64; 2],
    /// Trials with time steps beyond 1.5 nominal periods, and the greatest such step.
    pub gaps: Gaps,
    /// Share of samples in which each channel is measured, and its noise.
    pub channels: Vec<Channel>,
    /// Balance of the measured forces.
    pub balance: Balance,
    /// Where most trials do not balance: sensors whose turn or gain explains it, the likeliest first. No physics error
    /// then: the data can be, and a diagnosis can name it.
    pub suspects: Vec<Suspect>,
    /// Whether poses and forces go by one clock, and in which trials that cannot be known.
    pub clocks: Vec<Clocks>,
    /// How late the object's poses are behind the gripper's, by the motion before anything touches it; null where that does not
    /// show it.
    pub object_delay: Option<Delay>,
    /// What physics does not allow: units, signs, columns, clocks.
    pub findings: Vec<Finding>,
    /// Trials that no model can be run along, and why: every analysis with a model leaves them out.
    pub left_out: Vec<LeftOut>,
    /// What was refused.
    pub errors: Vec<String>,
    /// What is worth knowing.
    pub warnings: Vec<Warning>,
}

/// Trials of one object and primitive.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct PrimitiveCount {
    /// Primitive.
    pub primitive: String,
    /// Object.
    pub object: String,
    /// How many.
    pub trials: usize,
    /// Distinct values of each condition that occurs: name and values.
    pub conditions: Vec<(String, Vec<f64>)>,
}

/// Steps between time stamps that are too long.
#[derive(Clone, Copy, Debug, Default, JsonSchema, Serialize)]
pub struct Gaps {
    /// Trials with any.
    pub trials: usize,
    /// All of them.
    pub gaps: usize,
    /// The longest.
    pub longest_s: f64,
}

/// One channel over the data set.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Channel {
    /// Channel, as in every command: `finger1_fx`.
    pub channel: &'static str,
    /// Share of samples in which it is measured.
    pub measured: f64,
    /// White noise: median over trials.
    pub white: Option<f64>,
    /// Between repetitions, by stage: before contact, pushed, end. `None`: no repetition.
    pub floor: [Option<f64>; STAGES.len()],
}

/// Scatter of repetitions of each channel and stage.
#[derive(Clone)]
struct Floors(Vec<[Pool; STAGES.len()]>);

impl Default for Floors {
    fn default() -> Self {
        Self(vec![Default::default(); COUNT])
    }
}

/// What a group of repetitions tells.
#[derive(Default)]
struct GroupFacts {
    trials: Vec<TrialFacts>,
    floor: Floors,
    left_out: Vec<LeftOut>,
    errors: Vec<String>,
    warnings: Vec<Warning>,
}

/// Reads every trial of `index` and reports; a step of `progress` is a trial.
#[must_use]
pub fn check(index: &Index, progress: &dyn Progress) -> Report {
    let stated = sensors::unstated(&index.description).is_empty();
    progress.begin("checking trials", index.trials.len() * if stated { 1 } else { 2 });
    let groups = conditions(&index.trials);
    // What nobody stated is taken from all trials, so that each is judged by the same bounds.
    let seen = match stated {
        true => Vec::new(),
        false => seen(index, progress),
    };
    let used = sensors::completed(&index.description, &seen);
    let description = Description { sensors: used.sensors, ..index.description.clone() };
    let facts: Vec<GroupFacts> = groups
        .par_iter()
        .map(|group| {
            let facts = group_facts(index, &description, group);
            progress.step(group.len());
            facts
        })
        .collect();
    let mut floor = Floors::default();
    let mut errors: Vec<String> = index.errors.iter().map(ToString::to_string).collect();
    let mut warnings = index.warnings.clone();
    let mut left_out = Vec::new();
    let mut trials = Vec::new();
    for group in facts {
        for (mine, others) in floor.0.iter_mut().flatten().zip(group.floor.0.iter().flatten()) {
            mine.merge(others);
        }
        errors.extend(group.errors);
        left_out.extend(group.left_out);
        warnings.extend(group.warnings);
        trials.extend(group.trials);
    }
    let repeated: Vec<usize> = groups.iter().map(Vec::len).filter(|size| *size > 1).collect();
    if repeated.is_empty() && !index.trials.is_empty() {
        warnings.push(Warning {
            file: index.folder.join("trials.csv"),
            files: 1,
            text: "no repetition (equal conditions, different run): there is no noise floor, errors \
                   can only be compared with the sensors' noise"
                .to_owned(),
        });
    }
    warnings.extend(unknown_primitives(index));
    if let Some(text) = sensors::unstated(&index.description).sentence() {
        warnings.push(Warning { file: index.folder.join("dataset.toml"), files: 1, text });
    }
    // What is suspicious by chance in some trials is a habit where it is so in all.
    if let Some(first) =
        trials.first().filter(|_| trials.iter().all(|trial| !trial.physics.remarks.is_empty()))
    {
        let remark =
            |text: &String| Warning { file: first.file.clone(), files: trials.len(), text: text.clone() };
        warnings.extend(first.physics.remarks.iter().map(remark));
    }
    let samples: usize = trials.iter().map(|trial| trial.samples).sum();
    let rates: Vec<f64> =
        trials.iter().map(|trial| 1.0 / trial.median_step_s).filter(|rate| rate.is_finite()).collect();
    let nominal_rate_hz = index.description.sample_rate_hz;
    let rate_hz =
        [rates.iter().copied().fold(f64::INFINITY, f64::min), rates.iter().copied().fold(0.0, f64::max)];
    if rates.iter().any(|rate| (rate / nominal_rate_hz - 1.0).abs() > 0.02) {
        warnings.push(Warning {
            file: index.folder.join("dataset.toml"),
            files: 1,
            text: format!(
                "the samples come at {:.4} to {:.4} Hz, sample_rate_hz says {nominal_rate_hz}",
                rate_hz[0], rate_hz[1]
            ),
        });
    }
    let gaps = Gaps {
        trials: trials.iter().filter(|trial| trial.gaps > 0).count(),
        gaps: trials.iter().map(|trial| trial.gaps).sum(),
        longest_s: trials.iter().map(|trial| trial.longest_gap_s).fold(0.0, f64::max),
    };
    let balance = balance_table(&trials);
    let physics: Vec<(PathBuf, &TrialPhysics)> =
        trials.iter().map(|trial| (trial.file.clone(), &trial.physics)).collect();
    let clocks = physics::clocks(physics.iter().map(|(_, of)| *of));
    let delay = physics::delay(physics.iter().map(|(_, of)| *of));
    let mut findings = physics::findings(index, &physics);
    let suspects = imbalance::judge(&trials, &balance, &description, &mut findings, &mut warnings);
    Report {
        name: index.description.name.clone(),
        trials: trials.len(),
        samples,
        primitives: primitives(&index.trials),
        repeated_groups: repeated.len(),
        repeated_trials: repeated.iter().sum(),
        nominal_rate_hz,
        rate_hz,
        gaps,
        channels: channel_table(&trials, &floor, samples),
        balance,
        suspects,
        clocks,
        object_delay: delay,
        findings,
        left_out,
        errors,
        warnings: join_warnings(warnings),
    }
}

/// What each trial shows of the sensors.
fn seen(index: &Index, progress: &dyn Progress) -> Vec<sensors::Seen> {
    let of = |info| {
        let trial = index.read_trial_lenient(info).trial;
        progress.step(1);
        trial.map(|trial| sensors::Seen::of(&trial))
    };
    index.trials.par_iter().filter_map(of).collect()
}

fn group_facts(index: &Index, description: &Description, group: &[usize]) -> GroupFacts {
    let mut facts = GroupFacts::default();
    let mut runs: Vec<(Stages, Vec<Signals>)> = Vec::new();
    for (place, info) in group.iter().filter_map(|place| Some((*place, index.trials.get(*place)?))) {
        let reading = index.read_trial_lenient(info);
        facts.errors.extend(reading.error.map(|error| error.to_string()));
        facts.warnings.extend(reading.warnings);
        if let Some(trial) = reading.trial {
            facts.left_out.extend(prepare(description, &trial, place).err().map(|why| LeftOut::from(&why)));
            let stages = stages(&trial);
            let signals = signals(&trial);
            facts.trials.push(trial_facts(index, description, &trial, &stages, &signals));
            runs.push((stages, signals));
        }
    }
    for (channel, pools) in facts.floor.0.iter_mut().enumerate() {
        for (stage, pool) in STAGES.into_iter().zip(pools) {
            let run = |(facts, (stages, signals)): (&TrialFacts, &(Stages, Vec<Signals>))| {
                // Clear of the contact, as in a comparison with a model.
                let range = match stage {
                    Stage::BeforeContact => stages.rest(),
                    _ => stages.range(stage),
                };
                let rows = signals.get(range).unwrap_or_default();
                let values: Vec<f64> = rows.iter().map(|row| row[channel]).collect();
                (Course::of(&values), facts.white[channel].unwrap_or(0.0))
            };
            let courses: Vec<(Course, f64)> = facts.trials.iter().zip(&runs).map(run).collect();
            pool.add(courses.iter().map(|(course, white)| (course, *white)));
        }
    }
    facts
}

/// Channels of a trial about the gripper's pose at its start, or the object's where no gripper is
/// measured: means of the first 50 ms, so that the noise of one sample is not that of all.
fn signals(trial: &Trial) -> Vec<Signals> {
    let object = first_pose(trial, |sample| sample.object);
    let carrier = first_pose(trial, |sample| sample.gripper).or(object).unwrap_or_else(Placed::identity);
    let start = carrier.to_local(&object.unwrap_or(carrier)).rotation;
    trial.samples.iter().map(|sample| channels::measured(sample, &carrier, &start)).collect()
}

/// The mean of a body's poses in the first 50 ms in which it is measured.
fn first_pose(trial: &Trial, of: fn(&Sample) -> Option<Pose>) -> Option<Placed<f64>> {
    const FIRST_S: f64 = 0.05;
    let known = || trial.samples.iter().filter_map(|s| Some((s.t_s, channels::pose(&of(s)?))));
    let (start_s, _) = known().next()?;
    channels::mean_pose(known().take_while(|(t_s, _)| t_s - start_s <= FIRST_S).map(|(_, pose)| pose))
}

fn trial_facts(
    index: &Index,
    description: &Description,
    trial: &Trial,
    stages: &Stages,
    signals: &[Signals],
) -> TrialFacts {
    let steps: Vec<f64> = trial
        .samples
        .windows(2)
        .filter_map(|pair| match pair {
            [a, b] => Some(b.t_s - a.t_s),
            _ => None,
        })
        .collect();
    let gap_s = GAP_PERIODS / description.sample_rate_hz;
    let (gaps, longest_gap_s) = steps
        .iter()
        .filter(|step| **step > gap_s)
        .fold((0, 0.0), |(count, longest), step| (count + 1, f64::max(longest, *step)));
    let balance = balance::balance(description, trial, stages);
    let mass_kg = description.objects.iter().find(|o| o.id == trial.info.object).map_or(0.0, |o| o.mass_kg);
    TrialFacts {
        name: trial.info.trial.clone(),
        file: index.folder.join(&trial.info.file),
        weight_n: description.gravity_m_s2.map(|g| g * mass_kg),
        physics: physics::of_trial(description, trial, stages, &balance),
        samples: trial.samples.len(),
        measured: std::array::from_fn(|channel| signals.iter().filter(|row| !row[channel].is_nan()).count()),
        white: std::array::from_fn(|channel| white_noise(signals.iter().map(|row| row[channel]))),
        median_step_s: median(steps).unwrap_or(f64::NAN),
        gaps,
        longest_gap_s,
        balance,
        offsets: offsets::at_rest(description, trial, stages),
    }
}

/// A primitive that the format does not name has no known intent: the predictor takes it as a hold.
fn unknown_primitives(index: &Index) -> Vec<Warning> {
    let mut names: BTreeMap<&str, usize> = BTreeMap::new();
    for info in index.trials.iter().filter(|info| !PRIMITIVES.contains(&info.primitive.as_str())) {
        *names.entry(&info.primitive).or_default() += 1;
    }
    let warning = |(name, trials): (&str, usize)| Warning {
        file: index.folder.join("trials.csv"),
        files: 1,
        text: format!(
            "the primitive {} ({trials} trials) has no known intent: the predictor expects that nothing slides. \
             Known are {}; for any other, [pushers.{name}] and [supports.{name}] in dataset.toml say what touches",
            stickslip_data::schema::with_hint(name, &PRIMITIVES),
            PRIMITIVES.join(", ")
        ),
    };
    names.into_iter().map(warning).collect()
}

fn primitives(infos: &[TrialInfo]) -> Vec<PrimitiveCount> {
    let mut groups: BTreeMap<(&str, &str), Vec<&TrialInfo>> = BTreeMap::new();
    for info in infos {
        groups.entry((&info.primitive, &info.object)).or_default().push(info);
    }
    type Condition = (&'static str, fn(&TrialInfo) -> Option<f64>);
    let conditions: [Condition; 5] = [
        ("grip_n", |info| info.grip_n),
        ("speed_m_s", |info| info.speed_m_s),
        ("speed_rad_s", |info| info.speed_rad_s),
        ("slope_rad", |info| info.slope_rad),
        ("pusher_offset_m", |info| info.pusher_offset_m),
    ];
    groups
        .into_iter()
        .map(|((primitive, object), infos)| PrimitiveCount {
            primitive: primitive.to_owned(),
            object: object.to_owned(),
            trials: infos.len(),
            conditions: conditions
                .iter()
                .filter_map(|(name, value)| {
                    let mut values: Vec<f64> = infos.iter().filter_map(|info| value(info)).collect();
                    values.sort_by(f64::total_cmp);
                    values.dedup();
                    (!values.is_empty()).then(|| ((*name).to_owned(), values))
                })
                .collect(),
        })
        .collect()
}

fn channel_table(trials: &[TrialFacts], floor: &Floors, samples: usize) -> Vec<Channel> {
    (0..COUNT)
        .map(|channel| {
            let measured: usize = trials.iter().map(|trial| trial.measured[channel]).sum();
            Channel {
                channel: NAMES[channel],
                measured: measured as f64 / samples.max(1) as f64,
                white: median(trials.iter().filter_map(|trial| trial.white[channel])),
                floor: std::array::from_fn(|stage| floor.0[channel][stage].floor()),
            }
        })
        .collect()
}

fn balance_table(trials: &[TrialFacts]) -> Balance {
    let mut table = Balance::default();
    let mut reasons: Vec<(NotChecked, usize)> = Vec::new();
    let mut all: Vec<StageBalance> = Vec::new();
    for trial in trials {
        match &trial.balance {
            Ok(stages) => {
                table.checked += 1;
                all.extend(stages);
                let failing = stages.iter().filter(|stage| stage.fails());
                let worst = failing.max_by(|a, b| size(a).total_cmp(&size(b)));
                if let Some(worst) = worst {
                    table.failing += 1;
                    table.worst.push((trial.name.clone(), *worst));
                }
            }
            Err(reason) => match reasons.iter_mut().find(|(known, _)| known == reason) {
                Some((_, count)) => *count += 1,
                None => reasons.push((*reason, 1)),
            },
        }
    }
    table.worst.sort_by(|a, b| size(&b.1).total_cmp(&size(&a.1)));
    table.not_checked = reasons;
    for stage in STAGES {
        let of_stage: Vec<&StageBalance> = all.iter().filter(|balance| balance.stage == stage).collect();
        if let Some((mean_n, scatter_n)) = moments(of_stage.iter().map(|balance| balance.sum_n)) {
            table.stages.push(StageSummary {
                stage: stage.label(),
                trials: of_stage.len(),
                mean_n,
                scatter_n,
                worst_n: of_stage.iter().map(|balance| size(balance)).fold(0.0, f64::max),
                bound_n: of_stage.iter().map(|balance| balance.bound_n).fold(0.0, f64::max),
            });
        }
    }
    let found: Vec<AtRest> = trials.iter().filter_map(|trial| trial.offsets).collect();
    table.tare = moments(found.iter().map(|of| of.fingers_sum_n)).map(|(mean, scatter)| TareSummary {
        trials: found.len(),
        fingers_sum_n: mean,
        fingers_scatter_n: scatter,
        pusher_n: moments(found.iter().filter_map(|of| of.pusher_n)).map(|(mean, _)| mean),
    });
    table
}

fn size(balance: &StageBalance) -> f64 {
    balance.sum_n.iter().fold(0.0, |most, component| f64::max(most, component.abs()))
}

/// Mean and standard deviation of each axis; `None` of nothing.
fn moments(values: impl Iterator<Item = [f64; 3]> + Clone) -> Option<([f64; 3], [f64; 3])> {
    let count = values.clone().count() as f64;
    if count == 0.0 {
        return None;
    }
    let mean: [f64; 3] =
        std::array::from_fn(|axis| values.clone().map(|value| value[axis]).sum::<f64>() / count);
    let scatter = std::array::from_fn(|axis| {
        (values.clone().map(|value| (value[axis] - mean[axis]).powi(2)).sum::<f64>() / count).sqrt()
    });
    Some((mean, scatter))
}

/// Names of the primitives of `report`, for its headline.
#[must_use]
pub fn primitive_names(report: &Report) -> String {
    let names: BTreeSet<&str> = report.primitives.iter().map(|count| count.primitive.as_str()).collect();
    names.into_iter().collect::<Vec<_>>().join(", ")
}
