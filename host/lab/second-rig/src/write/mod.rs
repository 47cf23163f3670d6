//! Writes a data set and, apart from it, its key.

mod header;
mod key;
mod tables;

use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::dataset::{DataSet, Run};
use crate::error::Error;

/// Writes the folder and the key file. The key must not lie in the folder.
pub fn write(set: &DataSet, runs: &[Run], folder: &Path, key: &Path) -> Result<(), Error> {
    let inside = |p: &Path| p.components().collect::<PathBuf>().starts_with(folder);
    if inside(key) {
        return Err(Error::KeyInside(key.to_owned()));
    }
    make(&folder.join("trials"))?;
    put(&folder.join("dataset.toml"), &header::dataset_toml(set)?)?;
    put(&folder.join("trials.csv"), &tables::trials_csv(set)?)?;
    if set.bench.is_none() {
        put(&folder.join("model.toml"), &header::model_toml(set)?)?;
    }
    set.trials.par_iter().zip(runs).try_for_each(|(trial, run)| {
        let path = folder.join("trials").join(format!("{}.csv", trial.id));
        put(&path, &tables::trial_csv(set, trial, &run.rows)?)
    })?;
    if let Some(parent) = key.parent().filter(|p| !p.as_os_str().is_empty()) {
        make(parent)?;
    }
    put(key, &key::json(set, runs)?)
}

fn make(path: &Path) -> Result<(), Error> {
    fs::create_dir_all(path).map_err(|source| Error::Write { path: path.to_owned(), source })
}

fn put(path: &Path, text: &str) -> Result<(), Error> {
    fs::write(path, text).map_err(|source| Error::Write { path: path.to_owned(), source })
}
