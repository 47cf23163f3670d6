//! Poses and forces by one clock: when contact begins, the force rises and the object starts to
//! move in the grasp, at the same instant.
//!
//! Until the pusher touches, the object moves with the gripper. From then on its way in the
//! gripper's frame grows, first by the deformation of pads and pusher, to which the force is
//! proportional, then by slip. Where the pads are soft both begin together; where they are stiff, and what
//! carries pusher or gripper is not, the object is first seen to move when it slips, as the force has risen.
//! So the difference of the two onsets is that of the clocks and a share, between none and all, of the time in
//! which the force rises ([`Clock::rise_s`]): that share is found from trials that rise in different times, and
//! is any where they do not. The clocks' difference is equal at all speeds: what differs from
//! trial to trial in proportion to the time of the motion (play of the fingers) is not.
//!
//! Without a force sensor in the pusher the fingers show the contact: what both exert together, in
//! which the grip cancels, is the weight until then. Where nothing is pushed (a lift, a shake) the
//! force goes with the gripper's acceleration, which its pose shows tens of milliseconds later as a
//! way that grows like a power of time: no onset tells the clocks apart there.
//!
//! Which trials show it, and why others do not, is part of the report: a clock that nobody could
//! compare is not one that is right.

use schemars::JsonSchema;
use serde::Serialize;
use stickslip_data::signal::onset;
use stickslip_data::{Sample, Trial};

use super::breach::{Breach, Cause};
use crate::channels;
use crate::evidence::pose_clock::{self, Delay, OfTrial};
use crate::evidence::statistics::quantile;

/// Rotation counts at this arm, m.
const ARM_M: f64 = 0.03;
/// Offsets below this are within what filters and exposure times make, s.
const LEAST_S: f64 = 0.01;
/// Onsets farther apart have nothing to do with each other: the object moved in the grasp later
/// (a pivot that is pressed onto its edge first), s.
const MOST_S: f64 = 0.1;

/// Share of its level at which a force has risen: friction holds no more soon after.
const RISEN: f64 = 0.9;

/// By what the clocks of a trial are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Means {
    /// The pusher's force, and the object's motion in the grasp.
    PusherContact,
    /// The fingers' force, and the object's motion in the grasp.
    FingerContact,
}

impl Means {
    /// In words.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Means::PusherContact => "contact with the pusher, by its force",
            Means::FingerContact => "contact with the pusher, by the fingers' forces",
        }
    }
}

/// Why the clocks of a trial cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unknown {
    /// Nothing is pushed.
    NoContact,
    /// Neither pusher nor both fingers.
    NoForce,
    /// No gripper, or no object's pose where a contact is to be seen.
    NoPose,
    /// No rest at the start, or the force never leaves it.
    NoForceOnset,
    /// No rest at the start, or the motion never leaves it.
    NoMotionOnset,
    /// Not looked at: the trial breaks other physics.
    Unsound,
}

impl Unknown {
    /// In words.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Unknown::NoContact => {
                "nothing is pushed, and a pose shows the start of a smooth motion later than the forces do. Record one \
                 push by the same clocks"
            }
            Unknown::NoForce => "neither the pusher's force nor both fingers' forces are measured",
            Unknown::NoPose => "the poses of gripper and object are not measured",
            Unknown::NoForceOnset => {
                "the forces do not rise from a rest at the start (0.05 s) beyond their noise"
            }
            Unknown::NoMotionOnset => {
                "the motion does not rise from a rest at the start (0.05 s) beyond its noise"
            }
            Unknown::Unsound => "the data break other physics first",
        }
    }
}

/// Onsets in one trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// By what.
    pub means: Means,
    /// Onset of the motion less onset of the force: positive where the poses are late, s.
    pub lag_s: f64,
    /// Its standard deviation, s.
    pub sd_s: f64,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Time from the onset of the force until it is nearly what it is while the object slides, s.
    pub rise_s: f64,
}

/// The two onsets of a trial; `pushed`: something that stands in the way is pushed. By its `delay` the object is seen earlier: late
/// behind the gripper, it seems to move in the grasp as soon as that sets off.
///
/// # Errors
/// Why there are none.
pub fn clock(trial: &Trial, pushed: bool, delay: Option<&OfTrial>) -> Result<Clock, Unknown> {
    let rows = |of: &dyn Fn(&Sample) -> Option<[f64; 3]>| -> Vec<(f64, [f64; 6])> {
        let row = |s: &Sample| of(s).filter(|f| f.iter().all(|f| f.is_finite())).map(|f| (s.t_s, f));
        trial.samples.iter().filter_map(row).map(|(t, [x, y, z])| (t, [x, y, z, 0.0, 0.0, 0.0])).collect()
    };
    let pusher = rows(&|s| Some(s.pusher_wrench?.force_n));
    let both = |s: &Sample| -> Option<[f64; 3]> {
        let (a, b) = (s.finger[0]?.force_n, s.finger[1]?.force_n);
        Some(std::array::from_fn(|k| a[k] + b[k]))
    };
    if !pushed {
        return Err(Unknown::NoContact);
    }
    let (force, means) = match pusher.is_empty() {
        false => (pusher, Means::PusherContact),
        true => (rows(&both), Means::FingerContact),
    };
    if force.is_empty() {
        return Err(Unknown::NoForce);
    }
    let way = match delay.filter(|delay| delay.is_clear()) {
        Some(delay) => pose_clock::in_gripper(trial, delay.late_s),
        None => trial.samples.iter().filter_map(in_gripper).collect(),
    };
    if way.is_empty() {
        return Err(Unknown::NoPose);
    }
    let (force_s, force_sd) = onset(&force, 1).ok_or(Unknown::NoForceOnset)?;
    let (way_s, way_sd) = onset(&way, 5).ok_or(Unknown::NoMotionOnset)?;
    let lag_s = way_s - force_s;
    let (first_s, last_s) = (force.first().map_or(0.0, |f| f.0), force.last().map_or(0.0, |f| f.0));
    let step_s = (last_s - first_s) / force.len() as f64;
    Ok(Clock { means, lag_s, sd_s: force_sd.hypot(way_sd), step_s, rise_s: rise_s(&force, force_s) })
}

/// Time from `onset_s` until the change of a force since then is nearly its median, s.
fn rise_s(force: &[(f64, [f64; 6])], onset_s: f64) -> f64 {
    let rest: Vec<&[f64; 6]> = force.iter().take_while(|(t, _)| *t < onset_s).map(|(_, f)| f).collect();
    let mean: [f64; 3] =
        std::array::from_fn(|k| rest.iter().map(|f| f[k]).sum::<f64>() / rest.len().max(1) as f64);
    let change = |f: &[f64; 6]| (0..3).map(|k| (f[k] - mean[k]).powi(2)).sum::<f64>().sqrt();
    let after: Vec<(f64, f64)> = force.iter().skip(rest.len()).map(|(t, f)| (*t, change(f))).collect();
    let level = quantile(after.iter().map(|(_, change)| *change).collect(), 0.5).unwrap_or(0.0);
    let risen = after.iter().find(|(_, change)| *change > RISEN * level);
    risen.map_or(0.0, |(t, _)| (t - onset_s).max(0.0))
}

/// Time, and the object's place and turn in the gripper, m.
fn in_gripper(s: &Sample) -> Option<(f64, [f64; 6])> {
    let (gripper, object) = (channels::pose(&s.gripper?), channels::pose(&s.object?));
    let local = gripper.to_local(&object);
    let (p, r) = (local.position_m, local.rotation.scaled_axis() * ARM_M);
    Some((s.t_s, [p.x, p.y, p.z, r.x, r.y, r.z]))
}

/// What the trials of one primitive say of the clocks.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Clocks {
    /// Which.
    pub primitive: String,
    /// By what they were compared, and in how many trials.
    pub compared: Option<(Means, usize)>,
    /// How far the poses are behind the forces, and the half width of the 95 % interval, s.
    pub behind_s: Option<[f64; 2]>,
    /// Trials with both onsets that do not agree on one lag: the object moved in the grasp later.
    pub scattered: usize,
    /// Why others could not be compared, and in how many.
    pub unknown: Vec<(Unknown, usize)>,
}

/// Counts what is known of the trials of `primitive`, and their lag.
pub fn clocks(primitive: &str, all: &[Result<Clock, Unknown>]) -> Clocks {
    let of: Vec<Clock> = all.iter().filter_map(|c| c.ok()).collect();
    let lag = lag(&of);
    let mut unknown: Vec<(Unknown, usize)> = Vec::new();
    for why in all.iter().filter_map(|c| c.err()) {
        match unknown.iter_mut().find(|(known, _)| *known == why) {
            Some((_, count)) => *count += 1,
            None => unknown.push((why, 1)),
        }
    }
    Clocks {
        primitive: primitive.to_owned(),
        compared: of.first().zip(lag).map(|(first, lag)| (first.means, lag.trials)),
        behind_s: lag.map(|lag| [lag.middle_s, lag.half_s]),
        scattered: of.len() - lag.map_or(0, |lag| lag.trials),
        unknown,
    }
}

/// One number for the difference of the clocks.
#[derive(Clone, Copy)]
struct Lag {
    middle_s: f64,
    /// Half width of the 95 % interval.
    half_s: f64,
    trials: usize,
}

/// The clocks' difference over trials of one primitive, where it is one number.
fn lag(clocks: &[Clock]) -> Option<Lag> {
    let good: Vec<Clock> =
        clocks.iter().copied().filter(|clock| clock.sd_s < LEAST_S && clock.lag_s.abs() < MOST_S).collect();
    // Where most trials have no such onset, the others have theirs by chance.
    if 2 * good.len() <= clocks.len() {
        return None;
    }
    let quartiles = |share: f64| -> Option<[f64; 3]> {
        let of = |q: f64| quantile(good.iter().map(|c| c.lag_s - share * c.rise_s).collect(), q);
        Some([of(0.25)?, of(0.5)?, of(0.75)?])
    };
    let [low, middle, high] = quartiles(0.0)?;
    if high - low >= 0.5 * middle.abs() + LEAST_S / 2.0 {
        return None;
    }
    let count = good.len() as f64;
    let stated = good.iter().map(|clock| clock.sd_s).fold(0.0, f64::max);
    let ends = |share: f64| -> Option<[f64; 2]> {
        let [low, middle, high] = quartiles(share)?;
        // Standard error of a median of normal numbers, by their quartiles; never below what one trial
        // can tell.
        let error = (1.25 * (high - low) / 1.35).max(stated) / count.sqrt();
        // A force that jumps between two samples has its onset there, in all trials alike.
        let error = error.hypot(0.5 * good.iter().map(|clock| clock.step_s).fold(0.0, f64::max));
        Some([middle - 2.0 * error, middle + 2.0 * error])
    };
    let [least, most] = shares(&good);
    let (one, other) = (ends(least)?, ends(most)?);
    let (low, high) = (one[0].min(other[0]), one[1].max(other[1]));
    Some(Lag { middle_s: 0.5 * (low + high), half_s: 0.5 * (high - low), trials: good.len() })
}

/// Least and largest share of the force's rise that may have passed before the object was seen to move: the 95 % interval of the
/// slope of lags over rises, between none and all.
fn shares(clocks: &[Clock]) -> [f64; 2] {
    let n = clocks.len() as f64;
    let mean = |of: &dyn Fn(&Clock) -> f64| clocks.iter().map(of).sum::<f64>() / n;
    let (rise_s, lag_s) = (mean(&|c| c.rise_s), mean(&|c| c.lag_s));
    let (square, product) =
        (mean(&|c| (c.rise_s - rise_s).powi(2)), mean(&|c| (c.rise_s - rise_s) * (c.lag_s - lag_s)));
    let slope = product / square;
    let left = mean(&|c| (c.lag_s - lag_s - slope * (c.rise_s - rise_s)).powi(2));
    let error = (left / square / (n - 2.0)).sqrt();
    match slope.is_finite() && error.is_finite() {
        true => [slope - 2.0 * error, slope + 2.0 * error].map(|share| share.clamp(0.0, 1.0)),
        false => [0.0, 1.0],
    }
}

/// The delay of the object's poses behind the gripper's where it is more than filters and exposure times make.
pub fn late(delay: &Delay) -> Option<Breach> {
    let Delay { late_s, trials, .. } = *delay;
    let half_s = 2.0 * delay.sd_s;
    if late_s.abs() < LEAST_S + half_s {
        return None;
    }
    let (late, early) = if late_s > 0.0 { ("object", "gripper") } else { ("gripper", "object") };
    let text = format!(
        "the {late}'s poses are {:.1} ms behind the {early}'s (95 % interval {:.1} to {:.1} ms, {trials} trials): before anything \
         touches the object it moves with the gripper. Two trackers, or a filter on one of them? shift one of them by that time, \
         or leave it to the effect mocap_latency",
        1e3 * late_s.abs(),
        1e3 * (late_s.abs() - half_s),
        1e3 * (late_s.abs() + half_s),
    );
    Some(Breach { cause: Cause::ClockOffset, columns: "columns t_s, object_*, gripper_*".into(), text })
}

/// The clocks' difference over trials of one primitive where it is one number, and not zero.
pub fn offset(clocks: &[Clock]) -> Option<Breach> {
    let Lag { middle_s, half_s, trials } = lag(clocks)?;
    if middle_s.abs() < LEAST_S + half_s {
        return None;
    }
    let (late, early) = if middle_s > 0.0 { ("poses", "forces") } else { ("forces", "poses") };
    let cause = match middle_s > 0.0 {
        true => "Two clocks, or the delay of the motion capture? shift one of them by that time",
        // What lags behind the gripper as it sets off seems to move in the grasp before anything touches.
        false => {
            "Two clocks? shift one of them by that time. Or are the object's poses late, and the gripper's not? then the object \
             seems to move in the grasp as soon as the gripper sets off, and mocap_latency says by how much"
        }
    };
    let text = format!(
        "the {late} are {:.0} ms behind the {early} (95 % interval {:.0} to {:.0} ms, {trials} trials): at contact the \
         force rises and the object begins to move in the grasp, at one instant or while it rises. {cause}",
        1e3 * middle_s.abs(),
        1e3 * (middle_s.abs() - half_s),
        1e3 * (middle_s.abs() + half_s),
    );
    let by_pusher = clocks.iter().any(|clock| clock.means == Means::PusherContact);
    let force = if by_pusher { "pusher_f*" } else { "finger{1,2}_f*" };
    let columns = format!("columns t_s, object_*, gripper_*, {force}");
    Some(Breach { cause: Cause::ClockOffset, columns, text })
}
