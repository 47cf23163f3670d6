//! What a log holds, whatever its format, and what can be wrong with it.

use std::io;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// No record comes near this; a length beyond is damage, however the rest looks.
pub const MAX_PAYLOAD: usize = 16 << 20;

/// What a run is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The scene as it was sent to the device (postcard).
    pub scene: Vec<u8>,
    /// The model as it was sent to the device (postcard).
    pub model: Vec<u8>,
    /// What else is worth keeping: versions, device, data set, trial.
    pub meta: serde_json::Value,
}

/// One record of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Record {
    /// The caller's, from 1.
    pub kind: u8,
    /// Host time since the run began, ns.
    pub host_ns: u64,
    /// Opaque.
    pub payload: Vec<u8>,
}

/// Bytes that held no intact record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Lost {
    /// Offset in the file.
    pub at: usize,
    /// How many bytes.
    pub bytes: usize,
    /// How many intact records stand before it.
    pub after_records: usize,
    /// Is it the end of the file, as a crash leaves it?
    pub at_end: bool,
}

/// All that can be read of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// `None` where the header itself is damaged.
    pub header: Option<Header>,
    /// Every intact record, in the file's order.
    pub records: Vec<Record>,
    /// What was lost; empty for a whole file.
    pub lost: Vec<Lost>,
}

/// Why a log cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The operating system's answer.
    #[error("{file}: {error}")]
    Io {
        /// Which file.
        file: PathBuf,
        /// What it answered.
        error: io::Error,
    },
    /// Nothing in the file is a log.
    #[error("{file}: not a log of stickslip: neither MCAP nor .sslog, or nothing in it can be read")]
    NotALog {
        /// Which file.
        file: PathBuf,
    },
    /// Written by another version.
    #[error("{file}: log format {version}; this program reads format 1 and MCAP")]
    Version {
        /// Which file.
        file: PathBuf,
        /// Its version.
        version: u8,
    },
}

impl Contents {
    /// Notes that nothing intact stands from `from` to `to` of a file of `end` bytes.
    pub(super) fn lose(&mut self, from: usize, to: usize, end: usize) {
        if to > from {
            let after_records = self.records.len();
            self.lost.push(Lost { at: from, bytes: to - from, after_records, at_end: to == end });
        }
    }

    /// What was lost, for people; `None` for a whole file.
    #[must_use]
    pub fn loss(&self) -> Option<String> {
        let bytes: usize = self.lost.iter().map(|lost| lost.bytes).sum();
        let header = if self.header.is_none() { "the header and " } else { "" };
        match self.lost.as_slice() {
            [] if self.header.is_some() => None,
            [] => Some("the header is lost".to_owned()),
            [lost] if lost.at_end => Some(format!(
                "the log ends within a record: {header}{bytes} bytes after {} intact records are lost",
                self.records.len()
            )),
            places => Some(format!(
                "{header}{bytes} bytes in {} regions are damaged; {} intact records were read",
                places.len(),
                self.records.len()
            )),
        }
    }
}
