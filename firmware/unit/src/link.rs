//! Talking to the host: frames in, commands checked and queued, answers and reports out.

use core::marker::PhantomData;

use heapless::Vec;
use postcard_rpc::{Endpoint, Topic};
use serde::Serialize;
use stickslip_shared::wire::frame::{Frame, FrameError, FrameReader, MAX_LINE, encode};
use stickslip_shared::wire::sequence::{Order, Sequence};
use stickslip_shared::wire::{
    self, Answer, ClockReading, Info, Mode, Port, PostMortem, Recalled, Refusal, ResetCause, Sample, Source,
};

use crate::between::{Between, Command, SensorLines};
use crate::board::Board;
use crate::memory::Settings;
use crate::slot::Slot;
use crate::stored::Stored;
use crate::upload::Upload;

/// State of the receiving task.
pub struct Link<B: Board> {
    between: &'static Between,
    sensors: &'static SensorLines,
    upload: Upload,
    sequence: Sequence,
    reset_cause: ResetCause,
    boots: u32,
    post_mortem: Option<PostMortem>,
    stored: Stored<B::Flash>,
    recalled: Recalled,
    /// Checksum of the scene of the model that was accepted last.
    scene_crc: u32,
    /// As commanded so far; the control task has the same.
    settings: Settings,
    board: PhantomData<B>,
}

impl<B: Board> Link<B> {
    /// After a start of the processor.
    pub fn new(
        (between, sensors): (&'static Between, &'static SensorLines),
        (reset_cause, boots, post_mortem): (ResetCause, u32, Option<PostMortem>),
        flash: Option<B::Flash>,
    ) -> Self {
        Self {
            between,
            sensors,
            upload: Upload::default(),
            sequence: Sequence::default(),
            reset_cause,
            boots,
            post_mortem,
            stored: Stored::new(flash, B::MEMORY),
            recalled: Recalled::NoMemory,
            scene_crc: 0,
            settings: Settings::default(),
            board: PhantomData,
        }
    }

    /// Reads what was stored, the model into `slot`; what became of the settings, which are also taken without a model.
    pub fn recall(&mut self, slot: &mut Slot) -> Recalled {
        (self.settings, self.recalled) = self.stored.recall(&mut self.upload, slot);
        self.scene_crc = slot.scene_crc;
        self.sensors.with(|hub| hub.assign(&self.settings.sensors));
        if self.recalled == Recalled::WithoutModel { Recalled::Done } else { self.recalled }
    }

    /// As commanded so far.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Takes a byte of the line; the answer to the frame that it ends, where there is one, into `line`. `true`: the board is to
    /// restart once that is out.
    pub fn hear(&mut self, reader: &mut FrameReader, byte: u8, line: &mut Line) -> bool {
        line.clear();
        match reader.push(byte) {
            None => {}
            Some(Ok(frame)) => {
                self.respond(&frame, line);
                return frame.key == wire::ResetBoard::REQ_KEY;
            }
            Some(Err(FrameError::TooLong)) => self.between.counters.frames_too_long.add(1),
            Some(Err(_)) => self.between.counters.frames_damaged.add(1),
        }
        false
    }

    /// Carries out what a frame asks, and writes the answer where there is one.
    // Nothing waits in it: a future for each kind of message would take 2 KB of flash more.
    fn respond(&mut self, frame: &Frame<'_>, line: &mut Line) {
        let key = frame.key;
        if key == wire::Samples::TOPIC_KEY {
            match frame.decode() {
                Some(sample) => self.sample(sample),
                None => self.between.counters.bodies_undecodable.add(1),
            }
        } else if key == wire::GetInfo::REQ_KEY {
            write(wire::GetInfo::RESP_KEY, frame.seq, &self.info(), line);
        } else if key == wire::GetStatistics::REQ_KEY {
            write(wire::GetStatistics::RESP_KEY, frame.seq, &self.between.counters.read(&B::memory()), line);
        } else if key == wire::LoadModelChunk::REQ_KEY {
            self.command::<wire::LoadModelChunk>(frame, line, |link, chunk| link.upload.take(&chunk));
        } else if key == wire::CommitModel::REQ_KEY {
            self.command::<wire::CommitModel>(frame, line, |link, commit| link.commit(&commit));
        } else if key == wire::SetPlan::REQ_KEY {
            self.command::<wire::SetPlan>(frame, line, |link, plan| {
                wire::check::plan(&plan)?;
                link.queue(Command::Plan(plan))
            });
        } else if key == wire::SetGrip::REQ_KEY {
            self.command::<wire::SetGrip>(frame, line, |link, force_n| {
                wire::check::grip(force_n)?;
                link.queue(Command::Grip(force_n))?;
                link.settings.grip_cmd_n = Some(force_n);
                Ok(())
            });
        } else if key == wire::SetCalibration::REQ_KEY {
            self.command::<wire::SetCalibration>(frame, line, |link, calibration| {
                wire::check::calibration(&calibration)?;
                link.queue(Command::Calibration(calibration))?;
                if let Some(matrix) = link.settings.matrix.get_mut(usize::from(calibration.finger)) {
                    *matrix = Some(calibration.matrix);
                }
                Ok(())
            });
        } else if key == wire::Tare::REQ_KEY {
            self.command::<wire::Tare>(frame, line, |link, ()| {
                crate::fingers::check_all_fingers(&link.settings.sensors)?;
                link.queue(Command::Tare)
            });
        } else if key == wire::GetTare::REQ_KEY {
            write(wire::GetTare::RESP_KEY, frame.seq, &self.between.tared(), line);
        } else if key == wire::SetSensors::REQ_KEY {
            self.command::<wire::SetSensors>(frame, line, |link, sensors| {
                link.idle()?;
                if !sensors.iter().all(|s| has_port::<B>(s.port)) {
                    return Err(Refusal::NoPort);
                }
                crate::fingers::check_sensors(&sensors)?;
                link.queue(Command::Sensors(sensors.clone()))?;
                link.sensors.with(|hub| hub.assign(&sensors));
                link.settings.assign(&sensors)
            });
        } else if key == wire::SetGrasp::REQ_KEY {
            self.command::<wire::SetGrasp>(frame, line, |link, grasp| {
                grasp.as_ref().map_or(Ok(()), wire::check::grasp)?;
                link.queue(Command::Grasp(grasp))?;
                link.settings.grasp = grasp;
                Ok(())
            });
        } else if key == wire::SetGripLimits::REQ_KEY {
            self.command::<wire::SetGripLimits>(frame, line, |link, limits| {
                wire::check::grip_limits(&limits)?;
                link.queue(Command::GripLimits(limits))?;
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
            self.command::<wire::Forget>(frame, line, |link, ()| {
                link.idle().and_then(|()| link.stored.forget())
            });
        } else if key == wire::ReadClock::REQ_KEY {
            let received_us = B::now_us();
            let reading = ClockReading { received_us, sent_us: B::now_us() };
            write(wire::ReadClock::RESP_KEY, frame.seq, &reading, line);
        } else if key == wire::SetClock::REQ_KEY {
            self.command::<wire::SetClock>(frame, line, |link, clock| {
                wire::check::clock(&clock)?;
                link.queue(Command::Clock(clock))
            });
        } else if key == wire::Start::REQ_KEY {
            self.command::<wire::Start>(frame, line, |link, request| link.start(request));
        } else if key == wire::Stop::REQ_KEY {
            self.command::<wire::Stop>(frame, line, |link, ()| link.queue(Command::Stop));
        } else if key == wire::ResetBoard::REQ_KEY {
            self.command::<wire::ResetBoard>(frame, line, |_, ()| Ok(()));
        } else {
            self.between.counters.keys_unknown.add(1);
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
            self.between.counters.bodies_undecodable.add(1);
            return;
        };
        let result = carry_out(self, request);
        if result.is_err() {
            self.between.counters.commands_refused.add(1);
        }
        write(E::RESP_KEY, frame.seq, &result, line);
    }

    fn queue(&self, command: Command) -> Answer {
        self.between.commands.try_send(command).map_err(|_| Refusal::Busy)
    }

    /// # Errors
    /// A run goes on.
    fn idle(&self) -> Answer {
        if self.between.mode() == Mode::Running { Err(Refusal::Busy) } else { Ok(()) }
    }

    fn sample(&mut self, sample: Sample) {
        match self.sequence.judge(sample.seq) {
            Order::Next { lost } => {
                self.between.counters.samples_lost.add(lost);
                if self.between.samples.try_send(sample).is_err() {
                    self.between.counters.samples_dropped.add(1);
                }
            }
            Order::Repeated => self.between.counters.samples_repeated.add(1),
            Order::Late => self.between.counters.samples_reordered.add(1),
        }
    }

    fn start(&mut self, request: wire::StartRequest) -> Answer {
        wire::check::start(&request)?;
        match (self.between.mode(), request.source) {
            (Mode::Safe, _) => return Err(Refusal::NoModel),
            (Mode::Running, _) => return Err(Refusal::Busy),
            (Mode::Ready, Source::Unit) => self.settings.check_ready()?,
            (Mode::Ready, Source::Link) => {}
        }
        self.between
            .counters
            .samples_unasked
            .add(u32::try_from(self.between.samples.clear()).unwrap_or(u32::MAX));
        self.sequence = Sequence::default();
        self.queue(Command::Start(request))
    }

    /// Stores what was set, with the run that is to begin by itself.
    fn store(&mut self, start: Option<wire::StartRequest>) -> Answer {
        self.idle()?;
        if let Some(start) = &start {
            wire::check::start(start)?;
            if start.source == Source::Unit {
                self.settings.check_ready()?;
            }
        }
        self.settings.start = start;
        self.settings.offsets = self.between.tared().offsets;
        self.stored.store(&mut self.settings, &self.upload, self.between.model_crc())?;
        self.recalled = Recalled::Done;
        Ok(())
    }

    fn commit(&mut self, commit: &wire::ModelCommit) -> Answer {
        let slot = self.between.spare.try_receive().ok_or(Refusal::Busy)?;
        let running = self.between.mode() == Mode::Running;
        let scene = self.upload.commit(commit, &mut slot.package).and_then(|scene_crc| {
            // What is grasped does not become another object, nor the rig another one.
            if running && scene_crc != self.scene_crc {
                return Err(Refusal::OtherScene);
            }
            Ok(scene_crc)
        });
        match scene {
            Ok(scene_crc) => {
                (slot.crc, slot.scene_crc) = (commit.crc, scene_crc);
                match self.between.commands.try_send(Command::Install(slot)) {
                    Ok(()) => {
                        self.scene_crc = scene_crc;
                        Ok(())
                    }
                    Err(command) => {
                        if let Command::Install(slot) = command {
                            let _ = self.between.spare.try_send(slot);
                        }
                        Err(Refusal::Busy)
                    }
                }
            }
            Err(refusal) => {
                slot.package = None;
                let _ = self.between.spare.try_send(slot);
                Err(refusal)
            }
        }
    }

    fn info(&self) -> Info {
        let mode = self.between.mode();
        Info {
            protocol: wire::PROTOCOL,
            source: wire::SOURCE,
            firmware: text(env!("CARGO_PKG_VERSION")),
            board: text(B::NAME),
            timer_hz: B::TIMER_HZ,
            tick_us: wire::TICK_US,
            sample_queue: wire::SAMPLE_QUEUE as u16,
            contacts: stickslip_shared::contact::SLOTS as u16,
            model_bytes: wire::MAX_MODEL_BYTES as u16,
            gauges: B::HAS_GAUGES,
            unit: self.settings.unit,
            recalled: self.recalled,
            post_mortem: self.post_mortem,
            mode,
            reset_cause: self.reset_cause,
            boots: self.boots,
            model_crc: self.between.model_crc(),
        }
    }
}

fn has_port<B: Board>(port: Port) -> bool {
    match port {
        Port::Gauges => B::HAS_GAUGES,
        Port::Ft300 => B::HAS_SERIAL_SENSOR,
        Port::Ati { .. } | Port::Can => B::HAS_CAN,
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

/// A frame; empty where there is none.
pub type Line = Vec<u8, MAX_LINE>;

#[inline(never)]
fn write<T: Serialize>(key: postcard_rpc::Key, seq: u32, body: &T, line: &mut Line) {
    // Every message of the table fits: a test holds that.
    let _ = line.resize_default(MAX_LINE);
    let room = line.first_chunk_mut();
    let length = room.and_then(|room| encode(key, seq, body, room)).map_or(0, <[u8]>::len);
    line.truncate(length);
}
