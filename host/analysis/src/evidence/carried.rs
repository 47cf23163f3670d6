//! What the fingers bear of an object at rest where it also lies on something: statically undetermined, left
//! from closing the grasp, and known from their sensors alone.

use nalgebra::Vector3;

use crate::evidence::tolerance::RIGID;
use crate::run::simulate::{Carried, Prepared};

/// Time before a motion that is no rest, as motion is smoothed, s, and samples of rest at least.
const GUARD_S: f64 = 0.016;
const FEWEST_SAMPLES: usize = 5;

/// The same trial where the object only touches an edge at the start: with the fingers carrying what they were measured to. What lies
/// on a table or a platform lies there with its weight.
#[must_use]
pub fn at_an_edge(prepared: Prepared) -> Prepared {
    match measured(&prepared) {
        Some(carried) if !prepared.rests() => prepared.carrying(carried),
        _ => prepared,
    }
}

/// What the fingers were measured to bear before anything moves: at most all of the weight, and at least none, but where they press
/// the object onto an edge. `None` where the object lies on nothing beside them, or it is not measured.
#[must_use]
pub fn measured(prepared: &Prepared) -> Option<Carried> {
    let least_n = if prepared.rests() { 0.0 } else { f64::NEG_INFINITY };
    shown(prepared).map(|c| Carried { up_n: c.up_n.clamp(least_n, prepared.weight_n()), ..c })
}

/// The same as the sensors show it, constant errors included.
#[must_use]
pub fn shown(prepared: &Prepared) -> Option<Carried> {
    let lies = prepared.scene.support.is_some() || prepared.pusher_touches(2.0 * RIGID.position_m);
    let up = prepared.up().filter(|_| prepared.scene.fingers.is_some() && lies)?;
    let side = prepared.side().unwrap_or_default();
    let speed = prepared.drive_speed();
    let fastest = speed.iter().copied().fold(0.0, f64::max);
    let begins = speed.iter().position(|v| *v > 0.1 * fastest && *v > 1e-5)?;
    let until_s = prepared.t_s.get(begins)? - GUARD_S;
    let rest = prepared.t_s.iter().zip(&prepared.measured).take_while(|(t, _)| **t < until_s);
    let force = |s: &[f64]| Vector3::from_row_slice(&s[6..9]) + Vector3::from_row_slice(&s[12..15]);
    let known: Vec<Vector3<f64>> = rest.map(|(_, s)| force(s)).filter(|f| up.dot(f).is_finite()).collect();
    let mean = known.iter().sum::<Vector3<f64>>() / known.len() as f64;
    (known.len() >= FEWEST_SAMPLES).then(|| Carried { up_n: up.dot(&mean), side_n: side.dot(&mean) })
}
