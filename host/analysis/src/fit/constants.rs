//! What adds a constant to channels of force and torque in every trial: each sensor's own error, and pads that are off square.
//!
//! Pads whose faces are not parallel to the object's are pressed more on one side. Where all of it touches that is a moment about
//! the axes along the face, a pad's stiffness against turning times its angle, whatever the grip. What both moments have in
//! common must be balanced by forces along the faces ([`super::sharing`]) and slides away with them; what they differ in, the object
//! holds as long as it is gripped: for stiff pads more than a sensor's error is stated to be, on both fingers' sensors with
//! opposite signs. It is no finding.

use stickslip_data::Sensors;
use stickslip_shared::effects::contact_compliance::tangential_m_n;
use stickslip_shared::model::{FingerContact, Model};

use crate::fit::campaign::Campaign;
use crate::fit::gls::{OFFSETS, Prior, SENSORS};

/// Standard deviation of a pad's angle to the face, rad: 0.01 mm over 20 mm, a pad that was ground or set up.
const MOUNTED_RAD: f64 = 5e-4;
/// A pad of hard material gives way along its face by this for each newton where nothing else is known of it, m/N.
const HARD_M_N: f64 = 1e-6;
/// Share of the grip and of a pad's radius beyond which it lifts off on one side: a disc on springs.
const LIFTS_OFF: f64 = 0.25;
/// Most of a moment, in standard deviations.
const MOST: f64 = 3.0;

/// Prior of the constants in the order of [`super::gls`]. A sensor's error is uniform within the uncertainty stated, about: beyond a
/// tenth more and the noise it is no nuisance any more. Moments of pads of `model` are those of pads that are set up nearly square.
#[must_use]
pub fn prior(campaign: &Campaign, model: &Model<f64>) -> Prior {
    let mut out = of_sensors(&campaign.description.sensors);
    // Half of the difference of two pads.
    let opposed_nm = std::f64::consts::FRAC_1_SQRT_2 * off_square_nm(campaign, model);
    for of in SENSORS..OFFSETS {
        out.precision[of] = (opposed_nm * opposed_nm).max(1e-18).recip();
        out.bound[of] = MOST * opposed_nm;
    }
    out
}

fn of_sensors(sensors: &Sensors) -> Prior {
    let mut out = Prior::none(OFFSETS);
    for o in 0..SENSORS {
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
