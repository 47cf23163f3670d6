//! What the points of a disc cannot tell.
//!
//! A pad that turns while it shifts slowly bears a force that three points at one radius do not tell the same forth and back
//! (`stickslip_shared::contact::spread`). The fingers' points lie opposite, so that their sum is right; their difference is off
//! by some per cent of the friction. It is no property of the contact: a direction of the features' covariance, half of what
//! changes where both fingers' points are exchanged.

use stickslip_shared::effects::contact_compliance::exchange_points;
use stickslip_shared::model::Model;

use crate::fit::campaign::Run;
use crate::fit::features::Features;

/// The direction of one standard deviation, of the features `here` of `model` along `run`; none where nothing is exchanged.
#[must_use]
pub fn directions(run: &Run, model: &Model<f64>, here: &Features) -> Vec<Features> {
    let mut exchanged = model.clone();
    let pads =
        exchanged.effects.iter_mut().filter(|e| e.info().is_some_and(|info| info.role.is_compliance()));
    for pads in pads {
        exchange_points(&mut pads.parameters);
    }
    if run.prepared.scene.fingers.is_none() || exchanged == *model {
        return Vec::new();
    }
    let with = run.bins.modelled(&run.prepared.simulate_every(&exchanged, run.stride));
    vec![with.iter().zip(here).map(|(w, h)| 0.5 * (w - h)).collect()]
}
