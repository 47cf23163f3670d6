//! The offset between the clocks of two devices, from what both see.
//!
//! When the pushed object touches, force and motion begin together: until then the object moves with the gripper and the
//! fingers' forces are constant; from then on the force rises, and with it, by the pads' deformation, the object's way in
//! the gripper. Each onset is the corner, level before and a curve after, that fits best. The offset is the difference of
//! the onsets, each on its own clock, at its own rate.
//!
//! What curve it is, is not known, and moves the corner in all trials alike: no number of trials averages that away.
//!
//! - The force rises with a power of the time, from 1 (an elastic contact) to 2 (one that finds its place).
//! - While the force rises, what pushes gives way as well: the object then moves in the gripper by a share of the
//!   gripper's motion, and by all of it once the force is level (it slides). With `q` the share that it lacks and `T` the
//!   time in which the force `F` rises, its way is `b (t - q T F / F_max)`.
//!
//! The share is that of what pushes (plate, pusher, its mount) in all that gives way, the pads with it. All together gives
//! way by `v T / F_max`, with `v` the gripper's speed, which is measured; what pushes by no more than a bench does
//! (`PUSHED_M_N`). So the share is small where pads are soft, and may be all where they are as hard as the plate. Where
//! the largest share that is allowed fits best, larger ones are tried as well.
//!
//! Each pair of power and share is a fit of its own, the share with the force as measured. What is told is the interval
//! over all of them by their likelihood, and of many trials by the product of their likelihoods for the same pair: where
//! the data show the curve the interval is narrow, where they do not it holds what each curve says. No contact is exactly
//! one of them: a curve is out only if the trials speak against it by more than a standard deviation each. Noise counts as
//! many samples as are independent of each other.
//!
//! Two devices that were not restarted between trials have one offset: where most trials agree within what each can
//! tell, all take the median. Otherwise each has its own.

use nalgebra::{Isometry3, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

use super::filled::{Rows, measured};
use super::mapping::{Clock, Mapping, Stream};
use super::source::Source;
use crate::signal::{Corner, Rise, least, likely};

/// A turn of the object counts at this arm, m.
const ARM_M: f64 = 0.03;
/// What is kept to be drawn, before and after the onset, s.
const DRAWN_S: f64 = 0.3;
/// Offsets of trials that differ by more standard deviations are not one.
const ONE: f64 = 3.0;
/// Powers of the time with which the force rises.
const POWERS: [f64; 4] = [1.0, 1.25, 1.5, 2.0];
/// By how much what pushes gives way, m/N: a tilted plate that touches with its edge, a plate on a robot's arm (0.12 N/um
/// and more); a load cell on a table, touched by all of its face, gives way by an eighth of it. Twice as much makes
/// intervals of soft pads up to twice as wide: an object that only moves in the gripper when it slides looks as a later
/// clock does.
const PUSHED_M_N: f64 = 8e-6;
/// Shares of the gripper's motion that are tried besides none, up to all of it.
const SHARES: usize = 10;
/// Twice the difference of the logarithms of two likelihoods that differ by two standard deviations.
const TWO_SD: f64 = 4.0;
/// A trial has no more say than this in which curve it is (three standard deviations): one may be of another kind.
const MOST: f64 = 9.0;
/// By how much a curve may fit worse in each of many trials (a standard deviation) and not be out: no contact is exactly
/// one of the curves, and what it differs by is the same in all trials. Twice as much makes intervals of 40 trials up to
/// 1.4 times as wide.
const SHAPE: f64 = 1.0;
/// Standard deviation of what is somewhere within a range of 1.
const WITHIN: f64 = 0.29;

/// How a stream's clock was brought on the first one's.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Offset {
    /// Trial.
    pub trial: String,
    /// Stream whose clock it is.
    pub stream: String,
    /// Added to its time stamps, s.
    pub offset_s: f64,
    /// Half width of the 95 % interval, s.
    pub uncertainty_s: f64,
    /// Trials that it is from: 1, or those that agree.
    pub trials: usize,
    /// Time over which the noise of the force is correlated, s: a logger interpolated the force, or it was filtered, and
    /// its onset may be early or late by as much (part of the half width). 0: it is not correlated.
    pub blurred_s: f64,
    /// What this trial alone says, and its half width, s; none: no onset in it.
    pub own_s: Option<[f64; 2]>,
    /// Onset of the force, s on the first stream's clock.
    pub contact_s: Option<f64>,
    /// Force about the onset: s on the first stream's clock, N from the rest.
    #[serde(skip)]
    pub force: Vec<[f64; 2]>,
    /// Way of the object in the gripper about the onset: s on the first stream's clock, m from the rest.
    #[serde(skip)]
    pub way: Vec<[f64; 2]>,
}

/// A signal of a stream, by its number, where it has one.
type Signal<'a> = dyn Fn((usize, &Stream)) -> Result<Option<Rows>, String> + 'a;

/// What a trial says if its onsets have one of the curves.
#[derive(Clone, Copy)]
struct OfCurve {
    offset_s: f64,
    sd_s: f64,
    /// Twice by how much less likely the logarithm is than with the best curve.
    misfit: f64,
}

/// What one trial says.
pub(super) struct Own {
    offset_s: f64,
    sd_s: f64,
    /// One for each power and share, shares of a power side by side; infinite misfits where it cannot be.
    curves: Vec<OfCurve>,
    /// The largest share that what pushes can take, of [`SHARES`].
    shares: usize,
    /// Standard deviation of what the force hides between two samples, where it jumps.
    hidden_s: f64,
    /// As [`Offset::blurred_s`].
    blurred_s: f64,
    /// Is the stream with the estimated clock that of the forces?
    of_force: bool,
    force_s: f64,
    way_s: f64,
    force: Rows,
    way: Rows,
}

/// Which signal has no onset.
enum Unseen {
    Force,
    Way,
}

impl Own {
    fn new(force: Rows, way: Rows, of_force: bool) -> Result<Self, Unseen> {
        let force = measured(&force).unwrap_or(force);
        let force_rise = Rise::of(&force, 1).ok_or(Unseen::Force)?;
        let way_rise = Rise::of(&way, 5).ok_or(Unseen::Way)?;
        let from_s = begin_s(&force_rise).ok_or(Unseen::Force)?;
        let forces = POWERS.map(|power| force_rise.corners(from_s, &|since_s| since_s.powf(power)));
        let forces = Fitted::of(&force_rise, &forces).ok_or(Unseen::Force)?;
        let from_s = begin_s(&way_rise).ok_or(Unseen::Way)?;
        let mut tried: Vec<Vec<Corner>> = Vec::with_capacity(POWERS.len() * (SHARES + 1));
        let speed_m_s = way_rise.speed();
        let mut largest = 0.0;
        for (force_s, ..) in &forces.each {
            let loading = Loading::after(&force, &force_rise, *force_s, way_rise.last_s() - from_s);
            largest = f64::max(largest, PUSHED_M_N / (loading.s_per_n * speed_m_s).max(PUSHED_M_N));
            tried.extend((0..=SHARES).map(|k| {
                let share = k as f64 / SHARES as f64;
                way_rise.corners(from_s, &|since_s| since_s - share * loading.way_s(since_s))
            }));
        }
        let ways = Fitted::of(&way_rise, &tried).ok_or(Unseen::Way)?;
        let curves: Vec<OfCurve> = ways
            .each
            .iter()
            .enumerate()
            .map(|(k, (way_s, way_sd, way_misfit))| {
                let (force_s, force_sd, force_misfit) = forces.each[k / (SHARES + 1)];
                OfCurve {
                    offset_s: if of_force { way_s - force_s } else { force_s - way_s },
                    sd_s: force_sd.hypot(*way_sd),
                    misfit: force_misfit + way_misfit,
                }
            })
            .collect();
        let shares = (largest * SHARES as f64).round() as usize;
        let of = |shares| curves.chunks(SHARES + 1).flat_map(|of| &of[..=shares]).copied().collect();
        let (offset_s, half_s) = interval(&of, shares).ok_or(Unseen::Way)?;
        let (force_s, force_sd, _) = forces.best();
        let hidden_s = force_sd.min(WITHIN * force_rise.step_s);
        let way_s = if of_force { offset_s + force_s } else { force_s - offset_s };
        let blurred_s = force_rise.blurred_s();
        let sd_s = 0.5 * (half_s + blurred_s);
        Ok(Self { offset_s, sd_s, curves, shares, hidden_s, blurred_s, of_force, force_s, way_s, force, way })
    }

    /// What it says of each curve up to a share: no more than what is likely at all, where its onsets cannot have it.
    fn up_to(&self, shares: usize) -> Vec<OfCurve> {
        let allowed = || self.curves.chunks(SHARES + 1).flat_map(|of| &of[..=shares]);
        let best = allowed().map(|of| of.misfit).fold(f64::INFINITY, f64::min);
        let own = OfCurve { offset_s: self.offset_s, sd_s: self.sd_s, misfit: MOST };
        let of = |of: &OfCurve| OfCurve { misfit: (of.misfit - best).min(MOST), ..*of };
        allowed().map(|curve| if curve.misfit.is_finite() { of(curve) } else { own }).collect()
    }
}

/// The earliest corner of a curve: before that of the straight line that fits to it, by no more than it goes on after.
fn begin_s(rise: &Rise) -> Option<f64> {
    let corners = rise.corners(rise.first_s(), &|since_s| since_s);
    let (straight_s, _) = likely(&corners, rise.variance(least(&corners)?), rise.step_s)?;
    Some(2.0 * straight_s - rise.last_s() - 4.0 * rise.step_s)
}

/// Corners of one signal by curve: place, standard deviation, misfit.
struct Fitted {
    each: Vec<(f64, f64, f64)>,
}

impl Fitted {
    fn of(rise: &Rise, curves: &[Vec<Corner>]) -> Option<Self> {
        let best = curves.iter().filter_map(|corners| least(corners)).reduce(f64::min)?;
        let variance = rise.variance(best);
        let of = |corners: &Vec<Corner>| {
            let (at_s, sd_s) = likely(corners, variance, rise.step_s)?;
            Some((at_s, sd_s, (least(corners)? - best) / variance))
        };
        let each = curves.iter().map(|corners| of(corners).unwrap_or((0.0, 0.0, f64::INFINITY))).collect();
        Some(Self { each })
    }

    fn best(&self) -> (f64, f64, f64) {
        let least = self.each.iter().copied().reduce(|a, b| if b.2 < a.2 { b } else { a });
        least.unwrap_or((0.0, 0.0, f64::INFINITY))
    }
}

/// How the force rises after its onset, as the way that the gripper makes meanwhile if all of it goes into the force.
struct Loading {
    /// Time of the motion that a newton takes, s.
    s_per_n: f64,
    step_s: f64,
    way_s: Vec<f64>,
}

impl Loading {
    /// Points of the curve.
    const POINTS: usize = 400;
    /// Below this share of its most the force is noise.
    const TOLD: f64 = 0.2;

    fn after(force: &Rows, rise: &Rise, onset_s: f64, most_s: f64) -> Self {
        let step_s = most_s / Self::POINTS as f64;
        let mut next = force.partition_point(|(t, _)| *t <= onset_s);
        let mut last = (0.0, 0.0);
        let mut way_s = Vec::with_capacity(Self::POINTS + 1);
        for k in 0..=Self::POINTS {
            let since_s = step_s * k as f64;
            while let Some((t, x)) = force.get(next).filter(|(t, _)| *t - onset_s <= since_s) {
                last = (t - onset_s, rise.distance(x));
                next += 1;
            }
            let here = force.get(next).map_or(last, |(t, x)| (t - onset_s, rise.distance(x)));
            let share = if here.0 > last.0 { (since_s - last.0) / (here.0 - last.0) } else { 0.0 };
            way_s.push((last.1 + share * (here.1 - last.1)).max(0.0));
        }
        // The object never moves against the gripper's motion: all of it is as much as the force leaves room for.
        let most_n = way_s.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let told = way_s.iter().enumerate().filter(|(_, n)| **n > Self::TOLD * most_n);
        let s_per_n = told.map(|(k, n)| step_s * k as f64 / n).fold(f64::INFINITY, f64::min);
        let s_per_n = if s_per_n.is_finite() { s_per_n } else { 0.0 };
        way_s.iter_mut().for_each(|n| *n *= s_per_n);
        Self { s_per_n, step_s, way_s }
    }

    /// In time of the gripper's motion, so long after the onset.
    fn way_s(&self, since_s: f64) -> f64 {
        let last = self.way_s.len() - 1;
        let at = (since_s / self.step_s.max(f64::MIN_POSITIVE)).min(last as f64);
        let (k, share) = (at.floor() as usize, at.fract());
        self.way_s[k] + share * (self.way_s[(k + 1).min(last)] - self.way_s[k])
    }
}

/// Middle and half width of the 95 % interval over all curves up to the share numbered `shares`: where the likelihood is
/// within two standard deviations of the greatest. Where the greatest is that of the largest share, the range was too
/// small: the next is tried too.
fn interval(of: &dyn Fn(usize) -> Vec<OfCurve>, mut shares: usize) -> Option<(f64, f64)> {
    let curves = loop {
        let curves = of(shares);
        let place = (0..curves.len()).min_by(|a, b| curves[*a].misfit.total_cmp(&curves[*b].misfit))?;
        if shares >= SHARES || place % (shares + 1) != shares {
            break curves;
        }
        shares += 1;
    };
    let best = curves.iter().map(|of| of.misfit).reduce(f64::min).filter(|best| best.is_finite())?;
    let ends = curves.iter().filter(|of| of.misfit - best <= TWO_SD).map(|of| {
        let half_s = of.sd_s * (TWO_SD - (of.misfit - best)).sqrt();
        [of.offset_s - half_s, of.offset_s + half_s]
    });
    let [low, high] = ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])?;
    Some((0.5 * (low + high), 0.5 * (high - low)))
}

/// What the trial of these `streams` says of the clock of stream `estimated`.
///
/// # Errors
/// Why it says nothing.
pub(super) fn of_trial(mapping: &Mapping, streams: &[Source], estimated: usize) -> Result<Own, String> {
    let own = &mapping.streams[estimated];
    let on_first =
        |stream: &&(usize, &Stream)| stream.0 != estimated && stream.1.time.clock != Clock::Estimated;
    let others: Vec<(usize, &Stream)> = mapping.streams.iter().enumerate().collect();
    let others: Vec<(usize, &Stream)> = others.iter().filter(on_first).copied().collect();
    let advice = |what: &str| {
        format!(
            "clock = \"estimated\" of stream {}: {what}. It needs a push whose contact both streams record: forces (pusher, or \
             fingers) by one clock, object and gripper by the other",
            own.name
        )
    };
    let force_of = |(index, stream): (usize, &Stream)| forces(stream, &streams[index]);
    let way_of = |(index, stream): (usize, &Stream)| ways(mapping, stream, &streams[index]);
    // What the first of the other streams that has it says.
    let first = |of: &Signal<'_>| others.iter().find_map(|other| of(*other).transpose()).transpose();
    let here = (estimated, own);
    let (force, way, of_force) = match (way_of(here)?, force_of(here)?) {
        (Some(way), _) => (first(&force_of)?, Some(way), false),
        (None, Some(force)) => (Some(force), first(&way_of)?, true),
        (None, None) => return Err(advice("it has neither forces nor the object with the gripper")),
    };
    let force = force.ok_or_else(|| advice("no forces by another clock"))?;
    let way = way.ok_or_else(|| advice("no object and gripper by another clock"))?;
    let rest = "from a rest of 0.05 s at the start beyond its noise";
    Own::new(force, way, of_force).map_err(|unseen| match unseen {
        Unseen::Force => advice(&format!("the force does not rise {rest}")),
        Unseen::Way => advice(&format!("the object's way in the gripper does not rise {rest}")),
    })
}

/// The offsets of a stream in its trials: one for all where they agree.
pub(super) fn pooled(
    stream: &str,
    trials: Vec<String>,
    own: Vec<Result<Own, String>>,
) -> Vec<Result<Offset, String>> {
    let told: Vec<&Own> = own.iter().flatten().collect();
    let middle = |list: &[&Own], of: &dyn Fn(&Own) -> f64| {
        super::super::quantile(&super::super::sorted(list.iter().map(|own| of(own))), 0.5)
    };
    let middle_s = middle(&told, &|own| own.offset_s);
    let sd_s = middle(&told, &|own| own.sd_s);
    let agree: Vec<&Own> = told
        .iter()
        .copied()
        .filter(|own| (own.offset_s - middle_s).abs() <= ONE * own.sd_s.max(sd_s))
        .collect();
    // Clocks that were started anew agree by chance alone.
    let one = agree.len() >= 2 && 2 * agree.len() > told.len();
    // The curve is the same in all of them, and so is the share that physics allows.
    let of_curves = |shares: usize| -> Vec<OfCurve> {
        let each: Vec<Vec<OfCurve>> = agree.iter().map(|own| own.up_to(shares)).collect();
        let middle = |of: &dyn Fn(&[OfCurve]) -> f64| {
            super::super::quantile(&super::super::sorted(each.iter().map(|own| of(own))), 0.5)
        };
        let of_curve = |k: usize| {
            let offset_s = middle(&|own| own[k].offset_s);
            let scatter_s = 1.4826 * middle(&|own| (own[k].offset_s - offset_s).abs());
            // The median of normal numbers has 1.25 times the standard error of their mean.
            let sd_s = 1.25 * scatter_s.max(middle(&|own| own[k].sd_s)) / (each.len() as f64).sqrt();
            // With the wrong share, pushes at several speeds have several offsets.
            let apart =
                |of: &OfCurve| ((of.offset_s - offset_s) / of.sd_s.max(f64::MIN_POSITIVE)).powi(2).min(MOST);
            let misfit = each.iter().map(|own| own[k].misfit + apart(&own[k])).sum();
            OfCurve { offset_s, sd_s, misfit }
        };
        let mut curves: Vec<OfCurve> = (0..POWERS.len() * (shares + 1)).map(of_curve).collect();
        let best = curves.iter().map(|of| of.misfit).fold(f64::INFINITY, f64::min);
        let others = (each.len() - 1) as f64;
        // The best stays the best, for whether it is at the end of the range.
        curves.iter_mut().filter(|of| of.misfit > best).for_each(|of| {
            of.misfit = (of.misfit - SHAPE * others).max(best + f64::EPSILON * best.abs());
        });
        curves
    };
    let shares = middle(&agree, &|own| own.shares as f64).round() as usize;
    let all = if one { interval(&of_curves, shares) } else { None };
    let (middle_s, half_s) = all.unwrap_or((middle_s, 2.0 * sd_s));
    // Motions of one program may touch at the same place between two samples each time.
    let half_s = half_s.hypot(2.0 * middle(&agree, &|own| own.hidden_s));
    // What a logger or a filter does to the force, it does in all trials alike: no scatter that squares add up.
    let blurred_s = middle(&agree, &|own| own.blurred_s);
    let half_s = half_s + blurred_s;
    let agree = agree.len();
    trials
        .into_iter()
        .zip(own)
        .map(|(trial, own)| {
            let stream = stream.to_owned();
            let mut offset = Offset {
                trial,
                stream,
                offset_s: middle_s,
                uncertainty_s: half_s,
                trials: agree,
                blurred_s,
                own_s: None,
                contact_s: None,
                force: Vec::new(),
                way: Vec::new(),
            };
            match own {
                Err(_) if one => return Ok(offset),
                Err(why) => return Err(why),
                Ok(own) => {
                    if !one {
                        (offset.offset_s, offset.uncertainty_s, offset.trials) =
                            (own.offset_s, 2.0 * own.sd_s, 1);
                        offset.blurred_s = own.blurred_s;
                    }
                    offset.own_s = Some([own.offset_s, 2.0 * own.sd_s]);
                    let [force_by, way_by] =
                        if own.of_force { [offset.offset_s, 0.0] } else { [0.0, offset.offset_s] };
                    offset.contact_s = Some(own.force_s + force_by);
                    offset.force = drawn(&own.force, own.force_s, force_by);
                    offset.way = drawn(&own.way, own.way_s, way_by);
                }
            }
            Ok(offset)
        })
        .collect()
}

/// Distance from the rest about the onset, times moved by `by_s`.
fn drawn(rows: &Rows, onset_s: f64, by_s: f64) -> Vec<[f64; 2]> {
    let rest: Vec<&[f64; 6]> =
        rows.iter().filter(|(t, _)| *t < onset_s && *t > onset_s - DRAWN_S).map(|(_, x)| x).collect();
    let base: [f64; 6] =
        std::array::from_fn(|k| rest.iter().map(|x| x[k]).sum::<f64>() / rest.len().max(1) as f64);
    let away = |x: &[f64; 6]| x.iter().zip(base).map(|(x, base)| (x - base).powi(2)).sum::<f64>().sqrt();
    rows.iter().filter(|(t, _)| (t - onset_s).abs() <= DRAWN_S).map(|(t, x)| [t + by_s, away(x)]).collect()
}

/// Force of the pusher; otherwise of both fingers together, in which the grip cancels; otherwise of one finger. N.
fn forces(stream: &Stream, source: &Source) -> Result<Option<Rows>, String> {
    let of = |name: &str| stream.wrenches().find(|(known, _)| *known == name).map(|(_, columns)| columns);
    let list = match (of("pusher"), of("finger1"), of("finger2")) {
        (Some(pusher), _, _) => vec![pusher],
        (None, one, two) => one.into_iter().chain(two).collect(),
    };
    if list.is_empty() {
        return Ok(None);
    }
    let mut sums = vec![Vector3::zeros(); source.t_s.len()];
    for columns in list {
        let (frame, [scale, _]) = (columns.frame()?, columns.scales()?);
        let cells: Vec<Vec<f64>> = columns.columns().iter().take(3).map(|name| source.column(name)).collect();
        for (row, sum) in sums.iter_mut().enumerate() {
            let at =
                |axis: usize| cells.get(axis).and_then(|cells| cells.get(row)).copied().unwrap_or(f64::NAN);
            let force = Vector3::new(at(0), at(1), at(2)) * scale;
            let wrench = frame.apply(force, Vector3::zeros());
            *sum += Vector3::from(wrench.force_n);
        }
    }
    let rows = source.t_s.iter().zip(sums).filter(|(_, sum)| sum.iter().all(|x| x.is_finite()));
    Ok(Some(rows.map(|(t, f)| (*t, [f.x, f.y, f.z, 0.0, 0.0, 0.0])).collect()))
}

/// Place and turn of the object in the gripper, m; a gripper that stands still is in no stream.
fn ways(mapping: &Mapping, stream: &Stream, source: &Source) -> Result<Option<Rows>, String> {
    let of = |name: &str| stream.poses().find(|(known, _)| *known == name).map(|(_, columns)| columns);
    let Some(object) = of("object") else { return Ok(None) };
    let gripper: Vec<Option<Isometry3<f64>>> = match (of("gripper"), &mapping.fixed.gripper) {
        (Some(columns), _) => source.poses(columns)?,
        (None, Some(fixed)) => vec![Some(fixed.isometry()?); source.t_s.len()],
        (None, None) => return Ok(None),
    };
    let object = source.poses(object)?;
    let mut rows = Rows::new();
    for (t, (gripper, object)) in source.t_s.iter().zip(gripper.into_iter().zip(object)) {
        if let Some((gripper, object)) = gripper.zip(object) {
            let held = gripper.inv_mul(&object);
            let (p, r) = (held.translation.vector, held.rotation.scaled_axis() * ARM_M);
            rows.push((*t, [p.x, p.y, p.z, r.x, r.y, r.z]));
        }
    }
    Ok(Some(rows))
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use statrs::distribution::{Binomial, DiscreteCDF};

    use super::{Own, Rows, pooled};

    /// What is not white noise and straight lines in the recordings.
    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Kind {
        Plain,
        /// The tracker's filter leaves noise whose neighbours agree by 0.8; mains hum in the forces.
        Correlated,
        /// The pusher takes a third of the motion while the force rises.
        PusherGivesWay,
        /// Pads harder than the plate: it takes two thirds of the motion.
        PlateIsSofter,
        /// The object turns on a tilted plate before it moves in the gripper, when the force is level.
        TurnsFirst,
        /// The force rises with the power 1.5 of the way.
        FindsItsPlace,
        /// Rigid pads: the force is all there within a sample.
        Rigid,
        /// A sensor at 250 Hz, stiff pads, lines from sample to sample written at 1 kHz.
        FilledUp,
        /// The same, with noise of the logger's own.
        FilledUpAndNoise,
    }

    /// Time stamps of the poses have to be moved by so much.
    const TRUTH_S: f64 = 54_509.463;

    /// A push at 10 or 20 mm/s: force at 1 kHz with 20 mN of noise, poses at 120 Hz with 30 um.
    fn push(kind: Kind, rng: &mut ChaCha8Rng) -> (Rows, Rows) {
        let contact_s = 0.4 + rng.random_range(0.0..0.05);
        let speed_m_s = if rng.random::<bool>() { 0.01 } else { 0.02 };
        let (slides_m, lacks) = match kind {
            Kind::Rigid => (5e-6, 0.0),
            Kind::PusherGivesWay => (1e-4, 0.33),
            Kind::PlateIsSofter => (6e-5, 0.67),
            Kind::TurnsFirst => (1e-4, 1.0),
            Kind::FilledUp | Kind::FilledUpAndNoise => (7e-5, 0.3),
            _ => (2e-4, 0.0),
        };
        let mut normal = |sd: f64| sd * (0..12).map(|_| rng.random::<f64>() - 0.5).sum::<f64>();
        let power = if kind == Kind::FindsItsPlace { 1.5 } else { 1.0 };
        let loaded = |t: f64| (speed_m_s * (t - contact_s).max(0.0) / slides_m).min(1.0);
        let hum = if kind == Kind::Correlated { 0.02 } else { 0.0 };
        let phase = normal(3.0);
        let force = (0..900).map(|k| {
            let t = 1e-3 * f64::from(k);
            let n = 16.0 * loaded(t).powf(power) + hum * (314.16 * t + phase).sin();
            (t, [n + normal(0.02), normal(0.02), normal(0.02), 0.0, 0.0, 0.0])
        });
        let mut force: Rows = force.collect();
        if [Kind::FilledUp, Kind::FilledUpAndNoise].contains(&kind) {
            let sensor: Rows = force.iter().step_by(4).copied().collect();
            for (k, (_, x)) in force.iter_mut().enumerate() {
                let (before, share) = (sensor[k / 4].1, 0.25 * (k % 4) as f64);
                let after = sensor.get(k / 4 + 1).map_or(before, |(_, x)| *x);
                *x = std::array::from_fn(|j| before[j] + share * (after[j] - before[j]));
                if kind == Kind::FilledUpAndNoise {
                    x.iter_mut().take(3).for_each(|x| *x += normal(0.02));
                }
            }
        }
        let begin_s = 0.004 * normal(1.0);
        let remembers: f64 = if kind == Kind::Correlated { 0.8 } else { 0.0 };
        let mut state = [0.0; 6];
        let way = (0..108).map(|k| {
            let t = begin_s + f64::from(k) / 120.0;
            for x in &mut state {
                *x = remembers * *x + (1.0 - remembers * remembers).sqrt() * normal(3e-5);
            }
            let mut row = state;
            row[0] += speed_m_s * (t - contact_s).max(0.0) - lacks * slides_m * loaded(t).powf(power);
            (t - TRUTH_S, row)
        });
        (force, way.collect())
    }

    /// Whether the interval of `trials` pushes holds the truth, and its half width, s.
    fn told(kind: Kind, seed: u64, trials: usize) -> (bool, f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let own = (0..trials).map(|_| {
            let (force, way) = push(kind, &mut rng);
            Own::new(force, way, false).map_err(|_| "no onset".to_owned())
        });
        let own: Vec<_> = own.collect();
        let found = pooled("mocap", vec![String::new(); trials], own);
        let found = found[0].as_ref().expect("an onset");
        ((found.offset_s - TRUTH_S).abs() <= found.uncertainty_s, found.uncertainty_s)
    }

    /// Asserts that of the intervals of `trials` pushes, `sets` of each kind, 85 % hold the truth or more.
    fn intervals_hold(trials: usize, sets: u64) {
        use Kind::*;
        let give_way = [PusherGivesWay, PlateIsSofter, TurnsFirst, FindsItsPlace];
        let others = [Plain, Correlated, Rigid, FilledUp, FilledUpAndNoise];
        for kind in give_way.into_iter().chain(others) {
            let all: Vec<(bool, f64)> = (0..sets).map(|seed| told(kind, seed, trials)).collect();
            let hits = all.iter().filter(|(holds, _)| *holds).count();
            let mean_s = all.iter().map(|(_, half_s)| half_s).sum::<f64>() / all.len() as f64;
            println!("{kind:?}, {trials}: {hits} of {sets}, half width {:.1} ms", 1e3 * mean_s);
            let of_85_percent = Binomial::new(0.85, sets).expect("a probability");
            // By chance no more than once in 20.
            assert!(of_85_percent.cdf(hits as u64) > 0.05, "{kind:?}, {trials}: {hits} of {sets}");
        }
    }

    #[test]
    fn the_interval_of_a_clock_holds_the_truth_whatever_the_noise_and_the_contact_of_one_push() {
        intervals_hold(1, 60);
    }

    #[test]
    fn the_interval_of_a_clock_holds_the_truth_of_a_few_pushes() {
        intervals_hold(5, 12);
    }

    #[test]
    #[ignore = "long: make test-host-rest"]
    fn the_interval_of_a_clock_holds_the_truth_however_many_pushes() {
        intervals_hold(5, 30);
        intervals_hold(40, 12);
    }
}
