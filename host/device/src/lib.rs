//! A board on a line: a real one behind a serial port, or the firmware in QEMU.
//!
//! [`Device`] carries out requests and hands on telemetry; [`session`] streams a trial to
//! it. Reading runs in a thread of its own, so that telemetry is never lost to a slow
//! terminal.

pub mod clock;
pub mod error;
pub mod faults;
mod line;
pub mod log;
mod mailbox;
pub mod package;
pub mod qemu;
pub mod records;
pub mod session;

use std::collections::VecDeque;
use std::path::Path;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use postcard_rpc::{Endpoint, Topic};
use serde::Serialize;
use serde::de::DeserializeOwned;
use stickslip_shared::wire::frame::{MAX_LINE, encode};
use stickslip_shared::wire::{self, Answer, HostClock, Info, ModelChunk, ModelCommit, TelemetryReport};

use clock::{Clock, Exchange};
pub use error::DeviceError;
use faults::{Faults, Injected};
use line::{Event, Line};
use qemu::Qemu;

/// How long the answer to a request may take that is asked again. QEMU looks for a newly opened pseudo terminal once a second.
const ANSWER: Duration = Duration::from_millis(800);
/// The same of one that is asked once.
const ONCE: Duration = Duration::from_secs(4);
/// The same of an emulator at its own line: a busy machine may stop it for a while, and it loses nothing meanwhile.
const EMULATED: Duration = Duration::from_secs(4);
/// Tries of a request that may be repeated without harm.
const TRIES: usize = 5;

/// A connected board.
pub struct Device {
    line: Line,
    reports: VecDeque<TelemetryReport>,
    seq: u32,
    damaged: u64,
    faults: Option<Faults>,
    info: Info,
    // Dropped last: ends the emulator.
    qemu: Option<Qemu>,
}

impl Device {
    /// Opens `qemu`, `qemu:FIRMWARE` or `serial:PORT` and asks what it is.
    ///
    /// # Errors
    /// Where the name is none of these, the port or QEMU is not there, nothing answers, or
    /// the board speaks another protocol.
    pub fn open(name: &str) -> Result<Self, DeviceError> {
        let emulated = |firmware: &Path| -> Result<_, DeviceError> {
            let (qemu, reading, writing) = Qemu::start(firmware)?;
            Ok((Line::over(reading, writing), Some(qemu)))
        };
        let (line, qemu) = match name.split_once(':') {
            None if name == "qemu" => emulated(&qemu::built("STICKSLIP_FIRMWARE", "stickslip-mps2-an386"))?,
            Some(("qemu", firmware)) => emulated(firmware.as_ref())?,
            Some(("serial", port)) => (Line::open(port)?, None),
            _ => return Err(DeviceError::Name { name: name.to_owned() }),
        };
        let mut device = Self {
            line,
            reports: VecDeque::new(),
            seq: 0,
            damaged: 0,
            faults: None,
            info: Info::default(),
            qemu,
        };
        device.info = device.patient::<wire::GetInfo>(&())?;
        if device.info.protocol != wire::PROTOCOL {
            return Err(DeviceError::Protocol { board: device.info.protocol, host: wire::PROTOCOL });
        }
        Ok(device)
    }

    /// What the board said it is when it was opened.
    #[must_use]
    pub fn info(&self) -> &Info {
        &self.info
    }

    /// Process of the emulator, where the board is one.
    #[must_use]
    pub fn emulator(&self) -> Option<u32> {
        self.qemu.as_ref().map(Qemu::process)
    }

    /// Frames that arrived damaged so far.
    #[must_use]
    pub fn damaged_frames(&self) -> u64 {
        self.damaged
    }

    /// Sends a request once and waits for its answer.
    ///
    /// # Errors
    /// Where the line is cut or no answer comes.
    pub fn request<E: Endpoint>(&mut self, request: &E::Request) -> Result<E::Response, DeviceError>
    where
        E::Request: Serialize,
        E::Response: DeserializeOwned,
    {
        self.ask::<E>(request, ONCE)
    }

    fn ask<E: Endpoint>(&mut self, request: &E::Request, answer: Duration) -> Result<E::Response, DeviceError>
    where
        E::Request: Serialize,
        E::Response: DeserializeOwned,
    {
        self.seq = self.seq.wrapping_add(1);
        let mut line = [0; MAX_LINE];
        let bytes = encode(E::REQ_KEY, self.seq, request, &mut line)
            .ok_or(DeviceError::TooLong { request: E::PATH })?;
        self.line.write(bytes)?;
        let deadline = Instant::now() + if self.qemu.is_some() { EMULATED } else { answer };
        loop {
            match self.line.next(deadline)? {
                None => return Err(DeviceError::NoAnswer { request: E::PATH }),
                Some(Event::Frame(frame)) if frame.seq == self.seq && frame.key == E::RESP_KEY => {
                    return frame.decode().ok_or(DeviceError::Undecodable { request: E::PATH });
                }
                Some(Event::Frame(frame))
                    if frame.seq == self.seq && frame.key == wire::Unknown::TOPIC_KEY =>
                {
                    return Err(DeviceError::UnknownRequest { request: E::PATH });
                }
                Some(event) => self.keep(event),
            }
        }
    }

    /// The same, repeated where no answer comes.
    fn patient<E: Endpoint>(&mut self, request: &E::Request) -> Result<E::Response, DeviceError>
    where
        E::Request: Serialize,
        E::Response: DeserializeOwned,
    {
        let mut last = DeviceError::NoAnswer { request: E::PATH };
        for _ in 0..TRIES {
            match self.ask::<E>(request, ANSWER) {
                Err(error @ (DeviceError::NoAnswer { .. } | DeviceError::Undecodable { .. })) => last = error,
                done => return done,
            }
        }
        Err(last)
    }

    /// A command: like [`Device::request`], a refusal is an error.
    ///
    /// # Errors
    /// Also where the board refuses.
    pub fn command<E: Endpoint<Response = Answer>>(&mut self, request: &E::Request) -> Result<(), DeviceError>
    where
        E::Request: Serialize,
    {
        self.request::<E>(request)?.map_err(|refusal| DeviceError::Refused { request: E::PATH, refusal })
    }

    /// Sends a serialised model in pieces and puts it to use.
    ///
    /// # Errors
    /// Where it does not fit the board, or the board refuses it.
    pub fn load_model(&mut self, bytes: &[u8]) -> Result<(), DeviceError> {
        self.load_model_watched(bytes, &mut |_| ())
    }

    /// The same; `sent` is told of each piece's bytes when the board has taken them.
    ///
    /// # Errors
    /// As [`Device::load_model`].
    pub fn load_model_watched(
        &mut self,
        bytes: &[u8],
        sent: &mut dyn FnMut(usize),
    ) -> Result<(), DeviceError> {
        let refused = |request| move |refusal| DeviceError::Refused { request, refusal };
        let length = u16::try_from(bytes.len()).unwrap_or(u16::MAX);
        if length > self.info.model_bytes {
            return Err(DeviceError::ModelTooLong { bytes: bytes.len(), room: self.info.model_bytes });
        }
        let mut offset = 0;
        for piece in bytes.chunks(wire::CHUNK) {
            let bytes = heapless::Vec::from_slice(piece).unwrap_or_default();
            self.patient::<wire::LoadModelChunk>(&ModelChunk { offset, bytes })?
                .map_err(refused(wire::LoadModelChunk::PATH))?;
            offset += piece.len() as u16;
            sent(piece.len());
        }
        let commit = ModelCommit { length, crc: wire::frame::crc32(bytes) };
        self.patient::<wire::CommitModel>(&commit)?.map_err(refused(wire::CommitModel::PATH))
    }

    /// Sends a topic message.
    ///
    /// # Errors
    /// Where the line is cut.
    pub fn publish<T: Topic>(&mut self, seq: u32, message: &T::Message) -> Result<(), DeviceError>
    where
        T::Message: Serialize + Sized,
    {
        let mut line = [0; MAX_LINE];
        let bytes =
            encode(T::TOPIC_KEY, seq, message, &mut line).ok_or(DeviceError::TooLong { request: T::PATH })?;
        match &mut self.faults {
            Some(faults) => self.line.write(&faults.damage(bytes)),
            None => self.line.write(bytes),
        }
    }

    /// From now on the line loses, doubles, damages: see [`faults`].
    pub fn damage_line(&mut self, seed: u64) {
        self.faults = Some(Faults::new(seed));
    }

    /// What was done to the line; none of it where [`Device::damage_line`] was not called.
    #[must_use]
    pub fn injected(&self) -> Option<Injected> {
        self.faults.as_ref().map(|faults| faults.injected)
    }

    /// Sends bytes as they are: for tests of a noisy line.
    ///
    /// # Errors
    /// Where the line is cut.
    pub fn write_raw(&mut self, bytes: &[u8]) -> Result<(), DeviceError> {
        self.line.write(bytes)
    }

    /// The next report, waiting at most `wait`.
    ///
    /// # Errors
    /// Where the line is cut.
    pub fn report(&mut self, wait: Duration) -> Result<Option<TelemetryReport>, DeviceError> {
        let deadline = Instant::now() + wait;
        loop {
            if let Some(report) = self.reports.pop_front() {
                return Ok(Some(report));
            }
            match self.line.next(deadline)? {
                None => return Ok(None),
                Some(event) => self.keep(event),
            }
        }
    }

    /// Drops the reports received so far: they are from before what was just asked for.
    pub fn forget_reports(&mut self) {
        self.reports.clear();
    }

    /// Statistics since the board's reset.
    ///
    /// # Errors
    /// Where no answer comes.
    pub fn statistics(&mut self) -> Result<wire::Statistics, DeviceError> {
        self.patient::<wire::GetStatistics>(&())
    }

    /// Exchanges times with the board: `count` times, `apart` from one to the next. Times of this machine count from
    /// the first one.
    ///
    /// # Errors
    /// Where no answer comes.
    pub fn exchange_clocks(&mut self, count: usize, apart: Duration) -> Result<Vec<Exchange>, DeviceError> {
        self.exchange_clocks_since(Instant::now(), count, apart)
    }

    /// The same; times of this machine count from `began`.
    ///
    /// # Errors
    /// Where no answer comes.
    pub fn exchange_clocks_since(
        &mut self,
        began: Instant,
        count: usize,
        apart: Duration,
    ) -> Result<Vec<Exchange>, DeviceError> {
        let mut exchanges = Vec::with_capacity(count);
        for k in 0..count {
            if k > 0 {
                std::thread::sleep(apart);
            }
            let asked_s = began.elapsed().as_secs_f64();
            let reading = self.request::<wire::ReadClock>(&())?;
            let answered_s = began.elapsed().as_secs_f64();
            let board_s = [reading.received_us, reading.sent_us].map(|us| us as f64 * 1e-6);
            exchanges.push(Exchange { asked_s, board_s, answered_s });
        }
        Ok(exchanges)
    }

    /// Tells the board this machine's clock as exchanges found it: in the run that goes on a sample's `t_us` counts from where
    /// their times do ([`Device::exchange_clocks_since`]). Anew within half an hour, and within a minute where no drift is
    /// known.
    ///
    /// # Errors
    /// Where the board refuses, or no answer comes.
    pub fn tell_clock(&mut self, clock: &Clock) -> Result<(), DeviceError> {
        let low = |s: f64| (s * 1e6) as i64 as u32;
        let drift = clock.drift.unwrap_or(0.0) as f32;
        let told = HostClock { host_us: low(clock.at_s), board_us: low(clock.board_s(clock.at_s)), drift };
        self.command::<wire::SetClock>(&told)
    }

    fn keep(&mut self, event: Event) {
        match event {
            Event::Frame(frame) if frame.key == wire::Telemetry::TOPIC_KEY => match frame.decode() {
                Some(_) if self.faults.as_mut().is_some_and(Faults::loses_report) => {}
                Some(report) => self.reports.push_back(report),
                None => self.damaged += 1,
            },
            // A late answer to a request that was given up.
            Event::Frame(_) => {}
            Event::Damaged => self.damaged += 1,
        }
    }
}

impl From<RecvTimeoutError> for DeviceError {
    fn from(_: RecvTimeoutError) -> Self {
        DeviceError::Cut { cause: "the reading thread ended".into() }
    }
}
