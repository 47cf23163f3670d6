//! When slip, sag, turning and loss of the grasp really began, from the measured motion alone.
//!
//! Finger `k` slips by the motion of the object's material point under its patch,
//! `m_k = x + R (p_k - x0) - p_k` (gripper axes, across the finger), joined with the turn
//! about the finger axis at two thirds of the patch radius. The pose is averaged over five
//! samples; a slow mean of it (0.2 s) is the anchor. Slip is a departure from the anchor by
//! [`SLIPPED_M`], dated back to where the departure left the noise; one that stops short of
//! it, but beyond [`NEAR_M`], is a near slip, and so is a step that stays, beyond [`STEP_M`]
//! between the means of a tenth of a second before and after. Where a slip has ended, the anchor is set anew: one
//! that still lags the last slip would date the next before its cause. What moves slower than
//! about [`SLIPPED_M`] in 0.2 s, a creeping pad, is no slip; it shows as sag.

pub use super::cause::Cause;
use super::cause::cause;
use nalgebra::Vector3;
use stickslip_shared::model::{FingerContact, Scene};
use stickslip_shared::predictor::{Intent, Limits};
use stickslip_shared::track::Pose;

use crate::channels::{self, mean_pose};
use crate::run::replay::intent_of;
use stickslip_data::Trial;

/// Lead that a drop is to be warned with.
pub const DROP_AHEAD_S: f64 = 0.36;
/// Lead that a slip whose cause builds up is to be warned with.
pub const SLIP_AHEAD_S: f64 = 0.1;
/// A sudden slip is to be flagged this long after its onset at the latest.
pub const SUDDEN_WITHIN_S: f64 = 0.02;
/// Departure from the anchor that counts as slip.
pub const SLIPPED_M: f64 = 3e-4;
/// Departure that is motion beyond doubt: six standard deviations of the smoothed pose.
pub const NEAR_M: f64 = 1.2e-4;
/// Step that stays and is motion beyond doubt: six deviations of the difference of two means.
pub const STEP_M: f64 = 7.2e-5;
/// Samples in each mean, how far the means lie before and after the step, and how far back and
/// on again the means lie that tell how fast the pads creep.
const STEP_MEAN: usize = 25;
const STEP_GAP: [usize; 2] = [5, 10];
const CREEP: usize = 100;
/// Departure that may still be noise: onset is the last sample below it. Poses of gripper and
/// object with 30 um each leave 19 um on an axis after smoothing; this is 3.7 times that.
const NOISE_M: f64 = 7e-5;
const ANCHOR_S: f64 = 0.2;
/// Samples whose mean is the anchor after a slip.
const RESTED: usize = 10;
/// Smoothing of the pose: this many samples to either side.
const HALF_WINDOW: usize = 2;
/// Samples over which forces are averaged.
const FORCE_WINDOW: usize = 10;

/// What began.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, schemars::JsonSchema, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// An object slips in the grasp: either finger.
    Slip,
    /// Sag or rotation goes beyond its limit.
    Moved,
    /// The grasp is lost: the patches leave the face, or the fingers no longer press.
    Drop,
}

impl Kind {
    /// In a word or two.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Slip => "slip",
            Kind::Moved => "sag or rotation",
            Kind::Drop => "drop",
        }
    }
}

/// One event.
#[derive(Clone, Debug, schemars::JsonSchema, serde::Serialize)]
pub struct Event {
    /// What.
    pub kind: Kind,
    /// When it began.
    pub onset_s: f64,
    /// When it was over.
    pub end_s: f64,
    /// The plan means it.
    pub intended: bool,
    /// Drop: `BuildsUp` where it could be foreseen 360 ms ahead.
    pub cause: Cause,
    /// Slip: onset on each finger, where it slipped.
    pub finger_s: [Option<f64>; 2],
}

/// All events of a trial, and when the grasp was lost (the end of what can be scored).
#[derive(Clone, Debug, Default)]
pub struct Truth {
    /// In order of kind, then time.
    pub events: Vec<Event>,
    /// The object moved measurably, but not as far as a slip: from, to, s.
    pub near: Vec<(f64, f64)>,
    /// Scored up to here.
    pub until_s: f64,
    /// Smoothed ratio of tangential to normal force at each sample, NaN: not measured.
    pub ratio: Vec<f64>,
    /// Tangential force of both fingers, unsmoothed, N.
    pub tangential_n: Vec<f64>,
}

/// Finds the events of `trial`; times count from its first sample.
pub fn find(scene: &Scene<f64>, trial: &Trial, limits: &Limits) -> Truth {
    let t = times(trial);
    let last_s = t.last().copied().unwrap_or(0.0);
    let arm_m = match scene.fingers {
        Some(FingerContact::Disc { diameter_m }) => diameter_m / 3.0,
        Some(FingerContact::Line { length_m }) => length_m / 2.0,
        _ => 0.0,
    };
    let (ratio, tangential_n) = forces(trial, arm_m);
    let motion = smoothed(trial);
    let Some(start) = motion.iter().flatten().next().copied() else {
        return Truth { until_s: last_s, ratio, tangential_n, ..Truth::default() };
    };
    let intent = intent_of(&trial.info.primitive);
    let mut truth = Truth { until_s: last_s, ratio, tangential_n, ..Truth::default() };
    let lost = lost(scene, trial, &t, &motion, &start);
    truth.until_s = lost.unwrap_or(last_s);
    let paths = [0, 1].map(|k| path(scene, &motion, &start, k, arm_m));
    let beyond = |limit_m: f64| {
        let of = |k: usize| slips(&t, &paths[k], truth.until_s, k, limit_m);
        joined((0..2).flat_map(of).collect())
    };
    let (slips, near) = (beyond(SLIPPED_M), beyond(NEAR_M));
    let apart = |n: &(f64, f64)| slips.iter().all(|s| n.1 < s.0 || n.0 > s.1);
    let steps = paths.iter().flat_map(|path| steps(&t, path, truth.until_s));
    truth.near = near.into_iter().map(|(from, to, _)| (from, to)).chain(steps).filter(apart).collect();
    truth.near.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (onset_s, end_s, finger_s) in slips {
        let cause = cause(&t, &truth.ratio, onset_s, super::SLIP_AHEAD_S);
        let intended = intent != Intent::Hold;
        truth.events.push(Event { kind: Kind::Slip, onset_s, end_s, intended, cause, finger_s });
    }
    if let Some(onset_s) = moved(scene, intent, trial, &t, &motion, limits, truth.until_s) {
        let (end_s, cause) = (truth.until_s, cause(&t, &truth.ratio, onset_s, super::SLIP_AHEAD_S));
        let event = Event { kind: Kind::Moved, onset_s, end_s, intended: false, cause, finger_s: [None; 2] };
        truth.events.push(event);
    }
    if let Some(onset_s) = lost {
        let slip =
            truth.events.iter().filter(|e| e.kind == Kind::Slip).map(|e| (e.onset_s, e.cause)).next_back();
        let foreseen = slip.is_some_and(|(at, why)| {
            onset_s - at >= DROP_AHEAD_S
                || why == Cause::BuildsUp
                    && cause(&t, &truth.ratio, at, at - (onset_s - DROP_AHEAD_S)) == Cause::BuildsUp
        });
        let cause = if foreseen { Cause::BuildsUp } else { Cause::Sudden };
        let intended = false;
        let end_s = last_s;
        truth.events.push(Event { kind: Kind::Drop, onset_s, end_s, intended, cause, finger_s: [None; 2] });
    }
    truth
}

fn times(trial: &Trial) -> Vec<f64> {
    let start = trial.samples.first().map_or(0.0, |s| s.t_s);
    trial.samples.iter().map(|s| s.t_s - start).collect()
}

/// Object in the gripper, averaged over five samples.
fn smoothed(trial: &Trial) -> Vec<Option<Pose<f64>>> {
    let raw: Vec<Option<Pose<f64>>> = trial
        .samples
        .iter()
        .map(|s| Some(channels::pose(s.gripper.as_ref()?).to_local(&channels::pose(s.object.as_ref()?))))
        .collect();
    (0..raw.len())
        .map(|i| {
            raw[i]?;
            let from = i.saturating_sub(HALF_WINDOW);
            let near = raw.get(from..(i + HALF_WINDOW + 1).min(raw.len()))?;
            mean_pose(near.iter().flatten().copied())
        })
        .collect()
}

/// Slip path of finger `k`: across the finger along X and Z, and the turn at its arm, m.
fn path(
    scene: &Scene<f64>,
    motion: &[Option<Pose<f64>>],
    start: &Pose<f64>,
    k: usize,
    arm_m: f64,
) -> Vec<Option<Vector3<f64>>> {
    let half = scene.object.shape.reach(&start.rotation.inverse_transform_vector(&Vector3::y()));
    let pad = Vector3::new(0.0, if k == 0 { half } else { -half }, 0.0);
    let lever = pad - start.position_m;
    motion
        .iter()
        .map(|p| {
            let p = (*p)?;
            let turn = p.rotation * start.rotation.inverse();
            let moved = p.position_m + turn.transform_vector(&lever) - pad;
            Some(Vector3::new(moved.x, moved.z, arm_m * turn.scaled_axis().y))
        })
        .collect()
}

/// Departures of one finger by `limit_m`: finger, onset, end.
pub fn slips(
    t: &[f64],
    path: &[Option<Vector3<f64>>],
    until_s: f64,
    k: usize,
    limit_m: f64,
) -> Vec<(usize, f64, f64)> {
    let mut found: Vec<(usize, f64, f64)> = Vec::new();
    let Some(mut anchor) = path.iter().flatten().next().copied() else { return found };
    let mut quiet_s = 0.0;
    let mut slipping = false;
    let mut before_s = 0.0;
    for (i, (t, q)) in t.iter().zip(path).enumerate() {
        if *t > until_s {
            break;
        }
        let Some(q) = q else { continue };
        let away = (q - anchor).norm();
        if away < NOISE_M {
            quiet_s = *t;
        }
        if !slipping && away > limit_m {
            slipping = true;
            found.push((k, quiet_s, *t));
        } else if slipping && away < NEAR_M.min(limit_m) * 0.8 {
            slipping = false;
            if let Some(last) = found.last_mut() {
                last.2 = *t;
            }
            let rested = path[(i + 1).saturating_sub(RESTED)..=i].iter().flatten();
            let (sum, count) = rested.fold((Vector3::zeros(), 0.0), |(sum, n), q| (sum + q, n + 1.0));
            anchor = sum / count;
            quiet_s = *t;
        }
        anchor += (q - anchor) * ((t - before_s) / ANCHOR_S).min(1.0);
        before_s = *t;
    }
    if slipping && let Some(last) = found.last_mut() {
        last.2 = until_s;
    }
    found
}

/// Steps of one finger that stay, less what the pads creep: from, to.
pub fn steps(t: &[f64], path: &[Option<Vector3<f64>>], until_s: f64) -> Vec<(f64, f64)> {
    let mut sums = vec![(Vector3::zeros(), 0.0)];
    for q in path {
        let (sum, count) = sums.last().copied().unwrap_or_default();
        sums.push(q.map_or((sum, count), |q| (sum + q, count + 1.0)));
    }
    let mean = |from: usize| {
        let (a, b) = (sums.get(from)?, sums.get(from + STEP_MEAN)?);
        (b.1 - a.1 > 0.5 * STEP_MEAN as f64).then(|| (b.0 - a.0) / (b.1 - a.1))
    };
    let [back, on] = STEP_GAP;
    let mut found: Vec<(f64, f64)> = Vec::new();
    for (i, t) in t.iter().enumerate().take_while(|(_, t)| **t <= until_s) {
        let Some(before) = i.checked_sub(back + STEP_MEAN) else { continue };
        let (Some(was), Some(is)) = (mean(before), mean(i + on)) else { continue };
        let creeps = [
            before.checked_sub(CREEP).and_then(mean).map(|earlier| was - earlier),
            mean(i + on + CREEP).map(|later| later - is),
        ];
        let known = creeps.iter().flatten().count().max(1) as f64;
        let creep = creeps.iter().flatten().sum::<Vector3<f64>>() / known;
        let apart = (back + on + STEP_MEAN) as f64 / CREEP as f64;
        if (is - was - creep * apart).norm() > STEP_M {
            match found.last_mut() {
                Some(last) if t - last.1 < 0.05 => last.1 = *t,
                _ => found.push((*t, *t)),
            }
        }
    }
    found
}

/// Slips of both fingers as events of the object: what overlaps is one.
fn joined(mut slips: Vec<(usize, f64, f64)>) -> Vec<(f64, f64, [Option<f64>; 2])> {
    slips.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut all: Vec<(f64, f64, [Option<f64>; 2])> = Vec::new();
    for (k, onset, end) in slips {
        match all.last_mut() {
            Some(last) if onset <= last.1 + 0.05 => {
                last.1 = last.1.max(end);
                last.2[k] = last.2[k].or(Some(onset));
            }
            _ => {
                let mut fingers = [None; 2];
                fingers[k] = Some(onset);
                all.push((onset, end, fingers));
            }
        }
    }
    all
}

/// First time at which the patches are off the face or the fingers no longer press.
fn lost(
    scene: &Scene<f64>,
    trial: &Trial,
    t: &[f64],
    motion: &[Option<Pose<f64>>],
    start: &Pose<f64>,
) -> Option<f64> {
    scene.fingers.as_ref()?;
    let shape = &scene.object.shape;
    motion.iter().zip(t).zip(&trial.samples).find_map(|((pose, t), sample)| {
        let pose = (*pose)?;
        // The pad's centre in object axes, against the object's extent there.
        let pad = pose.rotation.inverse_transform_vector(&(Vector3::zeros() - pose.position_m));
        let first = start.rotation.inverse_transform_vector(&(Vector3::zeros() - start.position_m));
        let off = [Vector3::x(), Vector3::z()].iter().any(|axis| {
            let reach = shape.reach(axis);
            pad.dot(axis).abs() > reach && first.dot(axis).abs() < reach
        });
        let grip = sample.grip_cmd_n.or(trial.info.grip_n).unwrap_or(0.0);
        let open = grip > 0.5
            && sample.finger.iter().flatten().count() == 2
            && sample.finger.iter().flatten().all(|w| w.force_n[1].abs() < 0.1 * grip);
        (off || open).then_some(*t)
    })
}

/// Samples whose mean is where the object was at the start.
const START: usize = 10;

/// Unit vector of the slide that a linear push means, world axes: the way that the gripper went
/// from its first poses to its last ones, raised by the condition's slope over the horizontal
/// (positive upwards) where the condition gives one. `None` where that is no way.
fn meant(trial: &Trial, down: &Vector3<f64>) -> Option<Vector3<f64>> {
    let grippers: Vec<Pose<f64>> =
        trial.samples.iter().filter_map(|s| s.gripper.as_ref()).map(channels::pose).collect();
    let first = mean_pose(grippers.iter().take(START).copied())?;
    let last = mean_pose(grippers.iter().rev().take(START).copied())?;
    let way = last.position_m - first.position_m;
    let Some(slope) = trial.info.slope_rad else { return way.try_normalize(SLIPPED_M) };
    let heading = (way - down * way.dot(down)).try_normalize(SLIPPED_M)?;
    Some(heading * slope.cos() - down * slope.sin())
}

/// First time at which sag or rotation is beyond its limit where that is not meant: motion of the
/// object's point that lay between the pads at the start, along gravity, in a linear push without
/// what goes along the push. By the condition and the measured poses; no plan, and nothing of the
/// predictor's, has a part in it.
fn moved(
    scene: &Scene<f64>,
    intent: Intent,
    trial: &Trial,
    t: &[f64],
    motion: &[Option<Pose<f64>>],
    limits: &Limits,
    until_s: f64,
) -> Option<f64> {
    let down = Vector3::from(scene.gravity_m_s2).try_normalize(1e-3)?;
    let meant = if intent == Intent::Slide { meant(trial, &down) } else { None };
    let start = mean_pose(motion.iter().flatten().take(START).copied())?;
    let mut sag = Sag::default();
    motion.iter().zip(t).zip(&trial.samples).take_while(|((_, t), _)| **t <= until_s).find_map(
        |((pose, t), sample)| {
            let pose = (*pose)?;
            let gripper = channels::pose(sample.gripper.as_ref()?);
            let turn = pose.rotation * start.rotation.inverse();
            let place = pose.position_m - turn * start.position_m;
            let across = meant.map_or(down, |u| down - u * u.dot(&down));
            let sag = sag.at(place, gripper.rotation.inverse_transform_vector(&across));
            let turned = pose.rotation.angle_to(&start.rotation);
            let beyond = match intent {
                Intent::Free => false,
                Intent::Pivot => sag > f64::from(limits.sag_m),
                _ => sag > f64::from(limits.sag_m) || turned > f64::from(limits.rotation_rad),
            };
            beyond.then_some(*t)
        },
    )
}

/// Sum of the steps of a place, each times the direction in force (gripper axes), in stretches in
/// which the gripper turns by less than [`Sag::TURN`]: noise counts once a stretch.
#[derive(Default)]
struct Sag {
    done_m: f64,
    stretch: Option<(Vector3<f64>, Vector3<f64>)>,
}

impl Sag {
    const TURN: f64 = 0.01;

    fn at(&mut self, place: Vector3<f64>, along: Vector3<f64>) -> f64 {
        let (from, direction) = *self.stretch.get_or_insert((place, along));
        let sag = self.done_m + direction.dot(&(place - from));
        if (along - direction).norm() > Self::TURN {
            self.done_m = sag;
            self.stretch = Some((place, along));
        }
        sag
    }
}

/// Smoothed ratio of tangential load (force and torsion at the arm) to normal force of both
/// fingers, and the tangential force alone.
fn forces(trial: &Trial, arm_m: f64) -> (Vec<f64>, Vec<f64>) {
    let rows: Vec<Option<[f64; 4]>> = trial
        .samples
        .iter()
        .map(|s| {
            let [Some(a), Some(b)] = &s.finger else { return None };
            let sum = |f: &dyn Fn(&stickslip_data::Wrench) -> f64| f(a) + f(b);
            let row = [
                sum(&|w| w.force_n[0]),
                sum(&|w| w.force_n[2]),
                sum(&|w| w.torque_nm[1]),
                a.force_n[1].abs() + b.force_n[1].abs(),
            ];
            row.iter().all(|x| x.is_finite()).then_some(row)
        })
        .collect();
    let tangential = rows.iter().map(|r| r.map_or(f64::NAN, |r| r[0].hypot(r[1]))).collect();
    let ratio = (0..rows.len())
        .map(|i| {
            let (mut sum, mut count) = ([0.0; 4], 0.0);
            for r in rows[i.saturating_sub(FORCE_WINDOW - 1)..=i].iter().flatten() {
                sum.iter_mut().zip(r).for_each(|(s, x)| *s += x);
                count += 1.0;
            }
            let torsion = if arm_m > 0.0 { sum[2] / arm_m } else { 0.0 };
            if count > 0.0 && sum[3] > 0.05 * count {
                sum[0].hypot(sum[1]).hypot(torsion) / sum[3]
            } else {
                f64::NAN
            }
        })
        .collect();
    (ratio, tangential)
}
