//! The record of a run (`.sslog`): written as it happens, readable after a crash of either side.
//!
//! ```text
//! magic   8 bytes  "sslog\r\n\x01"   (the last byte is the format's version; CR LF tells a
//!                                  file mangled as text)
//! frame*  marker   4 bytes  "\xa5SSL"
//!         length   u32 LE   of the payload
//!         kind     u8       0: header, else the caller's
//!         time     u64 LE   host time, nanoseconds since the run began
//!         crc      u32 LE   CRC-32 (IEEE) of length, kind, time and payload
//!         payload  bytes    opaque
//! ```
//!
//! The first frame is the header: scene and model as bytes, and the run's description, as JSON.
//! A frame is written in one call and flushed, so a crash cuts the last one at most. The reader
//! takes every intact frame: where one is damaged it looks for the next marker whose frame
//! passes its check, and tells which bytes were lost.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

const MAGIC: [u8; 8] = *b"sslog\r\n\x01";
const VERSION_AT: usize = MAGIC.len() - 1;
const MARKER: [u8; 4] = *b"\xa5SSL";
const FRAME: usize = MARKER.len() + 4 + 1 + 8 + 4;
const HEADER_KIND: u8 = 0;
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
    #[error("{file}: not a stickslip log (.sslog): the file has no log header and no record")]
    NotALog {
        /// Which file.
        file: PathBuf,
    },
    /// Written by another version.
    #[error("{file}: log format {version}; this program reads format 1")]
    Version {
        /// Which file.
        file: PathBuf,
        /// Its version.
        version: u8,
    },
    /// A record that cannot be written.
    #[error(
        "a record of kind {kind} with {bytes} bytes: kind 0 is the header's, and a record has at most {MAX_PAYLOAD} bytes"
    )]
    Record {
        /// Its kind.
        kind: u8,
        /// Its size.
        bytes: usize,
    },
}

/// Writes a log, record by record.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    file: File,
    frame: Vec<u8>,
}

impl Writer {
    /// Creates the file; an existing one is not overwritten.
    ///
    /// # Errors
    /// What the file system answers.
    pub fn create(path: &Path, header: &Header) -> Result<Self, LogError> {
        let io = |error| LogError::Io { file: path.to_owned(), error };
        let mut file = File::create_new(path).map_err(io)?;
        file.write_all(&MAGIC).map_err(io)?;
        let text = serde_json::to_vec(header).map_err(|error| io(error.into()))?;
        let mut writer = Writer { path: path.to_owned(), file, frame: Vec::new() };
        writer.frame(HEADER_KIND, 0, &text)?;
        Ok(writer)
    }

    /// Appends a record and hands it to the operating system: it outlives a crash of this program.
    ///
    /// # Errors
    /// Kind 0, a payload beyond [`MAX_PAYLOAD`], what the file system answers.
    pub fn record(&mut self, kind: u8, host_ns: u64, payload: &[u8]) -> Result<(), LogError> {
        if kind == HEADER_KIND {
            return Err(LogError::Record { kind, bytes: payload.len() });
        }
        self.frame(kind, host_ns, payload)
    }

    /// Waits until all records are on the disk: they outlive a crash of the machine.
    ///
    /// # Errors
    /// What the file system answers.
    pub fn sync(&mut self) -> Result<(), LogError> {
        self.file.sync_data().map_err(|error| LogError::Io { file: self.path.clone(), error })
    }

    fn frame(&mut self, kind: u8, host_ns: u64, payload: &[u8]) -> Result<(), LogError> {
        let length = u32::try_from(payload.len())
            .ok()
            .filter(|_| payload.len() <= MAX_PAYLOAD)
            .ok_or(LogError::Record { kind, bytes: payload.len() })?;
        let (length, time) = (length.to_le_bytes(), host_ns.to_le_bytes());
        self.frame.clear();
        self.frame.extend_from_slice(&MARKER);
        self.frame.extend_from_slice(&length);
        self.frame.push(kind);
        self.frame.extend_from_slice(&time);
        self.frame.extend_from_slice(&checksum(length, kind, time, payload).to_le_bytes());
        self.frame.extend_from_slice(payload);
        // One call for the whole frame: `File` has no buffer of its own to lose.
        self.file.write_all(&self.frame).map_err(|error| LogError::Io { file: self.path.clone(), error })
    }
}

fn checksum(length: [u8; 4], kind: u8, time: [u8; 8], payload: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&length);
    hasher.update(&[kind]);
    hasher.update(&time);
    hasher.update(payload);
    hasher.finalize()
}

/// Reads all that is intact of the log at `path`.
///
/// # Errors
/// A file that cannot be read, that is no log, or of another version.
pub fn read(path: &Path) -> Result<Contents, LogError> {
    let bytes = std::fs::read(path).map_err(|error| LogError::Io { file: path.to_owned(), error })?;
    let version = bytes.get(VERSION_AT).copied();
    let intact_name = bytes.starts_with(&MAGIC[..VERSION_AT]);
    if let (true, Some(version)) = (intact_name, version)
        && version != MAGIC[VERSION_AT]
        && recover(&bytes).records.is_empty()
    {
        return Err(LogError::Version { file: path.to_owned(), version });
    }
    let contents = recover(&bytes);
    // A log that was cut within its first bytes is still one; anything else is not.
    let begins = MAGIC.starts_with(&bytes) || bytes.starts_with(&MAGIC);
    if !begins && contents.records.is_empty() && contents.header.is_none() {
        return Err(LogError::NotALog { file: path.to_owned() });
    }
    Ok(contents)
}

/// Every intact frame of `bytes`, whatever else is in them.
#[must_use]
pub fn recover(bytes: &[u8]) -> Contents {
    let mut contents = Contents { header: None, records: Vec::new(), lost: Vec::new() };
    let mut at = if bytes.starts_with(&MAGIC) { MAGIC.len() } else { 0 };
    let mut lost_from = at;
    // The damaged name of the file is a loss too, told with what follows it.
    let mut first = true;
    while at < bytes.len() {
        match frame(bytes.get(at..).unwrap_or_default()) {
            Some((record, size)) => {
                lose(&mut contents, lost_from, at, bytes.len());
                match serde_json::from_slice(&record.payload) {
                    Ok(header) if record.kind == HEADER_KIND && first => contents.header = Some(header),
                    _ => contents.records.push(record),
                }
                first = false;
                at += size;
                lost_from = at;
            }
            None => at += 1 + next_marker(bytes.get(at + 1..).unwrap_or_default()),
        }
    }
    lose(&mut contents, lost_from, bytes.len(), bytes.len());
    if bytes.len() < MAGIC.len() {
        // Cut within the first bytes: the header is lost though there is no frame to miss.
        contents.lost = vec![Lost { at: 0, bytes: bytes.len(), after_records: 0, at_end: true }];
    }
    contents
}

fn lose(contents: &mut Contents, from: usize, to: usize, end: usize) {
    if to > from {
        let after_records = contents.records.len();
        contents.lost.push(Lost { at: from, bytes: to - from, after_records, at_end: to == end });
    }
}

/// Bytes before the next place where a frame may begin.
fn next_marker(bytes: &[u8]) -> usize {
    bytes.windows(MARKER.len()).position(|window| window == MARKER).unwrap_or(bytes.len())
}

/// The frame at the beginning of `bytes`, and its size; `None` where there is no intact one.
fn frame(bytes: &[u8]) -> Option<(Record, usize)> {
    let rest = bytes.strip_prefix(&MARKER)?;
    let (length, rest) = rest.split_first_chunk::<4>()?;
    let (kind, rest) = rest.split_first()?;
    let (time, rest) = rest.split_first_chunk::<8>()?;
    let (crc, rest) = rest.split_first_chunk::<4>()?;
    let size = usize::try_from(u32::from_le_bytes(*length)).ok().filter(|size| *size <= MAX_PAYLOAD)?;
    let payload = rest.get(..size)?;
    (checksum(*length, *kind, *time, payload) == u32::from_le_bytes(*crc)).then(|| {
        let host_ns = u64::from_le_bytes(*time);
        (Record { kind: *kind, host_ns, payload: payload.to_vec() }, FRAME + size)
    })
}

impl Contents {
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn header() -> Header {
        Header { scene: vec![1, 2], model: vec![3], meta: serde_json::json!({"trial": "a"}) }
    }

    fn written(records: &[Record]) -> Vec<u8> {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("run.sslog");
        let mut writer = Writer::create(&path, &header()).expect("created");
        for record in records {
            writer.record(record.kind, record.host_ns, &record.payload).expect("written");
            // Flushed as it happens: the file is whole while the writer is alive.
            let so_far = read(&path).expect("readable while written");
            assert_eq!(so_far.records.last(), Some(record));
        }
        writer.sync().expect("synced");
        std::fs::read(&path).expect("read")
    }

    fn records() -> Vec<Record> {
        // One payload holds the marker itself, one is empty.
        [b"abc".to_vec(), MARKER.repeat(3), Vec::new(), vec![0; 40]]
            .into_iter()
            .zip(1..)
            .map(|(payload, kind)| Record { kind, host_ns: u64::from(kind) * 4_000_000, payload })
            .collect()
    }

    #[test]
    fn a_log_reads_back_and_one_is_not_overwritten() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("run.sslog");
        Writer::create(&path, &header()).expect("created");
        assert!(matches!(Writer::create(&path, &header()), Err(LogError::Io { .. })));
        let contents = recover(&written(&records()));
        assert_eq!(contents.header, Some(header()));
        assert_eq!(contents.records, records());
        assert_eq!(contents.lost, []);
        assert_eq!(contents.loss(), None);
    }

    #[test]
    fn a_log_cut_at_any_byte_keeps_every_record_before_the_cut_and_tells_the_loss() {
        let bytes = written(&records());
        let ends: Vec<usize> = records()
            .iter()
            .rev()
            .scan(bytes.len(), |end, record| {
                let this = *end;
                *end -= FRAME + record.payload.len();
                Some(this)
            })
            .collect();
        for cut in 0..=bytes.len() {
            let contents = recover(&bytes[..cut]);
            let whole = ends.iter().filter(|end| **end <= cut).count();
            assert_eq!(contents.records, records()[..whole], "cut at {cut}");
            let header_end = ends.last().map_or(0, |end| end - FRAME - 3);
            let at_boundary = ends.contains(&cut) || cut == header_end;
            assert_eq!(contents.loss().is_none(), at_boundary, "cut at {cut}: {:?}", contents.loss());
        }
    }

    #[test]
    fn what_is_no_log_or_of_another_version_is_refused() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("other");
        std::fs::write(&path, b"t_s,object_x_m\n0,0\n").expect("written");
        assert!(matches!(read(&path), Err(LogError::NotALog { .. })));
        std::fs::write(&path, b"sslog\r\n\x02whatever").expect("written");
        assert!(matches!(read(&path), Err(LogError::Version { version: 2, .. })));
    }

    proptest! {
        #[test]
        fn one_flipped_bit_loses_one_record_at_most(at in 0.0..1.0f64, bit in 0..8u32) {
            let bytes = written(&records());
            let mut damaged = bytes.clone();
            let at = (at * bytes.len() as f64) as usize;
            damaged[at] ^= 1 << bit;
            let contents = recover(&damaged);
            let kept = contents.records.iter().filter(|record| records().contains(record)).count();
            prop_assert_eq!(kept, contents.records.len(), "nothing is invented");
            let lost_header = usize::from(contents.header.is_none());
            prop_assert!(kept + 1 >= records().len() + lost_header);
            prop_assert!(contents.loss().is_some(), "told");
        }

        #[test]
        fn any_bytes_are_read_without_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200), splice in any::<bool>()) {
            let mut all = if splice { written(&records()) } else { MAGIC.to_vec() };
            all.splice(all.len() / 2..all.len() / 2, bytes.iter().copied());
            let contents = recover(&all);
            for record in &contents.records {
                prop_assert!(!splice || records().contains(record));
            }
        }
    }
}
