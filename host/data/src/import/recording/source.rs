//! Columns of a file of signals, by name, as numbers: CSV, Parquet, or a topic of an MCAP file.

use std::collections::BTreeMap;
use std::path::Path;

use super::error::RecordingError;
use super::mapping::Stream;
use crate::csv_text::CsvText;
use crate::import::BadRow;
use crate::spelling;

/// Rows of a file in the order of their time stamps.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// Time stamps as recorded times their factor, s.
    pub t_s: Vec<f64>,
    /// Columns by name; NaN: an empty cell.
    pub columns: BTreeMap<String, Vec<f64>>,
    /// Rows that could not be used.
    pub bad_rows: Vec<BadRow>,
}

impl Source {
    /// Reads the columns `names` and the time stamps of `stream` from `file`; `factor` takes these to s.
    ///
    /// # Errors
    /// A file that cannot be read, or without one of the columns.
    pub fn read(file: &Path, stream: &Stream, factor: f64, names: &[&str]) -> Result<Self, RecordingError> {
        let mut wanted = vec![stream.time.column.as_str()];
        for name in names {
            if !name.is_empty() && !wanted.contains(name) {
                wanted.push(name);
            }
        }
        #[cfg(feature = "mcap")]
        if let Some(topic) = &stream.topic {
            let mut source = Source::of(&wanted);
            let table = super::bag::read(file, topic, stream.child_frame.as_deref())?;
            source.table(&table.names, table.rows, file, &wanted, factor)?;
            source.bad_rows.extend(table.cut.map(|why| BadRow::new(table.messages + 1, "", why)));
            return source.filled(file);
        }
        let bytes = std::fs::read(file)
            .map_err(|error| RecordingError::Io { file: file.to_owned(), error: error.to_string() })?;
        let mut source = Source::of(&wanted);
        match file.extension().and_then(|extension| extension.to_str()) {
            #[cfg(feature = "parquet")]
            Some("parquet") => source.parquet(bytes, file, &wanted, factor)?,
            _ => source.csv(&bytes, file, &wanted, factor)?,
        }
        source.filled(file)
    }

    fn of(wanted: &[&str]) -> Self {
        Source {
            columns: wanted.iter().map(|name| ((*name).to_owned(), Vec::new())).collect(),
            ..Source::default()
        }
    }

    fn filled(self, file: &Path) -> Result<Self, RecordingError> {
        if self.t_s.is_empty() {
            return Err(RecordingError::Empty { file: file.to_owned(), bad_rows: self.bad_rows.len() });
        }
        Ok(self)
    }

    /// Rows whose cells are named by `names`.
    #[cfg(feature = "mcap")]
    fn table(
        &mut self,
        names: &[String],
        rows: Vec<Vec<f64>>,
        file: &Path,
        wanted: &[&str],
        factor: f64,
    ) -> Result<(), RecordingError> {
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let place =
            |name: &&str| known.iter().position(|k| k == name).ok_or_else(|| missing(file, name, &known));
        let places = wanted.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        for (number, row) in (1..).zip(rows) {
            let cells: Vec<f64> =
                places.iter().map(|place| row.get(*place).copied().unwrap_or(f64::NAN)).collect();
            self.push(&cells, wanted, factor, number);
        }
        Ok(())
    }

    fn csv(&mut self, bytes: &[u8], file: &Path, wanted: &[&str], factor: f64) -> Result<(), RecordingError> {
        let mut text = CsvText::open(bytes, file, wanted)?;
        for (column, name) in wanted.iter().enumerate() {
            if !text.has(column) {
                let known: Vec<&str> = text.unknown().collect();
                return Err(missing(file, name, &known));
            }
        }
        let mut row = vec![f64::NAN; wanted.len()];
        while let Some(next) = text.next_row() {
            let read = next.and_then(|()| {
                for (column, cell) in row.iter_mut().enumerate() {
                    *cell = text.number(column)?;
                }
                Ok(())
            });
            match read {
                Err(error) => self.bad_rows.push(BadRow::new(text.line() as usize, "", error.to_string())),
                Ok(()) => self.push(&row, wanted, factor, text.line() as usize),
            }
        }
        Ok(())
    }

    #[cfg(feature = "parquet")]
    fn parquet(
        &mut self,
        bytes: Vec<u8>,
        file: &Path,
        wanted: &[&str],
        factor: f64,
    ) -> Result<(), RecordingError> {
        let columns = crate::parquet_table::columns(bytes, file, wanted)?;
        for (column, name) in columns.found.iter().zip(wanted) {
            if column.is_none() {
                let known: Vec<&str> = columns.names.iter().map(String::as_str).collect();
                return Err(missing(file, name, &known));
            }
        }
        let found: Vec<Vec<f64>> = columns.found.into_iter().flatten().collect();
        let rows = found.iter().map(Vec::len).min().unwrap_or(0);
        for at in 0..rows {
            let row: Vec<f64> = found.iter().map(|column| column[at]).collect();
            self.push(&row, wanted, factor, at + 1);
        }
        Ok(())
    }

    /// One row: its time stamp first.
    fn push(&mut self, row: &[f64], wanted: &[&str], factor: f64, line: usize) {
        let bad = |reason: &str| BadRow::new(line, "", reason);
        let t_s = row.first().copied().unwrap_or(f64::NAN) * factor;
        if !t_s.is_finite() {
            self.bad_rows.push(bad("no time stamp"));
            return;
        }
        if let Some(last) = self.t_s.last()
            && t_s <= *last
        {
            self.bad_rows.push(bad(&format!("time does not rise: {t_s} s after {last} s")));
            return;
        }
        self.t_s.push(t_s);
        for (name, cell) in wanted.iter().zip(row) {
            if let Some(column) = self.columns.get_mut(*name) {
                column.push(*cell);
            }
        }
    }

    /// Cells of a column; all NaN for an empty name.
    #[must_use]
    pub fn column(&self, name: &str) -> Vec<f64> {
        self.columns.get(name).cloned().unwrap_or_else(|| vec![f64::NAN; self.t_s.len()])
    }

    /// The rows from `from_s` to `to_s`, both included.
    #[must_use]
    pub fn between(&self, from_s: f64, to_s: f64) -> Source {
        let from = self.t_s.partition_point(|t| *t < from_s);
        let to = self.t_s.partition_point(|t| *t <= to_s).max(from);
        Source {
            t_s: self.t_s[from..to].to_vec(),
            columns: self
                .columns
                .iter()
                .map(|(name, cells)| (name.clone(), cells[from..to].to_vec()))
                .collect(),
            bad_rows: Vec::new(),
        }
    }

    /// Median step between time stamps, s; NaN for fewer than two.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        let steps = super::super::sorted(self.t_s.windows(2).map(|pair| pair[1] - pair[0]));
        super::super::quantile(&steps, 0.5)
    }
}

fn missing(file: &Path, name: &str, known: &[&str]) -> RecordingError {
    let hint = spelling::did_you_mean(name, known)
        .map_or_else(|| format!("it has {}", known.join(", ")), |meant| format!("did you mean {meant:?}?"));
    RecordingError::Column { file: file.to_owned(), column: name.to_owned(), hint }
}
