//! Sensors on the other end of the line, written from the manuals and not from the decoders: whole tables of the
//! protocol, own checksum, own byte order.

use embedded_can::{Frame, Id, StandardId};

/// A classic CAN frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Can {
    pub id: Id,
    pub data: Vec<u8>,
    pub remote: bool,
}

impl Frame for Can {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        (data.len() <= 8).then(|| Self { id: id.into(), data: data.to_vec(), remote: false })
    }
    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        (dlc <= 8).then(|| Self { id: id.into(), data: vec![0; dlc], remote: true })
    }
    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }
    fn is_remote_frame(&self) -> bool {
        self.remote
    }
    fn id(&self) -> Id {
        self.id
    }
    fn dlc(&self) -> usize {
        self.data.len()
    }
    fn data(&self) -> &[u8] {
        &self.data
    }
}

/// Modbus CRC, bit by bit: polynomial 0xa001 from the low end, beginning with all ones.
pub fn modbus_crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xffff, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xa001 } else { crc >> 1 })
    })
}

/// A Robotiq FT 300: silent until register 410 is written.
#[derive(Default)]
pub struct Robotiq {
    pub streams: bool,
    stops: usize,
}

impl Robotiq {
    pub fn hear(&mut self, bytes: &[u8]) {
        let good = bytes.len() == 11 && modbus_crc(&bytes[..9]).to_le_bytes() == bytes[9..];
        if good && bytes[..9] == [9, 16, 1, 154, 0, 1, 2, 2, 0] {
            self.streams = true;
        }
        self.stops = if bytes.iter().all(|b| *b == 0xff) { self.stops + bytes.len() } else { 0 };
        self.streams &= self.stops < 50;
    }

    pub fn frame(wrench: [f32; 6]) -> [u8; 16] {
        let mut frame = [0; 16];
        frame[..2].copy_from_slice(&[0x20, 0x4e]);
        for (k, x) in wrench.iter().enumerate() {
            let counts = (x * if k < 3 { 100.0 } else { 1000.0 }).round() as i16;
            frame[2 + 2 * k..4 + 2 * k].copy_from_slice(&counts.to_le_bytes());
        }
        let crc = modbus_crc(&frame[..14]);
        frame[14..].copy_from_slice(&crc.to_le_bytes());
        frame
    }
}

/// An ATI NETCANOEM.
pub struct Netcanoem {
    pub base: u16,
    pub counts: [u32; 2],
    pub units: [u8; 2],
    pub matrix: [[f32; 6]; 6],
    pub gauges: [i16; 6],
    pub status: u16,
}

impl Netcanoem {
    fn say(&self, operation: u16, data: &[u8]) -> Can {
        let id = StandardId::new(self.base * 16 + operation).unwrap();
        Can { id: id.into(), data: data.to_vec(), remote: false }
    }

    pub fn answer(&self, asked: &Can) -> Vec<Can> {
        let Id::Standard(id) = asked.id else { return vec![] };
        if id.as_raw() / 16 != self.base {
            return vec![];
        }
        let g = self.gauges.map(i16::to_be_bytes);
        match id.as_raw() % 16 {
            0 => {
                let status = self.status.to_be_bytes();
                vec![
                    self.say(0, &[status, g[0], g[2], g[4]].concat()),
                    self.say(1, &[g[1], g[3], g[5]].concat()),
                ]
            }
            2 => {
                let row = self.matrix[usize::from(asked.data[0])].map(f32::to_be_bytes);
                (0..3).map(|k| self.say(2 + k, &row[2 * k as usize..][..2].concat())).collect()
            }
            7 => vec![self.say(7, &self.counts.map(u32::to_be_bytes).concat())],
            8 => vec![self.say(8, &self.units)],
            _ => vec![],
        }
    }
}
