//! Columns of a file of signals, by name, as numbers: CSV, Parquet, or a topic of an MCAP file.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::error::RecordingError;
use super::mapping::{PoseColumns, Stream};
use crate::csv_text::CsvText;
use crate::import::BadRow;
use crate::spelling;
use crate::stamp::{Stamp, Zero};

/// Rows of a file in the order of their time stamps.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// Time stamps after `zero`, s.
    pub t_s: Vec<f64>,
    /// From when on they count: the first row's, in whole units.
    pub zero: Zero,
    /// Columns by name; NaN: an empty cell.
    pub columns: BTreeMap<String, Vec<f64>>,
    /// Rows that could not be used.
    pub bad_rows: Vec<BadRow>,
}

impl Source {
    /// Reads the columns `names` and the time stamps of `stream` from `file`; these are in units of so many ns.
    ///
    /// # Errors
    /// A file that cannot be read, or without one of the columns.
    pub fn read(file: &Path, stream: &Stream, unit_ns: i64, names: &[&str]) -> Result<Self, RecordingError> {
        let file = &*recording_at(file)?;
        let mut wanted = vec![stream.time.column.as_str()];
        for name in names {
            if !name.is_empty() && !wanted.contains(name) {
                wanted.push(name);
            }
        }
        #[cfg(feature = "mcap")]
        if let Some(topic) = &stream.topic {
            let mut reading = Reading::of(&wanted, unit_ns);
            let table = super::bag::read(file, topic, stream.child_frame.as_deref())?;
            reading.table(&table.names, &table.stamps, table.rows, file)?;
            reading.bad_rows.extend(table.cut.map(|why| BadRow::new(table.messages + 1, "", why)));
            return reading.finish(file);
        }
        let io =
            |error: std::io::Error| RecordingError::Io { file: file.to_owned(), error: error.to_string() };
        let mut reading = Reading::of(&wanted, unit_ns);
        match file.extension().and_then(|extension| extension.to_str()) {
            #[cfg(feature = "parquet")]
            Some("parquet") => reading.parquet(std::fs::read(file).map_err(io)?, file)?,
            _ => reading.csv(std::fs::File::open(file).map_err(io)?, file)?,
        }
        reading.finish(file)
    }

    /// Cells of a column; all NaN for an empty name.
    #[must_use]
    pub fn column(&self, name: &str) -> Vec<f64> {
        self.columns.get(name).cloned().unwrap_or_else(|| vec![f64::NAN; self.t_s.len()])
    }

    /// Poses of every row, our frames; `None`: not measured.
    ///
    /// # Errors
    /// Axes or units that are none.
    pub fn poses(&self, columns: &PoseColumns) -> Result<Vec<Option<Isometry3<f64>>>, String> {
        let frame = columns.frame()?;
        let [length, angle] = columns.scales()?;
        let cells: Vec<Vec<f64>> = columns.columns().iter().map(|name| self.column(name)).collect();
        Ok((0..self.t_s.len())
            .map(|at| {
                let of = |column: usize| cells.get(column).map_or(f64::NAN, |cells| cells[at]);
                let position = Vector3::new(of(0), of(1), of(2)) * length;
                let rotation = if columns.quaternion_wxyz.is_some() {
                    let quaternion = nalgebra::Quaternion::new(of(3), of(4), of(5), of(6));
                    // Tracking systems write zeros for a body that they do not see.
                    ((quaternion.norm() - 1.0).abs() < 0.01)
                        .then(|| UnitQuaternion::from_quaternion(quaternion))?
                } else {
                    UnitQuaternion::from_euler_angles(of(3) * angle, of(4) * angle, of(5) * angle)
                };
                let at = frame.apply(position, rotation);
                at.to_homogeneous().iter().all(|number| number.is_finite()).then_some(at)
            })
            .collect())
    }

    /// The rows from `from_s` to `to_s`, both included.
    #[must_use]
    pub fn between(&self, from_s: f64, to_s: f64) -> Source {
        let from = self.t_s.partition_point(|t| *t < from_s);
        let to = self.t_s.partition_point(|t| *t <= to_s).max(from);
        Source {
            t_s: self.t_s[from..to].to_vec(),
            zero: self.zero,
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

/// Is there a recording at `path`, by the name's ending, or a bag's folder?
#[must_use]
pub fn is_recording(path: &Path) -> bool {
    let ends = |path: &Path, list: &[&str]| {
        let ending = path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase());
        list.contains(&ending.as_str())
    };
    let bag = |path: PathBuf| ends(&path, &["mcap", "db3"]);
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().any(|entry| bag(entry.path())),
        Err(_) => path.exists() && ends(path, &["mcap", "csv", "parquet", "db3"]),
    }
}

/// The file that holds the recording: ROS 2 writes a bag as a folder.
///
/// # Errors
/// A folder without an MCAP file or with several, and a bag in a database.
pub fn recording_at(file: &Path) -> Result<Cow<'_, Path>, RecordingError> {
    let refuse = |error: String| Err(RecordingError::Io { file: file.to_owned(), error });
    let is = |file: &Path, end: &str| file.extension().is_some_and(|extension| extension == end);
    const SQLITE: &str = "a ROS 2 bag in an SQLite database; make an MCAP file of it: ros2 bag convert";
    if is(file, "db3") {
        return refuse(SQLITE.to_owned());
    }
    let Ok(entries) = std::fs::read_dir(file) else { return Ok(Cow::Borrowed(file)) };
    let inside: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    let mut bags: Vec<&PathBuf> = inside.iter().filter(|path| is(path, "mcap")).collect();
    bags.sort();
    match bags.as_slice() {
        [bag] => Ok(Cow::Owned((*bag).clone())),
        [] if inside.iter().any(|path| is(path, "db3")) => refuse(SQLITE.to_owned()),
        [] => refuse("a folder without an MCAP file; give the file of the recording".to_owned()),
        [first, ..] => refuse(format!(
            "a folder with {} MCAP files; give one of them, as {}, or join them first: ros2 bag convert",
            bags.len(),
            first.display()
        )),
    }
}

/// Bad rows that are listed one by one; the others of a file are counted.
const LISTED: usize = 1000;

/// A file being read: of its rows only the cells that are wanted.
struct Reading<'a> {
    /// Columns; the time stamps' first.
    wanted: &'a [&'a str],
    /// Nanoseconds in a unit of these.
    unit_ns: i64,
    zero: Option<Zero>,
    t_s: Vec<f64>,
    /// By column of `wanted`.
    cells: Vec<Vec<f64>>,
    bad_rows: Vec<BadRow>,
    further_bad: usize,
}

impl<'a> Reading<'a> {
    fn of(wanted: &'a [&'a str], unit_ns: i64) -> Self {
        let cells = vec![Vec::new(); wanted.len()];
        let (t_s, bad_rows) = (Vec::new(), Vec::new());
        Reading { wanted, unit_ns, zero: None, t_s, cells, bad_rows, further_bad: 0 }
    }

    fn finish(mut self, file: &Path) -> Result<Source, RecordingError> {
        if self.t_s.is_empty() {
            let bad_rows = self.bad_rows.len() + self.further_bad;
            let first = self.bad_rows.first().map(|row| row.reason.clone());
            return Err(RecordingError::Empty { file: file.to_owned(), bad_rows, first });
        }
        if self.further_bad > 0 {
            let why = format!("and {} more rows that cannot be used", self.further_bad);
            self.bad_rows.push(BadRow::new(self.t_s.len(), "", why));
        }
        let columns = self.wanted.iter().map(|name| (*name).to_owned()).zip(self.cells).collect();
        Ok(Source { t_s: self.t_s, zero: self.zero.unwrap_or_default(), columns, bad_rows: self.bad_rows })
    }

    fn refuse(&mut self, line: usize, reason: impl Into<String>) {
        if self.bad_rows.len() < LISTED {
            self.bad_rows.push(BadRow::new(line, "", reason));
        } else {
            self.further_bad += 1;
        }
    }

    /// Rows whose cells are named by `names`; the first columns are the times of `stamps`.
    #[cfg(feature = "mcap")]
    fn table(
        &mut self,
        names: &[String],
        stamps: &[[Option<Stamp>; 3]],
        rows: Vec<Vec<f64>>,
        file: &Path,
    ) -> Result<(), RecordingError> {
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let place =
            |name: &&str| known.iter().position(|k| k == name).ok_or_else(|| missing(file, name, &known));
        let places = self.wanted.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        for (number, (row, stamps)) in (1..).zip(rows.into_iter().zip(stamps)) {
            let cells: Vec<f64> =
                places.iter().map(|place| row.get(*place).copied().unwrap_or(f64::NAN)).collect();
            let exact = places.first().and_then(|place| stamps.get(*place)).copied();
            self.push(exact.unwrap_or_else(|| cells.first().copied().and_then(Stamp::of)), &cells, number);
        }
        Ok(())
    }

    fn csv(&mut self, stream: std::fs::File, file: &Path) -> Result<(), RecordingError> {
        let wanted = self.wanted;
        let mut text = CsvText::over(stream, file, wanted)?;
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
                Err(error) => self.refuse(text.line() as usize, error.to_string()),
                Ok(()) => self.push(text.stamp(0), &row, text.line() as usize),
            }
        }
        Ok(())
    }

    #[cfg(feature = "parquet")]
    fn parquet(&mut self, bytes: Vec<u8>, file: &Path) -> Result<(), RecordingError> {
        let columns = crate::parquet_table::columns(bytes, file, self.wanted)?;
        for (column, name) in columns.found.iter().zip(self.wanted) {
            if column.is_none() {
                let known: Vec<&str> = columns.names.iter().map(String::as_str).collect();
                return Err(missing(file, name, &known));
            }
        }
        let whole = columns.whole;
        let found: Vec<Vec<f64>> = columns.found.into_iter().flatten().collect();
        let rows = found.iter().map(Vec::len).min().unwrap_or(0);
        for at in 0..rows {
            let row: Vec<f64> = found.iter().map(|column| column[at]).collect();
            let exact = whole.get(at).copied().flatten().map(Stamp::whole);
            self.push(exact.or_else(|| row.first().copied().and_then(Stamp::of)), &row, at + 1);
        }
        Ok(())
    }

    /// One row at `stamp`, which is the first of its cells too.
    fn push(&mut self, stamp: Option<Stamp>, row: &[f64], line: usize) {
        let Some(stamp) = stamp else {
            self.refuse(line, "no time stamp");
            return;
        };
        let zero = *self.zero.get_or_insert_with(|| Zero::at(stamp, self.unit_ns));
        let t_s = stamp.since_s(zero, self.unit_ns);
        if let Some(last) = self.t_s.last()
            && t_s <= *last
        {
            let reason = format!("time does not rise: {} s after {} s", zero.s() + t_s, zero.s() + last);
            self.refuse(line, reason);
            return;
        }
        self.t_s.push(t_s);
        for (column, cell) in self.cells.iter_mut().zip(row) {
            column.push(*cell);
        }
    }
}

fn missing(file: &Path, name: &str, known: &[&str]) -> RecordingError {
    let hint = spelling::did_you_mean(name, known)
        .map_or_else(|| format!("it has {}", known.join(", ")), |meant| format!("did you mean {meant:?}?"));
    RecordingError::Column { file: file.to_owned(), column: name.to_owned(), hint }
}
