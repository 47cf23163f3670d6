//! The log of a run: an MCAP file, written as the run happens, readable after a crash of either side.
//!
//! What the records hold exactly, as the device sent it, is on one channel; beside it the same as protobuf with named
//! schemas for Foxglove, Rerun, PlotJuggler and the like (`mcap_file.rs`, `shown.rs`). Logs of the version before (`.sslog`) are read for
//! one release (`sslog.rs`).

mod mcap_file;
pub(crate) mod record;
mod shown;
mod sslog;

use std::path::Path;

pub use mcap_file::{Entry, Writer};
pub use record::{Contents, Header, LogError, Lost, MAX_PAYLOAD, Record};

/// Reads all that is intact of the log at `path`.
///
/// # Errors
/// A file that cannot be read, that is no log, or of another version.
pub fn read(path: &Path) -> Result<Contents, LogError> {
    let bytes = std::fs::read(path).map_err(|error| LogError::Io { file: path.to_owned(), error })?;
    if let Some(version) = sslog::other_version(&bytes) {
        return Err(LogError::Version { file: path.to_owned(), version });
    }
    let contents = recover(&bytes);
    // A log that was cut within its first bytes is still one; anything else is not.
    let begins = mcap_file::begins(&bytes) || sslog::begins(&bytes);
    if !begins && contents.records.is_empty() && contents.header.is_none() {
        return Err(LogError::NotALog { file: path.to_owned() });
    }
    Ok(contents)
}

/// Every intact record of `bytes`, whatever else is in them.
#[must_use]
pub fn recover(bytes: &[u8]) -> Contents {
    if bytes.starts_with(mcap::MAGIC) { mcap_file::recover(bytes) } else { sslog::recover(bytes) }
}
