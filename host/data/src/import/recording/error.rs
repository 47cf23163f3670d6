//! Why a mapping or its recordings cannot be used.

use std::path::PathBuf;

use crate::DatasetError;

/// Why a mapping or its recordings cannot be used at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordingError {
    /// The mapping file.
    #[error("{}: {advice}", file.display())]
    Mapping {
        /// Its path.
        file: PathBuf,
        /// What is wrong and what to do.
        advice: String,
    },
    /// The operating system's answer.
    #[error("{}: cannot be read: {error}", file.display())]
    Io {
        /// Which.
        file: PathBuf,
        /// Why.
        error: String,
    },
    /// A column that the file does not have.
    #[error("{}: no column {column:?}; {hint}", file.display())]
    Column {
        /// Which file.
        file: PathBuf,
        /// Which column.
        column: String,
        /// What it has.
        hint: String,
    },
    /// A file without a row that can be used.
    #[error("{}: no row that can be used ({bad_rows} refused){}", file.display(), because(.first))]
    Empty {
        /// Which.
        file: PathBuf,
        /// Rows refused.
        bad_rows: usize,
        /// Why the first one was.
        first: Option<String>,
    },
    /// The table of trials, or a file of signals.
    #[error(transparent)]
    Table(#[from] DatasetError),
    /// Nothing left.
    #[error("{}: no trial could be imported; {why}", file.display())]
    NoTrials {
        /// The mapping.
        file: PathBuf,
        /// The first reason.
        why: String,
    },
}

fn because(first: &Option<String>) -> String {
    first.as_ref().map_or_else(String::new, |why| format!("; the first: {why}"))
}
