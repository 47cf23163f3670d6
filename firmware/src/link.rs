//! Talking to the host: frames in, commands checked and queued, answers and reports out.

use embassy_futures::select::{Either, select};
use embedded_io_async::{Read, Write};
use heapless::Vec;
use postcard_rpc::{Endpoint, Topic};
use serde::Serialize;
use stickslip_shared::wire::frame::{Frame, FrameError, FrameReader, MAX_LINE, encode};
use stickslip_shared::wire::sequence::{Order, Sequence};
use stickslip_shared::wire::{
    self, Answer, ClockReading, Info, Mode, Port, PostMortem, Recalled, Refusal, ResetCause, Sample, Source,
};
use stickslip_unit::memory::Settings;

use crate::board::current as board;
use crate::queues::{ANSWERS, COMMANDS, Command, MODEL_CRC, REPORTS, SAMPLES, SPARE, mode, tared};
use crate::slot::Slot;
use crate::stats::COUNTERS;
use crate::stored::Stored;
use crate::upload::Upload;

/// State of the receiving task.
pub struct Link {
    upload: Upload,
    sequence: Sequence,
    reset_cause: ResetCause,
    boots: u32,
    post_mortem: Option<PostMortem>,
    stored: Stored,
    recalled: Recalled,
    /// Checksum of the scene of the model that was accepted last.
    scene_crc: u32,
    /// As commanded so far; the control task has the same.
    settings: Settings,
}

impl Link {
    /// After a start of the processor.
    pub fn new(reset_cause: ResetCause, boots: u32, post_mortem: Option<PostMortem>, stored: Stored) -> Self {
        Self {
            upload: Upload::default(),
            sequence: Sequence::default(),
            reset_cause,
            boots,
            post_mortem,
            stored,
            recalled: Recalled::NoMemory,
            scene_crc: 0,
            settings: Settings::default(),
        }
    }

    /// Reads what was stored, the model into `slot`.
    pub fn recall(&mut self, slot: &mut Slot) -> Recalled {
        (self.settings, self.recalled) = self.stored.recall(&mut self.upload, slot);
        self.scene_crc = slot.scene_crc;
        crate::sensors::assign(&self.settings.sensors);
        self.recalled
    }

    /// As commanded so far.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Receives for ever.
    pub async fn run<R: Read>(&mut self, mut rx: R) -> ! {
        let mut reader = FrameReader::new();
        let mut bytes = [0; 64];
        loop {
            let Ok(count) = rx.read(&mut bytes).await else {
                COUNTERS.frames_damaged.add(1);
                continue;
            };
            for byte in bytes.iter().take(count) {
                match reader.push(*byte) {
                    None => {}
                    Some(Ok(frame)) => self.handle(&frame).await,
                    Some(Err(FrameError::TooLong)) => COUNTERS.frames_too_long.add(1),
                    Some(Err(_)) => COUNTERS.frames_damaged.add(1),
                }
            }
        }
    }

    async fn handle(&mut self, frame: &Frame<'_>) {
        let mut line = Vec::new();
        self.respond(frame, &mut line);
        if !line.is_empty() {
            ANSWERS.send(line).await;
        }
        if frame.key == wire::ResetBoard::REQ_KEY {
            // Lets the answer out first.
            embassy_time::Timer::after_millis(20).await;
            board::reset();
        }
    }

    /// Carries out what a frame asks, and writes the answer where there is one.
    // Nothing waits in it: a future for each kind of message would take 2 KB of flash more.
    fn respond(&mut self, frame: &Frame<'_>, line: &mut Line) {
        let key = frame.key;
        if key == wire::Samples::TOPIC_KEY {
            match frame.decode() {
                Some(sample) => self.sample(sample),
                None => COUNTERS.bodies_undecodable.add(1),
            }
        } else if key == wire::GetInfo::REQ_KEY {
            write(wire::GetInfo::RESP_KEY, frame.seq, &self.info(), line);
        } else if key == wire::GetStatistics::REQ_KEY {
            write(wire::GetStatistics::RESP_KEY, frame.seq, &COUNTERS.read(), line);
        } else if key == wire::LoadModelChunk::REQ_KEY {
            self.command::<wire::LoadModelChunk>(frame, line, |link, chunk| link.upload.take(&chunk));
        } else if key == wire::CommitModel::REQ_KEY {
            self.command::<wire::CommitModel>(frame, line, |link, commit| link.commit(&commit));
        } else if key == wire::SetPlan::REQ_KEY {
            self.command::<wire::SetPlan>(frame, line, |_, plan| {
                wire::check::plan(&plan)?;
                queue(Command::Plan(plan))
            });
        } else if key == wire::SetGrip::REQ_KEY {
            self.command::<wire::SetGrip>(frame, line, |link, force_n| {
                wire::check::grip(force_n)?;
                queue(Command::Grip(force_n))?;
                link.settings.grip_cmd_n = Some(force_n);
                Ok(())
            });
        } else if key == wire::SetCalibration::REQ_KEY {
            self.command::<wire::SetCalibration>(frame, line, |link, calibration| {
                wire::check::calibration(&calibration)?;
                queue(Command::Calibration(calibration))?;
                if let Some(matrix) = link.settings.matrix.get_mut(usize::from(calibration.finger)) {
                    *matrix = Some(calibration.matrix);
                }
                Ok(())
            });
        } else if key == wire::Tare::REQ_KEY {
            self.command::<wire::Tare>(frame, line, |link, ()| {
                stickslip_unit::fingers::check_all_fingers(&link.settings.sensors)?;
                queue(Command::Tare)
            });
        } else if key == wire::GetTare::REQ_KEY {
            write(wire::GetTare::RESP_KEY, frame.seq, &tared(), line);
        } else if key == wire::SetSensors::REQ_KEY {
            self.command::<wire::SetSensors>(frame, line, |link, sensors| {
                idle()?;
                if !sensors.iter().all(|s| has_port(s.port)) {
                    return Err(Refusal::NoPort);
                }
                stickslip_unit::fingers::check_sensors(&sensors)?;
                queue(Command::Sensors(sensors.clone()))?;
                crate::sensors::assign(&sensors);
                link.settings.assign(&sensors)
            });
        } else if key == wire::SetGrasp::REQ_KEY {
            self.command::<wire::SetGrasp>(frame, line, |link, grasp| {
                grasp.as_ref().map_or(Ok(()), wire::check::grasp)?;
                queue(Command::Grasp(grasp))?;
                link.settings.grasp = grasp;
                Ok(())
            });
        } else if key == wire::SetGripLimits::REQ_KEY {
            self.command::<wire::SetGripLimits>(frame, line, |link, limits| {
                wire::check::grip_limits(&limits)?;
                queue(Command::GripLimits(limits))?;
                link.settings.grip = Some(limits);
                Ok(())
            });
        } else if key == wire::SetUnit::REQ_KEY {
            self.command::<wire::SetUnit>(frame, line, |link, number| {
                link.settings.unit = number;
                Ok(())
            });
        } else if key == wire::Store::REQ_KEY {
            self.command::<wire::Store>(frame, line, |link, start| link.store(start));
        } else if key == wire::Forget::REQ_KEY {
            self.command::<wire::Forget>(frame, line, |link, ()| idle().and_then(|()| link.stored.forget()));
        } else if key == wire::ReadClock::REQ_KEY {
            let received_us = embassy_time::Instant::now().as_micros();
            let reading = ClockReading { received_us, sent_us: embassy_time::Instant::now().as_micros() };
            write(wire::ReadClock::RESP_KEY, frame.seq, &reading, line);
        } else if key == wire::SetClock::REQ_KEY {
            self.command::<wire::SetClock>(frame, line, |_, clock| {
                wire::check::clock(&clock)?;
                queue(Command::Clock(clock))
            });
        } else if key == wire::Start::REQ_KEY {
            self.command::<wire::Start>(frame, line, |link, request| link.start(request));
        } else if key == wire::Stop::REQ_KEY {
            self.command::<wire::Stop>(frame, line, |_, ()| queue(Command::Stop));
        } else if key == wire::ResetBoard::REQ_KEY {
            self.command::<wire::ResetBoard>(frame, line, |_, ()| Ok(()));
        } else {
            COUNTERS.keys_unknown.add(1);
            let unknown = wire::UnknownKey { key: key.to_bytes() };
            write(wire::Unknown::TOPIC_KEY, frame.seq, &unknown, line);
        }
    }

    fn command<E: Endpoint<Response = Answer>>(
        &mut self,
        frame: &Frame<'_>,
        line: &mut Line,
        carry_out: impl FnOnce(&mut Self, E::Request) -> Answer,
    ) where
        E::Request: serde::de::DeserializeOwned,
    {
        let Some(request) = frame.decode() else {
            COUNTERS.bodies_undecodable.add(1);
            return;
        };
        let result = carry_out(self, request);
        if result.is_err() {
            COUNTERS.commands_refused.add(1);
            defmt::info!("refused {=str}", E::PATH);
        }
        write(E::RESP_KEY, frame.seq, &result, line);
    }

    fn sample(&mut self, sample: Sample) {
        match self.sequence.judge(sample.seq) {
            Order::Next { lost } => {
                COUNTERS.samples_lost.add(lost);
                if SAMPLES.try_send(sample).is_err() {
                    COUNTERS.samples_dropped.add(1);
                }
            }
            Order::Repeated => COUNTERS.samples_repeated.add(1),
            Order::Late => COUNTERS.samples_reordered.add(1),
        }
    }

    fn start(&mut self, request: wire::StartRequest) -> Answer {
        wire::check::start(&request)?;
        match (mode(), request.source) {
            (Mode::Safe, _) => return Err(Refusal::NoModel),
            (Mode::Running, _) => return Err(Refusal::Busy),
            (Mode::Ready, Source::Unit) => self.settings.check_ready()?,
            (Mode::Ready, Source::Link) => {}
        }
        COUNTERS.samples_unasked.add(u32::try_from(SAMPLES.clear()).unwrap_or(u32::MAX));
        self.sequence = Sequence::default();
        queue(Command::Start(request))
    }

    /// Stores what was set, with the run that is to begin by itself.
    fn store(&mut self, start: Option<wire::StartRequest>) -> Answer {
        idle()?;
        if let Some(start) = &start {
            wire::check::start(start)?;
            if start.source == Source::Unit {
                self.settings.check_ready()?;
            }
        }
        self.settings.start = start;
        self.settings.offsets = tared().offsets;
        self.stored.store(&self.settings, &self.upload)?;
        self.recalled = Recalled::Done;
        Ok(())
    }

    fn commit(&mut self, commit: &wire::ModelCommit) -> Answer {
        let slot = SPARE.try_receive().ok_or(Refusal::Busy)?;
        let scene = self.upload.commit(commit, &mut slot.package).and_then(|scene_crc| {
            // What is grasped does not become another object, nor the rig another one.
            if mode() == Mode::Running && scene_crc != self.scene_crc {
                return Err(Refusal::OtherScene);
            }
            Ok(scene_crc)
        });
        match scene {
            Ok(scene_crc) => {
                (slot.crc, slot.scene_crc) = (commit.crc, scene_crc);
                match COMMANDS.try_send(Command::Install(slot)) {
                    Ok(()) => {
                        self.scene_crc = scene_crc;
                        Ok(())
                    }
                    Err(command) => {
                        if let Command::Install(slot) = command {
                            let _ = SPARE.try_send(slot);
                        }
                        Err(Refusal::Busy)
                    }
                }
            }
            Err(refusal) => {
                slot.package = None;
                let _ = SPARE.try_send(slot);
                Err(refusal)
            }
        }
    }

    fn info(&self) -> Info {
        let mode = mode();
        let crc = MODEL_CRC.load(core::sync::atomic::Ordering::Relaxed);
        Info {
            protocol: wire::PROTOCOL,
            source: wire::SOURCE,
            firmware: text(env!("CARGO_PKG_VERSION")),
            board: text(board::NAME),
            timer_hz: board::TIMER_HZ,
            tick_us: wire::TICK_US,
            sample_queue: wire::SAMPLE_QUEUE as u16,
            contacts: stickslip_shared::contact::SLOTS as u16,
            model_bytes: wire::MAX_MODEL_BYTES as u16,
            gauges: board::HAS_GAUGES,
            unit: self.settings.unit,
            recalled: self.recalled,
            post_mortem: self.post_mortem,
            mode,
            reset_cause: self.reset_cause,
            boots: self.boots,
            model_crc: (mode != Mode::Safe).then_some(crc),
        }
    }
}

/// # Errors
/// A run goes on.
fn idle() -> Answer {
    if mode() == Mode::Running { Err(Refusal::Busy) } else { Ok(()) }
}

fn has_port(port: Port) -> bool {
    match port {
        Port::Gauges => board::HAS_GAUGES,
        Port::Ft300 => board::HAS_SERIAL_SENSOR,
        Port::Ati { .. } | Port::Can => board::HAS_CAN,
    }
}

fn text(from: &str) -> heapless::String<16> {
    let mut text = heapless::String::new();
    for letter in from.chars() {
        if text.push(letter).is_err() {
            break;
        }
    }
    text
}

fn queue(command: Command) -> Answer {
    COMMANDS.try_send(command).map_err(|_| Refusal::Busy)
}

/// A frame; empty where there is none.
type Line = Vec<u8, MAX_LINE>;

#[inline(never)]
fn write<T: Serialize>(key: postcard_rpc::Key, seq: u32, body: &T, line: &mut Line) {
    // Every message of the table fits: a test holds that.
    let _ = line.resize_default(MAX_LINE);
    let room = line.first_chunk_mut();
    let length = room.and_then(|room| encode(key, seq, body, room)).map_or(0, <[u8]>::len);
    line.truncate(length);
}

/// Sends for ever, answers before reports.
pub async fn transmit<W: Write>(mut tx: W) -> ! {
    // Ends whatever the line carried before.
    let _ = tx.write_all(&[0]).await;
    let mut line = [0; MAX_LINE];
    loop {
        match select(ANSWERS.receive(), REPORTS.receive()).await {
            Either::First(bytes) => {
                let _ = tx.write_all(&bytes).await;
            }
            Either::Second(report) => {
                let key = wire::Telemetry::TOPIC_KEY;
                if let Some(bytes) = encode(key, report.seq, &report, &mut line) {
                    let _ = tx.write_all(bytes).await;
                }
            }
        }
    }
}
