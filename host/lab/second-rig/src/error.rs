//! What can go wrong.

use std::path::PathBuf;

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No such effect.
    #[error("no hidden effect is called '{0}'; `stickslip-second-rig effects` lists them")]
    UnknownEffect(String),
    /// No such family.
    #[error("no family is called '{0}'; `stickslip-second-rig families` lists them")]
    UnknownFamily(String),
    /// A strength that is no number.
    #[error("--effect {0}: write NAME or NAME=LEVEL, the level a positive number (1 is typical)")]
    BadEffect(String),
    /// The key would give the answer away.
    #[error("the key {0} lies inside the data set; choose a file outside it")]
    KeyInside(PathBuf),
    /// A file.
    #[error("cannot write {path}: {source}")]
    Write {
        /// Where.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A table.
    #[error("cannot write a table: {0}")]
    Csv(#[from] csv::Error),
    /// dataset.toml.
    #[error("cannot write dataset.toml: {0}")]
    Toml(#[from] toml::ser::Error),
    /// The key.
    #[error("cannot write the key: {0}")]
    Json(#[from] serde_json::Error),
}
