//! Reads a data set from its folder, trials in parallel.
//!
//! [`read`] is strict: the first thing wrong is the answer. [`read_lenient`] keeps every good
//! trial, the good rows of a trial that was cut, and lists what was refused. Data sets beyond
//! memory (the paper's grid takes about 0.8 GB) are read trial by trial: [`Index::open`], then
//! [`Index::read_trial`].

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use super::error::{DatasetError, Problem, Warning, join_warnings};
use super::table::TableReading;
use super::trials::{self, TrialRows};
use super::{Dataset, Description, Trial, TrialInfo, csv_table, description, parquet_table};

/// A data set whose trials are read one by one, when they are asked for: from its folder, or from memory
/// where it was made from a [`Dataset`].
#[derive(Clone, Debug)]
pub struct Index {
    /// Its folder.
    pub folder: PathBuf,
    /// dataset.toml.
    pub description: Description,
    /// Good rows of trials.csv.
    pub trials: Vec<TrialInfo>,
    /// Refused rows of trials.csv.
    pub errors: Vec<DatasetError>,
    /// What is worth knowing.
    pub warnings: Vec<Warning>,
    /// Its trials, where it does not stand in a folder.
    in_memory: Option<Arc<[Trial]>>,
}

impl From<Dataset> for Index {
    fn from(dataset: Dataset) -> Self {
        let Dataset { folder, description, trials } = dataset;
        let infos = trials.iter().map(|trial| trial.info.clone()).collect();
        let in_memory = Some(trials.into());
        Index { folder, description, trials: infos, errors: Vec::new(), warnings: Vec::new(), in_memory }
    }
}

/// What a lenient reading gave.
#[derive(Clone, Debug)]
pub struct Reading {
    /// The good trials, and the good rows of trials that were cut.
    pub dataset: Dataset,
    /// What was refused, in the order of trials.csv.
    pub errors: Vec<DatasetError>,
    /// What is worth knowing, equal remarks joined.
    pub warnings: Vec<Warning>,
}

/// One trial as a lenient reading gives it.
#[derive(Clone, Debug, Default)]
pub struct TrialReading {
    /// `None`: nothing of it could be kept.
    pub trial: Option<Trial>,
    /// Why something or all is lost.
    pub error: Option<DatasetError>,
    /// What is worth knowing.
    pub warnings: Vec<Warning>,
}

impl TrialReading {
    /// What was lost of the trial, and why; `None`: nothing.
    #[must_use]
    pub fn refusal(&self) -> Option<String> {
        let error = self.error.as_ref()?;
        Some(match &self.trial {
            Some(kept) => format!("{error}; the {} rows before are used", kept.samples.len()),
            None => format!("{error}; the trial is left out"),
        })
    }
}

/// Reads the whole data set in `folder`.
///
/// # Errors
/// The first refusal, in the order dataset.toml, trials.csv, trials.
pub fn read(folder: &Path) -> Result<Dataset, DatasetError> {
    let Index { folder, description, trials, errors, .. } = Index::open(folder)?;
    if let Some(error) = errors.into_iter().next() {
        return Err(error);
    }
    let trials: Vec<_> = trials.into_par_iter().map(|info| read_table(&folder, info, Keep::Whole)).collect();
    let mut read = Vec::with_capacity(trials.len());
    for TrialReading { trial, error, .. } in trials {
        match error {
            Some(error) => return Err(error),
            None => read.extend(trial),
        }
    }
    Ok(Dataset { folder, description, trials: read })
}

/// Reads what is good of the data set in `folder` and lists the rest.
///
/// # Errors
/// Without a readable dataset.toml and header of trials.csv nothing can be kept.
pub fn read_lenient(folder: &Path) -> Result<Reading, DatasetError> {
    let Index { folder, description, trials, mut errors, mut warnings, .. } = Index::open(folder)?;
    let readings: Vec<_> =
        trials.into_par_iter().map(|info| read_table(&folder, info, Keep::GoodRows)).collect();
    let mut kept = Vec::with_capacity(readings.len());
    for reading in readings {
        kept.extend(reading.trial);
        errors.extend(reading.error);
        warnings.extend(reading.warnings);
    }
    Ok(Reading {
        dataset: Dataset { folder, description, trials: kept },
        errors,
        warnings: join_warnings(warnings),
    })
}

impl Index {
    /// Reads dataset.toml and trials.csv of `folder`.
    ///
    /// # Errors
    /// A missing or refused dataset.toml, a missing trials.csv or one without its columns. A bad
    /// row of trials.csv is one of [`Index::errors`].
    pub fn open(folder: &Path) -> Result<Self, DatasetError> {
        let file = folder.join("dataset.toml");
        let bytes = read_file(&file, "give the folder that holds dataset.toml")?;
        let text = String::from_utf8(bytes).map_err(|_| {
            DatasetError::of_file(&file, Problem::Toml("not UTF-8 text; save it as UTF-8".into()))
        })?;
        let (description, mut warnings) = description::parse(&text, &file)?;
        let file = folder.join("trials.csv");
        let bytes = read_file(&file, "a data set lists its trials there")?;
        let TrialRows { trials, errors, warnings: more } = trials::parse(&bytes, &file, &description)?;
        warnings.extend(more);
        if trials.is_empty() && errors.is_empty() {
            let text = "the data set lists no trials".to_owned();
            warnings.push(Warning { file, files: 1, text });
        }
        Ok(Index { folder: folder.to_owned(), description, trials, errors, warnings, in_memory: None })
    }

    /// The trial named `id`, or the first, and its place among the trials (wear goes with it).
    ///
    /// # Errors
    /// No trial has that name, or there is none at all.
    pub fn find(&self, id: Option<&str>) -> Result<(usize, &TrialInfo), DatasetError> {
        let mut trials = self.trials.iter().enumerate();
        let (found, problem) = match id {
            None => (trials.next(), Problem::NoTrials),
            Some(id) => (trials.find(|(_, info)| info.trial == id), Problem::NoSuchTrial(id.to_owned())),
        };
        found.ok_or_else(|| DatasetError::of_file(self.folder.join("trials.csv"), problem))
    }

    /// Reads one trial strictly.
    ///
    /// # Errors
    /// The first refusal in its table.
    pub fn read_trial(&self, info: &TrialInfo) -> Result<Trial, DatasetError> {
        let reading = self.reading(info, Keep::Whole);
        match (reading.error, reading.trial) {
            (Some(error), _) => Err(error),
            (None, Some(trial)) => Ok(trial),
            // Not reached: a reading without a trial has an error.
            (None, None) => Err(DatasetError::of_file(&self.folder, Problem::NoSamples)),
        }
    }

    /// Reads what is good of one trial.
    #[must_use]
    pub fn read_trial_lenient(&self, info: &TrialInfo) -> TrialReading {
        self.reading(info, Keep::GoodRows)
    }

    fn reading(&self, info: &TrialInfo, keep: Keep) -> TrialReading {
        match &self.in_memory {
            None => read_table(&self.folder, info.clone(), keep),
            Some(trials) => match trials.iter().find(|trial| trial.info.trial == info.trial) {
                Some(trial) => TrialReading { trial: Some(trial.clone()), ..TrialReading::default() },
                None => {
                    let problem = Problem::NoSuchTrial(info.trial.clone());
                    let error = Some(DatasetError::of_file(&self.folder, problem));
                    TrialReading { error, ..TrialReading::default() }
                }
            },
        }
    }
}

/// What is kept of a table with a bad last row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Keep {
    Whole,
    GoodRows,
}

fn read_table(folder: &Path, info: TrialInfo, keep: Keep) -> TrialReading {
    let path = trials::table_path(folder, &info);
    let table = read_file(&path, "trials.csv names it; restore it or remove the row").and_then(|bytes| {
        if bytes.starts_with(b"PAR1") || path.extension().is_some_and(|end| end == "parquet") {
            parquet_table::read(bytes, &path)
        } else {
            csv_table::read(&bytes, &path)
        }
    });
    match table {
        Err(error) => TrialReading { error: Some(error), ..TrialReading::default() },
        Ok(TableReading { samples, error, cut_at_end, mut warnings }) => {
            let cut = error.is_some();
            let usable = !cut || (cut_at_end && keep == Keep::GoodRows);
            let error = error
                .or_else(|| samples.is_empty().then(|| DatasetError::of_file(&path, Problem::NoSamples)));
            let trial = (usable && !samples.is_empty()).then_some(Trial { info, samples });
            if let (true, Some(trial)) = (cut, &trial) {
                let rows = trial.samples.len();
                let text = format!("truncated: the {rows} good samples are used");
                warnings.push(Warning { file: path, files: 1, text });
            }
            TrialReading { trial, error, warnings }
        }
    }
}

fn read_file(path: &Path, missing: &str) -> Result<Vec<u8>, DatasetError> {
    fs::read(path).map_err(|error| {
        let problem = match error.kind() {
            std::io::ErrorKind::NotFound => Problem::MissingFile(missing.to_owned()),
            _ => Problem::Io(error.to_string()),
        };
        DatasetError::of_file(path, problem)
    })
}
