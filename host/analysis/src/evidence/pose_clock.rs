//! How late the object's pose is behind the gripper's, from the motion before anything touches the object: no model of contact.
//!
//! Until something pushes it, an object in a grasp moves with the gripper. Seen `tau` late it trails by `tau v`: at each time it
//! is where the gripper was `tau` before. [`of_trial`] finds the `tau` of a trial by least squares over the whole pose, from the
//! rest at the start to the contact. [`Delay::over`] makes one number of the trials, where they agree on one: what trails by the
//! same distance at each speed is play, or pads that give way, and no clock.

use nalgebra::UnitQuaternion;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};
use stickslip_data::{Sample, Trial};
use stickslip_shared::track::Pose;

use crate::channels::{self, Signals};
use crate::evidence::contact;
use crate::evidence::statistics::weighted_median;
use crate::run::motion::{between, denoised};

/// Rotation counts at this arm, m.
const ARM_M: f64 = 0.03;
/// No delay is longer, s.
const MOST_S: f64 = 0.2;
/// Gauss-Newton steps; the first few find it.
const STEPS: usize = 12;
/// Samples in motion before the contact, at least.
const FEWEST_SAMPLES: usize = 4;
/// Trials, at least.
const FEWEST_TRIALS: usize = 4;
/// Of a delay, the same distance at each speed leaves this many times as much as the same time.
const NOT_PLAY: f64 = 2.0;
/// Trials agree where they scatter by less than this share of the delay, beside what each may be off by.
const SCATTER: f64 = 0.25;

/// A delay of more than so many standard deviations beyond a sample is one.
const TOLD: f64 = 3.0;
/// Share of a sample to which the delay of the motion in a grasp is that of the clock.
const OF_SAMPLE: f64 = 0.25;

/// The delay of one trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OfTrial {
    /// The object's pose is this late behind the gripper's, s.
    pub late_s: f64,
    /// Standard deviation of it, s.
    pub sd_s: f64,
    /// Speed of the gripper, of which it is a delay, m/s (root mean square, turning counted at 30 mm).
    pub speed_m_s: f64,
    /// Mean time between samples, s.
    pub period_s: f64,
}

impl OfTrial {
    /// Whether the trial alone shows it, and it is more than a sample.
    #[must_use]
    pub fn is_clear(&self) -> bool {
        self.late_s.abs() - TOLD * self.sd_s > self.period_s
    }
}

/// Six components of a motion: place, and turn at [`ARM_M`], m.
type Way = [f64; 6];

/// The object's delay in `trial`. `None`: poses are missing, or the gripper does not move before something touches the object.
#[must_use]
pub fn of_trial(trial: &Trial) -> Option<OfTrial> {
    let (gripper, object) = poses(trial);
    let still = UnitQuaternion::identity();
    let t_s: Vec<f64> = trial.samples.iter().map(|s| s.t_s).collect();
    let forces: Vec<Signals> =
        trial.samples.iter().map(|s| channels::measured(s, &Pose::identity(), &still)).collect();
    // The touch itself lies between two samples.
    let contact = contact::measured(&t_s, &forces)??.checked_sub(2)?;
    let (first_s, until_s) = (*t_s.first()?, *t_s.get(contact)?);
    let step_s = (until_s - first_s) / contact as f64;
    let mut late_s = 0.0;
    let mut found = None;
    for _ in 0..STEPS {
        // Times of the gripper's pose at which the object is compared with it.
        let seen = |t: f64| t - late_s >= first_s && t - late_s <= until_s;
        let object: Vec<At> = object.iter().copied().filter(|(t, _)| seen(*t)).collect();
        let [before, here, after] = [-step_s, 0.0, step_s].map(|by_s| way(&gripper, &object, late_s - by_s));
        let (before, here, after) = (before?, here?, after?);
        let speed: Vec<Way> = before
            .iter()
            .zip(&after)
            .map(|(b, a)| std::array::from_fn(|k| (a[k] - b[k]) / (2.0 * step_s)))
            .collect();
        let fit = slope(&here, &speed)?;
        late_s = (late_s + fit.slope).clamp(-MOST_S, MOST_S);
        found = Some(OfTrial { late_s, sd_s: fit.sd, speed_m_s: fit.size, period_s: step_s });
        if fit.slope.abs() < 0.01 * step_s {
            break;
        }
    }
    found.filter(|of| of.late_s.abs() < MOST_S && of.sd_s.is_finite())
}

/// By the gripper's clock: where the object is in the gripper, if its poses are `late_s` behind; place and turn at 30 mm, m.
#[must_use]
pub fn in_gripper(trial: &Trial, late_s: f64) -> Vec<(f64, [f64; 6])> {
    let (gripper, object) = poses(trial);
    let way = way(&gripper, &object, late_s).unwrap_or_default();
    object.iter().map(|(t, _)| t - late_s).zip(way).collect()
}

/// A pose and when it is.
type At = (f64, Pose<f64>);

/// Poses of gripper and object, those of the gripper without noise: it would enter the speed.
fn poses(trial: &Trial) -> (Vec<At>, Vec<At>) {
    let of = |pose: fn(&Sample) -> Option<stickslip_data::Pose>| -> Vec<At> {
        trial.samples.iter().filter_map(|s| Some((s.t_s, channels::pose(&pose(s)?)))).collect()
    };
    let (t_s, gripper): (Vec<f64>, Vec<Pose<f64>>) = of(|s| s.gripper).into_iter().unzip();
    let gripper = denoised(&t_s, &gripper);
    (t_s.into_iter().zip(gripper).collect(), of(|s| s.object))
}

/// The object in the frame of the gripper as that was `late_s` before, less where it was at first.
fn way(gripper: &[At], object: &[At], late_s: f64) -> Option<Vec<Way>> {
    let carriers = between(gripper, object.iter().map(|(t, _)| t - late_s))?;
    let first = carriers.first()?.to_local(&object.first()?.1);
    let one = |(carrier, (_, object)): (&Pose<f64>, &At)| {
        let local = carrier.to_local(object);
        let (p, r) = (local.position_m - first.position_m, local.rotation * first.rotation.inverse());
        let r = r.scaled_axis() * ARM_M;
        [p.x, p.y, p.z, r.x, r.y, r.z]
    };
    Some(carriers.iter().zip(object).map(one).collect())
}

/// A line through components that each have a level of their own.
struct Slope {
    slope: f64,
    sd: f64,
    /// Root mean square of what it is the slope over, about its mean, where that is not near zero.
    size: f64,
}

/// `y = level + slope x` in all components.
fn slope(y: &[Way], x: &[Way]) -> Option<Slope> {
    let n = y.len() as f64;
    let mean = |of: &[Way]| -> Way { std::array::from_fn(|k| of.iter().map(|row| row[k]).sum::<f64>() / n) };
    let (y_mean, x_mean) = (mean(y), mean(x));
    let sum = |of: &dyn Fn(usize, usize) -> f64| -> f64 {
        (0..y.len()).flat_map(|i| (0..6).map(move |k| (i, k))).map(|(i, k)| of(i, k)).sum()
    };
    let square = sum(&|i, k| (x[i][k] - x_mean[k]).powi(2));
    let product = sum(&|i, k| (x[i][k] - x_mean[k]) * (y[i][k] - y_mean[k]));
    let moving: Vec<f64> = x.iter().map(|row| row.iter().map(|v| v * v).sum::<f64>()).collect();
    let fastest = moving.iter().copied().fold(0.0, f64::max);
    let fast: Vec<f64> = moving.into_iter().filter(|v| *v > 0.1 * fastest).collect();
    if fast.len() < FEWEST_SAMPLES || square <= 0.0 {
        return None;
    }
    let slope = product / square;
    let left = sum(&|i, k| (y[i][k] - y_mean[k] - slope * (x[i][k] - x_mean[k])).powi(2));
    let sd = (left / (6.0 * n - 7.0).max(1.0) / square).sqrt();
    Some(Slope { slope, sd, size: (fast.iter().sum::<f64>() / fast.len() as f64).sqrt() })
}

/// One delay of all trials.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Delay {
    /// The object's poses are this late behind the gripper's, s.
    pub late_s: f64,
    /// Standard deviation of it, s.
    pub sd_s: f64,
    /// Mean time between samples, s.
    pub period_s: f64,
    /// From so many trials.
    pub trials: usize,
}

impl Delay {
    /// Of the trials; `None` where too few show one, or they do not agree on one.
    #[must_use]
    pub fn over(all: &[OfTrial]) -> Option<Self> {
        if all.len() < FEWEST_TRIALS {
            return None;
        }
        let weight = |of: &OfTrial| of.sd_s.powi(-2);
        let middle = weighted_median(all.iter().map(|of| (of.late_s, weight(of))).collect())?;
        let sd = weighted_median(all.iter().map(|of| (of.sd_s, 1.0)).collect())?;
        let off = weighted_median(all.iter().map(|of| ((of.late_s - middle).abs(), 1.0)).collect())? / 0.6745;
        if off > SCATTER * middle.abs() + 3.0 * sd {
            return None;
        }
        let distance_m =
            weighted_median(all.iter().map(|of| (of.late_s * of.speed_m_s, weight(of))).collect())?;
        let left = |by: &dyn Fn(&OfTrial) -> f64| {
            weighted_median(
                all.iter().map(|of| ((of.late_s - by(of)).abs().max(0.1 * of.sd_s), 1.0)).collect(),
            )
        };
        let (as_clock, as_play) = (left(&|_| middle)?, left(&|of| distance_m / of.speed_m_s)?);
        if as_play < NOT_PLAY * as_clock && middle.abs() > 3.0 * sd {
            return None;
        }
        let sd_s = 1.25 * off.max(sd) / (all.len() as f64).sqrt();
        let period_s = all.iter().map(|of| of.period_s).sum::<f64>() / all.len() as f64;
        Some(Self { late_s: middle, sd_s, period_s, trials: all.len() })
    }

    /// The same of raw trials.
    #[must_use]
    pub fn measured(trials: &[&Trial]) -> Option<Self> {
        Self::over(&trials.par_iter().filter_map(|trial| of_trial(trial)).collect::<Vec<_>>())
    }

    /// By how much the object has to be seen earlier, s: seen late, it seems to move in the grasp before it is loaded.
    #[must_use]
    pub fn found_s(of: Option<Self>) -> f64 {
        of.filter(Self::is_found).map_or(0.0, |delay| delay.late_s)
    }

    /// Whether it is more than a sample, beyond chance: shutters and filters make as much as that.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.late_s.abs() - TOLD * self.sd_s > self.period_s
    }

    /// Standard deviation of what a fit may find: pads that carry the object along trail by a little more.
    #[must_use]
    pub fn within_s(&self) -> f64 {
        self.sd_s.hypot(OF_SAMPLE * self.period_s)
    }

    /// Probability of one as long by chance.
    #[must_use]
    pub fn by_chance(&self) -> f64 {
        let freedom = self.trials as f64 - 1.0;
        StudentsT::new(0.0, 1.0, freedom).map_or(1.0, |t| 2.0 * t.sf((self.late_s / self.sd_s).abs()))
    }
}
