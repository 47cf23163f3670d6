//! Logs of the version before MCAP (`.sslog`), read only.
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

use super::record::{Contents, Lost, MAX_PAYLOAD, Record};

const MAGIC: [u8; 8] = *b"sslog\r\n\x01";
const VERSION_AT: usize = MAGIC.len() - 1;
const MARKER: [u8; 4] = *b"\xa5SSL";
const FRAME: usize = MARKER.len() + 4 + 1 + 8 + 4;
const HEADER_KIND: u8 = 0;

/// The version of a file that has the right name, no record that can be read, and another version.
pub(super) fn other_version(bytes: &[u8]) -> Option<u8> {
    let version = bytes.get(VERSION_AT).copied()?;
    let named = bytes.starts_with(&MAGIC[..VERSION_AT]);
    (named && version != MAGIC[VERSION_AT] && recover(bytes).records.is_empty()).then_some(version)
}

/// Does it begin as such a file, or is it the beginning of one?
pub(super) fn begins(bytes: &[u8]) -> bool {
    MAGIC.starts_with(bytes) || bytes.starts_with(&MAGIC)
}

fn checksum(length: [u8; 4], kind: u8, time: [u8; 8], payload: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&length);
    hasher.update(&[kind]);
    hasher.update(&time);
    hasher.update(payload);
    hasher.finalize()
}

/// Every intact frame of `bytes`, whatever else is in them.
pub(super) fn recover(bytes: &[u8]) -> Contents {
    let mut contents = Contents { header: None, records: Vec::new(), lost: Vec::new() };
    let mut at = if bytes.starts_with(&MAGIC) { MAGIC.len() } else { 0 };
    let mut lost_from = at;
    // The damaged name of the file is a loss too, told with what follows it.
    let mut first = true;
    while at < bytes.len() {
        match frame(bytes.get(at..).unwrap_or_default()) {
            Some((record, size)) => {
                contents.lose(lost_from, at, bytes.len());
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
    contents.lose(lost_from, bytes.len(), bytes.len());
    if bytes.len() < MAGIC.len() {
        // Cut within the first bytes: the header is lost though there is no frame to miss.
        contents.lost = vec![Lost { at: 0, bytes: bytes.len(), after_records: 0, at_end: true }];
    }
    contents
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Header;
    use proptest::prelude::*;

    fn header() -> Header {
        Header { scene: vec![1, 2], model: vec![3], meta: serde_json::json!({"trial": "a"}) }
    }

    /// As the version before wrote it.
    fn written(records: &[Record]) -> Vec<u8> {
        let text = serde_json::to_vec(&header()).expect("text");
        let first = Record { kind: HEADER_KIND, host_ns: 0, payload: text };
        let mut bytes = MAGIC.to_vec();
        for Record { kind, host_ns, payload } in [&first].into_iter().chain(records) {
            let (length, time) = ((payload.len() as u32).to_le_bytes(), host_ns.to_le_bytes());
            bytes.extend(MARKER);
            bytes.extend(length);
            bytes.push(*kind);
            bytes.extend(time);
            bytes.extend(checksum(length, *kind, time, payload).to_le_bytes());
            bytes.extend(payload);
        }
        bytes
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
    fn a_log_of_the_version_before_is_read() {
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
