//! Simulated grasps with what is true of them: a data set, its key and the model that is told, trial by trial.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rayon::prelude::*;

use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::replay::{Feed, feed};
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::warnings::{Key, TrialKey, until_s};
use stickslip_data::{Index, TrialInfo};
use stickslip_shared::model::Model;
use stickslip_shared::predictor::{Checked, Limits, ModelError, Plan, Prediction, Predictor, validate};
use stickslip_shared::wire::Sample;

use crate::degrade::Fault;

/// Samples whose forces a threshold averages.
const SMOOTHED: usize = 10;

/// A predictor as a unit has it that stays on from one trial to the next: what it has learnt of friction it knows in the
/// next grasp.
#[derive(Debug, Default)]
pub struct Unit {
    on: Option<Predictor<f32>>,
    tuning: Checked<f32>,
}

impl Unit {
    /// Not switched on yet, with numbers of its own.
    #[must_use]
    pub fn tuned(tuning: Checked<f32>) -> Self {
        Self { on: None, tuning }
    }
}

impl Unit {
    /// Ready for a grasp: of another object as after an upload to the board.
    fn begin(&mut self, grasp: &Grasp<'_>) -> Result<&mut Predictor<f32>, ModelError> {
        let (scene, model, limits) = (grasp.feed.scene.clone(), grasp.model.cast(), Limits::default());
        let predictor = match self.on.take() {
            Some(mut predictor) => {
                validate(&scene, &model)?;
                predictor.swap(scene, model, limits);
                predictor
            }
            None => Predictor::new(scene, model, limits)?.with_tuning(&self.tuning),
        };
        let predictor = self.on.insert(predictor);
        predictor.restart();
        Ok(predictor)
    }
}

/// One trial.
pub struct Grasp<'a> {
    /// Its name.
    pub trial: &'a str,
    /// Its place in the data set.
    pub ordinal: usize,
    /// What is true of it.
    pub truth: &'a TrialKey,
    /// What the predictor is given; the plan tells the grip at the start.
    pub feed: Feed,
    /// The model that is told.
    pub model: Model<f64>,
    /// Times of the samples, s.
    pub t_s: Vec<f64>,
    /// Up to when it is judged, s.
    pub until_s: f64,
}

impl Grasp<'_> {
    /// As a faulty rig would have recorded it.
    pub fn spoil(&mut self, fault: Fault) {
        fault.apply(&mut self.feed.samples, &mut self.model);
        self.t_s = times(&self.feed);
        self.until_s = until_s(self.truth, &self.t_s);
    }

    /// What the predictor says of every sample.
    ///
    /// # Errors
    /// Where it refuses scene or model.
    pub fn predictions(&self, pose: ObjectPose, plan: bool) -> anyhow::Result<Vec<Prediction>> {
        self.predictions_by(&mut Unit::default(), pose, plan)
    }

    /// The same by a unit that may have taken others before.
    ///
    /// # Errors
    /// Where it refuses scene or model.
    pub fn predictions_by(
        &self,
        unit: &mut Unit,
        pose: ObjectPose,
        plan: bool,
    ) -> anyhow::Result<Vec<Prediction>> {
        let predictor = unit
            .begin(self)
            .map_err(|why| anyhow::anyhow!("trial {}: scene or model refused: {why:?}", self.trial))?;
        predictor.set_plan(if plan { self.feed.plan.clone() } else { Plan::default() });
        predictor.set_trial(self.ordinal as f32);
        let mut started = false;
        let of = self.feed.samples.iter().map(|s| {
            let mut sample = *s;
            if pose == ObjectPose::Start && started {
                sample.object = None;
            }
            started |= s.object.is_some();
            predictor.take(&sample)
        });
        Ok(of.collect())
    }

    /// Tangential over normal force of both fingers, of the mean over ten samples; 0 where nothing presses.
    pub fn ratios(&self) -> impl Iterator<Item = f64> + '_ {
        let samples = &self.feed.samples;
        (0..samples.len()).map(|i| {
            let near = samples.get(i.saturating_sub(SMOOTHED - 1)..=i).unwrap_or(&[]);
            let sum = near.iter().fold([0.0f64; 3], |mut sum, s| {
                if let Some(force) = force(s) {
                    sum.iter_mut().zip(force).for_each(|(sum, x)| *sum += x);
                }
                sum
            });
            if sum[2] > 0.0 { sum[0].hypot(sum[1]) / sum[2] } else { 0.0 }
        })
    }
}

/// Times of the samples, s.
fn times(feed: &Feed) -> Vec<f64> {
    feed.samples.iter().map(|s| f64::from(s.t_us) * 1e-6).collect()
}

/// Of both fingers together, N: along X and Z, and normal; `None` where one is not measured.
#[must_use]
pub fn force(sample: &Sample) -> Option<[f64; 3]> {
    let [Some(a), Some(b)] = sample.finger else { return None };
    Some([a[0] + b[0], a[2] + b[2], a[1].abs() + b[1].abs()].map(f64::from))
}

/// The key beside a data set.
#[must_use]
pub fn key_of(folder: &Path) -> PathBuf {
    let mut name = folder.as_os_str().to_owned();
    name.push(".key.json");
    let own = PathBuf::from(name);
    if own.exists() { own } else { folder.join("../key.json") }
}

/// A data set of simulated grasps.
struct Grasps {
    path: PathBuf,
    key: Key,
    index: Index,
    model: Model<f64>,
}

impl Grasps {
    /// `key` and `model` in place of those beside the data.
    fn open(folder: &Path, (key, model): (Option<&Path>, Option<&Path>)) -> anyhow::Result<Self> {
        let path = key.map_or_else(|| key_of(folder), Path::to_owned);
        let text = std::fs::read(&path)
            .with_context(|| format!("{}: cannot be read; state --key", path.display()))?;
        let key: Key = serde_json::from_slice(&text)
            .with_context(|| format!("{}: not a key of simulated grasps", path.display()))?;
        let index = Index::open(folder)?;
        let beside = [folder.join("model.toml"), folder.join("../model.toml")];
        let told = model.or_else(|| beside.iter().find(|p| p.exists()).map(PathBuf::as_path));
        Ok(Self { path, key, index, model: model_or_default(told)? })
    }

    fn grasp<'a>(&'a self, (ordinal, info): (usize, &'a TrialInfo)) -> anyhow::Result<Grasp<'a>> {
        let truth = self
            .key
            .trials
            .get(&info.trial)
            .with_context(|| format!("{}: no entry for trial '{}'", self.path.display(), info.trial))?;
        let trial = self.index.read_trial(info)?;
        let mut feed = feed(&self.index.description, &trial)?;
        let first = trial.samples.iter().find_map(|s| s.grip_cmd_n).or(info.grip_n).unwrap_or(0.0);
        // The plan tells the set-point at the start: that a grip decays is not in it.
        feed.plan.segments.iter_mut().for_each(|s| s.grip_n = first as f32);
        let t_s = times(&feed);
        let until_s = until_s(truth, &t_s);
        Ok(Grasp { trial: &info.trial, ordinal, truth, feed, model: self.model.clone(), t_s, until_s })
    }
}

/// What `of` makes of each trial of `folder`, in order. `key` and `model` in place of those beside the data.
///
/// # Errors
/// Where the key, the model or the data cannot be read, or `of` fails.
pub fn each<T: Send>(
    folder: &Path,
    told: (Option<&Path>, Option<&Path>),
    of: impl Fn(Grasp<'_>) -> anyhow::Result<T> + Sync,
) -> anyhow::Result<Vec<T>> {
    let grasps = Grasps::open(folder, told)?;
    grasps.index.trials.par_iter().enumerate().map(|trial| of(grasps.grasp(trial)?)).collect()
}

/// The same with one trial after the other.
///
/// # Errors
/// As [`each`].
pub fn in_turn<T>(
    folder: &Path,
    told: (Option<&Path>, Option<&Path>),
    mut of: impl FnMut(Grasp<'_>) -> anyhow::Result<T>,
) -> anyhow::Result<Vec<T>> {
    let grasps = Grasps::open(folder, told)?;
    grasps.index.trials.iter().enumerate().map(|trial| of(grasps.grasp(trial)?)).collect()
}
