//! How much of an object's weight the fingers carry at rest where it also lies on something: statically undetermined, left
//! from closing the grasp, and known from their sensors alone.

use nalgebra::Vector3;

use crate::evidence::tolerance::RIGID;
use crate::run::simulate::Prepared;

/// Time before a motion that is no rest, as motion is smoothed, s, and samples of rest at least.
const GUARD_S: f64 = 0.016;
const FEWEST_SAMPLES: usize = 5;

/// The same trial where the object only touches an edge at the start: with the fingers carrying what they were measured to. What lies
/// on a table or a platform lies there with its weight.
#[must_use]
pub fn at_an_edge(prepared: Prepared) -> Prepared {
    match measured_n(&prepared) {
        Some(carried_n) if !prepared.rests() => prepared.carrying(carried_n),
        _ => prepared,
    }
}

/// Weight that the fingers were measured to carry before anything moves, N: at most all of it, and at least none, but where they press
/// the object onto an edge. `None` where the object lies on nothing beside them, or it is not measured.
#[must_use]
pub fn measured_n(prepared: &Prepared) -> Option<f64> {
    let least_n = if prepared.rests() { 0.0 } else { f64::NEG_INFINITY };
    shown_n(prepared).map(|n| n.clamp(least_n, prepared.weight_n()))
}

/// The same as the sensors show it, constant errors included.
#[must_use]
pub fn shown_n(prepared: &Prepared) -> Option<f64> {
    let lies = prepared.scene.support.is_some() || prepared.pusher_touches(2.0 * RIGID.position_m);
    let up = prepared.up().filter(|_| prepared.scene.fingers.is_some() && lies)?;
    let speed = prepared.drive_speed();
    let fastest = speed.iter().copied().fold(0.0, f64::max);
    let begins = speed.iter().position(|v| *v > 0.1 * fastest && *v > 1e-5)?;
    let until_s = prepared.t_s.get(begins)? - GUARD_S;
    let rest = prepared.t_s.iter().zip(&prepared.measured).take_while(|(t, _)| **t < until_s);
    let force = |s: &[f64]| Vector3::from_row_slice(&s[6..9]) + Vector3::from_row_slice(&s[12..15]);
    let known: Vec<f64> = rest.map(|(_, s)| up.dot(&force(s))).filter(|x| x.is_finite()).collect();
    (known.len() >= FEWEST_SAMPLES).then(|| known.iter().sum::<f64>() / known.len() as f64)
}
