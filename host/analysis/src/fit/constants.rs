//! What adds a constant to a channel of force or torque in every trial: the sensor's own error, and pads that are mounted off square.
//!
//! A pad whose face is not parallel to the object's is pressed more on one side. Where all of it touches that is a moment about
//! its finger's axes along the face, the pad's stiffness against turning times the angle, whatever the grip: in the data a
//! constant error of the finger's sensor, and for stiff pads far more than that is stated to be. It is no finding.

use stickslip_data::Sensors;
use stickslip_shared::effects::contact_compliance::tangential_m_n;
use stickslip_shared::model::{FingerContact, Model};

use crate::fit::campaign::Campaign;
use crate::fit::gls::{OFFSETS, Prior};

/// Standard deviation of a pad's angle to the face, rad: 6 um over 20 mm, a pad that was ground or set up.
const MOUNTED_RAD: f64 = 3e-4;
/// A pad of hard material gives way along its face by this for each newton where nothing else is known of it, m/N.
const HARD_M_N: f64 = 1e-6;
/// Share of the grip and of a pad's radius beyond which it lifts off on one side: a disc on springs.
const LIFTS_OFF: f64 = 0.25;
/// Most of a moment, in standard deviations.
const MOST: f64 = 2.0;

/// Prior of the constants ([`crate::fit::gls`] has their order): a sensor's error is uniform within the uncertainty stated, about,
/// and beyond a tenth more and the noise it is no nuisance any more; a finger's torques along the face hold the moment of its pad as well.
#[must_use]
pub fn prior(campaign: &Campaign, model: &Model<f64>) -> Prior {
    let sensors = &campaign.description.sensors;
    let off_square_nm = off_square_nm(campaign, model);
    let mut out = of_sensors(sensors);
    for finger in 0..2 {
        // About X and about Z; the closing direction is Y.
        for of in [6 * finger + 3, 6 * finger + 5] {
            out.precision[of] = 1.0 / (1.0 / out.precision[of] + off_square_nm * off_square_nm);
            out.bound[of] += MOST * off_square_nm;
        }
    }
    out
}

fn of_sensors(sensors: &Sensors) -> Prior {
    let mut out = Prior::none(OFFSETS);
    for o in 0..OFFSETS {
        let sensor = if o < 12 { &sensors.finger } else { &sensors.pusher };
        let (noise, uncertainty) = match o % 6 {
            0..3 => (sensor.force_noise_n.max(1e-4), sensor.force_uncertainty_n),
            _ => (sensor.torque_noise_nm.max(1e-6), sensor.torque_uncertainty_nm),
        };
        out.precision[o] = 1.0 / (uncertainty * uncertainty / 3.0 + 0.01 * noise * noise);
        out.bound[o] = 1.1 * uncertainty + 3.0 * noise;
    }
    out
}

/// Standard deviation of the moment of one pad of `model`, N m: at most what lifts it off at the least grip; zero where the fingers
/// have no discs. Pressed in, a pad is taken to be as stiff as along its face.
fn off_square_nm(campaign: &Campaign, model: &Model<f64>) -> f64 {
    let grips_n = campaign.runs.iter().map(|r| r.prepared.grip_n()).filter(|n| *n > 0.0);
    let least_n = grips_n.fold(f64::INFINITY, f64::min);
    let fingers = campaign.runs.iter().find_map(|r| r.prepared.scene.fingers);
    let (Some(FingerContact::Disc { diameter_m }), true) = (fingers, least_n.is_finite()) else { return 0.0 };
    let pads = model.effects.iter().find(|e| e.info().is_some_and(|info| info.role.is_compliance()));
    let compliance_m_n = pads.map_or(0.0, |e| tangential_m_n(&e.parameters, least_n)).max(HARD_M_N);
    let radius_m = 0.5 * diameter_m;
    // A disc on springs: its second moment is a quarter of its squared radius.
    let stiffness_nm_rad = 0.25 * radius_m * radius_m / compliance_m_n;
    (stiffness_nm_rad * MOUNTED_RAD).min(LIFTS_OFF * least_n * radius_m)
}
