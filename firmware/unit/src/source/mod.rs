//! Sources of fingertip wrenches: each takes what its sensor sends (bytes, frames, converter counts) with the
//! time of arrival, and gives readings with the sensor's own time.
//!
//! A source knows its sensor's protocol and nothing of fingers, runs or transports. Six numbers of a reading
//! become a finger's wrench by that finger's 6 x 6 matrix and tare ([`crate::fingers`]): of raw gauges it is
//! their calibration, of a sensor that gives N and N m how it is mounted.

pub mod ati;
pub mod ft300;
pub mod gauges;
pub mod hub;

/// What a sensor measured at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// When it was measured, us by the unit's clock, which may wrap around.
    pub at_us: u32,
    /// For how long it stands where nothing newer comes, us: the sensor's own delay and one and a half of
    /// its periods. A reading lost is none held on to.
    pub stands_us: u32,
    /// By the sensor: force (N) and torque (N m), or converter counts.
    pub values: [f32; 6],
}

/// A sensor's protocol.
pub trait WrenchSource {
    /// What arrives: a byte, a frame, a scan of converters.
    type Input<'a>;

    /// Takes what arrived at `at_us`; a reading where it completes one.
    fn take(&mut self, input: Self::Input<'_>, at_us: u32) -> Option<Reading>;

    /// What was lost so far.
    fn losses(&self) -> Losses;
}

/// What of a sensor's stream could not be used. Counts stay at their largest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Frames whose checksum, length or numbers are not what the protocol says.
    pub damaged: u32,
    /// Bytes or frames outside any frame, or of another sensor.
    pub skipped: u32,
    /// Readings that the sensor itself marks as faulty.
    pub faulty: u32,
    /// Readings that never came, by the sensor's own count or beat, but for those that came damaged.
    pub lost: u32,
}

impl Losses {
    /// Nothing yet.
    pub const NONE: Self = Self { damaged: 0, skipped: 0, faulty: 0, lost: 0 };
}

pub(crate) fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
