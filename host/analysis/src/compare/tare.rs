//! Constant sensor offsets, and what may be called one.
//!
//! Before contact the model says what a true sensor would show. The mean of measured minus
//! modelled there ([`crate::evidence::offsets`]) is taken as that trial's offset of a force or torque
//! channel and subtracted. What of its mean over the data set is more than the uncertainty that
//! `dataset.toml` states (a tenth more, the noise, and for the fingers how they share the
//! object's weight) is no offset and stays: a pressure that is not centred, a wrong mass.
//!
//! The fingers' normal forces are the exception: both too high is a grip that differs from
//! the command, which a tare would hide. Of them only the imbalance `(d1 + d2) / 2` is
//! taken out trial by trial (a grip loads both fingers alike with opposite signs). The
//! opposite part `(d2 - d1) / 2`, the measured less the commanded grip, stays in the errors,
//! except for its mean over the whole data set where that is within the sensors' stated
//! uncertainty: then nobody can tell it from their offset, and the report says so.

use schemars::JsonSchema;
use serde::Serialize;

use super::trial::TrialErrors;
use crate::channels::{COUNT, NAMES, Quantity, Signals, quantity};
use crate::evidence::tolerance::RIGID;
use stickslip_data::{Description, Sensors};

/// Finger 1's and finger 2's normal force.
pub const NORMAL: [usize; 2] = [7, 13];

/// How sensor offsets are treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum Tare {
    /// Each trial's mean before contact is taken out of force and torque channels.
    BeforeContact,
    /// Measurements are used as they are.
    None,
}

/// Offset of one channel over the data set.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct ChannelOffset {
    /// Name of the channel.
    pub channel: &'static str,
    /// SI.
    pub unit: &'static str,
    /// Mean of measured minus modelled before contact.
    pub mean: f64,
    /// Standard deviation from trial to trial.
    pub deviation: f64,
    /// Bound that dataset.toml states; 0: not stated.
    pub stated_bound: f64,
    /// More than the stated bound: hardly an offset of the sensor.
    pub beyond_bound: bool,
}

/// Grip: measured less commanded, mean of both fingers before contact.
#[derive(Clone, Copy, Debug, JsonSchema, Serialize)]
pub struct GripError {
    /// Mean over the trials, N.
    pub mean_n: f64,
    /// Standard deviation from trial to trial, N.
    pub deviation_n: f64,
    /// Whether the mean counts as sensor offset (within the stated bound) and was taken out.
    pub taken_out: bool,
}

/// What was found, and what was done with it.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Offsets {
    /// How.
    pub tare: Tare,
    /// By channel, measured ones only.
    pub channels: Vec<ChannelOffset>,
    /// Where both fingers are measured.
    pub grip: Option<GripError>,
    /// Trials with too little before contact: the mean offset of the others is taken.
    pub trials_without: usize,
}

/// Finds the offsets of all trials, and what is to be taken out of each.
pub fn offsets(trials: &[&TrialErrors], description: &Description, tare: Tare) -> (Offsets, Vec<Signals>) {
    let sensors = &description.sensors;
    let known = |k: usize| trials.iter().map(move |t| t.offset[k]).filter(|x| x.is_finite());
    let mean: Signals = std::array::from_fn(|k| mean_and_deviation(known(k)).0);
    let channels = (0..COUNT)
        .filter(|k| mean[*k].is_finite())
        .map(|k| {
            let (mean, deviation) = mean_and_deviation(known(k));
            let stated_bound = stated_bound(sensors, k);
            ChannelOffset {
                channel: NAMES[k],
                unit: quantity(k).unit(),
                mean,
                deviation,
                stated_bound,
                beyond_bound: stated_bound > 0.0 && mean.abs() > stated_bound,
            }
        })
        .collect();
    let grips = trials.iter().map(|t| grip_error(&t.offset)).filter(|g| g.is_finite());
    let (grip_mean, grip_deviation) = mean_and_deviation(grips);
    let constant = grip_mean.abs() <= stated_bound(sensors, NORMAL[0]);
    let grip = grip_mean.is_finite().then_some(GripError {
        mean_n: grip_mean,
        deviation_n: grip_deviation,
        taken_out: constant && tare == Tare::BeforeContact,
    });
    let grip_offset = if constant { grip_mean } else { 0.0 };
    let beyond: Signals = std::array::from_fn(|k| {
        let most = largest_offset(description, k);
        if most > 0.0 && mean[k].is_finite() { mean[k] - mean[k].clamp(-most, most) } else { 0.0 }
    });
    let tares = trials
        .iter()
        .map(|t| match tare {
            Tare::None => [0.0; COUNT],
            Tare::BeforeContact => of_trial(&t.offset, &mean, &beyond, grip_offset),
        })
        .collect();
    let without = |t: &&&TrialErrors| (0..COUNT).any(|k| mean[k].is_finite() && !t.offset[k].is_finite());
    let trials_without = trials.iter().filter(without).count();
    (Offsets { tare, channels, grip, trials_without }, tares)
}

/// What is taken out of one trial; `beyond` is what of the mean is no offset.
fn of_trial(offset: &Signals, mean: &Signals, beyond: &Signals, grip_offset: f64) -> Signals {
    let mut out: Signals = std::array::from_fn(|k| {
        [offset[k], mean[k]].into_iter().find(|x| x.is_finite()).map_or(0.0, |x| x - beyond[k])
    });
    let [one, two] = NORMAL;
    let imbalance = 0.5 * (out[one] + out[two]);
    let both = mean[one].is_finite() && mean[two].is_finite();
    // A single measured finger cannot tell grip from offset: nothing is taken out of it.
    (out[one], out[two]) = if both { (imbalance - grip_offset, imbalance + grip_offset) } else { (0.0, 0.0) };
    out
}

/// Measured less commanded grip. Finger 1 presses along -Y, finger 2 along +Y.
fn grip_error(offset: &Signals) -> f64 {
    0.5 * (offset[NORMAL[1]] - offset[NORMAL[0]])
}

/// The bound on a constant error that dataset.toml states.
pub fn stated_bound(sensors: &Sensors, channel: usize) -> f64 {
    let sensor = if channel < 18 { sensors.finger } else { sensors.pusher };
    match quantity(channel) {
        Quantity::Force => sensor.force_uncertainty_n,
        Quantity::Torque => sensor.torque_uncertainty_nm,
        Quantity::Position | Quantity::Rotation => 0.0,
    }
}

/// What may be called an offset at most; 0 where the data set states nothing.
fn largest_offset(description: &Description, channel: usize) -> f64 {
    let sensor = if channel < 18 { description.sensors.finger } else { description.sensors.pusher };
    let stated = stated_bound(&description.sensors, channel);
    if stated <= 0.0 {
        return 0.0;
    }
    let gravity = description.gravity_m_s2.iter().map(|g| g * g).sum::<f64>().sqrt();
    let weight_n = description.objects.iter().map(|o| o.mass_kg).fold(0.0, f64::max) * gravity;
    let shared = if channel < 18 { RIGID.share_of_weight(weight_n, quantity(channel)) } else { 0.0 };
    let noise = match quantity(channel) {
        Quantity::Force => sensor.force_noise_n,
        _ => sensor.torque_noise_nm,
    };
    1.1 * stated + 3.0 * noise + shared
}

/// Mean and standard deviation; NaN where there is nothing.
fn mean_and_deviation(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let square = values.map(|x| (x - mean) * (x - mean)).sum::<f64>();
    (if n > 0.0 { mean } else { f64::NAN }, if n > 1.0 { (square / (n - 1.0)).sqrt() } else { 0.0 })
}
