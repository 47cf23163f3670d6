//! Simulated grasps with what is true of them: a data set, its key and the model that is told, trial by trial.

use std::path::{Path, PathBuf};

use anyhow::Context;
use rayon::prelude::*;

use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::run::replay::{Feed, feed};
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::warnings::{Key, TrialKey, until_s};
use stickslip_data::Index;
use stickslip_shared::model::{Model, Scene};
use stickslip_shared::predictor::{Limits, ModelError, Plan, Prediction, Predictor, validate};
use stickslip_shared::wire::Sample;

use crate::degrade::Fault;

/// Samples whose forces a threshold averages.
const SMOOTHED: usize = 10;

/// A predictor as a unit has it that stays on from one trial to the next: what it has learnt of friction, pads, clocks and
/// noise it knows in the next grasp of the same object.
#[derive(Debug, Default)]
pub struct Unit {
    on: Option<(Predictor<f32>, Scene<f32>, Model<f64>)>,
}

impl Unit {
    /// Ready for a trial: the same predictor where scene and model are those of the last one, else one that knows nothing.
    ///
    /// # Errors
    /// The predictor refuses scene or model.
    pub fn begin(
        &mut self,
        feed: &Feed,
        model: &Model<f64>,
        limits: Limits,
        ordinal: usize,
    ) -> Result<&mut Predictor<f32>, ModelError> {
        let mut on = match self.on.take().filter(|on| on.2 == *model) {
            Some(mut on) => {
                if on.1 != feed.scene {
                    validate(&feed.scene, &model.cast())?;
                    on.0.swap(feed.scene.clone(), model.cast(), limits);
                    on.1 = feed.scene.clone();
                }
                on
            }
            None => {
                (Predictor::new(feed.scene.clone(), model.cast(), limits)?, feed.scene.clone(), model.clone())
            }
        };
        on.0.restart();
        on.0.set_plan(feed.plan.clone());
        on.0.set_trial(ordinal as f32);
        Ok(&mut self.on.insert(on).0)
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
    pub fn predictions(
        &self,
        unit: &mut Unit,
        pose: ObjectPose,
        plan: bool,
    ) -> anyhow::Result<Vec<Prediction>> {
        let predictor = unit
            .begin(&self.feed, &self.model, Limits::default(), self.ordinal)
            .map_err(|why| anyhow::anyhow!("trial {}: scene or model refused: {why:?}", self.trial))?;
        if !plan {
            predictor.set_plan(Plan::default());
        }
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

/// What `of` makes of each trial of `folder`, in order, by one unit that `stays_on` or by one for each. `key` and `model` in place of those beside the data.
///
/// # Errors
/// Where the key, the model or the data cannot be read, or `of` fails.
pub fn each<T: Send>(
    folder: &Path,
    (key, model): (Option<&Path>, Option<&Path>),
    stays_on: bool,
    of: impl Fn(Grasp<'_>, &mut Unit) -> anyhow::Result<T> + Sync,
) -> anyhow::Result<Vec<T>> {
    let path = key.map_or_else(|| key_of(folder), Path::to_owned);
    let text =
        std::fs::read(&path).with_context(|| format!("{}: cannot be read; state --key", path.display()))?;
    let key: Key = serde_json::from_slice(&text)
        .with_context(|| format!("{}: not a key of simulated grasps", path.display()))?;
    let index = Index::open(folder)?;
    let beside = [folder.join("model.toml"), folder.join("../model.toml")];
    let told = model.or_else(|| beside.iter().find(|p| p.exists()).map(PathBuf::as_path));
    let model = model_or_default(told)?;
    let grasp = |unit: &mut Unit, (ordinal, info): (usize, &stickslip_data::TrialInfo)| {
        let truth = key
            .trials
            .get(&info.trial)
            .with_context(|| format!("{}: no entry for trial '{}'", path.display(), info.trial))?;
        let trial = index.read_trial(info)?;
        let mut feed = feed(&index.description, &trial)?;
        let first = trial.samples.iter().find_map(|s| s.grip_cmd_n).or(info.grip_n).unwrap_or(0.0);
        // The plan tells the set-point at the start: that a grip decays is not in it.
        feed.plan.segments.iter_mut().for_each(|s| s.grip_n = first as f32);
        let t_s = times(&feed);
        let until_s = until_s(truth, &t_s);
        of(Grasp { trial: &info.trial, ordinal, truth, feed, model: model.clone(), t_s, until_s }, unit)
    };
    match stays_on {
        true => {
            let mut unit = Unit::default();
            index.trials.iter().enumerate().map(|trial| grasp(&mut unit, trial)).collect()
        }
        false => {
            index.trials.par_iter().enumerate().map(|trial| grasp(&mut Unit::default(), trial)).collect()
        }
    }
}
