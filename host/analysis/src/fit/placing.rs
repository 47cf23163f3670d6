//! Where the object lies to its pusher, when its pose is known only now and then.
//!
//! Motion capture and the robot have each their own frame, and a calibration between them that
//! differs from place to place. Where the pose is measured at every sample the features take its
//! changes; where it is known before and after a push only, the frames' difference moves the first
//! touch, the lever of the push and the end of the way. It is no property of the contact: two directions
//! of the features' covariance, the object placed elsewhere along the pusher's normal and across it. How
//! much is read off: pusher and object touch when the push ends, and what the measured poses leave
//! between them is the frames' difference.

use nalgebra::Vector3;
use stickslip_shared::model::{Model, PusherContact};

use crate::channels::PUSHER_FORCE;
use crate::fit::campaign::Run;
use crate::fit::features::Features;
use crate::run::simulate::Prepared;

/// Share of the trial's largest push beyond which the pusher touches.
const TOUCHES: f64 = 0.3;
/// Step of the derivative, m: small beside an onset, far above the rounding of a step.
const STEP_M: f64 = 2e-4;

/// Distance that the measured poses leave between object and pusher at the end of a push, m: positive
/// apart. `None` where they are not known together, or where the pusher is no point or does not touch.
#[must_use]
pub fn left_between(prepared: &Prepared) -> Option<f64> {
    let Some(PusherContact::Point { tip_radius_m }) = prepared.scene.pusher else { return None };
    let push_n = |row: &[f64]| {
        row[PUSHER_FORCE..PUSHER_FORCE + 3].iter().filter(|f| f.is_finite()).map(|f| f * f).sum()
    };
    let most_n2: f64 = prepared.measured.iter().map(|row| push_n(row)).fold(0.0, f64::max);
    let end = prepared.measured.iter().rposition(|row| row[..6].iter().all(|x| x.is_finite()))?;
    // The last sample with both may come after the rod has stopped: it still leans on the object.
    let touches = push_n(prepared.measured.get(end)?) > TOUCHES * TOUCHES * most_n2;
    let object = prepared.world_pose(end, prepared.measured.get(end)?);
    let tip = prepared.poses().get(end)?.pusher?.position_m;
    let seen = object.rotation.inverse_transform_vector(&(tip - object.position_m));
    let (_, _, distance_m) = prepared.scene.object.shape.closest(&seen);
    (touches && end > 0).then_some(distance_m - tip_radius_m)
}

/// Root mean square of [`left_between`] over the trials whose pose is sparse, m; zero where there are fewer
/// than three.
#[must_use]
pub fn scatter_m(runs: &[Run]) -> f64 {
    let sparse = runs.iter().filter(|r| r.prepared.is_sparse());
    let left: Vec<f64> = sparse.filter_map(|r| left_between(&r.prepared)).collect();
    if left.len() < 3 {
        return 0.0;
    }
    (left.iter().map(|x| x * x).sum::<f64>() / left.len() as f64).sqrt()
}

/// Two directions of one standard deviation `scatter_m` of the placing, for the features `coarse` of the
/// model along `run`; none where the pose is dense or nothing is known of the placing.
#[must_use]
pub fn directions(run: &Run, model: &Model<f64>, coarse: &Features, scatter_m: f64) -> Vec<Features> {
    let pusher = run.prepared.poses().first().and_then(|p| p.pusher);
    let Some(pusher) = pusher.filter(|_| scatter_m > 0.0 && run.prepared.is_sparse()) else {
        return Vec::new();
    };
    let (normal, across) = (pusher.rotation * Vector3::x(), pusher.rotation * Vector3::y());
    let carrier = run.prepared.carrier.rotation;
    [normal, across]
        .iter()
        .map(|along| {
            let shift = carrier.inverse_transform_vector(along) * STEP_M;
            let elsewhere = run.prepared.placed(&shift);
            let moved = run.bins.modelled(&elsewhere.simulate_every(model, run.stride));
            moved.iter().zip(coarse).map(|(m, c)| (m - c) * (scatter_m / STEP_M)).collect()
        })
        .collect()
}
