//! How much of the weight the fingers carry of an object that also lies on something.
//!
//! It is left from closing the grasp, and only the fingers' sensors know it ([`crate::evidence::carried`]), as well as they
//! know any constant force. An error of 0.1 N at rest is an error of what pads hold when the object is lifted or
//! turned, and no property of the contact: a direction of the features' covariance.

use stickslip_data::Sensors;
use stickslip_shared::model::Model;

use crate::fit::campaign::Run;
use crate::fit::features::Features;
use crate::run::simulate::Prepared;

/// Share of the weight by which it is changed: far above a step's rounding.
const STEP: f64 = 0.1;

/// One direction of one standard deviation, of the features of `model` along `run`; `None` where nothing lies under the
/// object, or the fingers' forces are not measured. Each sensor is uniform within its stated uncertainty.
#[must_use]
pub fn direction(run: &Run, model: &Model<f64>, sensors: &Sensors) -> Option<Features> {
    let (elsewhere, step_n) = elsewhere(&run.prepared)?;
    let features = |prepared: &Prepared| run.bins.modelled(&prepared.simulate_every(model, run.stride));
    let sd_n = (2.0_f64 / 3.0).sqrt() * sensors.finger.force_uncertainty_n;
    let moved = features(&elsewhere);
    Some(moved.iter().zip(&features(&run.prepared)).map(|(m, c)| (m - c) * (sd_n / step_n)).collect())
}

/// The same trial with another share of the weight carried, and by how much it differs, towards the middle.
fn elsewhere(prepared: &Prepared) -> Option<(Prepared, f64)> {
    let (carried_n, weight_n) = (prepared.carried_n?, prepared.weight_n());
    let step_n = if carried_n > 0.5 * weight_n { -STEP } else { STEP } * weight_n;
    (weight_n > 0.0).then(|| (prepared.carrying(carried_n + step_n), step_n))
}
