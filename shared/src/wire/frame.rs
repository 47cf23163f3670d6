//! Frames on the line: `COBS(header, body, CRC-32 little-endian) 0x00`.
//!
//! COBS (Cheshire and Baker 1999) keeps the byte 0 for the end of a frame, so a receiver
//! finds the next frame after any damage; the CRC-32 (ISO-HDLC) finds the damage.

use crc::{CRC_32_ISO_HDLC, Crc};
use postcard_rpc::Key;
use postcard_rpc::header::{VarHeader, VarKey, VarSeq};
use serde::{Serialize, de::DeserializeOwned};

use super::MAX_BODY;

/// Discriminant, 8-byte key, 4-byte number.
pub const HEADER: usize = 13;
/// Checksum.
pub const CHECKSUM: usize = 4;
/// Longest frame before COBS.
pub const MAX_PLAIN: usize = HEADER + MAX_BODY + CHECKSUM;
/// Longest frame on the line: one byte more for every 254, one in front, the 0 behind.
pub const MAX_LINE: usize = MAX_PLAIN + MAX_PLAIN / 254 + 2;

/// By a table of 1 KB: a frame a tick is summed.
static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// CRC-32 (ISO-HDLC) of `bytes`.
pub fn crc32(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// Why bytes are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than any frame.
    TooLong,
    /// Not COBS, or shorter than header and checksum.
    Malformed,
    /// The checksum does not match.
    Checksum,
    /// The header is not postcard-rpc's.
    Header,
}

/// A sound frame.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// What the body is.
    pub key: Key,
    /// Number that ties an answer to its request.
    pub seq: u32,
    /// postcard bytes.
    pub body: &'a [u8],
}

impl Frame<'_> {
    /// The body as `T`; `None` where the bytes are not one, or are more than one.
    pub fn decode<T: DeserializeOwned>(&self) -> Option<T> {
        match postcard::take_from_bytes(self.body) {
            Ok((value, [])) => Some(value),
            _ => None,
        }
    }
}

/// Writes a frame into `line` and returns the bytes to send; `None` where it does not fit.
#[inline]
pub fn encode<'a, T: Serialize>(
    key: Key,
    seq: u32,
    body: &T,
    line: &'a mut [u8; MAX_LINE],
) -> Option<&'a [u8]> {
    let mut plain = [0; MAX_PLAIN];
    let room = plain.get_mut(HEADER..MAX_PLAIN.checked_sub(CHECKSUM)?)?;
    let body = postcard::to_slice(body, room).ok()?.len();
    seal(key, seq, &mut plain, body, line)
}

/// Puts header and checksum about the `body` bytes after the header, and frames them: once for all messages, it saves flash.
#[inline(never)]
fn seal<'a>(
    key: Key,
    seq: u32,
    plain: &mut [u8; MAX_PLAIN],
    body: usize,
    line: &'a mut [u8],
) -> Option<&'a [u8]> {
    let header = VarHeader { key: VarKey::Key8(key), seq_no: VarSeq::Seq4(seq) };
    let _ = header.write_to_slice(plain)?;
    let length = HEADER.checked_add(body)?;
    let end = length.checked_add(CHECKSUM)?;
    let crc = crc32(plain.get(..length)?);
    plain.get_mut(length..end)?.copy_from_slice(&crc.to_le_bytes());
    stuff(plain.get(..end)?, line)
}

/// COBS with the closing 0.
#[inline]
fn stuff<'a>(plain: &[u8], line: &'a mut [u8]) -> Option<&'a [u8]> {
    let mut at = 0_usize;
    // Between zeros: runs of at most 254 bytes, each behind its length plus one. A full
    // run stands for no zero.
    let mut rest = plain;
    loop {
        let run = rest.iter().take(254).take_while(|byte| **byte != 0).count();
        let (head, tail) = rest.split_at_checked(run)?;
        *line.get_mut(at)? = u8::try_from(run.checked_add(1)?).ok()?;
        at = at.checked_add(1)?;
        let end = at.checked_add(run)?;
        line.get_mut(at..end)?.copy_from_slice(head);
        at = end;
        rest = match (run, tail.split_first()) {
            (_, None) => break,
            (254, _) => tail,
            (_, Some((_, after))) => after,
        };
        if rest.is_empty() && run < 254 {
            // The frame ends with a zero: an empty run stands for it.
            *line.get_mut(at)? = 1;
            at = at.checked_add(1)?;
            break;
        }
    }
    *line.get_mut(at)? = 0;
    line.get(..at.checked_add(1)?)
}

/// Undoes [`stuff`] in place, without the closing 0; returns the length.
#[inline]
fn unstuff(bytes: &mut [u8]) -> Option<usize> {
    let (mut from, mut to) = (0_usize, 0_usize);
    while let Some(code) = bytes.get(from).copied() {
        let run = usize::from(code).checked_sub(1)?;
        let start = from.checked_add(1)?;
        let end = start.checked_add(run)?;
        if end > bytes.len() {
            return None;
        }
        bytes.copy_within(start..end, to);
        to = to.checked_add(run)?;
        from = end;
        if run < 254 && from < bytes.len() {
            *bytes.get_mut(to)? = 0;
            to = to.checked_add(1)?;
        }
    }
    Some(to)
}

/// Finds frames in a stream of bytes.
#[derive(Debug)]
pub struct FrameReader {
    buffer: [u8; MAX_LINE],
    length: usize,
    overflow: bool,
}

impl Default for FrameReader {
    fn default() -> Self {
        Self::new()
    }
}

impl FrameReader {
    /// At the beginning of a frame.
    pub const fn new() -> Self {
        Self { buffer: [0; MAX_LINE], length: 0, overflow: false }
    }

    /// Takes one byte; `Some` at the end of a frame, sound or not.
    #[inline]
    pub fn push(&mut self, byte: u8) -> Option<Result<Frame<'_>, FrameError>> {
        if byte != 0 {
            match self.buffer.get_mut(self.length) {
                Some(place) => {
                    *place = byte;
                    self.length = self.length.saturating_add(1);
                }
                None => self.overflow = true,
            }
            return None;
        }
        let length = core::mem::take(&mut self.length);
        if core::mem::take(&mut self.overflow) {
            return Some(Err(FrameError::TooLong));
        }
        if length == 0 {
            // Two zeros in a row: a sender's way to end whatever went before.
            return None;
        }
        let bytes = self.buffer.get_mut(..length)?;
        Some(parse(bytes))
    }
}

#[inline]
fn parse(bytes: &mut [u8]) -> Result<Frame<'_>, FrameError> {
    let length = unstuff(bytes).ok_or(FrameError::Malformed)?;
    let end = length.checked_sub(CHECKSUM).ok_or(FrameError::Malformed)?;
    let (plain, crc) =
        bytes.get(..length).and_then(|b| b.split_at_checked(end)).ok_or(FrameError::Malformed)?;
    if crc32(plain).to_le_bytes() != *crc {
        return Err(FrameError::Checksum);
    }
    match VarHeader::take_from_slice(plain) {
        Some((VarHeader { key: VarKey::Key8(key), seq_no: VarSeq::Seq4(seq) }, body)) => {
            Ok(Frame { key, seq, body })
        }
        _ => Err(FrameError::Header),
    }
}
