//! Recordings as laboratories have them, brought into the format by a mapping file.
//!
//! A recording is a set of streams, each with its own file, clock, rate, units, axes and signs.
//! [`import`] cuts them into trials, turns every signal into the format's frames, and brings all on
//! one base of time ([`grid`]). What was assumed is part of the result ([`Signal`]).

mod assumed;
#[cfg(feature = "mcap")]
pub mod bag;
mod condition_columns;
pub mod conditions;
mod cut;
pub mod error;
mod filled;
pub mod frames;
pub mod grid;
pub mod guess;
mod guess_head;
mod guess_names;
pub mod mapping;
mod noise;
pub mod offset;
pub mod source;
pub mod units;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rayon::prelude::*;

use super::BadRow;
use crate::stamp::{Stamp, Zero};
use crate::{Dataset, Sample, Trial, TrialInfo, Wrench};
use assumed::{Facts, sensors, signals};
pub use assumed::{SensorFrame, Signal};
pub use error::RecordingError;
use frames::pose;
use grid::Tick;
use mapping::{Clock, Mapping, PoseColumns, WrenchColumns};
pub use offset::Offset;
use source::Source;

/// An imported recording.
#[derive(Clone, Debug)]
pub struct Import {
    /// In our format, folder not set.
    pub dataset: Dataset,
    /// What was assumed.
    pub signals: Vec<Signal>,
    /// Force sensors whose origin or axes are not ours.
    pub sensors: Vec<SensorFrame>,
    /// Trials and rows of the table that were left out, with the reason.
    pub refused: Vec<String>,
    /// By file: rows that could not be used.
    pub bad_rows: Vec<(PathBuf, BadRow)>,
    /// Mean that `tare_s` took off, N and N m, by trial and signal.
    pub tares: Vec<(String, String, [f64; 6])>,
    /// Of clocks that are `"estimated"`, by trial and stream.
    pub offsets: Vec<Offset>,
    /// Noise of sensors that the mapping does not state, taken from the data: key of `[sensors]`, SI.
    pub noise: Vec<(&'static str, f64)>,
    /// The trials follow each other as their time stamps do; otherwise as their names or the table do, because the first
    /// stream's clock starts anew in each of them.
    pub in_time_order: bool,
}

/// Reads the mapping at `path` and all recordings that it names.
///
/// # Errors
/// A mapping that cannot be used, a file that is missing in every trial. A trial that fails alone is in
/// [`Import::refused`].
pub fn import(path: &Path) -> Result<Import, RecordingError> {
    if source::is_recording(path) {
        let advice = format!(
            "this is a recording, not a mapping file; `stickslip new {} --out mapping.toml` begins its mapping",
            path.display()
        );
        return Err(RecordingError::Mapping { file: path.to_owned(), advice });
    }
    let text = std::fs::read_to_string(path)
        .map_err(|error| RecordingError::Io { file: path.to_owned(), error: error.to_string() })?;
    let mapping = Mapping::parse(&text, path)?;
    let recordings =
        if mapping.one_recording() { one_file_of_all(&mapping)? } else { one_file_a_trial(&mapping)? };
    let Recordings { mut trials, mut refused, bad_rows, mut offsets } = recordings;
    trials.retain_mut(|recorded| {
        let read = conditions::from_columns(&mapping, &mut recorded.info, &recorded.streams);
        read.map_err(|why| refused.push(why)).is_ok()
    });
    let in_time_order = by_time(&mut trials);
    if !mapping.one_recording() {
        offsets = estimate(&mapping, &mut trials, &mut refused);
    }
    let built: Vec<_> = trials
        .into_par_iter()
        .map(|recorded| {
            let name = recorded.info.trial.clone();
            build(&mapping, recorded).map_err(|why| format!("trial {name}: {why}"))
        })
        .collect();
    let mut dataset =
        Dataset { folder: PathBuf::new(), description: mapping.description.clone(), trials: Vec::new() };
    let mut facts = Vec::new();
    let mut tares = Vec::new();
    for result in built {
        match result {
            Ok(built) => {
                tares.extend(built.tares.into_iter().map(|(s, t)| (built.trial.info.trial.clone(), s, t)));
                dataset.trials.push(built.trial);
                facts.push(built.facts);
            }
            Err(why) => refused.push(why),
        }
    }
    if dataset.trials.is_empty() {
        let why = refused.first().cloned().unwrap_or_else(|| "no file has the name of a trial".to_owned());
        return Err(RecordingError::NoTrials { file: path.to_owned(), why });
    }
    let signals = signals(&mapping, &facts);
    let noise = noise::fill(&mut dataset);
    let sensors = sensors(&mapping);
    Ok(Import { dataset, signals, sensors, refused, bad_rows, tares, offsets, noise, in_time_order })
}

/// Brings the trials into the order in which they were recorded, where the first stream's clock ran on from one to the next:
/// what wears goes by it. Otherwise they stay as they are.
fn by_time(trials: &mut [Recorded]) -> bool {
    let span = |recorded: &Recorded| {
        let first = recorded.streams.first()?;
        let zero_s = first.zero.s();
        Some([zero_s + *first.t_s.first()?, zero_s + *first.t_s.last()?])
    };
    let mut spans: Vec<[f64; 2]> = trials.iter().filter_map(span).collect();
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let one_after_another = spans.windows(2).all(|pair| pair[0][1] < pair[1][0]);
    if one_after_another {
        trials.sort_by(|a, b| {
            let start = |recorded: &Recorded| span(recorded).map_or(f64::INFINITY, |[start, _]| start);
            start(a).total_cmp(&start(b))
        });
    }
    one_after_another
}

/// The rows of each stream of one trial, on the first stream's clock; all count from its zero.
struct Recorded {
    info: TrialInfo,
    streams: Vec<Source>,
}

#[derive(Default)]
struct Recordings {
    trials: Vec<Recorded>,
    refused: Vec<String>,
    bad_rows: Vec<(PathBuf, BadRow)>,
    /// Of clocks of the whole recording.
    offsets: Vec<Offset>,
}

/// The columns that `mapping` needs of the stream at `index`, from `file`.
fn read(mapping: &Mapping, index: usize, file: &Path) -> Result<Source, RecordingError> {
    let stream = &mapping.streams[index];
    let factor = units::Quantity::Time
        .factor(&stream.time.unit)
        .map_err(|advice| RecordingError::Mapping { file: file.to_owned(), advice })?;
    let unit_ns = (factor * 1e9).round() as i64;
    let mut names: Vec<&str> = stream.wrenches().flat_map(|(_, wrench)| wrench.columns()).collect();
    names.extend(stream.poses().flat_map(|(_, pose)| pose.columns()));
    names.extend(stream.grip.as_ref().map(|grip| grip.column.as_str()));
    names.extend(mapping.trials.cut_by.as_deref().filter(|_| index == 0));
    names.extend(mapping.condition_columns(index).map(|(_, column)| column));
    Source::read(file, stream, unit_ns, &names)
}

fn one_file_a_trial(mapping: &Mapping) -> Result<Recordings, RecordingError> {
    let first = mapping.streams.first().map_or("", |stream| stream.file.as_str());
    let only =
        Path::new(first).file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let mut files = Vec::new();
    for stream in &mapping.streams {
        let found = if stream.file.contains("{trial}") {
            conditions::files(&mapping.path, &stream.file)?
        } else {
            BTreeMap::from([(only.clone(), conditions::beside(&mapping.path, Path::new(&stream.file)))])
        };
        if found.is_empty() {
            return Err(RecordingError::Mapping {
                file: mapping.path.clone(),
                advice: format!(
                    "streams.{}.file: no file matches {:?}{}",
                    stream.name,
                    stream.file,
                    conditions::nearest(&mapping.path, &stream.file)
                ),
            });
        }
        files.push(found);
    }
    let names: BTreeSet<String> = files.iter().flat_map(|found| found.keys().cloned()).collect();
    let found = conditions::conditions(mapping, Some(&names))?;
    let mut recordings = Recordings { refused: found.refused, ..Recordings::default() };
    let read_trial = |info: TrialInfo| -> Result<(Recorded, Vec<(PathBuf, BadRow)>), String> {
        let mut streams = Vec::new();
        let mut bad = Vec::new();
        for (index, (stream, files)) in mapping.streams.iter().zip(&files).enumerate() {
            let file = files
                .get(&info.trial)
                .ok_or_else(|| format!("trial {}: no file {}", info.trial, stream.file))?;
            let mut source =
                read(mapping, index, file).map_err(|error| format!("trial {}: {error}", info.trial))?;
            bad.extend(std::mem::take(&mut source.bad_rows).into_iter().map(|row| (file.clone(), row)));
            streams.push(source);
        }
        align(mapping, &mut streams);
        Ok((Recorded { info, streams }, bad))
    };
    for read in found.trials.into_par_iter().map(read_trial).collect::<Vec<_>>() {
        match read {
            Ok((recorded, bad)) => {
                recordings.trials.push(recorded);
                recordings.bad_rows.extend(bad);
            }
            Err(why) => recordings.refused.push(why),
        }
    }
    Ok(recordings)
}

fn one_file_of_all(mapping: &Mapping) -> Result<Recordings, RecordingError> {
    let mut recordings = Recordings::default();
    let mut streams = Vec::new();
    for (index, stream) in mapping.streams.iter().enumerate() {
        let file = conditions::beside(&mapping.path, Path::new(&stream.file));
        let mut source = read(mapping, index, &file)?;
        recordings
            .bad_rows
            .extend(std::mem::take(&mut source.bad_rows).into_iter().map(|row| (file.clone(), row)));
        streams.push(source);
    }
    align(mapping, &mut streams);
    for (index, stream) in mapping.streams.iter().enumerate() {
        if stream.time.clock != Clock::Estimated {
            continue;
        }
        // By the first contact in it.
        let own = offset::of_trial(mapping, &streams, index);
        for found in offset::pooled(&stream.name, vec!["the recording".to_owned()], vec![own]) {
            let found =
                found.map_err(|advice| RecordingError::Mapping { file: mapping.path.clone(), advice })?;
            streams[index].t_s.iter_mut().for_each(|t| *t += found.offset_s);
            recordings.offsets.push(found);
        }
    }
    let mut spans: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    let cut = cut::spans(mapping, &streams)
        .map_err(|advice| RecordingError::Mapping { file: mapping.path.clone(), advice })?;
    let found = match cut {
        Some(trials) => {
            for (name, span) in trials {
                if spans.insert(name.clone(), span).is_some() {
                    recordings.refused.push(format!(
                        "trial {name}: its number occurs in two separate parts of column {:?}; the later is used",
                        mapping.trials.cut_by.as_deref().unwrap_or_default()
                    ));
                }
            }
            let names: BTreeSet<String> = spans.keys().cloned().collect();
            conditions::conditions(mapping, Some(&names))?
        }
        None => {
            let mut found = conditions::conditions(mapping, None)?;
            let zero = streams.first().map_or_else(Zero::default, |source| source.zero);
            found.trials.retain_mut(|info| {
                let mut time = |key: &str| {
                    let stamp = Stamp::parse(info.extra.remove(key)?.replace(',', ".").trim())?;
                    Some(stamp.since_s(zero, 1_000_000_000))
                };
                let span = [time("start_s"), time("end_s")];
                match span {
                    [Some(start), Some(end)] if end > start => {
                        spans.insert(info.trial.clone(), [start, end]);
                        true
                    }
                    _ => {
                        found.refused.push(format!(
                            "trial {}: needs start_s and end_s in the table, end after start",
                            info.trial
                        ));
                        false
                    }
                }
            });
            found
        }
    };
    recordings.refused.extend(found.refused);
    for info in found.trials {
        let Some([from, to]) = spans.get(&info.trial) else { continue };
        let streams = streams.iter().map(|source| source.between(*from, *to)).collect();
        recordings.trials.push(Recorded { info, streams });
    }
    Ok(recordings)
}

/// Brings the streams on the first one's clock.
fn align(mapping: &Mapping, streams: &mut [Source]) {
    let first = streams.first();
    let start = first.and_then(|source| source.t_s.first()).copied().unwrap_or(0.0);
    let zero = first.map_or_else(Zero::default, |source| source.zero);
    for (stream, source) in mapping.streams.iter().zip(streams) {
        let own = match stream.time.clock {
            // What is estimated is so from the time stamps that the mapping leaves.
            Clock::Shared | Clock::Estimated => source.zero.after_s(zero),
            Clock::StartsTogether => start - source.t_s.first().copied().unwrap_or(start),
        };
        let later_s = own + stream.time.offset_s;
        source.t_s.iter_mut().for_each(|t| *t += later_s);
        source.zero = zero;
    }
}

/// Brings the streams whose clocks are to be estimated on the first one's; trials where that cannot be are left out.
fn estimate(mapping: &Mapping, trials: &mut Vec<Recorded>, refused: &mut Vec<String>) -> Vec<Offset> {
    let mut found = Vec::new();
    for (index, stream) in mapping.streams.iter().enumerate() {
        if stream.time.clock != Clock::Estimated {
            continue;
        }
        let own: Vec<_> =
            trials.par_iter().map(|recorded| offset::of_trial(mapping, &recorded.streams, index)).collect();
        let names = trials.iter().map(|recorded| recorded.info.trial.clone()).collect();
        let offsets = offset::pooled(&stream.name, names, own);
        let mut kept = Vec::with_capacity(trials.len());
        for (mut recorded, offset) in trials.drain(..).zip(offsets) {
            match offset {
                Ok(offset) => {
                    if let Some(source) = recorded.streams.get_mut(index) {
                        source.t_s.iter_mut().for_each(|t| *t += offset.offset_s);
                    }
                    found.push(offset);
                    kept.push(recorded);
                }
                Err(why) => refused.push(format!("trial {}: {why}", recorded.info.trial)),
            }
        }
        *trials = kept;
    }
    found
}

struct Built {
    trial: Trial,
    /// By stream: median rate, how many of the rows it fills, averaged or not.
    facts: Vec<Facts>,
    tares: Vec<(String, [f64; 6])>,
}

fn build(mapping: &Mapping, recorded: Recorded) -> Result<Built, String> {
    let Recorded { mut info, streams } = recorded;
    let step_s = 1.0 / mapping.rate_hz;
    let [mut from_s, mut to_s] = [f64::NEG_INFINITY, f64::INFINITY];
    for (stream, source) in mapping.streams.iter().zip(&streams) {
        let ([first, ..], [.., last]) = (source.t_s.as_slice(), source.t_s.as_slice()) else {
            return Err(format!("stream {} has no row in it", stream.name));
        };
        from_s = from_s.max(*first);
        to_s = to_s.min(*last);
    }
    if !(to_s > from_s) {
        let spans = mapping.streams.iter().zip(&streams).map(|(stream, source)| {
            let [first, last] = [source.t_s.first(), source.t_s.last()]
                .map(|t| source.zero.s() + t.copied().unwrap_or(f64::NAN));
            format!("{} {first:.3} to {last:.3} s", stream.name)
        });
        return Err(format!(
            "its streams never run at the same time ({}); give clock = \"estimated\", \"starts_together\" or offset_s",
            spans.collect::<Vec<_>>().join(", ")
        ));
    }
    // A model needs all poses at the start: the base begins at a row of the slowest stream that has poses, where that
    // leaves cells empty.
    let slow = mapping.streams.iter().zip(&streams).filter(|(stream, _)| stream.poses().next().is_some());
    let slowest = slow.map(|(_, source)| source).max_by(|a, b| a.period_s().total_cmp(&b.period_s()));
    if let Some(source) = slowest.filter(|source| source.period_s() > 1.5 * step_s) {
        let next = source.t_s.partition_point(|t| *t < from_s);
        from_s = source.t_s.get(next).copied().filter(|t| *t < to_s).unwrap_or(from_s);
    }
    // The base of one stream at the data set's rate is its own time.
    let count = ((to_s - from_s) * mapping.rate_hz + 1e-6).floor() as usize + 1;
    let mut samples: Vec<Sample> =
        (0..count).map(|k| Sample { t_s: k as f64 * step_s, ..Sample::default() }).collect();
    let mut facts = Vec::new();
    let mut tares = Vec::new();
    for (stream, source) in mapping.streams.iter().zip(&streams) {
        let period_s = source.period_s();
        let base = grid::ticks(&source.t_s, period_s, from_s, step_s, count);
        let filled = base.iter().filter(|tick| **tick != Tick::Empty).count();
        facts.push(Facts {
            rate_hz: 1.0 / period_s,
            filled: filled as f64 / count as f64,
            averaged: base.iter().any(|tick| matches!(tick, Tick::Line { from, to, .. } if to - from > 1)),
        });
        for (name, columns) in stream.wrenches() {
            let (wrenches, tare) = wrenches(columns, source, &base, from_s)?;
            tares.extend(tare.map(|tare| (name.to_owned(), tare)));
            for (sample, wrench) in samples.iter_mut().zip(wrenches) {
                match name {
                    "finger1" => sample.finger[0] = wrench,
                    "finger2" => sample.finger[1] = wrench,
                    _ => sample.pusher_wrench = wrench,
                }
            }
        }
        for (name, columns) in stream.poses() {
            for (sample, at) in samples.iter_mut().zip(poses(columns, source, &base)?) {
                let at = at.map(|at| pose(&at));
                match name {
                    "object" => sample.object = at,
                    "gripper" => sample.gripper = at,
                    _ => sample.pusher = at,
                }
            }
        }
        if let Some(grip) = &stream.grip {
            let factor = units::Quantity::Force.factor(&grip.unit)?;
            for (sample, value) in
                samples.iter_mut().zip(grid::column(&base, &source.t_s, &source.column(&grip.column)))
            {
                sample.grip_cmd_n = (!value.is_nan()).then_some(value * factor);
            }
        }
    }
    if let Some(fixed) = &mapping.fixed.gripper {
        let at = pose(&fixed.isometry()?);
        samples.iter_mut().for_each(|sample| sample.gripper = Some(at));
    }
    if let Some(fixed) = &mapping.fixed.pusher
        && info.pusher.is_none()
    {
        info.pusher = Some(pose(&fixed.isometry()?));
    }
    Ok(Built { trial: Trial { info, samples }, facts, tares })
}

/// Wrenches on the base, with the tare that was taken off.
type Wrenches = (Vec<Option<Wrench>>, Option<[f64; 6]>);

fn wrenches(
    columns: &WrenchColumns,
    source: &Source,
    base: &[Tick],
    from_s: f64,
) -> Result<Wrenches, String> {
    let frame = columns.frame()?;
    let [force, torque] = columns.scales()?;
    let mut cells: Vec<Vec<f64>> = columns.columns().iter().map(|name| source.column(name)).collect();
    let mut tare = None;
    if let Some([from, to]) = columns.tare_s {
        let rows = source.between(from_s + from, from_s + to).t_s.len();
        let first = source.t_s.partition_point(|t| *t < from_s + from);
        if rows == 0 {
            return Err(format!("no row between {from} and {to} s, where tare_s looks"));
        }
        let mut means = [0.0; 6];
        for (mean, (column, factor)) in
            means.iter_mut().zip(cells.iter_mut().zip([force, force, force, torque, torque, torque]))
        {
            let sum: f64 = column[first..first + rows].iter().sum();
            let offset = sum / rows as f64;
            column.iter_mut().for_each(|cell| *cell -= offset);
            *mean = offset * factor;
        }
        tare = Some(means);
    }
    let on_base: Vec<Vec<f64>> = cells.iter().map(|cells| grid::column(base, &source.t_s, cells)).collect();
    let row = |at: usize| -> Option<Wrench> {
        let of = |column: usize| on_base[column][at];
        let wrench = frame
            .apply(Vector3::new(of(0), of(1), of(2)) * force, Vector3::new(of(3), of(4), of(5)) * torque);
        let measured = wrench.force_n.iter().chain(&wrench.torque_nm).any(|component| !component.is_nan());
        measured.then_some(wrench)
    };
    Ok(((0..base.len()).map(row).collect(), tare))
}

fn poses(
    columns: &PoseColumns,
    source: &Source,
    base: &[Tick],
) -> Result<Vec<Option<Isometry3<f64>>>, String> {
    let recorded = source.poses(columns)?;
    Ok(base
        .iter()
        .map(|tick| match *tick {
            Tick::Empty => None,
            Tick::Between { left, share } => {
                let (before, after) = (recorded.get(left)?.as_ref()?, recorded.get(left + 1)?.as_ref()?);
                before.try_lerp_slerp(after, share, 1e-9)
            }
            Tick::Line { from, to, at_s } => line(source.t_s.get(from..to)?, recorded.get(from..to)?, at_s),
        })
        .collect())
}

/// The straight line through the poses that were measured, at `at_s`; rotations by their vectors from the middle one.
fn line(t_s: &[f64], poses: &[Option<Isometry3<f64>>], at_s: f64) -> Option<Isometry3<f64>> {
    let measured: Vec<(f64, &Isometry3<f64>)> =
        t_s.iter().zip(poses).filter_map(|(t, pose)| Some((*t, pose.as_ref()?))).collect();
    let (_, middle) = measured.get(measured.len() / 2)?;
    let times: Vec<f64> = measured.iter().map(|(t, _)| *t).collect();
    let weighted = || grid::weights(&times, at_s).into_iter().zip(&measured);
    let position: Vector3<f64> = weighted().map(|(weight, (_, pose))| pose.translation.vector * weight).sum();
    let turn: Vector3<f64> = weighted()
        .map(|(weight, (_, pose))| (pose.rotation * middle.rotation.inverse()).scaled_axis() * weight)
        .sum();
    Some(Isometry3::from_parts(position.into(), UnitQuaternion::from_scaled_axis(turn) * middle.rotation))
}
