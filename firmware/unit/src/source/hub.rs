//! The sensors on a unit's lines: what arrives goes to the one whose it is, and comes out with port and finger.

use stickslip_shared::wire::{Port, Sensors};

use super::ati::{Ati, Received, Request};
use super::ft300::Ft300;
use super::{Losses, Reading, WrenchSource};
use crate::bus::{BusWrench, WRENCH_ID};

/// A reading, where it was measured, and of which finger.
pub type Measured = (Port, u8, Reading);

/// Sensors on the serial line and on CAN.
#[derive(Clone, Debug, Default)]
pub struct Hub {
    sensors: Sensors,
    ft300: Ft300,
    ati: [Option<Ati>; 2],
    bus: [BusWrench; 2],
}

impl Hub {
    /// Nothing connected.
    pub const fn new() -> Self {
        Self {
            sensors: Sensors::new(),
            ft300: Ft300::new(),
            ati: [None, None],
            bus: [BusWrench::new(), BusWrench::new()],
        }
    }

    /// Which sensor measures which finger; checked by [`crate::fingers::check_sensors`]. ATI sensors are asked for their
    /// matrix anew; of what the others sent before nothing is missing.
    pub fn assign(&mut self, sensors: &Sensors) {
        self.sensors.clone_from(sensors);
        (self.ft300, self.bus) = (Ft300::new(), [BusWrench::new(), BusWrench::new()]);
        self.ati = [None, None];
        for sensor in sensors {
            if let (Port::Ati { base }, Some(place)) =
                (sensor.port, self.ati.get_mut(usize::from(sensor.finger)))
            {
                *place = Ati::new(base).ok();
            }
        }
    }

    fn finger_of(&self, port: Port) -> Option<u8> {
        self.sensors.iter().find(|s| s.port == port).map(|s| s.finger)
    }

    /// Whether a sensor is to be read on the serial line.
    pub fn has_serial(&self) -> bool {
        self.finger_of(Port::Ft300).is_some()
    }

    /// Whether a sensor on the bus knows classic frames only.
    pub fn is_classic(&self) -> bool {
        self.ati.iter().any(Option::is_some)
    }

    /// A byte of the serial line.
    pub fn byte(&mut self, byte: u8, at_us: u32) -> Option<Measured> {
        let finger = self.finger_of(Port::Ft300)?;
        let reading = self.ft300.take(byte, at_us)?;
        Some((Port::Ft300, finger, reading))
    }

    /// A frame of the bus with a standard identifier.
    pub fn frame(&mut self, id: u16, data: &[u8], at_us: u32) -> Option<Measured> {
        for ((ati, bus), finger) in self.ati.iter_mut().zip(&mut self.bus).zip(0..) {
            if let Some(ati) = ati.as_mut().filter(|ati| ati.owns(id)) {
                let port = Port::Ati { base: ati.base() };
                return ati.take(Received { id, data }, at_us).map(|reading| (port, finger, reading));
            }
            let wired = self.sensors.iter().any(|s| s.finger == finger && s.port == Port::Can);
            if wired && id == WRENCH_ID + u16::from(finger) {
                return bus.take(data, at_us).map(|reading| (Port::Can, finger, reading));
            }
        }
        None
    }

    /// What to ask of the sensors on the bus, once a tick.
    pub fn requests(&mut self, now_us: u32) -> impl Iterator<Item = Request> {
        self.ati.iter_mut().flatten().filter_map(move |ati| ati.request(now_us))
    }

    /// What was lost of all of them.
    pub fn losses(&self) -> Losses {
        let ati = self.ati.iter().flatten().map(Ati::losses);
        let all = ati.chain(self.bus.iter().map(BusWrench::losses)).chain([self.ft300.losses()]);
        all.fold(Losses::default(), |sum, one| Losses {
            damaged: sum.damaged.saturating_add(one.damaged),
            skipped: sum.skipped.saturating_add(one.skipped),
            faulty: sum.faulty.saturating_add(one.faulty),
            lost: sum.lost.saturating_add(one.lost),
        })
    }
}
