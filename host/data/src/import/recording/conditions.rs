//! Which trials a recording holds, and under which conditions: from the names of files, a table, or a column.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::condition_columns::factor;
use super::error::RecordingError;
use super::mapping::{Mapping, Trials};
use super::source::Source;
use crate::spelling::did_you_mean;
use crate::{TrialInfo, trials};

/// Trials that the mapping finds, and what of their description was refused.
#[derive(Debug, Default)]
pub struct Found {
    /// In order of their names, or of the table.
    pub trials: Vec<TrialInfo>,
    /// Refused rows of the table, or of names.
    pub refused: Vec<String>,
}

/// Conditions of the trials `names`; of all that the table lists where `names` is `None`.
///
/// # Errors
/// A table that cannot be read, a pattern that does not compile, an unknown column or unit.
pub fn conditions(mapping: &Mapping, names: Option<&BTreeSet<String>>) -> Result<Found, RecordingError> {
    let Mapping { trials, description, path, .. } = mapping;
    let refuse = |advice: String| RecordingError::Mapping { file: path.clone(), advice };
    let (bytes, file) = match &trials.table {
        Some(table) => {
            if trials.pattern.is_some() || !trials.constants.is_empty() {
                return Err(refuse("trials: give a table, or a pattern with constants".to_owned()));
            }
            let file = beside(path, table);
            let bytes = std::fs::read(&file)
                .map_err(|error| RecordingError::Io { file: file.clone(), error: error.to_string() })?;
            (bytes, file)
        }
        None => {
            let names = names.cloned().unwrap_or_default();
            (from_names(trials, &names).map_err(refuse)?, path.clone())
        }
    };
    let rows = trials::parse(&bytes, &file, description)?;
    let mut found = Found { trials: rows.trials, ..Found::default() };
    found.refused.extend(rows.errors.iter().map(|error| match &trials.table {
        Some(_) => error.to_string(),
        // Line numbers of a table made from names say nothing.
        None => {
            let column = error.place.column.as_deref().unwrap_or_default();
            let value = error.place.value.as_deref().unwrap_or_default();
            format!("{}, trials: {column} {value:?}: {}", file.display(), error.problem)
        }
    }));
    if let Some(names) = names {
        let (listed, others): (Vec<_>, Vec<_>) =
            found.trials.into_iter().partition(|info| names.contains(&info.trial));
        found.refused.extend(
            others.iter().map(|info| format!("{}: no recording of trial {}", file.display(), info.trial)),
        );
        let known: BTreeSet<&str> = listed.iter().map(|info| info.trial.as_str()).collect();
        if trials.table.is_some() {
            found.refused.extend(
                names
                    .iter()
                    .filter(|name| !known.contains(name.as_str()))
                    .map(|name| format!("{}: trial {name} is recorded and not in the table", file.display())),
            );
        }
        found.trials = listed;
    }
    for info in &mut found.trials {
        info.file = String::new();
    }
    Ok(found)
}

/// A trials.csv made from names of trials, read as any other.
fn from_names(trials: &Trials, names: &BTreeSet<String>) -> Result<Vec<u8>, String> {
    let pattern = match &trials.pattern {
        Some(pattern) => {
            Some(regex::Regex::new(pattern).map_err(|error| format!("trials.pattern: {error}"))?)
        }
        None => None,
    };
    let groups: Vec<&str> = pattern.iter().flat_map(|pattern| pattern.capture_names().flatten()).collect();
    for name in groups.iter().copied().chain(trials.constants.keys().map(String::as_str)) {
        if !trials::COLUMNS.contains(&name) || name == "trial" || name == "file" {
            let hint = crate::spelling::with_hint(name, &trials::COLUMNS);
            return Err(format!(
                "trials: {hint} is no condition; one of {}",
                trials::COLUMNS[2..10].join(", ")
            ));
        }
    }
    if let Some(twice) = groups.iter().find(|name| trials.constants.contains_key(**name)) {
        return Err(format!("trials: {twice} is in the pattern and in the constants"));
    }
    let mut factors = BTreeMap::new();
    for name in trials.units.keys() {
        factors.insert(name.as_str(), factor(&trials.units, name)?);
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    let constants: Vec<(&str, String)> =
        trials.constants.iter().map(|(name, value)| (name.as_str(), cell(value))).collect();
    let header = ["trial"].into_iter().chain(groups.iter().copied()).chain(constants.iter().map(|c| c.0));
    writer.write_record(header).map_err(|error| error.to_string())?;
    for name in names {
        let captures = pattern.as_ref().map(|pattern| {
            pattern.captures(name).ok_or_else(|| {
                format!("trials.pattern does not match the trial {name:?}; correct the pattern or move the file away")
            })
        });
        let captures = captures.transpose()?;
        let mut row = vec![name.clone()];
        for group in &groups {
            let text =
                captures.as_ref().and_then(|found| found.name(group)).map_or("", |found| found.as_str());
            row.push(match (factors.get(group), text.parse::<f64>()) {
                (Some(factor), Ok(number)) => (number * factor).to_string(),
                _ => text.to_owned(),
            });
        }
        row.extend(constants.iter().map(|(name, text)| match (factors.get(name), text.parse::<f64>()) {
            (Some(factor), Ok(number)) => (number * factor).to_string(),
            _ => text.clone(),
        }));
        writer.write_record(&row).map_err(|error| error.to_string())?;
    }
    writer.into_inner().map_err(|error| error.to_string())
}

/// Fills in the conditions that the trial's streams have as columns.
///
/// # Errors
/// A column without a number or with several in this trial, a value that is none of the condition, a condition that
/// the trial has from its name or the table.
pub fn from_columns(mapping: &Mapping, info: &mut TrialInfo, streams: &[Source]) -> Result<(), String> {
    for (index, (stream, source)) in mapping.streams.iter().zip(streams).enumerate() {
        for (condition, column) in mapping.condition_columns(index) {
            let file = beside(&mapping.path, Path::new(&stream.file.replace("{trial}", &info.trial)));
            let refuse = |why: String| {
                Err(format!("{}, trial {}, column {column:?}: {why}", file.display(), info.trial))
            };
            let cells = source.column(column);
            let measured = || source.t_s.iter().zip(&cells).filter(|(_, cell)| !cell.is_nan());
            let Some((_, first)) = measured().next() else {
                return refuse(format!("no number in this trial; {condition} needs one"));
            };
            if let Some((t_s, other)) = measured().find(|(_, cell)| *cell != first) {
                let after_s = t_s - source.t_s.first().unwrap_or(t_s);
                return refuse(format!(
                    "{first} at first, {other} after {after_s:.3} s; {condition} needs one value in a trial: cut the \
                     trials where it changes, or give {condition} in trials.table"
                ));
            }
            let value = first * factor(&mapping.trials.units, condition)?;
            if condition == "grip_n" && value < 0.0 {
                return refuse(format!("{value}; a grip force cannot be below zero"));
            }
            if condition == "run" && value.fract() != 0.0 {
                return refuse(format!("{value}; number the repetitions 1, 2, 3, ..."));
            }
            let twice = match condition {
                "run" => info.run.replace(value as i64).is_some(),
                "grip_n" => info.grip_n.replace(value).is_some(),
                "speed_m_s" => info.speed_m_s.replace(value).is_some(),
                "speed_rad_s" => info.speed_rad_s.replace(value).is_some(),
                "slope_rad" => info.slope_rad.replace(value).is_some(),
                _ => info.pusher_offset_m.replace(value).is_some(),
            };
            if twice {
                return refuse(format!(
                    "{condition} is in trials.columns and in the trial's name or the table"
                ));
            }
        }
    }
    Ok(())
}

fn cell(value: &toml::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// Where the files of a pattern (`raw/{trial}_ft.csv`) are looked for.
struct Place<'a> {
    /// What is listed.
    folder: PathBuf,
    /// What the pattern has before the name with the placeholder (`raw/`).
    before: &'a str,
    /// Of that name, before and after the placeholder.
    head: &'a str,
    tail: &'a str,
    /// What follows below it.
    after: PathBuf,
}

/// `None`: no placeholder.
fn place<'a>(mapping: &Path, pattern: &'a str) -> Option<Place<'a>> {
    let (start, end) = pattern.split_once("{trial}")?;
    let (before, head) = start.split_at(start.rfind('/').map_or(0, |slash| slash + 1));
    let (tail, after) = end.split_once('/').unwrap_or((end, ""));
    let folder = match beside(mapping, Path::new(before)) {
        here if here.as_os_str().is_empty() => PathBuf::from("."),
        folder => folder,
    };
    Some(Place { folder, before, head, tail, after: PathBuf::from(after) })
}

/// Names of the trials whose files exist for `pattern` (`raw/{trial}_ft.csv`), with their paths.
///
/// # Errors
/// A folder that cannot be listed.
pub fn files(mapping: &Path, pattern: &str) -> Result<BTreeMap<String, PathBuf>, RecordingError> {
    let mut found = BTreeMap::new();
    let Some(Place { folder, head, tail, after, .. }) = place(mapping, pattern) else { return Ok(found) };
    let io = |error: std::io::Error| RecordingError::Io { file: folder.clone(), error: error.to_string() };
    for entry in std::fs::read_dir(&folder).map_err(io)? {
        let name = entry.map_err(io)?.file_name().to_string_lossy().into_owned();
        let trial = name.strip_prefix(head).and_then(|rest| rest.strip_suffix(tail));
        let path =
            if after.as_os_str().is_empty() { folder.join(&name) } else { folder.join(&name).join(&after) };
        if let Some(trial) = trial.filter(|trial| !trial.is_empty())
            && path.is_file()
        {
            found.insert(trial.to_owned(), path);
        }
    }
    Ok(found)
}

/// Of what is in the folder of a pattern that no file matches, a file whose name ends nearly as the pattern: `; did you
/// mean "{trial}_mocap.csv"?`.
pub fn nearest(mapping: &Path, pattern: &str) -> String {
    let place = place(mapping, pattern).filter(|place| place.after.as_os_str().is_empty());
    let Some(Place { folder, before, head, tail, .. }) = place else { return String::new() };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let ends = names.filter_map(|name| {
        let from = name.len().checked_sub(tail.len() + 1)?;
        let alike = |k: usize| {
            let end = did_you_mean(tail, &[name.get(from + k..)?])?;
            Some((strsim::damerau_levenshtein(end, tail), end.to_owned()))
        };
        (0..=2).filter_map(alike).min()
    });
    ends.min()
        .map_or_else(String::new, |(_, end)| format!("; did you mean \"{before}{head}{{trial}}{end}\"?"))
}

/// `path` relative to the folder of the mapping.
pub fn beside(mapping: &Path, path: &Path) -> PathBuf {
    mapping.parent().unwrap_or(Path::new("")).join(path)
}
