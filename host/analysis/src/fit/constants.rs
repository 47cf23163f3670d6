//! What adds a constant to a channel of force or torque in every trial: the sensor's own error.

use stickslip_data::Sensors;

use crate::fit::gls::{OFFSETS, Prior};

/// Prior of the constants ([`crate::fit::gls`] has their order): a sensor's error is uniform within the uncertainty stated, about,
/// and beyond a tenth more and the noise it is no nuisance any more.
#[must_use]
pub fn prior(sensors: &Sensors) -> Prior {
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
