//! Rows of a trial's table, from CSV or Parquet, checked one after the other.

use std::path::{Path, PathBuf};

use super::Sample;
use super::columns::{BODIES, BadCell, COLUMNS, Cells, PartialPoses, sample};
use super::error::{DatasetError, Warning};
use super::spelling;

/// What was read of a table.
#[derive(Debug)]
pub struct TableReading {
    /// The good rows before the first bad one.
    pub samples: Vec<Sample>,
    /// The first bad row.
    pub error: Option<DatasetError>,
    /// Is the bad row the last one, as in a file that was cut? Then the rows before are a
    /// shorter trial; otherwise what follows is lost with it.
    pub cut_at_end: bool,
    /// What is worth knowing.
    pub warnings: Vec<Warning>,
}

/// Turns rows of cells into samples.
#[derive(Debug)]
pub struct TableReader {
    file: PathBuf,
    samples: Vec<Sample>,
    partial: PartialPoses,
    warnings: Vec<Warning>,
}

impl TableReader {
    /// For the table in `file`.
    #[must_use]
    pub fn new(file: &Path) -> Self {
        TableReader {
            file: file.to_owned(),
            samples: Vec::new(),
            partial: PartialPoses::default(),
            warnings: Vec::new(),
        }
    }

    /// Expects about this many rows.
    pub fn reserve(&mut self, rows: usize) {
        self.samples.reserve(rows);
    }

    /// Tells of columns that the format does not name.
    pub fn unknown_columns<'n>(&mut self, names: impl Iterator<Item = &'n str>) {
        let names: Vec<String> = names.map(|name| spelling::with_hint(name, &COLUMNS)).collect();
        if !names.is_empty() {
            self.warn(format!("columns that the format does not name are ignored: {}", names.join(", ")));
        }
    }

    /// A remark on this file.
    pub fn warn(&mut self, text: impl Into<String>) {
        self.warnings.push(Warning { file: self.file.clone(), files: 1, text: text.into() });
    }

    /// The next row.
    ///
    /// # Errors
    /// The cell that is refused; the reader can be used further.
    pub fn push(&mut self, row: &Cells) -> Result<(), BadCell> {
        let previous_s = self.samples.last().map(|previous| previous.t_s);
        self.samples.push(sample(row, previous_s, &mut self.partial)?);
        Ok(())
    }

    /// The end of a good table.
    #[must_use]
    pub fn finish(mut self) -> TableReading {
        for (body, rows) in BODIES.iter().zip(self.partial.rows) {
            if rows > 0 {
                self.warn(format!("the pose of the {body} is incomplete and counts as not measured"));
            }
        }
        TableReading { samples: self.samples, error: None, cut_at_end: false, warnings: self.warnings }
    }

    /// The end at a bad row, which is the `last` one or not.
    #[must_use]
    pub fn stop(self, error: DatasetError, last: bool) -> TableReading {
        TableReading { error: Some(error), cut_at_end: last, ..self.finish() }
    }
}
