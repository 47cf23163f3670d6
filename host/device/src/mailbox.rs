//! The line to the emulated board through memory that QEMU shares as a file
//! (`stickslip_shared::wire::mailbox`), as a reader and a writer of bytes.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use stickslip_shared::wire::mailbox::{MARK, MEMORY_BYTES, OFFERED, Ring, TAKEN, TO_BOARD, TO_HOST, steady};

/// How often each side looks.
const LOOK: Duration = Duration::from_micros(500);
/// A board that takes nothing for so long is gone.
const STUCK: Duration = Duration::from_secs(2);

/// The shared memory, before QEMU has it open.
pub struct Offer {
    file: tempfile::NamedTempFile,
}

impl Offer {
    /// Memory with the host's mark, in memory where the system has such a folder.
    pub fn new() -> io::Result<Self> {
        let shared = Path::new("/dev/shm");
        let folder = if shared.is_dir() { shared.to_owned() } else { std::env::temp_dir() };
        let file = tempfile::Builder::new().prefix("stickslip-").tempfile_in(folder)?;
        file.as_file().set_len(u64::from(MEMORY_BYTES))?;
        set_word(file.as_file(), OFFERED, MARK)?;
        Ok(Self { file })
    }

    /// For QEMU to open.
    pub fn path(&self) -> PathBuf {
        self.file.path().to_owned()
    }

    /// Whether the board is at the line.
    pub fn taken(&self) -> io::Result<bool> {
        Ok(word(self.file.as_file(), TAKEN)? == MARK)
    }

    /// Both halves of the line; the file's name is gone from now on. `ended` tells that there
    /// is no emulator any more.
    pub fn into_halves(self, ended: &Arc<AtomicBool>) -> (Reading, Writing) {
        let file = Arc::new(self.file.into_file());
        let reading = Reading { file: Arc::clone(&file), ended: Arc::clone(ended) };
        (reading, Writing { file, ended: Arc::clone(ended) })
    }
}

fn word(file: &File, offset: u32) -> io::Result<u32> {
    let mut bytes = [0; 4];
    file.read_exact_at(&mut bytes, u64::from(offset))?;
    Ok(u32::from_le_bytes(bytes))
}

fn set_word(file: &File, offset: u32, value: u32) -> io::Result<()> {
    file.write_all_at(&value.to_le_bytes(), u64::from(offset))
}

fn gone() -> io::Error {
    io::Error::new(io::ErrorKind::BrokenPipe, "the emulator ended")
}

/// What the board sends.
pub struct Reading {
    file: Arc<File>,
    ended: Arc<AtomicBool>,
}

impl Read for Reading {
    /// `TimedOut` where there is nothing yet.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        const RING: Ring = TO_HOST;
        // Looked at before the bytes: what was sent before the end is still read.
        let ended = self.ended.load(Ordering::Acquire);
        let read = word(&self.file, RING.read)?;
        let (from, length) = RING.readable(steady(|| word(&self.file, RING.written))?, read);
        let length = buffer.len().min(length as usize);
        if length == 0 {
            if ended {
                return Err(gone());
            }
            std::thread::sleep(LOOK);
            return Err(io::ErrorKind::TimedOut.into());
        }
        let Some(piece) = buffer.get_mut(..length) else { return Ok(0) };
        self.file.read_exact_at(piece, u64::from(from))?;
        set_word(&self.file, RING.read, read.wrapping_add(length as u32))?;
        Ok(length)
    }
}

/// What the host sends.
pub struct Writing {
    file: Arc<File>,
    ended: Arc<AtomicBool>,
}

impl Write for Writing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        const RING: Ring = TO_BOARD;
        let began = Instant::now();
        loop {
            if self.ended.load(Ordering::Acquire) {
                return Err(gone());
            }
            let written = word(&self.file, RING.written)?;
            let (to, room) = RING.writable(written, steady(|| word(&self.file, RING.read))?);
            let length = bytes.len().min(room as usize);
            if let Some(piece) = bytes.get(..length).filter(|piece| !piece.is_empty() || bytes.is_empty()) {
                self.file.write_all_at(piece, u64::from(to))?;
                set_word(&self.file, RING.written, written.wrapping_add(length as u32))?;
                return Ok(length);
            }
            if began.elapsed() > STUCK {
                return Err(io::Error::new(io::ErrorKind::TimedOut, "the board accepts no bytes"));
            }
            std::thread::sleep(LOOK);
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_brings_every_byte_in_order_across_its_end_and_refuses_what_has_no_room() {
        let offer = Offer::new().expect("memory");
        let (_, mut writing) = offer.into_halves(&Arc::new(AtomicBool::new(false)));
        let file = Arc::clone(&writing.file);
        let total = 3 * TO_BOARD.length as usize + 17;
        let sent: Vec<u8> = (0..total).map(|k| (k % 251) as u8).collect();
        let mut received = Vec::new();
        let mut at = 0;
        while received.len() < total {
            // Fills what is free, then takes a part: the ring runs full again and again.
            loop {
                let written = word(&file, TO_BOARD.written).unwrap();
                let read = word(&file, TO_BOARD.read).unwrap();
                if at == total || TO_BOARD.writable(written, read).1 == 0 {
                    break;
                }
                at += writing.write(&sent[at..total.min(at + 1000)]).unwrap();
            }
            let read = word(&file, TO_BOARD.read).unwrap();
            let (from, length) = TO_BOARD.readable(word(&file, TO_BOARD.written).unwrap(), read);
            let mut piece = vec![0; length.min(40_000) as usize];
            file.read_exact_at(&mut piece, u64::from(from)).unwrap();
            set_word(&file, TO_BOARD.read, read.wrapping_add(piece.len() as u32)).unwrap();
            received.extend(piece);
        }
        assert_eq!(received, sent);
    }

    #[test]
    fn counts_that_cannot_be_give_nothing_to_read_or_write() {
        assert_eq!(TO_HOST.readable(5, 9).1, 0);
        assert_eq!(TO_HOST.writable(0, 1).1, 0);
        assert_eq!(TO_HOST.readable(2, u32::MAX - 3), (TO_HOST.bytes + TO_HOST.length - 4, 4));
    }

    #[test]
    fn an_emulator_that_ended_cuts_the_line() {
        let ended = Arc::new(AtomicBool::new(true));
        let (mut reading, mut writing) = Offer::new().expect("memory").into_halves(&ended);
        assert_eq!(reading.read(&mut [0; 4]).unwrap_err().kind(), io::ErrorKind::BrokenPipe);
        assert_eq!(writing.write(&[1]).unwrap_err().kind(), io::ErrorKind::BrokenPipe);
    }
}
