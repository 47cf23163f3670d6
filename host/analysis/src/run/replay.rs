//! A recorded trial through the predictor, tick by tick in `f32`, as the board does it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::Vector3;
use stickslip_shared::model::{Model, Scene};
use stickslip_shared::predictor::{
    Checked, HASH_START, Intent, Limits, MAX_SEGMENTS, ModelError, Plan, Prediction, Predictor, Segment,
    Testimony,
};
use stickslip_shared::track::Pose;
use stickslip_shared::wire;
use thiserror::Error;

use crate::channels;
use crate::run::motion::{denoised, samples_a_pose};
use crate::run::scene::{SceneError, scene};
use stickslip_data::{Description, Trial, TrialInfo};

/// Why a trial cannot be replayed.
#[derive(Debug, Error)]
pub enum ReplayError {
    /// No scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Scene or model refused.
    #[error("trial {trial}: the predictor refuses scene or model: {why:?}")]
    Refused {
        /// Trial.
        trial: String,
        /// Why.
        why: ModelError,
    },
}

/// A trial as it goes to the board: scene, plan and samples.
#[derive(Clone, Debug)]
pub struct Feed {
    /// Rig and object.
    pub scene: Scene<f32>,
    /// Derived from the gripper's measured motion.
    pub plan: Plan,
    /// The motion has more pieces than a plan holds: unlike ones were joined, and what is unexpected
    /// means little.
    pub crowded: bool,
    /// One for each recorded sample.
    pub samples: Vec<wire::Sample>,
}

/// What a replay gave.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// One for each sample.
    pub predictions: Vec<Prediction>,
    /// Hash of every output word.
    pub hash: u32,
    /// What the other formulation said of the steps; `None`: the model asks for no witness.
    pub testimony: Option<Testimony>,
}

/// Scene, plan and samples of a trial.
///
/// # Errors
/// See [`scene`].
pub fn feed(description: &Description, trial: &Trial) -> Result<Feed, SceneError> {
    let scene = scene(description, trial)?;
    let mut convert = Converter::new(trial);
    let samples = trial.samples.iter().map(|s| convert.sample(s)).collect();
    let (plan, crowded) = plan_of(trial);
    Ok(Feed { scene: scene.cast(), plan, crowded, samples })
}

/// What a trial's poses tell the predictor wrongly where they were interpolated from a lower rate to
/// the samples' times: it learns their noise from one to the next, finds next to none, and a new frame
/// is a slip. `None` where every pose is measured. Gripper and object show it both, or it is not said:
/// what swings fast in the grasp is not interpolated.
pub fn interpolated_poses(trial: &Trial) -> Option<String> {
    let known: Vec<(f64, Pose<f64>, Pose<f64>)> = trial
        .samples
        .iter()
        .filter_map(|s| {
            Some((s.t_s, channels::pose(s.gripper.as_ref()?), channels::pose(s.object.as_ref()?)))
        })
        .collect();
    let t_s: Vec<f64> = known.iter().map(|k| k.0).collect();
    let grippers: Vec<Pose<f64>> = known.iter().map(|k| k.1).collect();
    let grasped: Vec<Pose<f64>> = known.iter().map(|k| k.1.to_local(&k.2)).collect();
    let every = samples_a_pose(&t_s, &grippers).min(samples_a_pose(&t_s, &grasped));
    (every > 1).then(|| {
        "the poses are interpolated from a lower rate: the predictor underestimates their noise and may report slip \
         at each new frame. Measure poses at the samples' rate, or disregard slip that follows from them"
            .to_owned()
    })
}

/// The predictor's tick, as on a board, s.
const TICK_S: f64 = 0.004;

/// The trial as a board takes it, which has a tick of 4 ms: of a record at a higher rate every second
/// sample, or every so many (the number that is returned; one: all).
pub fn at_board_rate(mut trial: Trial) -> (Trial, usize) {
    let mut steps: Vec<f64> = trial.samples.windows(2).map(|w| w[1].t_s - w[0].t_s).collect();
    let half = steps.len() / 2;
    let step_s =
        if steps.is_empty() { TICK_S } else { *steps.select_nth_unstable_by(half, f64::total_cmp).1 };
    let every = if step_s > 0.0 { (TICK_S / step_s).round().clamp(1.0, 1e6) as usize } else { 1 };
    if every > 1 {
        let mut at = 0;
        trial.samples.retain(|_| {
            at += 1;
            (at - 1) % every == 0
        });
        trial.samples.shrink_to_fit();
    }
    (trial, every)
}

/// Runs the predictor over a trial; `ordinal` is the trial's place in its data set.
///
/// # Errors
/// No scene, or the predictor refuses scene or model.
pub fn replay(
    description: &Description,
    trial: &Trial,
    model: &Model<f64>,
    limits: Limits,
    ordinal: usize,
) -> Result<Replayed, ReplayError> {
    let feed = feed(description, trial)?;
    run(&feed, model, limits, ordinal, |_| ())
        .map_err(|why| ReplayError::Refused { trial: trial.info.trial.clone(), why })
}

/// The predictor before its first sample, in single precision as on a board: of a record, of a score, of samples as they
/// come. `ordinal` is the trial's place in its data set.
///
/// # Errors
/// The predictor refuses scene, model or limits.
pub fn ready(
    scene: Scene<f32>,
    plan: Plan,
    model: &Model<f64>,
    limits: Limits,
    ordinal: usize,
) -> Result<Predictor<f32>, ModelError> {
    let mut predictor = Predictor::new(scene, model.cast(), limits)?;
    predictor.set_plan(plan);
    predictor.set_trial(ordinal as f32);
    Ok(predictor)
}

/// Samples from one call of `done` to the next.
const REPORTED: usize = 250;

/// Runs the predictor over what goes to the board; `done` hears how many samples were taken since
/// it was called last.
///
/// # Errors
/// The predictor refuses scene or model.
pub fn run(
    feed: &Feed,
    model: &Model<f64>,
    limits: Limits,
    ordinal: usize,
    done: impl FnMut(usize),
) -> Result<Replayed, ModelError> {
    run_tuned(feed, model, limits, &Checked::default(), ordinal, done)
}

/// [`run`] with other numbers than the default ones.
///
/// # Errors
/// The predictor refuses scene or model.
pub fn run_tuned(
    feed: &Feed,
    model: &Model<f64>,
    limits: Limits,
    tuning: &Checked<f32>,
    ordinal: usize,
    mut done: impl FnMut(usize),
) -> Result<Replayed, ModelError> {
    let mut predictor =
        ready(feed.scene.clone(), feed.plan.clone(), model, limits, ordinal)?.with_tuning(tuning);
    let mut predictions = Vec::with_capacity(feed.samples.len());
    for some in feed.samples.chunks(REPORTED) {
        predictions.extend(some.iter().map(|s| predictor.take(s)));
        done(some.len());
    }
    let hash = hash(&predictions);
    let testimony = model.witness.then(|| predictor.testimony());
    Ok(Replayed { predictions, hash, testimony })
}

/// Hash of every output word of a run.
pub fn hash<'a>(predictions: impl IntoIterator<Item = &'a Prediction>) -> u32 {
    predictions.into_iter().fold(HASH_START, |h, p| p.hash(h))
}

/// Turns recorded samples into those that go over the wire, one after the other: what is
/// commanded (grip) or fixed (pusher) holds until it is given anew; what is measured does
/// not. Time counts from the first sample.
#[derive(Clone, Debug)]
pub struct Converter {
    seq: u32,
    pub(super) start_s: f64,
    grip_n: f32,
    pusher: Option<wire::Pose>,
}

impl Converter {
    /// For the samples of `trial`.
    pub fn new(trial: &Trial) -> Self {
        Self::since(trial.samples.first().map_or(0.0, |s| s.t_s), &trial.info)
    }

    /// For samples of a trial from `start_s` on.
    pub fn since(start_s: f64, info: &TrialInfo) -> Self {
        Self {
            seq: 0,
            start_s,
            grip_n: info.grip_n.unwrap_or(0.0) as f32,
            pusher: info.pusher.as_ref().map(narrow_pose),
        }
    }

    /// Counts time from `start_s` on; what is commanded or fixed still holds.
    pub fn restart(&mut self, start_s: f64) {
        (self.seq, self.start_s) = (0, start_s);
    }

    /// The next sample. Only the first needs the object's pose.
    pub fn sample(&mut self, s: &stickslip_data::Sample) -> wire::Sample {
        self.grip_n = s.grip_cmd_n.map_or(self.grip_n, |g| g as f32);
        self.pusher = s.pusher.as_ref().map(narrow_pose).or(self.pusher);
        let seq = self.seq;
        self.seq = self.seq.wrapping_add(1);
        wire::Sample {
            seq,
            // Wraps around every 71 minutes, as a board's clock: the predictor knows.
            t_us: ((s.t_s - self.start_s) * 1e6).round() as u64 as u32,
            grip_cmd_n: self.grip_n,
            gripper: s.gripper.as_ref().map(narrow_pose),
            object: s.object.as_ref().map(narrow_pose),
            pusher: self.pusher,
            finger: s.finger.map(|w| {
                w.map(|w| {
                    let ([fx, fy, fz], [tx, ty, tz]) = (w.force_n, w.torque_nm);
                    [fx, fy, fz, tx, ty, tz].map(|x| x as f32)
                })
            }),
        }
    }
}

fn narrow_pose(pose: &stickslip_data::Pose) -> wire::Pose {
    wire::Pose {
        position_m: pose.position_m.map(|x| x as f32),
        quaternion: pose.quaternion.map(|x| x as f32),
    }
}

/// What a primitive of the format means to do with the grasp. Any other name, a user's own
/// included, means to hold the object: what is not known to be intended is flagged.
pub fn intent_of(primitive: &str) -> Intent {
    match primitive {
        "linear_push" => Intent::Slide,
        "pivot" => Intent::Pivot,
        "roll" | "planar_push" => Intent::Free,
        _ => Intent::Hold,
    }
}

/// The plan that a trial followed, counted from its first sample, as far as the gripper's
/// measured motion tells: up to eight segments of nearly constant velocity, with the intent of the
/// primitive ([`intent_of`]). The motion is the measured one without its noise ([`denoised`]): where
/// that does not move, the gripper rests, and a segment of rest intends nothing but to hold.
pub fn plan_for(trial: &Trial) -> Plan {
    plan_of(trial).0
}

/// The plan, and whether unlike pieces had to be joined for it.
fn plan_of(trial: &Trial) -> (Plan, bool) {
    let intent = intent_of(&trial.info.primitive);
    let mut moments: Vec<Moment> = {
        let mut grip_n = trial.info.grip_n.unwrap_or(0.0);
        trial
            .samples
            .iter()
            .filter_map(|s| {
                grip_n = s.grip_cmd_n.unwrap_or(grip_n);
                s.gripper.as_ref().map(|g| Moment { t_s: s.t_s, pose: channels::pose(g), grip_n })
            })
            .collect()
    };
    let t_s: Vec<f64> = moments.iter().map(|m| m.t_s).collect();
    let raw: Vec<Pose<f64>> = moments.iter().map(|m| m.pose).collect();
    for (moment, pose) in moments.iter_mut().zip(denoised(&t_s, &raw)) {
        moment.pose = pose;
    }
    let mut plan = Plan { start_s: 0.0, segments: Default::default() };
    let (pieces, crowded) = pieces(&moments);
    for (from, to) in pieces {
        let (a, b) = (&moments[from], &moments[to]);
        let rests = rests(a, b);
        let v = if rests { [0.0; 6] } else { velocity(a, b) };
        let grips = &moments[from..=to];
        let segment = Segment {
            duration_s: (b.t_s - a.t_s) as f32,
            velocity_m_s: [v[0], v[1], v[2]].map(|x| x as f32),
            angular_rad_s: [v[3], v[4], v[5]].map(|x| x as f32),
            grip_n: (grips.iter().map(|m| m.grip_n).sum::<f64>() / grips.len() as f64) as f32,
            intent: if rests { Intent::Hold } else { intent },
        };
        // `pieces` gives no more than fit.
        let _ = plan.segments.push(segment);
    }
    (plan, crowded)
}

/// Whether the denoised motion between two moments is none, but for the last digit of a file.
fn rests(a: &Moment, b: &Moment) -> bool {
    const DIGIT_M: f64 = 1e-6;
    (b.pose.position_m - a.pose.position_m).norm() < DIGIT_M
        && b.pose.rotation.angle_to(&a.pose.rotation) * ARM_M < DIGIT_M
}

/// A rotation moves the object's ends, so far away, m.
const ARM_M: f64 = 0.05;

struct Moment {
    t_s: f64,
    pose: Pose<f64>,
    grip_n: f64,
}

/// Mean velocity (m/s) and angular velocity (rad/s) between two moments, world axes.
fn velocity(a: &Moment, b: &Moment) -> [f64; 6] {
    let dt = b.t_s - a.t_s;
    let v: Vector3<f64> = (b.pose.position_m - a.pose.position_m) / dt;
    let w: Vector3<f64> = (b.pose.rotation * a.pose.rotation.inverse()).scaled_axis() / dt;
    [v.x, v.y, v.z, w.x, w.y, w.z]
}

/// Cuts the motion into at most [`MAX_SEGMENTS`] pieces: starting from slices of 40 ms,
/// the two neighbours whose velocities differ least (by path over the shorter) are joined
/// until what is left differs by more than a tenth of the largest speed and the pieces fit.
/// Rest and motion are joined only where the pieces would not fit otherwise; whether unlike ones of some length were.
fn pieces(moments: &[Moment]) -> (Vec<(usize, usize)>, bool) {
    const SLICE_S: f64 = 0.04;
    // A motion as long as a slip is to be warned ahead: joining a shorter one (a ramp of the speed)
    // misleads nobody.
    const BRIEF_S: f64 = 0.2;
    let mut cuts = vec![0];
    for (i, m) in moments.iter().enumerate() {
        if m.t_s - moments[cuts[cuts.len() - 1]].t_s >= SLICE_S {
            cuts.push(i);
        }
    }
    if cuts.len() > 1
        && let Some(last) = cuts.last_mut()
    {
        *last = moments.len() - 1;
    }
    let mut pieces: Vec<(usize, usize)> = cuts.windows(2).map(|w| (w[0], w[1])).collect();
    let speed = |v: &[f64; 6]| {
        let n = |a: &[f64]| a.iter().map(|x| x * x).sum::<f64>().sqrt();
        n(&v[..3]) + ARM_M * n(&v[3..])
    };
    let of = |p: &(usize, usize)| velocity(&moments[p.0], &moments[p.1]);
    let largest = pieces.iter().map(|p| speed(&of(p))).fold(0.0, f64::max);
    // Whether two neighbours may only be joined for room, and what the joint costs.
    let joint = |a: &(usize, usize), b: &(usize, usize)| {
        let length = |p: &(usize, usize)| moments[p.1].t_s - moments[p.0].t_s;
        let shorter = length(a).min(length(b));
        let (u, v) = (of(a), of(b));
        let apart = speed(&std::array::from_fn(|i| u[i] - v[i]));
        let rests = |p: &(usize, usize)| rests(&moments[p.0], &moments[p.1]);
        let alike = rests(a) == rests(b)
            && (apart < 0.1 * largest || shorter < 2.0 * SLICE_S && apart < 0.3 * largest);
        // Short pieces go first: a brief deviation matters less than a long one. Bits of a number
        // that is not negative are in its order.
        (!alike, (apart * shorter).abs().to_bits())
    };
    // A piece keeps its place in the list; what is joined to the one before is empty. `next` is
    // the place of its neighbour.
    let count = pieces.len();
    let mut next: Vec<usize> = (1..=count).collect();
    let mut before: Vec<Option<usize>> = (0..count).map(|k| k.checked_sub(1)).collect();
    let (mut left, mut crowded) = (count, false);
    let mut joints = BinaryHeap::new();
    let offer = |joints: &mut BinaryHeap<_>, pieces: &[(usize, usize)], k: usize, n: usize| {
        if let Some((a, b)) = pieces.get(k).zip(pieces.get(n)) {
            joints.push(Reverse((joint(a, b), k, a.1, b.1)));
        }
    };
    (0..count).for_each(|k| offer(&mut joints, &pieces, k, k + 1));
    while let Some(Reverse(((forced, _), k, middle, end))) = joints.pop() {
        let n = next[k];
        let is = |k: usize, end: usize| pieces.get(k).is_some_and(|p| p.1 == end && p.1 > p.0);
        let current = is(k, middle) && is(n, end);
        if !current {
            continue;
        }
        if forced && left <= MAX_SEGMENTS {
            break;
        }
        let length_s = |p: (usize, usize)| moments[p.1].t_s - moments[p.0].t_s;
        crowded |= forced && length_s(pieces[k]).min(length_s(pieces[n])) > BRIEF_S;
        pieces[k].1 = end;
        pieces[n] = (end, end);
        next[k] = next[n];
        left -= 1;
        if let Some(after) = before.get_mut(next[k]) {
            *after = Some(k);
        }
        offer(&mut joints, &pieces, k, next[k]);
        if let Some(first) = before[k] {
            offer(&mut joints, &pieces, first, k);
        }
    }
    pieces.retain(|p| p.1 > p.0);
    (pieces, crowded)
}

/// Where two runs part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, schemars::JsonSchema, serde::Serialize)]
pub struct Difference {
    /// Tick.
    pub tick: usize,
    /// Which word of the prediction, in the order of its message (docs/protocol.md).
    pub word: usize,
    /// Bits in the log; all ones where the replay has no such tick.
    pub logged: u32,
    /// Bits of the replay.
    pub replayed: u32,
}

/// The first logged prediction that is not the replay's, bit for bit.
pub fn first_difference(logged: &[(usize, Prediction)], replayed: &[Prediction]) -> Option<Difference> {
    logged.iter().find_map(|(tick, log)| match replayed.get(*tick) {
        None => Some(Difference { tick: *tick, word: 0, logged: u32::MAX, replayed: 0 }),
        Some(own) => log
            .words()
            .zip(own.words())
            .enumerate()
            .find(|(_, (a, b))| a != b)
            .map(|(word, (logged, replayed))| Difference { tick: *tick, word, logged, replayed }),
    })
}

/// Names of the bits of [`Prediction::flags`], in order.
pub const FLAGS: [&str; 10] = [
    "slip, finger 1",
    "slip, finger 2",
    "slip ahead, finger 1",
    "slip ahead, finger 2",
    "unexpected",
    "sag",
    "rotation",
    "drop",
    "pushing",
    "unsure",
];

/// Names of the bits of [`Prediction::validity`], in order.
pub const VALIDITY: [&str; 18] = [
    "doubt: solver",
    "doubt: model restarted at the measurement",
    "doubt: unusable sample",
    "doubt: gap in the samples",
    "doubt: no fingertip wrench",
    "doubt: no plan",
    "doubt: waiting for the object's pose",
    "doubt: contact points left out",
    "doubt: wrench not finite",
    "doubt: one finger's wrench missing",
    "doubt: wrench stuck",
    "doubt: wrench saturated",
    "doubt: wrench biased",
    "doubt: model and measurement disagree",
    "doubt: a step of the look-ahead not solved",
    "doubt: nothing foreseen yet",
    "doubt: object's pose far from the model's, frozen or held between frames",
    "solved with the cone in place of pyramids",
];

/// One stretch of time in which a bit is set.
#[derive(Clone, Debug, PartialEq, schemars::JsonSchema, serde::Serialize)]
pub struct Span {
    /// Name of the bit.
    pub flag: &'static str,
    /// Time stamp at which it rises.
    pub rises_s: f64,
    /// Time stamp at which it falls; `null`: up at the end.
    pub falls_s: Option<f64>,
    /// Ticks with it.
    pub ticks: usize,
}

/// When each bit of `word` was set, in order of rising.
pub fn spans(
    t_s: &[f64],
    predictions: &[Prediction],
    names: &[&'static str],
    word: impl Fn(&Prediction) -> u32,
) -> Vec<Span> {
    let mut out = Vec::new();
    for (bit, flag) in names.iter().enumerate() {
        let mut open: Option<Span> = None;
        for (t, p) in t_s.iter().zip(predictions) {
            let set = word(p) >> bit & 1 == 1;
            match (&mut open, set) {
                (None, true) => open = Some(Span { flag, rises_s: *t, falls_s: None, ticks: 1 }),
                (Some(span), true) => span.ticks += 1,
                (Some(span), false) => {
                    span.falls_s = Some(*t);
                    out.extend(open.take());
                }
                (None, false) => {}
            }
        }
        out.extend(open);
    }
    out.sort_by(|a, b| a.rises_s.total_cmp(&b.rises_s));
    out
}
