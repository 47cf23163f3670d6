//! Writes a data set: what is written can be read again, to the same bits.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::columns::{COLUMNS as TABLE_COLUMNS, PartialPoses, cells, sample};
use super::error::{DatasetError, Line, Problem};
use super::trials::{COLUMNS, stays_inside, unknown_object};
use super::{Dataset, Description, Trial, TrialInfo, csv_table, description, parquet_table};

/// How trials are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum TableFormat {
    /// Text that anything reads.
    #[default]
    Csv,
    /// Compressed columns, smaller and faster.
    Parquet,
}

/// Writes `dataset` into `folder` with CSV tables; see [`write_as`].
///
/// # Errors
/// As [`write_as`].
pub fn write(dataset: &Dataset, folder: &Path) -> Result<(), DatasetError> {
    write_as(dataset, folder, TableFormat::Csv)
}

/// Writes `dataset` into `folder`, which is made where it is not there. Files of the same names
/// are replaced. dataset.toml comes last: a folder without it is a data set written in part.
///
/// # Errors
/// What the reader would refuse (with the place it would have), and what the file system answers.
pub fn write_as(dataset: &Dataset, folder: &Path, format: TableFormat) -> Result<(), DatasetError> {
    description::check_description(&dataset.description, folder)?;
    let infos: Vec<&TrialInfo> = dataset.trials.iter().map(|trial| &trial.info).collect();
    check_infos(&dataset.description, &infos, folder)?;
    for trial in &dataset.trials {
        check_samples(&trial.samples, &folder.join(table_file(&trial.info, TableFormat::Csv)))?;
    }
    let writer = Writer::begin(&dataset.description, folder, format)?;
    dataset
        .trials
        .par_iter()
        .map(|trial| write_table(trial, &folder.join(table_file(&trial.info, format)), format))
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Result<(), _>>()?;
    writer.finish(&infos)
}

/// A data set written trial by trial: its tables need not be in memory together. Tables may be
/// written from several threads.
#[derive(Debug)]
pub struct Writer<'a> {
    description: &'a Description,
    folder: &'a Path,
    format: TableFormat,
    toml: String,
}

impl<'a> Writer<'a> {
    /// Makes the folder; a dataset.toml that lies there is removed until [`Self::finish`].
    ///
    /// # Errors
    /// A description that the reader would refuse; what the file system answers.
    pub fn begin(
        description: &'a Description,
        folder: &'a Path,
        format: TableFormat,
    ) -> Result<Self, DatasetError> {
        description::check_description(description, folder)?;
        let file = folder.join("dataset.toml");
        let toml = toml::to_string(description)
            .map_err(|error| DatasetError::of_file(&file, Problem::Toml(error.to_string())))?;
        make_folder(folder)?;
        if file.exists() {
            fs::remove_file(&file).map_err(|error| io(&file, &error))?;
        }
        Ok(Self { description, folder, format, toml })
    }

    /// Writes one trial's table.
    ///
    /// # Errors
    /// As [`write_as`].
    pub fn table(&self, trial: &Trial) -> Result<(), DatasetError> {
        let file = table_file(&trial.info, self.format);
        check_samples(&trial.samples, &self.folder.join(table_file(&trial.info, TableFormat::Csv)))?;
        write_table(trial, &self.folder.join(file), self.format)
    }

    /// Writes trials.csv, then dataset.toml.
    ///
    /// # Errors
    /// As [`write_as`].
    pub fn finish(self, infos: &[&TrialInfo]) -> Result<(), DatasetError> {
        check_infos(self.description, infos, self.folder)?;
        let file = self.folder.join("trials.csv");
        write_trials(infos, self.format, &file).map_err(|error| io(&file, &std::io::Error::other(error)))?;
        let file = self.folder.join("dataset.toml");
        fs::write(&file, &self.toml).map_err(|error| io(&file, &error))
    }
}

/// The table's path: the trial's own, or `trials/<trial>`, with the format's ending.
fn table_file(info: &TrialInfo, format: TableFormat) -> String {
    let named = if info.file.is_empty() { format!("trials/{}", info.trial) } else { info.file.clone() };
    let stem = named.strip_suffix(".csv").or_else(|| named.strip_suffix(".parquet"));
    let ending = match format {
        TableFormat::Csv => "csv",
        TableFormat::Parquet => "parquet",
    };
    format!("{}.{ending}", stem.unwrap_or(&named))
}

fn check_infos(description: &Description, infos: &[&TrialInfo], folder: &Path) -> Result<(), DatasetError> {
    let file = folder.join("trials.csv");
    let mut names = BTreeSet::new();
    for (index, info) in infos.iter().enumerate() {
        let refuse = |column: &str, value: &str, problem| {
            let refusal = DatasetError::of_file(&file, problem).at(Line::Text(index as u64 + 2));
            Err(refusal.column(column).value(value))
        };
        for (column, text) in
            [("trial", &info.trial), ("object", &info.object), ("primitive", &info.primitive)]
        {
            if text.is_empty() {
                let problem = Problem::EmptyCell("every trial needs a name, an object and a primitive");
                return refuse(column, text, problem);
            }
        }
        if !names.insert(&info.trial) {
            return refuse("trial", &info.trial, Problem::Duplicate);
        }
        if !description.objects.iter().any(|object| object.id == info.object) {
            return refuse("object", &info.object, unknown_object(description));
        }
        if !stays_inside(Path::new(&table_file(info, TableFormat::Csv))) {
            return refuse("file", &info.file, Problem::OutsideFolder);
        }
        let conditions =
            [info.grip_n, info.speed_m_s, info.speed_rad_s, info.slope_rad, info.pusher_offset_m];
        for (column, number) in COLUMNS.iter().skip(4).zip(conditions) {
            if let Some(number) = number.filter(|number| !number.is_finite()) {
                return refuse(column, &number.to_string(), Problem::NonFinite);
            }
        }
        if let Some(grip) = info.grip_n.filter(|grip| *grip < 0.0) {
            return refuse("grip_n", &grip.to_string(), Problem::Negative("a grip force"));
        }
    }
    Ok(())
}

/// Rows are checked as they would be read: NaN in a wrench is an empty cell, anything else
/// that is not finite is refused.
fn check_samples(samples: &[super::Sample], file: &Path) -> Result<(), DatasetError> {
    if samples.is_empty() {
        return Err(DatasetError::of_file(file, Problem::NoSamples));
    }
    let mut previous_s = None;
    for (index, written) in samples.iter().enumerate() {
        let refuse = |column: usize, value: f64, problem| {
            Err(DatasetError::of_file(file, problem)
                .at(Line::Text(index as u64 + 2))
                .column(TABLE_COLUMNS.get(column).copied().unwrap_or_default())
                .value(value.to_string()))
        };
        let row = cells(written);
        if let Some(column) = row.iter().position(|cell| cell.is_infinite()) {
            return refuse(column, row[column], Problem::NonFinite);
        }
        match sample(&row, previous_s, &mut PartialPoses::default()) {
            Err(bad) => return refuse(bad.column, row[bad.column], bad.problem),
            Ok(read) => {
                // A pose or a grip with a NaN would come back as not measured.
                for (column, lost) in [
                    (1, written.grip_cmd_n.is_some() && read.grip_cmd_n.is_none()),
                    (2, written.gripper.is_some() && read.gripper.is_none()),
                    (9, written.object.is_some() && read.object.is_none()),
                    (16, written.pusher.is_some() && read.pusher.is_none()),
                ] {
                    if lost {
                        return refuse(column, f64::NAN, Problem::NonFinite);
                    }
                }
                previous_s = Some(read.t_s);
            }
        }
    }
    Ok(())
}

fn write_table(trial: &Trial, path: &Path, format: TableFormat) -> Result<(), DatasetError> {
    if let Some(parent) = path.parent() {
        make_folder(parent)?;
    }
    let file = File::create(path).map_err(|error| io(path, &error))?;
    match format {
        TableFormat::Csv => {
            let mut stream = BufWriter::new(file);
            csv_table::write(&trial.samples, &mut stream)
                .and_then(|()| stream.flush())
                .map_err(|error| io(path, &error))
        }
        TableFormat::Parquet => parquet_table::write(&trial.samples, file)
            .map_err(|error| DatasetError::of_file(path, Problem::Parquet(error.to_string()))),
    }
}

fn write_trials(infos: &[&TrialInfo], format: TableFormat, path: &Path) -> Result<(), csv::Error> {
    let extra: BTreeSet<&String> = infos.iter().flat_map(|info| info.extra.keys()).collect();
    let mut writer = csv::Writer::from_path(path)?;
    writer.write_record(COLUMNS.iter().copied().chain(extra.iter().map(|name| name.as_str())))?;
    for info in infos {
        let number = |number: Option<f64>| number.map(|n| n.to_string()).unwrap_or_default();
        let mut record = vec![
            info.trial.clone(),
            table_file(info, format),
            info.object.clone(),
            info.primitive.clone(),
            number(info.grip_n),
            number(info.speed_m_s),
            number(info.speed_rad_s),
            number(info.slope_rad),
            number(info.pusher_offset_m),
            info.run.map(|run| run.to_string()).unwrap_or_default(),
        ];
        match info.pusher {
            Some(pose) => {
                record.extend(pose.position_m.iter().chain(&pose.quaternion).map(|number| number.to_string()))
            }
            None => record.extend(std::iter::repeat_n(String::new(), 7)),
        }
        record.extend(extra.iter().map(|name| info.extra.get(*name).cloned().unwrap_or_default()));
        writer.write_record(&record)?;
    }
    writer.flush()?;
    Ok(())
}

fn make_folder(folder: &Path) -> Result<(), DatasetError> {
    fs::create_dir_all(folder).map_err(|error| io(folder, &error))
}

fn io(path: &Path, error: &std::io::Error) -> DatasetError {
    DatasetError::of_file(PathBuf::from(path), Problem::Io(error.to_string()))
}
