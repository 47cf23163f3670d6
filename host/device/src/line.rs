//! The line: bytes out, frames in from a reading thread.

use std::io::{self, Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use postcard_rpc::Key;
use serde::de::DeserializeOwned;
use stickslip_shared::wire::frame::FrameReader;

use crate::error::DeviceError;

/// Bits a second of a serial port.
const BAUD: u32 = 1_000_000;
/// How often the reading thread looks whether to end.
const POLL: Duration = Duration::from_millis(50);

/// A sound frame, owned.
pub struct OwnedFrame {
    pub key: Key,
    pub seq: u32,
    body: Vec<u8>,
}

impl OwnedFrame {
    /// The body as `T`.
    pub fn decode<T: DeserializeOwned>(&self) -> Option<T> {
        match postcard::take_from_bytes(&self.body) {
            Ok((value, [])) => Some(value),
            _ => None,
        }
    }
}

/// What the line brought.
pub enum Event {
    Frame(OwnedFrame),
    Damaged,
}

/// An open line.
pub struct Line {
    port: Box<dyn Write>,
    events: Receiver<Result<Event, String>>,
    stop: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
}

impl Line {
    /// A serial port.
    pub fn open(path: &str) -> Result<Self, DeviceError> {
        let failed = |source| DeviceError::NotThere { port: path.to_owned(), source };
        let port = serialport::new(path, BAUD).timeout(POLL).open().map_err(failed)?;
        let reading = port.try_clone().map_err(failed)?;
        Ok(Self::over(reading, port))
    }

    /// Over two halves. A read that finds nothing ends soon, as `TimedOut`.
    pub fn over(reading: impl Read + Send + 'static, writing: impl Write + 'static) -> Self {
        let mut port = Box::new(writing);
        let (sender, events) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let reader = std::thread::spawn(move || read(reading, &sender, &flag));
        // Ends whatever a former user of the line left half sent.
        let _ = port.write_all(&[0]);
        Self { port, events, stop, reader: Some(reader) }
    }

    pub fn write(&mut self, bytes: &[u8]) -> Result<(), DeviceError> {
        self.port.write_all(bytes).map_err(|error| DeviceError::Cut { cause: error.to_string() })
    }

    /// The next event; `None` at `deadline`.
    pub fn next(&mut self, deadline: Instant) -> Result<Option<Event>, DeviceError> {
        match self.events.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok(Ok(event)) => Ok(Some(event)),
            Ok(Err(cause)) => Err(DeviceError::Cut { cause }),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(error @ RecvTimeoutError::Disconnected) => Err(error.into()),
        }
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}

fn read(mut port: impl Read, events: &Sender<Result<Event, String>>, stop: &AtomicBool) {
    let mut reader = FrameReader::new();
    let mut bytes = [0; 4096];
    while !stop.load(Ordering::Relaxed) {
        let count = match port.read(&mut bytes) {
            Ok(0) => {
                let _ = events.send(Err("end of file".into()));
                return;
            }
            Ok(count) => count,
            Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::Interrupted) => {
                continue;
            }
            Err(error) => {
                let _ = events.send(Err(error.to_string()));
                return;
            }
        };
        for byte in bytes.iter().take(count) {
            let event = match reader.push(*byte) {
                None => continue,
                Some(Ok(frame)) => {
                    Event::Frame(OwnedFrame { key: frame.key, seq: frame.seq, body: frame.body.to_vec() })
                }
                Some(Err(_)) => Event::Damaged,
            };
            if events.send(Ok(event)).is_err() {
                return;
            }
        }
    }
}
