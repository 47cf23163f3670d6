//! How square the pusher is mounted.
//!
//! A plate or an edge that is told to be square is so as well as it was set up. A face that lies flat on a stiff plate is
//! pressed at its rim by far less than a milliradian; the object turns by micrometres in its pads and friction of the plate
//! holds it, so that forces across the push change by up to a newton. It is no property of the contact: directions of the
//! features' covariance, the pusher turned about each of its axes that matters. What is much larger is a finding
//! (`stickslip_shared::effects::plate_tilt`).

use nalgebra::{UnitVector3, Vector3};
use stickslip_shared::model::{Model, PusherContact};

use crate::fit::campaign::Run;
use crate::fit::features::Features;

/// Standard deviation of each angle, rad: 0.02 mm over 100 mm, what a dial gauge sets up.
const MOUNTED_RAD: f64 = 2e-4;

/// Directions of one standard deviation each, of the features of `model` along `run`: a plate turned about its axes Y and Z,
/// an edge about Z, so that one end of it comes first; none for a tip.
#[must_use]
pub fn directions(run: &Run, model: &Model<f64>) -> Vec<Features> {
    let turned = |axis: &UnitVector3<f64>, angle_rad: f64| {
        let elsewhere = run.prepared.mounted(axis, angle_rad);
        run.bins.modelled(&elsewhere.simulate_every(model, run.stride))
    };
    // Whichever way it is turned a face lifts off: half of the way from one to the other.
    let direction = |axis: &UnitVector3<f64>| {
        let [one, other] = [1.0, -1.0].map(|side| turned(axis, side * MOUNTED_RAD));
        one.iter().zip(&other).map(|(a, b)| 0.5 * (a - b)).collect()
    };
    let (y, z) = (Vector3::y_axis(), Vector3::z_axis());
    match run.prepared.scene.pusher {
        Some(PusherContact::Plane) => vec![direction(&y), direction(&z)],
        Some(PusherContact::Line { .. }) => vec![direction(&z)],
        _ => Vec::new(),
    }
}
