//! The offset between the clocks of two devices, from what both see.
//!
//! When the pushed object touches, force and motion begin together: until then the object moves with the gripper and the
//! fingers' forces are constant; from then on the force rises, and with it, by the pads' deformation, the object's way in
//! the gripper. Each onset is the corner of the broken line, level and then straight, that fits best ([`onset`]); half
//! the range of corners that fit as well is its standard deviation. The offset is the difference of the onsets, each on
//! its own clock, at its own rate.
//!
//! Two devices that were not restarted between trials have one offset: where most trials agree within what each can
//! tell, all take the median. Otherwise each has its own.

use nalgebra::{Isometry3, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

use super::mapping::{Clock, Mapping, Stream};
use super::source::Source;
use crate::signal::onset;

/// A turn of the object counts at this arm, m.
const ARM_M: f64 = 0.03;
/// What is kept to be drawn, before and after the onset, s.
const DRAWN_S: f64 = 0.3;
/// Offsets of trials that differ by more standard deviations are not one.
const ONE: f64 = 3.0;

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

/// Rows of a signal of up to six components.
type Rows = Vec<(f64, [f64; 6])>;

/// A signal of a stream, by its number, where it has one.
type Signal<'a> = dyn Fn((usize, &Stream)) -> Result<Option<Rows>, String> + 'a;

/// What one trial says.
pub(super) struct Own {
    offset_s: f64,
    sd_s: f64,
    /// Is the stream with the estimated clock that of the forces?
    of_force: bool,
    force_s: f64,
    way_s: f64,
    force: Rows,
    way: Rows,
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
            "clock = \"estimated\" of stream {}: {what}. It needs a push whose contact both see: forces (pusher, or \
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
    let (force_s, force_sd) =
        onset(&force, 1).ok_or_else(|| advice(&format!("the force does not rise {rest}")))?;
    let (way_s, way_sd) = onset(&way, 5)
        .ok_or_else(|| advice(&format!("the object's way in the gripper does not rise {rest}")))?;
    let offset_s = if of_force { way_s - force_s } else { force_s - way_s };
    Ok(Own { offset_s, sd_s: force_sd.hypot(way_sd), of_force, force_s, way_s, force, way })
}

/// The offsets of a stream in its trials: one for all where they agree.
pub(super) fn pooled(
    stream: &str,
    trials: Vec<String>,
    own: Vec<Result<Own, String>>,
) -> Vec<Result<Offset, String>> {
    let told: Vec<&Own> = own.iter().flatten().collect();
    let of = |share: f64, of: &dyn Fn(&Own) -> f64| {
        super::super::quantile(&super::super::sorted(told.iter().map(|own| of(own))), share)
    };
    let middle_s = of(0.5, &|own| own.offset_s);
    let sd_s = of(0.5, &|own| own.sd_s);
    let scatter_s = 1.4826 * of(0.5, &|own| (own.offset_s - middle_s).abs());
    let agree = told.iter().filter(|own| (own.offset_s - middle_s).abs() <= ONE * own.sd_s.max(sd_s)).count();
    // Clocks that were started anew agree by chance alone.
    let one = agree >= 2 && 2 * agree > told.len();
    // The median of normal numbers has 1.25 times the standard error of their mean.
    let error_s = 1.25 * scatter_s.max(sd_s) / (agree.max(1) as f64).sqrt();
    trials
        .into_iter()
        .zip(own)
        .map(|(trial, own)| {
            let stream = stream.to_owned();
            let mut offset = Offset {
                trial,
                stream,
                offset_s: middle_s,
                uncertainty_s: 2.0 * error_s,
                trials: agree,
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
