//! `trials.csv`: which trials were run, under which conditions.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use super::columns::{PoseCells, pose};
use super::csv_text::CsvText;
use super::error::{DatasetError, Problem, Warning};
use super::{Description, TrialInfo, spelling};

/// Columns of trials.csv, in the format's order.
pub const COLUMNS: [&str; 17] = [
    "trial",
    "file",
    "object",
    "primitive",
    "grip_n",
    "speed_m_s",
    "speed_rad_s",
    "slope_rad",
    "pusher_offset_m",
    "run",
    "pusher_x_m",
    "pusher_y_m",
    "pusher_z_m",
    "pusher_qw",
    "pusher_qx",
    "pusher_qy",
    "pusher_qz",
];
const TRIAL: usize = 0;
const FILE: usize = 1;
const OBJECT: usize = 2;
const PRIMITIVE: usize = 3;
const GRIP: usize = 4;
const RUN: usize = 9;
const POSE: std::ops::Range<usize> = 10..17;

/// Rows of trials.csv: the good ones, the refused ones, remarks.
#[derive(Debug, Default)]
pub struct TrialRows {
    /// In the file's order.
    pub trials: Vec<TrialInfo>,
    /// One for each refused row.
    pub errors: Vec<DatasetError>,
    /// What is worth knowing.
    pub warnings: Vec<Warning>,
}

/// Reads the bytes of `file`.
///
/// # Errors
/// A header without the columns trial, object and primitive, or with a column twice. A bad row
/// is one of [`TrialRows::errors`].
pub fn parse(bytes: &[u8], file: &Path, description: &Description) -> Result<TrialRows, DatasetError> {
    let mut table = CsvText::open(bytes, file, &COLUMNS)?;
    for required in [TRIAL, OBJECT, PRIMITIVE] {
        table.require(required)?;
    }
    let extra: Vec<String> = table.unknown().map(str::to_owned).collect();
    let mut rows = TrialRows::default();
    // Further columns are welcome here; only one that looks like a slip of the pen is named.
    for (name, meant) in extra.iter().filter_map(|name| Some((name, spelling::did_you_mean(name, &COLUMNS)?)))
    {
        let text = format!("the column {name} is kept as text and not used; did you mean {meant}?");
        rows.warnings.push(Warning { file: file.to_owned(), files: 1, text });
    }
    let mut names = BTreeSet::new();
    while let Some(next) = table.next_row() {
        match next.and_then(|()| row(&table, description, &extra)) {
            Ok((info, _)) if !names.insert(info.trial.clone()) => {
                rows.errors.push(table.refuse_cell(TRIAL, Problem::Duplicate));
            }
            Ok((info, warning)) => {
                rows.warnings.extend(warning.map(|text| Warning {
                    file: file.to_owned(),
                    files: 1,
                    text: format!("trial {}: {text}", info.trial),
                }));
                rows.trials.push(info);
            }
            Err(error) => rows.errors.push(error),
        }
    }
    Ok(rows)
}

fn row(
    table: &CsvText<'_>,
    description: &Description,
    extra: &[String],
) -> Result<(TrialInfo, Option<&'static str>), DatasetError> {
    let text = |column: usize| String::from_utf8_lossy(table.cell(column)).into_owned();
    for column in [TRIAL, OBJECT, PRIMITIVE] {
        if table.cell(column).is_empty() {
            let problem = Problem::EmptyCell("every trial needs a name, an object and a primitive");
            return Err(table.refuse_cell(column, problem));
        }
    }
    let object = text(OBJECT);
    if !description.objects.iter().any(|known| known.id == object) {
        return Err(table.refuse_cell(OBJECT, unknown_object(description)));
    }
    let mut numbers = [f64::NAN; COLUMNS.len()];
    for (column, slot) in numbers.iter_mut().enumerate().skip(GRIP) {
        *slot = table.number(column)?;
    }
    let number = |column: usize| numbers.get(column).copied().filter(|cell| !cell.is_nan());
    if number(GRIP).is_some_and(|grip| grip < 0.0) {
        return Err(table.refuse_cell(GRIP, Problem::Negative("a grip force")));
    }
    let run = match number(RUN) {
        None => None,
        // Beyond 2^53 a repetition number is a mistake, and f64 would round it.
        Some(run) if run.fract() == 0.0 && run.abs() < 9.0e15 => Some(run as i64),
        Some(_) => return Err(table.refuse_cell(RUN, Problem::NotAnInteger)),
    };
    let mut warning = None;
    let pusher = match pose(&numbers[POSE]) {
        Ok(PoseCells::Whole(pose)) => Some(pose),
        Ok(PoseCells::Absent) => None,
        Ok(PoseCells::Part) => {
            warning = Some("the pusher's pose is incomplete and counts as not known");
            None
        }
        Err(norm) => {
            return Err(table.refuse_cell(POSE.start + 3, Problem::QuaternionNorm { norm }));
        }
    };
    let trial = text(TRIAL);
    let file = match text(FILE) {
        file if file.is_empty() => format!("trials/{trial}.csv"),
        file => file,
    };
    if !stays_inside(Path::new(&file)) {
        return Err(table.refuse_cell(FILE, Problem::OutsideFolder));
    }
    let info = TrialInfo {
        trial,
        file,
        object,
        primitive: text(PRIMITIVE),
        grip_n: number(GRIP),
        speed_m_s: number(5),
        speed_rad_s: number(6),
        slope_rad: number(7),
        pusher_offset_m: number(8),
        run,
        pusher,
        extra: extra
            .iter()
            .map(|name| (name.clone(), table.text(name)))
            .filter(|(_, text)| !text.is_empty())
            .collect(),
    };
    Ok((info, warning))
}

/// The problem 'unknown object', with the ids there are.
pub(super) fn unknown_object(description: &Description) -> Problem {
    let known: Vec<&str> = description.objects.iter().map(|object| object.id.as_str()).collect();
    Problem::UnknownObject { known: known.join(", ") }
}

/// A relative path without `..`.
pub(super) fn stays_inside(path: &Path) -> bool {
    path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}

/// The table of a trial: `file` in the folder, or in its `trials/`, as CSV or Parquet.
pub(super) fn table_path(folder: &Path, info: &TrialInfo) -> PathBuf {
    let named = folder.join(&info.file);
    let in_trials = folder.join("trials").join(&info.file);
    let candidates = [named.clone(), in_trials, named.with_extension("parquet"), named.with_extension("csv")];
    candidates.into_iter().find(|path| path.is_file()).unwrap_or(named)
}
