//! One recording is cut into its trials: by a column that numbers them, or by what moves.

use nalgebra::{Isometry3, Point3, Vector3};

use super::mapping::{CutByMotion, Mapping, PoseColumns};
use super::source::Source;

/// A trial's name, from when to when it goes, s.
pub type Span = (String, [f64; 2]);

/// Over this time positions are averaged before and after a moment, s.
const MEAN_S: f64 = 0.05;
/// A turn counts as the way of points at this distance, m.
const ARM_M: f64 = 0.05;

/// The trials in `streams`, which run on one clock; `None` where the table tells their times.
///
/// # Errors
/// Nothing that could move, or that does.
pub fn spans(mapping: &Mapping, streams: &[Source]) -> Result<Option<Vec<Span>>, String> {
    if let Some(column) = &mapping.trials.cut_by {
        return Ok(streams.first().map(|first| by_column(&first.t_s, &first.column(column))));
    }
    mapping.trials.cut_by_motion.as_ref().map(|cut| by_motion(mapping, streams, cut)).transpose()
}

/// Spans of equal values, by the value; NaN and zero are no trial.
fn by_column(t_s: &[f64], values: &[f64]) -> Vec<Span> {
    let mut found: Vec<Span> = Vec::new();
    let mut last = f64::NAN;
    for (t, value) in t_s.iter().zip(values) {
        if !value.is_nan() && *value != 0.0 {
            match found.last_mut() {
                Some((_, span)) if last == *value => span[1] = *t,
                _ => found.push((value.to_string(), [*t, *t])),
            }
        }
        last = *value;
    }
    found
}

/// Motions of the gripper, of the object where no stream has the gripper's pose, between rests of `rest_s`; half of it belongs
/// to a trial at either end. They are numbered from 1.
fn by_motion(mapping: &Mapping, streams: &[Source], cut: &CutByMotion) -> Result<Vec<Span>, String> {
    let of = |what: &'static str| {
        let each = mapping.streams.iter().zip(streams);
        each.flat_map(|(stream, source)| stream.poses().map(move |(name, columns)| (name, columns, source)))
            .find(|(name, ..)| *name == what)
    };
    let (what, columns, source): (_, &PoseColumns, _) = of("gripper")
        .or_else(|| of("object"))
        .ok_or("trials.cut_by_motion needs the pose of the gripper or of the object in a stream")?;
    let poses = source.poses(columns)?;
    let known: Vec<(f64, Isometry3<f64>)> =
        source.t_s.iter().zip(poses).filter_map(|(t, pose)| Some((*t, pose?))).collect();
    let mut found: Vec<[f64; 2]> = Vec::new();
    for ((t, _), speed_m_s) in known.iter().zip(speeds(&known)) {
        if speed_m_s <= cut.speed_m_s {
            continue;
        }
        match found.last_mut() {
            Some(span) if t - span[1] < cut.rest_s => span[1] = *t,
            _ => found.push([*t, *t]),
        }
    }
    let named = |(k, [from, to]): (usize, [f64; 2])| {
        ((k + 1).to_string(), [from - 0.5 * cut.rest_s, to + 0.5 * cut.rest_s])
    };
    match found.is_empty() {
        true => {
            Err(format!("trials.cut_by_motion: the {what} never moves faster than {} m/s", cut.speed_m_s))
        }
        false => Ok(found.into_iter().enumerate().map(named).collect()),
    }
}

/// Speed at each moment, m/s: the way of the fastest of three points from their mean before to that after it.
fn speeds(known: &[(f64, Isometry3<f64>)]) -> Vec<f64> {
    let arms = [Vector3::zeros(), Vector3::x() * ARM_M, Vector3::z() * ARM_M];
    let mut sums = vec![[Vector3::zeros(); 3]];
    for (_, pose) in known {
        let mut sum = sums.last().copied().unwrap_or_default();
        for (sum, arm) in sum.iter_mut().zip(&arms) {
            *sum += (pose * Point3::from(*arm)).coords;
        }
        sums.push(sum);
    }
    let mean = |from: usize, to: usize, k: usize| (sums[to][k] - sums[from][k]) / (to - from) as f64;
    let at = |k: usize| {
        let t = known[k].0;
        let from = known.partition_point(|(other, _)| *other < t - MEAN_S);
        let to = known.partition_point(|(other, _)| *other <= t + MEAN_S);
        let way = |arm: usize| (mean(k, to, arm) - mean(from, k + 1, arm)).norm();
        (0..arms.len()).map(way).fold(0.0, f64::max) / MEAN_S
    };
    (0..known.len()).map(at).collect()
}
