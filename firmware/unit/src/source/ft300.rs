//! Robotiq FT 300 and FT 300-S: the sensor's data stream on its serial line.
//!
//! 19200 baud, 8 data bits, no parity, one stop bit. 100 frames a second of 16 bytes: `20 4e`, six signed
//! 16-bit numbers, low byte first (forces in N times 100, torques in N m times 1000), CRC-16 of Modbus, low byte
//! first. The stream begins when 0x0200 is written to register 410 of Modbus slave 9, and ends when 50
//! bytes `ff` are sent. Frames leave the sensor evenly: one that comes later than its period says waited on the way, and is
//! as old as that. Source: FT 300-S Force Torque Sensor, instruction manual (Robotiq), 4.4
//! 'Serial communication'.

use crc::{CRC_16_MODBUS, Crc, NoTable};

use super::{Losses, Reading, WrenchSource, count};

/// Bits a second of the sensor's line.
pub const BAUD: u32 = 19_200;
/// Bytes of a frame.
pub const FRAME: usize = 16;
/// From one frame to the next, us.
pub const PERIOD_US: u32 = 10_000;
/// A byte on the line, us: ten bits.
pub const BYTE_US: u32 = 10 * 1_000_000 / BAUD;
/// A frame on the line, us: ten bits a byte. The measurement is older than its last byte by as much.
pub const TRANSMISSION_US: u32 = (FRAME as u32) * 10 * 1_000_000 / BAUD;
/// Byte that ends the stream; sent [`STOP_COUNT`] times.
pub const STOP: u8 = 0xff;
/// See [`STOP`].
pub const STOP_COUNT: usize = 50;

/// Of a delay so much is taken for the sensor's clock being slow: one of 0.1 % is followed within 0.16 ms.
const DRIFT_SHARE: u32 = 16;
/// After a longer silence the sensor's beat is not known any more, us: clocks 0.1 % apart lose a ms of it.
const LONGEST_US: u32 = 1_000_000;

const HEADER: [u8; 2] = [0x20, 0x4e];
static CRC: Crc<u16, NoTable> = Crc::<u16, NoTable>::new(&CRC_16_MODBUS);

/// The request that begins the stream: write one register (function 16), 410, with 0x0200, and its CRC.
pub fn start_stream() -> [u8; 11] {
    let mut frame = [0x09, 0x10, 0x01, 0x9a, 0x00, 0x01, 0x02, 0x02, 0x00, 0, 0];
    if let Some((body, crc)) = frame.split_last_chunk_mut::<2>() {
        *crc = CRC.checksum(body).to_le_bytes();
    }
    frame
}

/// The decoder of the stream.
#[derive(Clone, Debug, Default)]
pub struct Ft300 {
    bytes: [u8; FRAME],
    filled: usize,
    losses: Losses,
    /// When the last frame was measured, us.
    last_us: Option<u32>,
    /// Losses of damage until then.
    damaged: u32,
}

impl Ft300 {
    /// Nothing received.
    pub const fn new() -> Self {
        Self { bytes: [0; FRAME], filled: 0, losses: Losses::NONE, last_us: None, damaged: 0 }
    }

    /// When a frame was measured whose last byte came at `at_us`. Frames are a period apart, some may be lost; one that is late by
    /// less than half a period is as old as it would be in time, but for a share of the delay: the sensor's clock is its own.
    fn measured_us(&mut self, at_us: u32) -> u32 {
        let come_us = at_us.wrapping_sub(TRANSMISSION_US);
        let since_us =
            self.last_us.map(|last_us| come_us.wrapping_sub(last_us)).filter(|us| *us <= LONGEST_US);
        let late_us = since_us.map_or(0, |us| us % PERIOD_US);
        // Beyond half a period it is early, or late by more: then it counts as in time.
        let in_time = late_us >= PERIOD_US / 2 || since_us.is_some_and(|us| us < PERIOD_US / 2);
        let older_us = if in_time { 0 } else { late_us - late_us / DRIFT_SHARE };
        let measured_us = come_us.wrapping_sub(older_us);
        // By the beat; of those that are missing some came damaged.
        let missing = since_us.map_or(0, |us| ((us + PERIOD_US / 2) / PERIOD_US).saturating_sub(1));
        let damaged = self.losses.damaged.saturating_sub(self.damaged);
        self.losses.lost = self.losses.lost.saturating_add(missing.saturating_sub(damaged));
        (self.last_us, self.damaged) = (Some(measured_us), self.losses.damaged);
        measured_us
    }

    /// Drops the oldest byte.
    fn drop_first(&mut self) {
        self.bytes.rotate_left(1);
        self.filled = self.filled.saturating_sub(1);
    }

    /// The frame in the buffer, which is full and begins as one; `None` where its checksum does not match.
    fn frame(&self) -> Option<[f32; 6]> {
        let (body, crc) = self.bytes.split_last_chunk::<2>()?;
        if CRC.checksum(body) != u16::from_le_bytes(*crc) {
            return None;
        }
        let (_, data) = body.split_first_chunk::<2>()?;
        let mut values = [0.0; 6];
        for (k, (value, pair)) in values.iter_mut().zip(data.chunks_exact(2)).enumerate() {
            let [low, high] = *pair else { return None };
            let scale = if k < 3 { 100.0 } else { 1000.0 };
            *value = f32::from(i16::from_le_bytes([low, high])) / scale;
        }
        Some(values)
    }
}

impl WrenchSource for Ft300 {
    type Input<'a> = u8;

    fn take(&mut self, byte: u8, at_us: u32) -> Option<Reading> {
        // There is always room: a full buffer is emptied or shifted below.
        *self.bytes.get_mut(self.filled)? = byte;
        self.filled += 1;
        loop {
            let begins = self.bytes.iter().zip(HEADER).take(self.filled).all(|(a, b)| *a == b);
            if !begins {
                count(&mut self.losses.skipped);
                self.drop_first();
            } else if self.filled < FRAME {
                return None;
            } else if let Some(values) = self.frame() {
                self.filled = 0;
                let stands_us = TRANSMISSION_US + PERIOD_US + PERIOD_US / 2;
                return Some(Reading { at_us: self.measured_us(at_us), stands_us, values });
            } else {
                count(&mut self.losses.damaged);
                self.drop_first();
            }
        }
    }

    fn losses(&self) -> Losses {
        self.losses
    }
}
