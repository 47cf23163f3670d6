//! What the fingers bear of an object that also lies on something.
//!
//! It is left from closing the grasp, and only the fingers' sensors know it ([`crate::evidence::carried`]), as well as they
//! know any constant force. An error of 0.1 N at rest is an error of what pads hold when the object is lifted or
//! turned, and no property of the contact: directions of the features' covariance.

use stickslip_data::Sensors;
use stickslip_shared::model::Model;

use crate::fit::campaign::Run;
use crate::fit::features::Features;
use crate::run::simulate::{Carried, Prepared};

/// Share of the weight by which it is changed: far above a step's rounding.
const STEP: f64 = 0.1;

/// Directions of one standard deviation each, of the features `here` of `model` along `run`: one upward, and where the object touches an edge
/// one to the side; none where nothing lies under the object, or the fingers' forces are not measured. Each sensor is uniform
/// within its stated uncertainty.
#[must_use]
pub fn directions(run: &Run, model: &Model<f64>, here: &Features, sensors: &Sensors) -> Vec<Features> {
    let sd_n = (2.0_f64 / 3.0).sqrt() * sensors.finger.force_uncertainty_n;
    let direction = |(elsewhere, step_n): (Prepared, f64)| {
        let moved = run.bins.modelled(&elsewhere.simulate_every(model, run.stride));
        moved.iter().zip(here).map(|(m, c)| (m - c) * (sd_n / step_n)).collect()
    };
    elsewhere(&run.prepared).into_iter().map(direction).collect()
}

/// The same trial with something else borne, and by how much it differs, N, towards the middle.
fn elsewhere(prepared: &Prepared) -> Vec<(Prepared, f64)> {
    let (Some(carried), weight_n) = (prepared.carried, prepared.weight_n()) else { return Vec::new() };
    if weight_n <= 0.0 {
        return Vec::new();
    }
    let towards = |from_n: f64, middle_n: f64| if from_n > middle_n { -STEP } else { STEP } * weight_n;
    let up_n = towards(carried.up_n, 0.5 * weight_n);
    let mut out = vec![(prepared.carrying(Carried { up_n: carried.up_n + up_n, ..carried }), up_n)];
    if !prepared.rests() && prepared.side().is_some() {
        let side_n = towards(carried.side_n, 0.0);
        out.push((prepared.carrying(Carried { side_n: carried.side_n + side_n, ..carried }), side_n));
    }
    out
}
