//! The tick's sample from the unit's own sensors, and the host's poses beside them.
//!
//! Each finger has one sensor (its port), a 6 x 6 matrix and a tare: `wrench = C (values - tare)`, in N and N m.
//! Readings come at the sensors' own rates with their own times: the newest one stands for as long as its
//! sensor says, then the finger is not measured. A finger without a matrix has no wrench.
//!
//! What the host last sent has an age: a pose is a measurement once, when it is new, and the prescribed
//! bodies' poses stand for [`MAX_AGE_US`]; older ones are none, so that a stalled host or camera does not
//! pass for an object at rest. A run without a host has the poses that were stored for it ([`Grasp`]).

use stickslip_shared::wire::{Calibration, Grasp, Port, Refusal, Sample, Sensor};

use crate::host_clock::{MAX_AGE_US, age_us};
use crate::source::Reading;

/// A tare averages readings for so long, us.
pub const TARE_US: u32 = 500_000;
/// Readings that a tare needs at least: noise of a single one goes down by five.
pub const TARE_READINGS: u32 = 25;
/// A pause in the readings beyond which a tare begins anew, us: ten periods of the slowest sensor.
const TARE_GAP_US: u32 = 100_000;

/// The host's newest sample, and when it was measured by the unit's clock: when it came, where the host's is not known.
#[derive(Clone, Copy, Debug)]
struct Newest {
    sample: Sample,
    at_us: u32,
    /// Its object pose has not been used yet.
    new: bool,
}

/// Readings averaged so far.
#[derive(Clone, Copy, Debug)]
struct Taring {
    began_us: u32,
    last_us: u32,
    readings: u32,
    sums: [f32; 6],
}

/// One finger's sensor.
#[derive(Clone, Debug)]
struct Finger {
    port: Option<Port>,
    matrix: Option<[[f32; 6]; 6]>,
    offset: [f32; 6],
    taring: Option<Option<Taring>>,
    newest: Option<Reading>,
}

impl Finger {
    const NONE: Self = Self { port: None, matrix: None, offset: [0.0; 6], taring: None, newest: None };

    fn take(&mut self, reading: Reading) -> bool {
        let late = self.newest.is_some_and(|n| reading.at_us.wrapping_sub(n.at_us).cast_signed() <= 0);
        if late || !reading.values.iter().all(|value| value.is_finite()) {
            return false;
        }
        self.newest = Some(reading);
        if let Some(taring) = &mut self.taring {
            let begun =
                Taring { began_us: reading.at_us, last_us: reading.at_us, readings: 0, sums: [0.0; 6] };
            let known = taring.filter(|t| reading.at_us.wrapping_sub(t.last_us) <= TARE_GAP_US);
            let mut now = known.unwrap_or(begun);
            now.last_us = reading.at_us;
            now.readings = now.readings.saturating_add(1);
            now.sums.iter_mut().zip(reading.values).for_each(|(sum, value)| *sum += value);
            *taring = Some(now);
            if now.last_us.wrapping_sub(now.began_us) >= TARE_US && now.readings >= TARE_READINGS {
                self.offset = now.sums.map(|sum| sum / now.readings as f32);
                self.taring = None;
            }
        }
        true
    }

    /// The wrench that stands at `now_us`, N and N m, and how old it is, us.
    fn wrench(&self, now_us: u32) -> Option<([f32; 6], u32)> {
        let matrix = self.matrix.as_ref()?;
        // One of a time to come has an age beyond any: the clock was set, or the sensor's delay is wrong.
        let reading = self.newest.filter(|r| now_us.wrapping_sub(r.at_us) <= r.stands_us)?;
        let mut wrench = [0.0; 6];
        for (out, row) in wrench.iter_mut().zip(matrix) {
            for ((entry, value), zero) in row.iter().zip(reading.values).zip(self.offset) {
                *out += entry * (value - zero);
            }
        }
        Some((wrench, now_us.wrapping_sub(reading.at_us)))
    }
}

/// Sensors, matrices and tares of both fingers, and the host's newest sample.
#[derive(Clone, Debug)]
pub struct Fingers {
    finger: [Finger; 2],
    newest: Option<Newest>,
    grasp: Option<Grasp>,
    grip_n: f32,
    seq: u32,
    began_us: Option<u32>,
    told: bool,
    alone: bool,
    measured_us: u32,
}

impl Default for Fingers {
    fn default() -> Self {
        Self::new()
    }
}

/// # Errors
/// The first finger that two of `sensors` measure, or that there is not; one port for two fingers, where it is
/// one sensor; an ATI sensor with the identifiers of the unit's own frames, or with wrenches in CAN-FD frames beside it.
pub fn check_sensors(sensors: &[Sensor]) -> Result<(), Refusal> {
    for (k, sensor) in sensors.iter().enumerate() {
        stickslip_shared::wire::check::finger(sensor.finger)?;
        for other in sensors.iter().take(k) {
            if other.finger == sensor.finger {
                return Err(Refusal::RoleTaken { finger: sensor.finger });
            }
            if other.port == sensor.port && sensor.port.is_one_sensor() {
                return Err(Refusal::PortTaken { port: sensor.port });
            }
        }
        if let Port::Ati { base } = sensor.port {
            stickslip_shared::wire::check::ati_base(base)?;
            if crate::bus::OWN_IDS.iter().any(|id| id >> 4 == u16::from(base)) {
                return Err(Refusal::BaseTaken { base });
            }
            if sensors.iter().any(|other| other.port == Port::Can) {
                return Err(Refusal::ClassicBus);
            }
        }
    }
    Ok(())
}

/// Where the sensor of `finger` is connected.
pub fn port_of(sensors: &[Sensor], finger: u8) -> Option<Port> {
    sensors.iter().find(|s| s.finger == finger).map(|s| s.port)
}

/// # Errors
/// The first finger (0 or 1) without a sensor.
pub fn check_all_fingers(sensors: &[Sensor]) -> Result<(), Refusal> {
    let missing = (0..2).find(|finger| port_of(sensors, *finger).is_none());
    missing.map_or(Ok(()), |finger| Err(Refusal::NoSensor { finger }))
}

impl Fingers {
    /// No sensors, nothing calibrated.
    pub const fn new() -> Self {
        Self {
            finger: [Finger::NONE; 2],
            newest: None,
            grasp: None,
            grip_n: f32::NAN,
            seq: 0,
            began_us: None,
            told: false,
            alone: false,
            measured_us: 0,
        }
    }

    /// For one run; sensors, matrices, tares and grip set-point stay.
    pub fn restart(&mut self) {
        self.newest = None;
        self.seq = 0;
        self.began_us = None;
        self.told = false;
        self.alone = false;
    }

    /// Which sensor measures which finger. What was tared of another sensor is no longer so.
    ///
    /// # Errors
    /// As [`check_sensors`]; nothing has changed then.
    pub fn assign(&mut self, sensors: &[Sensor]) -> Result<(), Refusal> {
        check_sensors(sensors)?;
        for (finger, k) in self.finger.iter_mut().zip(0..) {
            let port = port_of(sensors, k);
            if port != finger.port {
                let rest = if port == Some(Port::Gauges) { crate::source::gauges::REST } else { 0.0 };
                *finger = Finger { port, offset: [rest; 6], ..Finger::NONE };
            }
        }
        Ok(())
    }

    /// The sensors in use.
    pub fn sensors(&self) -> impl Iterator<Item = Sensor> {
        self.finger.iter().zip(0..).filter_map(|(f, finger)| f.port.map(|port| Sensor { port, finger }))
    }

    /// Sets one finger's matrix.
    pub fn calibrate(&mut self, calibration: &Calibration) {
        if let Some(finger) = self.finger.get_mut(usize::from(calibration.finger)) {
            finger.matrix = Some(calibration.matrix);
        }
    }

    /// The first finger (0 or 1) without a matrix.
    pub fn uncalibrated(&self) -> Option<u8> {
        self.finger.iter().zip(0..).find(|(f, _)| f.matrix.is_none()).map(|(_, k)| k)
    }

    /// Grip set-point while the host sends none.
    pub fn set_grip(&mut self, force_n: f32) {
        self.grip_n = force_n;
    }

    /// What to assume of the poses where no host tells any.
    pub fn set_grasp(&mut self, grasp: Option<Grasp>) {
        self.grasp = grasp;
    }

    /// Averages the coming half second as no load, both fingers.
    pub fn tare(&mut self) {
        for finger in &mut self.finger {
            finger.taring = Some(None);
        }
    }

    /// Of which finger a tare goes on: with a sensor.
    pub fn taring(&self) -> [bool; 2] {
        let [first, second] = &self.finger;
        [first, second].map(|f| f.port.is_some() && f.taring.is_some())
    }

    /// Whether a tare goes on.
    pub fn is_taring(&self) -> bool {
        self.taring().contains(&true)
    }

    /// What counts as no load, by the sensors' numbers.
    pub fn offsets(&self) -> [[f32; 6]; 2] {
        let [first, second] = &self.finger;
        [first.offset, second.offset]
    }

    /// Sets what counts as no load, as [`Self::offsets`] gave it.
    pub fn set_offsets(&mut self, offsets: [[f32; 6]; 2]) {
        for (finger, offset) in self.finger.iter_mut().zip(offsets) {
            (finger.offset, finger.taring) = (offset, None);
        }
    }

    /// A reading of the sensor of `finger`; `false` where it is not used: not of the sensor in use, older than
    /// the newest, or not finite.
    pub fn take(&mut self, port: Port, finger: u8, reading: Reading) -> bool {
        let own = self.finger.get_mut(usize::from(finger)).filter(|f| f.port == Some(port));
        own.is_some_and(|f| f.take(reading))
    }

    /// A sample of the host, measured at `at_us` by the unit's clock, or come then where the host's is not known.
    pub fn told(&mut self, sample: Sample, at_us: u32) {
        self.told = true;
        self.newest = Some(Newest { sample, at_us, new: true });
    }

    /// Whether the poses of the last sample were the stored ones.
    pub fn is_alone(&self) -> bool {
        self.alone
    }

    /// When the oldest wrench of the last sample was measured, us by the unit's clock; its tick's time, where it has none.
    pub fn measured_us(&self) -> u32 {
        self.measured_us
    }

    /// The sample of the tick at `now_us` by the unit's clock, which may wrap around. Its time is the tick's, since the run's first:
    /// the readings in it are each of another time ([`Self::measured_us`]).
    pub fn sample(&mut self, now_us: u32) -> Sample {
        let seq = self.seq;
        self.seq = seq.wrapping_add(1);
        let began_us = *self.began_us.get_or_insert(now_us);
        let [first, second] = &self.finger;
        let measured = [first.wrench(now_us), second.wrench(now_us)];
        let oldest_us = measured.iter().flatten().fold(0, |oldest, (_, age_us)| oldest.max(*age_us));
        self.measured_us = now_us.wrapping_sub(oldest_us);
        let finger = measured.map(|reading| reading.map(|(wrench, _)| wrench));
        let (mut gripper, mut object, mut pusher, mut grip_cmd_n) = (None, None, None, self.grip_n);
        let grasp = self.grasp.filter(|_| !self.told);
        self.alone = grasp.is_some();
        if let Some(grasp) = grasp {
            gripper = Some(grasp.gripper);
            // A measurement it is not: it only says where to begin.
            object = (seq == 0).then_some(grasp.object);
        }
        let fresh = self.newest.as_mut().filter(|n| age_us(n.at_us, now_us) <= MAX_AGE_US);
        if let Some(newest) = fresh {
            (gripper, pusher) = (newest.sample.gripper, newest.sample.pusher);
            object = newest.sample.object.filter(|_| newest.new);
            newest.new = false;
            grip_cmd_n = newest.sample.grip_cmd_n;
        }
        Sample { seq, t_us: now_us.wrapping_sub(began_us), grip_cmd_n, gripper, object, pusher, finger }
    }
}
