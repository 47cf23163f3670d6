//! What can be wrong with a data set: where (file, line, column, value), what, and what to do.

use std::fmt;
use std::path::PathBuf;

/// Position in a file, as a user would look for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// Line of a text file, from 1.
    Text(u64),
    /// Row of a Parquet table, from 1.
    Row(u64),
}

/// A refusal, with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct DatasetError {
    /// Where; boxed to keep results small.
    pub place: Box<Place>,
    /// What is wrong.
    pub problem: Problem,
}

/// Where a data set is wrong.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// File with its path.
    pub file: PathBuf,
    /// Where in the file; `None` where the whole file is meant.
    pub line: Option<Line>,
    /// Column name of a table, key of the TOML file (`objects[0].mass_kg`), or column number
    /// where the file cannot be parsed.
    pub column: Option<String>,
    /// The offending text.
    pub value: Option<String>,
}

/// What is wrong, and what to do about it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// A trial that trials.csv does not list.
    #[error("no trial is named `{0}`; `stickslip check` lists them")]
    NoSuchTrial(String),
    /// Nothing to choose from.
    #[error("the data set lists no trials")]
    NoTrials,
    /// dataset.toml names another format.
    #[error("unknown format; this reader knows \"stickslip-dataset/1\" only")]
    UnknownFormat,
    /// The file is not there.
    #[error("the file is missing; {0}")]
    MissingFile(String),
    /// The operating system's answer.
    #[error("the file cannot be read or written: {0}")]
    Io(String),
    /// What is there would be mixed with what is written.
    #[error("the folder has content; choose another, or remove it")]
    FolderNotEmpty,
    /// A path that leaves the data set's folder.
    #[error("the path leaves the data set's folder; give it relative to the folder, without `..`")]
    OutsideFolder,
    /// Not TOML, or a key with a wrong type, or a key missing.
    #[error("{0}")]
    Toml(String),
    /// Not CSV (not UTF-8, a row with too few or too many cells).
    #[error("{0}")]
    Csv(String),
    /// Not Parquet, or a type that holds no number.
    #[error("{0}")]
    Parquet(String),
    /// A column that must be there.
    #[error("the column is missing; add it to the header line")]
    MissingColumn,
    /// A column twice.
    #[error("the column occurs twice; remove or rename one")]
    DuplicateColumn,
    /// Columns in memory that do not make a table.
    #[error("{has} values where t_s has {time}; give one for each sample, NaN where it was not measured")]
    Length {
        /// Values of the column.
        has: usize,
        /// Values of `t_s`.
        time: usize,
    },
    /// A cell that must be filled.
    #[error("the cell is empty; {0}")]
    EmptyCell(&'static str),
    /// A number that does not parse.
    #[error("not a number; write a decimal number, or leave the cell empty if it was not measured")]
    NotANumber,
    /// A whole number is needed.
    #[error("not a whole number; number the repetitions 1, 2, 3, ...")]
    NotAnInteger,
    /// NaN or infinity.
    #[error("not a finite number; leave the cell empty if it was not measured")]
    NonFinite,
    /// Time stamps must rise strictly.
    #[error(
        "time does not rise: the previous sample is at {previous_s} s; sort the rows and remove duplicates"
    )]
    TimeNotRising {
        /// Time stamp of the row before.
        previous_s: f64,
    },
    /// A quaternion that is none.
    #[error(
        "the quaternion's norm is {norm:.4}, off by more than 1 %; give qw,qx,qy,qz of a unit quaternion"
    )]
    QuaternionNorm {
        /// Its norm.
        norm: f64,
    },
    /// trials.csv names an object that dataset.toml lacks.
    #[error("no such object in dataset.toml, which has {known}; add an [[objects]] table or correct the id")]
    UnknownObject {
        /// The ids it has.
        known: String,
    },
    /// Below zero where that has no meaning.
    #[error("negative; {0} cannot be below zero")]
    Negative(&'static str),
    /// Zero or below where that has no meaning.
    #[error("not above zero; {0} must be positive")]
    NotPositive(&'static str),
    /// A name outside the format's list.
    #[error("unknown {what}; one of {allowed}")]
    UnknownName {
        /// What is named.
        what: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A key that the shape or contact needs.
    #[error("the key is missing; {0} needs it")]
    MissingKey(String),
    /// Two objects or trials of one name.
    #[error("the name occurs twice; names must be unique")]
    Duplicate,
    /// Geometry that makes no body.
    #[error("{0}")]
    Geometry(&'static str),
    /// Nothing in it.
    #[error("no samples in the table; a trial needs at least one")]
    NoSamples,
}

impl DatasetError {
    /// A refusal of the whole file.
    #[must_use]
    pub fn of_file(file: impl Into<PathBuf>, problem: Problem) -> Self {
        let place = Place { file: file.into(), ..Place::default() };
        DatasetError { place: Box::new(place), problem }
    }

    /// The same with a line.
    #[must_use]
    pub fn at(mut self, line: Line) -> Self {
        self.place.line = Some(line);
        self
    }

    /// The same with a column or key.
    #[must_use]
    pub fn column(mut self, column: impl Into<String>) -> Self {
        self.place.column = Some(column.into());
        self
    }

    /// The same with the offending text, shortened where it is long.
    #[must_use]
    pub fn value(mut self, value: impl Into<String>) -> Self {
        let value: String = value.into();
        let mut short: String = value.chars().take(60).collect();
        if short.len() < value.len() {
            short.push_str("...");
        }
        self.place.value = Some(short);
        self
    }
}

impl fmt::Display for DatasetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.place.file.display())?;
        match self.place.line {
            Some(Line::Text(line)) => write!(f, ", line {line}")?,
            Some(Line::Row(row)) => write!(f, ", row {row}")?,
            None => {}
        }
        if let Some(column) = &self.place.column {
            write!(f, ", column {column}")?;
        }
        if let Some(value) = &self.place.value {
            write!(f, ", value {value:?}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for DatasetError {}

/// Something worth knowing that is no error: an ignored column, a pose given in part.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, schemars::JsonSchema, serde::Serialize)]
pub struct Warning {
    /// Where it was found first.
    pub file: PathBuf,
    /// In how many files.
    pub files: usize,
    /// What.
    pub text: String,
}

/// Joins warnings of equal text: 2,760 trials with one extra column are one warning.
#[must_use]
pub fn join_warnings(warnings: impl IntoIterator<Item = Warning>) -> Vec<Warning> {
    let mut joined: Vec<Warning> = Vec::new();
    for warning in warnings {
        match joined.iter_mut().find(|known| known.text == warning.text) {
            Some(known) => known.files += warning.files,
            None => joined.push(warning),
        }
    }
    joined
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.file.display(), self.text)?;
        if self.files > 1 {
            write!(f, " (in {} files)", self.files)?;
        }
        Ok(())
    }
}
