//! A data set from memory: what the files of a folder hold, as text and columns of numbers.
//!
//! The same checks as of files; what is refused names the table `trials.csv` or the trial, and the row.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::columns::{self, EMPTY};
use super::error::{DatasetError, Line, Problem, Warning};
use super::table::TableReader;
use super::{Dataset, Index, Trial, description, trials};

/// Columns of one trial's table.
pub struct Columns<'a> {
    /// Name of the trial.
    pub trial: &'a str,
    /// Names as in the format, and values, equally many; NaN is an empty cell.
    pub columns: Vec<(&'a str, &'a [f64])>,
}

/// A data set of `description` (the text of dataset.toml), `rows` (that of trials.csv) and a table for each
/// trial.
///
/// # Errors
/// The first thing that the format refuses; a trial without a table, a table without a trial, columns of
/// different lengths.
pub fn from_memory(
    description: &str,
    rows: &str,
    tables: &[Columns<'_>],
) -> Result<(Index, Vec<Warning>), DatasetError> {
    let (description, mut warnings) = description::parse(description, Path::new("dataset.toml"))?;
    let list = Path::new("trials.csv");
    let listed = trials::parse(rows.as_bytes(), list, &description)?;
    warnings.extend(listed.warnings);
    if let Some(error) = listed.errors.into_iter().next() {
        return Err(error);
    }
    let mut left: BTreeSet<&str> = tables.iter().map(|table| table.trial).collect();
    let mut read = Vec::with_capacity(listed.trials.len());
    for info in listed.trials {
        let Some(table) = tables.iter().find(|table| table.trial == info.trial) else {
            let problem = Problem::MissingFile("give the columns of every trial that is listed".into());
            return Err(DatasetError::of_file(place(&info.trial), problem));
        };
        left.remove(table.trial);
        let samples = samples(table, &mut warnings)?;
        read.push(Trial { info, samples });
    }
    if let Some(stranger) = left.into_iter().next() {
        return Err(DatasetError::of_file(list, Problem::NoSuchTrial(stranger.to_owned())));
    }
    Ok((Index::from(Dataset { folder: PathBuf::new(), description, trials: read }), warnings))
}

/// A rig without trials: the text of a dataset.toml, called `file` where it is refused.
///
/// # Errors
/// What the format refuses.
pub fn rig(description: &str, file: &Path) -> Result<(Index, Vec<Warning>), DatasetError> {
    let (description, warnings) = description::parse(description, file)?;
    Ok((Index::from(Dataset { folder: PathBuf::new(), description, trials: Vec::new() }), warnings))
}

/// How a table in memory is called in messages.
fn place(trial: &str) -> PathBuf {
    PathBuf::from(format!("trial {trial}"))
}

fn samples(table: &Columns<'_>, warnings: &mut Vec<Warning>) -> Result<Vec<super::Sample>, DatasetError> {
    let file = place(table.trial);
    let refuse = |problem| DatasetError::of_file(&file, problem);
    let mut reader = TableReader::new(&file);
    let known = |name: &&str| columns::position(name).is_some();
    reader.unknown_columns(table.columns.iter().map(|(name, _)| *name).filter(|name| !known(name)));
    let rows = table.columns.iter().find(|(name, _)| *name == columns::COLUMNS[0]);
    let rows = rows.ok_or_else(|| refuse(Problem::MissingColumn).column(columns::COLUMNS[0]))?.1.len();
    let mut placed = Vec::with_capacity(table.columns.len());
    for (name, values) in &table.columns {
        let Some(at) = columns::position(name) else { continue };
        if values.len() != rows {
            return Err(refuse(Problem::Length { has: values.len(), time: rows }).column(*name));
        }
        if placed.iter().any(|(other, _)| *other == at) {
            return Err(refuse(Problem::DuplicateColumn).column(*name));
        }
        placed.push((at, *values));
    }
    if rows == 0 {
        return Err(refuse(Problem::NoSamples));
    }
    reader.reserve(rows);
    for row in 0..rows {
        let at_row = |column: usize, problem| {
            let value = placed.iter().find(|(at, _)| *at == column).map(|(_, values)| values[row]);
            let error = refuse(problem).at(Line::Row(row as u64 + 1)).column(columns::COLUMNS[column]);
            value.map_or(error.clone(), |value| error.value(value.to_string()))
        };
        let mut cells = EMPTY;
        for (at, values) in &placed {
            if values[row].is_infinite() {
                return Err(at_row(*at, Problem::NonFinite));
            }
            cells[*at] = values[row];
        }
        reader.push(&cells).map_err(|bad| at_row(bad.column, bad.problem))?;
    }
    let reading = reader.finish();
    warnings.extend(reading.warnings);
    Ok(reading.samples)
}

/// A trial's filled columns, by name, empty cells as NaN.
#[must_use]
pub fn filled(trial: &Trial) -> Vec<(&'static str, Vec<f64>)> {
    let filled = super::csv_table::filled_columns(&trial.samples);
    let mut out: Vec<_> =
        filled.iter().map(|at| (columns::COLUMNS[*at], Vec::with_capacity(trial.samples.len()))).collect();
    for sample in &trial.samples {
        let cells = columns::cells(sample);
        for ((_, values), at) in out.iter_mut().zip(&filled) {
            values.push(cells[*at]);
        }
    }
    out
}
