//! How many warnings come in time at how many false alarms an hour: the predictor beside detectors that anyone
//! could write in a line, and beside one that was learnt.
//!
//! A detector gives one number a sample and warns where it is above a level; each level is a point of its curve.
//! *Threshold*: tangential over normal force, of the friction told (mean of ten samples). *Force rate*:
//! change of the tangential force in 20 ms. *Learnt*: boosted trees ([`Learnt`]) on [`features`] of the last
//! half second, trained on other data; their number is an estimate of the probability that the object slides now or
//! will within [`AHEAD_S`]. What no detector reaches may be a limit of the data.

use anyhow::{Context, ensure};
use rayon::prelude::*;
use serde::Serialize;
use smartcore::linalg::basic::matrix::DenseMatrix;
use smartcore::xgboost::{XGRegressor, XGRegressorParameters};

use crate::grasps::{Grasp, force};
use stickslip_analysis::channels;
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::alarms::{Episode, SLIPS, episodes};
use stickslip_analysis::score::warnings::{Figures, SLIPPED_M, Share, TrialKey, judge};
use stickslip_shared::predictor::flags;

/// The learnt detector shall warn so long before a slip, s.
pub const AHEAD_S: f64 = 0.2;
/// Of a trial's samples one of so many is learnt from: neighbours are alike.
const LEARNT_FROM: usize = 4;
/// Levels of a curve.
pub const LEVELS: usize = 24;
/// Spans over which a feature looks back, samples of 4 ms.
const SPANS: [usize; 3] = [5, 25, 125];

/// One number for each sample.
pub type Course = Vec<f64>;

/// Tangential over normal force, of the friction told.
#[must_use]
pub fn threshold(grasp: &Grasp<'_>) -> Course {
    grasp.ratios().map(|ratio| ratio / grasp.model.friction.finger).collect()
}

/// Change of the tangential force in 20 ms, N/s.
#[must_use]
pub fn force_rate(grasp: &Grasp<'_>) -> Course {
    let forces = forces(grasp);
    (0..forces.len())
        .map(|i| {
            let (now, before) = (forces[i], forces[i.saturating_sub(SPANS[0])]);
            (now[0] - before[0]).hypot(now[1] - before[1]) / 0.02
        })
        .collect()
}

/// Sum of both fingers: tangential along X and Z, normal; the last one known where a wrench is missing.
fn forces(grasp: &Grasp<'_>) -> Vec<[f64; 3]> {
    let mut last = [0.0; 3];
    let of = grasp.feed.samples.iter().map(|s| {
        last = force(s).unwrap_or(last);
        last
    });
    of.collect()
}

/// What the learnt detector sees of each sample: forces and their changes over 20, 100 and 500 ms, the grip command, the
/// gripper's acceleration, and, where the object's pose is given, how far it has moved in the grasp.
#[must_use]
pub fn features(grasp: &Grasp<'_>, pose: ObjectPose) -> Vec<Vec<f64>> {
    let forces = forces(grasp);
    let friction = grasp.model.friction.finger;
    let ratio: Vec<f64> = threshold(grasp);
    let raw = |f: &[f64; 3]| f[0].hypot(f[1]) / f[2].max(0.1) / friction;
    let mut gripper = [0.0; 3];
    let grippers: Vec<[f64; 3]> = grasp
        .feed
        .samples
        .iter()
        .map(|s| {
            gripper = s.gripper.map_or(gripper, |p| p.position_m.map(f64::from));
            gripper
        })
        .collect();
    let mut known = None;
    let mut place = [0.0; 3];
    let places: Vec<[f64; 3]> = grasp
        .feed
        .samples
        .iter()
        .map(|s| {
            if let (Some(carrier), Some(object), ObjectPose::Every) = (s.gripper, s.object, pose) {
                let body = |p: stickslip_shared::wire::Pose| {
                    let (position_m, quaternion) = (p.position_m.map(f64::from), p.quaternion.map(f64::from));
                    channels::pose(&stickslip_data::Pose { position_m, quaternion })
                };
                let here = body(carrier).to_local(&body(object)).position_m;
                let start = *known.get_or_insert(here);
                place = (here - start).into();
            }
            place
        })
        .collect();
    let distance =
        |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    (0..forces.len())
        .map(|i| {
            let back = |span: usize| i.saturating_sub(span);
            let now = &forces[i];
            let mut row = vec![
                ratio[i],
                raw(now),
                now[2],
                now[0].hypot(now[1]),
                2.0 * f64::from(grasp.feed.samples[i].grip_cmd_n) - now[2],
                distance(&places[i], &[0.0; 3]),
            ];
            for span in SPANS {
                let before = back(span);
                let near = &ratio[before..=i];
                let mean = near.iter().sum::<f64>() / near.len() as f64;
                let spread = near.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / near.len() as f64;
                row.push(ratio[i] - ratio[before]);
                row.push(spread.sqrt());
                row.push(now[2] - forces[before][2]);
                row.push((now[0] - forces[before][0]).hypot(now[1] - forces[before][1]));
                row.push(distance(&places[i], &places[before]));
                let (a, b, c) = (&grippers[i], &grippers[back(span / 2)], &grippers[before]);
                let bend: [f64; 3] = std::array::from_fn(|k| a[k] - 2.0 * b[k] + c[k]);
                row.push(distance(&bend, &[0.0; 3]) / (0.002 * span as f64).powi(2));
            }
            row.iter().map(|x| if x.is_finite() { *x } else { 0.0 }).collect()
        })
        .collect()
}

/// Rows to learn from, and whether the object slides or will within [`AHEAD_S`].
#[must_use]
pub fn lessons(grasp: &Grasp<'_>, pose: ObjectPose) -> Vec<(Vec<f64>, f64)> {
    let slides = |t: f64| {
        let slips = grasp.truth.episodes.iter().filter(|[.., m]| *m > SLIPPED_M);
        slips.into_iter().any(|[from, to, _]| (from - AHEAD_S..=*to).contains(&t))
    };
    let rows = features(grasp, pose).into_iter().zip(&grasp.t_s).step_by(LEARNT_FROM);
    rows.filter(|(_, t)| **t <= grasp.until_s)
        .map(|(row, t)| (row, f64::from(u8::from(slides(*t)))))
        .collect()
}

/// Boosted regression trees on 0 and 1.
pub struct Learnt(XGRegressor<f64, f64, DenseMatrix<f64>, Vec<f64>>);

impl Learnt {
    /// From the rows of all trials.
    ///
    /// # Errors
    /// Where there are none.
    pub fn from(lessons: Vec<(Vec<f64>, f64)>) -> anyhow::Result<Self> {
        ensure!(!lessons.is_empty(), "nothing to learn from");
        let (rows, truth): (Vec<Vec<f64>>, Vec<f64>) = lessons.into_iter().unzip();
        let parameters = XGRegressorParameters {
            n_estimators: 80,
            max_depth: 5,
            learning_rate: 0.15,
            min_child_weight: 30,
            subsample: 0.5,
            base_score: 0.0,
            seed: 1,
            ..XGRegressorParameters::default()
        };
        let rows = DenseMatrix::from_2d_vec(&rows).context("rows of unlike length")?;
        Ok(Self(XGRegressor::fit(&rows, &truth, parameters).context("no trees could be learnt")?))
    }

    /// Of every sample of a trial.
    ///
    /// # Errors
    /// Where the trees do not fit the features.
    pub fn course(&self, grasp: &Grasp<'_>, pose: ObjectPose) -> anyhow::Result<Course> {
        let rows = DenseMatrix::from_2d_vec(&features(grasp, pose)).context("rows of unlike length")?;
        self.0.predict(&rows).context("the trees do not fit")
    }
}

/// Names of the detectors beside the predictor, in the order of the curves.
pub const DETECTORS: [&str; 3] = ["threshold", "force rate", "learnt"];

/// A trial, with what each detector and the predictor said of it.
pub struct Scored {
    truth: TrialKey,
    t_s: Vec<f64>,
    until_s: f64,
    courses: [Course; 3],
    predictor: (Figures, Share),
}

impl Scored {
    /// All of one trial.
    ///
    /// # Errors
    /// Where the predictor refuses it, or the trees do not fit.
    pub fn of(grasp: &Grasp<'_>, pose: ObjectPose, learnt: &Learnt) -> anyhow::Result<Self> {
        let raised = grasp.predictions(pose, true)?;
        let up = |mask: u32| episodes(&grasp.t_s, raised.iter().map(|p| p.flags & mask != 0), grasp.until_s);
        let is_slip = raised.iter().map(|p| p.flags & SLIPS != 0);
        Ok(Self {
            predictor: (judge(grasp.truth, &up(SLIPS), &up(flags::DROP), grasp.until_s), samples_up(is_slip)),
            courses: [threshold(grasp), force_rate(grasp), learnt.course(grasp, pose)?],
            truth: grasp.truth.clone(),
            t_s: grasp.t_s.clone(),
            until_s: grasp.until_s,
        })
    }

    fn above(&self, detector: usize, level: f64) -> (Figures, Share) {
        let is_up = self.courses[detector].iter().map(|x| *x > level);
        let up: Vec<Episode> = episodes(&self.t_s, is_up.clone(), self.until_s);
        (judge(&self.truth, &up, &up, self.until_s), samples_up(is_up))
    }
}

fn samples_up(is_up: impl Iterator<Item = bool>) -> Share {
    let mut up = Share::default();
    is_up.for_each(|is_up| up.count(is_up));
    up
}

/// A detector's figures where it warns above a level.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// The level.
    pub level: f64,
    /// What comes of it.
    pub figures: Figures,
    /// Samples with the alarm up. Alarms that run into one another are few, and no better for it.
    pub up: Share,
}

/// The predictor's figures over all trials, and samples with its slip alarm up.
#[must_use]
pub fn predictor(trials: &[Scored]) -> (Figures, Share) {
    let (figures, up): (Vec<Figures>, Vec<Share>) = trials.iter().map(|t| t.predictor.clone()).unzip();
    (sum(figures.into_iter()), joined(&up))
}

/// The curve of a detector, from its most careful level to its most trusting one: those that evenly spaced (in
/// their logarithm) shares of all samples are above.
#[must_use]
pub fn curve(trials: &[Scored], detector: usize) -> Vec<Point> {
    let mut all: Vec<f64> =
        trials.iter().flat_map(|t| &t.courses[detector]).copied().filter(|x| x.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    let level = |k: usize| {
        let above = 10f64.powf(-0.3 - 4.0 * k as f64 / LEVELS as f64);
        all.get(((1.0 - above) * all.len() as f64) as usize).copied()
    };
    let mut levels: Vec<f64> = (0..LEVELS).filter_map(level).collect();
    levels.dedup();
    let of = |level| {
        let (figures, up): (Vec<Figures>, Vec<Share>) =
            trials.iter().map(|t| t.above(detector, level)).unzip();
        Point { level, figures: sum(figures.into_iter()), up: joined(&up) }
    };
    levels.into_par_iter().map(of).collect()
}

fn joined(shares: &[Share]) -> Share {
    shares.iter().fold(Share::default(), |mut sum, s| {
        sum.join(s);
        sum
    })
}

fn sum(figures: impl Iterator<Item = Figures>) -> Figures {
    figures.fold(Figures::default(), |mut sum, f| {
        sum.join(&f);
        sum
    })
}

/// The point of a curve that finds most of `what` at no more false alarms than `most` an hour, with the alarm up in no
/// more than `up` of the samples.
#[must_use]
pub fn at_most(curve: &[Point], (most, up): (f64, f64), what: fn(&Figures) -> &Share) -> Option<&Point> {
    let few = |p: &&Point| p.figures.all_false().rate().is_some_and(|r| r.per_hour <= most);
    let short = |p: &&Point| p.up.found as f64 <= up * p.up.of as f64;
    curve.iter().filter(few).filter(short).max_by_key(|p| what(&p.figures).found)
}
