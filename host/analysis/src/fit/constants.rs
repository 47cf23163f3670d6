//! What a rig has in every trial alike, and is no finding.
//!
//! Each sensor's constant error, within what is stated. Where each sensor has its origin: that of the drawing to a tenth of a
//! millimetre; a pad presses beside its middle, which is another origin for its finger's wrench, and shows moments of the grip and
//! of what the finger pushes with. And pads whose faces are not parallel to the object's are pressed more on one side. Where all of
//! it touches that is a moment about the axes along the face, a pad's stiffness against turning times its angle, whatever the grip.
//! What both moments have in common must be balanced by forces along the faces ([`super::sharing`]) and slides away with them; what
//! they differ in, the object holds as long as it is gripped: for stiff pads more than a sensor's error is stated to be, on both
//! fingers' sensors with opposite signs.
//!
//! Each is one coefficient of all trials with a prior; what is far beyond it is a finding, of the effect that is about it.

use std::ops::Range;

use nalgebra::Vector3;
use stickslip_data::Sensors;
use stickslip_shared::effects::contact_compliance::tangential_m_n;
use stickslip_shared::effects::{Info, Role};
use stickslip_shared::model::Model;

use crate::channels::COUNT;
use crate::evidence::sensors::most_error;
use crate::fit::campaign::Campaign;
use crate::fit::features::{FEATURES, Features};
use crate::fit::gls::Prior;
use crate::fit::phases::{BINS, PEAK};

/// Constant errors of the force and torque channels of finger 1, finger 2 and pusher, N and N m.
pub const SENSORS: Range<usize> = 0..COUNT - 6;
/// Moments about X and Z with which two pads press against each other, N m.
pub const OPPOSED: Range<usize> = SENSORS.end..SENSORS.end + 2;
/// Origins of the sensors of finger 1, finger 2 and pusher beside their place, along X, Y and Z, m.
pub const ORIGINS: Range<usize> = OPPOSED.end..OPPOSED.end + 9;
/// Number of constants: nuisances of every fit.
pub const OFFSETS: usize = ORIGINS.end;

/// Standard deviation of a pad's angle to the face, rad: 0.01 mm over 20 mm, a pad that was ground or set up.
const SQUARE_RAD: f64 = 5e-4;
/// A pad of hard material gives way along its face by this for each newton where nothing else is known of it, m/N.
const HARD_M_N: f64 = 1e-6;
/// Share of the grip and of a pad's radius beyond which it lifts off on one side: a disc on springs.
const LIFTS_OFF: f64 = 0.25;
/// Standard deviation of the middle of a pad's pressure, as share of its diameter: 0.2 mm of 20 mm.
pub const OF_DIAMETER: f64 = 0.01;
/// Standard deviation of a sensor's origin, m: parts that are screwed together.
const ORIGIN_M: f64 = 1e-4;
/// Most of a constant that is assumed, in standard deviations.
const MOST: f64 = 3.0;
/// Share of its bound from which a constant counts as being there.
const AT_BOUND: f64 = 0.99;

/// First channel of the sum of both fingers' wrenches, of their difference, and of the pusher's.
const SUM: usize = 6;
const DIFFERENCE: usize = 12;
const PUSHER: usize = 18;

/// The channels that a unit of a constant error or moment shifts, and by how much: finger 1, finger 2 (in their sum and in their
/// difference), pusher; then equal and opposite torques of both fingers, which only their difference shows.
#[must_use]
pub fn shifts(offset: usize) -> Vec<(usize, f64)> {
    match offset {
        0..6 => vec![(offset + SUM, 1.0), (offset + DIFFERENCE, 1.0)],
        6..12 => vec![(offset, 1.0), (offset + 6, -1.0)],
        _ if OPPOSED.contains(&offset) => vec![(DIFFERENCE + 3 + 2 * (offset - OPPOSED.start), 2.0)],
        _ => vec![(offset + 6, 1.0)],
    }
}

/// What a constant error or moment of this size adds to the features; a peak is counted from a mean, which moves with it.
#[must_use]
pub fn constant(offset: usize, size: f64) -> Features {
    let mut out = vec![0.0; FEATURES];
    for (channel, sign) in shifts(offset) {
        out[channel * BINS..channel * BINS + PEAK].fill(sign * size);
    }
    out
}

/// What a unit of each constant adds to the features of a group that was `measured`.
#[must_use]
pub fn columns(measured: &Features) -> Vec<Features> {
    let constants = (0..OPPOSED.end).map(|offset| constant(offset, 1.0));
    let origins = (0..9).map(|k| origin(measured, k / 3, k % 3));
    constants.chain(origins).collect()
}

/// What an origin of a `sensor` 1 m along an `axis` beside its place makes of features like these: `-d x f`.
fn origin(measured: &Features, sensor: usize, axis: usize) -> Features {
    let mut out = vec![0.0; FEATURES];
    let mut d = Vector3::zeros();
    d[axis] = 1.0;
    for bin in 0..PEAK {
        let at = |first: usize| Vector3::from_fn(|k, _| measured[(first + k) * BINS + bin]);
        // Finger 2 is the sum less finger 1.
        let finger = if sensor == 0 { 1.0 } else { -1.0 };
        let force_n = match sensor {
            2 => at(PUSHER),
            _ => 0.5 * (at(SUM) + finger * at(DIFFERENCE)),
        };
        let torque_nm = force_n.cross(&d);
        for k in 0..3 {
            let mut show = |first: usize, x: f64| out[(first + 3 + k) * BINS + bin] = x;
            match sensor {
                2 => show(PUSHER, torque_nm[k]),
                _ => {
                    show(SUM, torque_nm[k]);
                    show(DIFFERENCE, finger * torque_nm[k]);
                }
            }
        }
    }
    out
}

/// Prior of the constants in the order of [`columns`]. A sensor's error is uniform within the uncertainty stated, about: beyond
/// [`most_error`] it is no nuisance any more. Moments of pads of `model` are those of pads that are set up nearly square.
#[must_use]
pub fn prior(campaign: &Campaign, model: &Model<f64>) -> Prior {
    let mut out = of_sensors(&campaign.description.sensors);
    // Half of the difference of two pads.
    let opposed_nm = std::f64::consts::FRAC_1_SQRT_2 * off_square_nm(campaign, model);
    let beside_m = OF_DIAMETER * campaign.pad_diameter_m().unwrap_or(0.0);
    for of in OPPOSED.start..OFFSETS {
        let sd = match of {
            _ if OPPOSED.contains(&of) => opposed_nm,
            // Each pad presses beside its middle as well, along its face.
            _ if is_along_face(of - ORIGINS.start) => beside_m.hypot(ORIGIN_M),
            _ => ORIGIN_M,
        };
        out.precision[of] = (sd * sd).max(1e-18).recip();
        out.bound[of] = MOST * sd;
    }
    out
}

/// Places of the parameters of an effect that something can be said of beside a fit's constants `offsets`: of a sensor's constant errors
/// those of the channels whose constant has come to its bound. What is within what is stated is a nuisance in every fit already, and
/// eighteen more constants that follow the noise cost a set that has one of them its prediction of held-out conditions.
#[must_use]
pub fn open(info: &Info, offsets: &[f64], prior: &Prior) -> Vec<usize> {
    let is_bias = info.role == Role::Constants;
    let at_bound = |k: &usize| offsets.get(*k).is_some_and(|x| x.abs() >= AT_BOUND * prior.bound[*k]);
    (0..info.parameters.len()).filter(|k| !is_bias || at_bound(k)).collect()
}

/// Whether an origin is that of a finger along X or Z.
fn is_along_face(origin: usize) -> bool {
    origin < 6 && origin % 3 != 1
}

fn of_sensors(sensors: &Sensors) -> Prior {
    let mut out = Prior::none(OFFSETS);
    for o in SENSORS {
        let sensor = if o < 12 { &sensors.finger } else { &sensors.pusher };
        let (noise, uncertainty) = match o % 6 {
            0..3 => (sensor.force_noise_n.max(1e-4), sensor.force_uncertainty_n),
            _ => (sensor.torque_noise_nm.max(1e-6), sensor.torque_uncertainty_nm),
        };
        out.precision[o] = 1.0 / (uncertainty * uncertainty / 3.0 + 0.01 * noise * noise);
        out.bound[o] = most_error(sensor, o % 6 >= 3);
    }
    out
}

/// Standard deviation of the moment of one pad of `model`, N m: at most what lifts it off at the least grip; zero where the fingers
/// have no discs. Pressed in, a pad is taken to be as stiff as along its face.
fn off_square_nm(campaign: &Campaign, model: &Model<f64>) -> f64 {
    let grips_n = campaign.runs.iter().map(|r| r.prepared.grip_n()).filter(|n| *n > 0.0);
    let least_n = grips_n.fold(f64::INFINITY, f64::min);
    let (Some(diameter_m), true) = (campaign.pad_diameter_m(), least_n.is_finite()) else { return 0.0 };
    let pads = model.effects.iter().find(|e| e.info().is_some_and(|info| info.role.is_compliance()));
    let compliance_m_n = pads.map_or(0.0, |e| tangential_m_n(&e.parameters, least_n)).max(HARD_M_N);
    let radius_m = 0.5 * diameter_m;
    // A disc on springs: its second moment is a quarter of its squared radius.
    let stiffness_nm_rad = 0.25 * radius_m * radius_m / compliance_m_n;
    (stiffness_nm_rad * SQUARE_RAD).min(LIFTS_OFF * least_n * radius_m)
}
