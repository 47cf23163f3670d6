//! How evenly the pads press.
//!
//! A pad that turns resists a slow shift beside the turn by what lies near its middle: `F = mu N <e e^T / r> v / omega`, with `e`
//! the direction from the middle and `r` the distance. That is the same along and across under even pressure, as the model has it;
//! no real pad presses that evenly. With a pressure `1 + a cos 2 phi` about the middle it differs by the factor `1 + a`, along
//! axes that nobody knows. What the object is forced to do (an edge that it turns about) then takes another force,
//! and where it may it moves otherwise. It is no property of the contact: two directions of the features' covariance, the
//! shift of the pads resisted more along than across, and more along one diagonal than the other.
//!
//! To first order a pad that resists `(I + A) v` is one that resists `v` on a gripper that moves by `-A v` beside its track.

use nalgebra::{Matrix2, Vector2, Vector3};
use stickslip_shared::model::Model;

use crate::channels::Signals;
use crate::fit::campaign::Run;
use crate::fit::features::Features;
use crate::run::simulate::Simulated;

/// Standard deviation of `a`. What a pad resists altogether is no direction: it changes no force where the object is free to shift, and
/// is what friction that falls or rises with the slip does as well.
pub const UNEVEN: f64 = 0.2;
/// Less of a turn beside a shift, as share of a radius, is none: straight sliding shows nothing of it.
const LEAST: f64 = 1e-3;

/// Directions of one standard deviation each, of the features `here` of `model`, which were reduced from `simulated`, along
/// `run`; none where the fingers have no pads or these hardly turn.
#[must_use]
pub fn directions(run: &Run, model: &Model<f64>, simulated: &Simulated, here: &Features) -> Vec<Features> {
    let Some(diameter_m) = run.prepared.pad_diameter_m() else { return Vec::new() };
    let steps = shifts_beside_turn(&simulated.signals, 0.5 * diameter_m);
    let a = 0.5 * UNEVEN;
    let ways = [Matrix2::new(a, 0.0, 0.0, -a), Matrix2::new(0.0, a, a, 0.0)];
    let direction = |more: &Matrix2<f64>| {
        let mut beside = Vector3::zeros();
        let track = |v: &Vector2<f64>| {
            let v = more * v;
            beside -= Vector3::new(v.x, 0.0, v.y);
            beside
        };
        let track: Vec<Vector3<f64>> = steps.iter().map(track).collect();
        let mut with = run.prepared.shifted(&track).simulate_every(model, run.stride);
        // Seen from where the gripper is.
        for (row, beside) in with.signals.iter_mut().zip(&track) {
            row.iter_mut().zip(beside.iter()).for_each(|(x, more)| *x += more);
        }
        run.bins.modelled(&with).iter().zip(here).map(|(w, h)| w - h).collect()
    };
    match steps.iter().any(|v| v.norm() > 0.0) {
        true => ways.iter().map(direction).collect(),
        false => Vec::new(),
    }
}

/// How far the object shifts over the middle of the pads from each sample to the next (carrier X and Z), as much of it as counts
/// beside the turn of pads with this radius.
fn shifts_beside_turn(signals: &[Signals], radius_m: f64) -> Vec<Vector2<f64>> {
    let step = |w: &[Signals]| {
        let [a, b] = w else { return Vector2::zeros() };
        let turn = b[4] - a[4];
        // Of the object's point at the middle of the pads, where the carrier's origin is.
        let shift = Vector2::new(b[0] - a[0] - turn * b[2], b[2] - a[2] + turn * b[0]);
        let (rim2, shift2) = ((radius_m * turn).powi(2), shift.norm_squared());
        let share = if rim2 > 0.0 { rim2 / (rim2 + shift2) } else { 0.0 };
        if share > LEAST { shift * share } else { Vector2::zeros() }
    };
    std::iter::once(Vector2::zeros()).chain(signals.windows(2).map(step)).collect()
}
