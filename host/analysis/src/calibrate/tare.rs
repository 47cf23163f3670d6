//! Constant errors of the force sensors, for a calibration: what they show before contact beyond the model
//! ([`crate::evidence::offsets`]).
//!
//! Of the fingers only the sum's offset is known, half of it is each one's; a single measured finger and a pusher that
//! touches at rest bear an unknown load and are left alone.
//!
//! How an object that touches an edge shares its weight with it is left from placing it, so that these trials tell no
//! offset along the vertical and to the side, and what the fingers are measured to carry has theirs in it. Sensors are
//! those of the other trials. Where all touch an edge, the balance still tells the sum of both offsets, and each sensor
//! has its share of that by its stated uncertainty.

use nalgebra::Vector3;
use stickslip_data::{Description, Sensors, Trial, TrialInfo};
use stickslip_shared::model::Model;

use super::share::{Share, pick};
use super::windows::Windowed;
use crate::channels::{COUNT, Signals};
use crate::evidence::carried::shown;
use crate::evidence::conditions::condition_of;
use crate::evidence::offsets;
use crate::evidence::statistics::median;
use crate::run::simulate::Prepared;

/// First channels of the fingers' forces and of the pusher's.
const FINGERS: [usize; 2] = [6, 12];
const PUSHER: usize = 18;

/// Constant errors of the channels, zero where none is known, and whether any trial has a rest before its motion.
/// `elsewhere`: those of the same sensors in other trials, asked for where an edge touches.
pub fn tare(
    trials: &[&Windowed],
    model: &Model<f64>,
    sensors: &Sensors,
    elsewhere: impl Fn() -> Signals,
) -> ([f64; COUNT], bool) {
    let mut found = apart(trials, model);
    let at_edges: Vec<&Windowed> = trials.iter().copied().filter(|w| w.is_at_an_edge()).collect();
    if !at_edges.is_empty() {
        fill(&mut found, &elsewhere());
        if !found[FINGERS[0]].is_finite() {
            fill(&mut found, &of_edges(&at_edges, model, sensors));
        }
    }
    (found.map(|o| if o.is_finite() { o } else { 0.0 }), found.iter().any(|o| o.is_finite()))
}

/// Offsets of the sensors in a share of `trials`, those that no edge touches; NaN where these tell none.
pub fn of_others(description: &Description, trials: &[(usize, &Trial)], model: &Model<f64>) -> Signals {
    let infos: Vec<&TrialInfo> = trials.iter().map(|(_, trial)| &trial.info).collect();
    let some = pick(&condition_of(&infos), Share::of(0.1)).into_iter().filter_map(|i| {
        let (ordinal, trial) = trials[i];
        Windowed::new(description, trial, ordinal, 0).ok()
    });
    let some: Vec<Windowed> = some.collect();
    apart(&some.iter().collect::<Vec<_>>(), model)
}

/// Those of trials that no edge touches.
fn apart(trials: &[&Windowed], model: &Model<f64>) -> Signals {
    let apart = trials.iter().filter(|w| !w.is_at_an_edge());
    let found: Vec<Signals> = apart.filter_map(|w| at_rest(w, &w.prepared, model)).collect();
    offsets::over_trials(&found)
}

/// Those of one trial, run as `prepared`.
fn at_rest(w: &Windowed, prepared: &Prepared, model: &Model<f64>) -> Option<Signals> {
    let simulated = prepared.simulate_every(model, w.rest.len().max(1));
    let (expected, normal_n) = (simulated.signals.first()?, simulated.normal_n.first()?);
    let mut offset = offsets::of_samples(w.prepared.measured[w.rest.clone()].iter().map(|m| (m, expected)));
    for (k, sum) in offsets::fingers_sum(&offset).into_iter().enumerate() {
        (offset[FINGERS[0] + k], offset[FINGERS[1] + k]) = (0.5 * sum, 0.5 * sum);
    }
    if normal_n[2] != 0.0 || w.is_at_an_edge() {
        offset[PUSHER..].fill(f64::NAN);
    }
    Some(offset)
}

/// Those of trials that all touch an edge.
fn of_edges(trials: &[&Windowed], model: &Model<f64>, sensors: &Sensors) -> Signals {
    // Upward and to the side, world axes.
    let axes = |p: &Prepared| [p.up(), p.side()].map(|a| p.carrier.rotation * a.unwrap_or_default());
    // What fingers and pusher bear together beyond the weight.
    let beyond = |w: &&Windowed| {
        let shown = shown(&w.prepared)?;
        let [up, side] = axes(&w.prepared);
        let of_pusher = |along: Vector3<f64>| {
            let force = |s: &Signals| along.dot(&Vector3::from_row_slice(&s[PUSHER..PUSHER + 3]));
            median(w.prepared.measured[w.rest.clone()].iter().map(force).filter(|x| x.is_finite()))
        };
        Some([shown.up_n + of_pusher(up)? - w.prepared.weight_n(), shown.side_n + of_pusher(side)?])
    };
    let mut found = [f64::NAN; COUNT];
    let (of_finger, of_pusher) = (sensors.finger.force_uncertainty_n, sensors.pusher.force_uncertainty_n);
    let variances = [2.0 * of_finger.powi(2), of_pusher.powi(2)];
    let beyond: Vec<[f64; 2]> = trials.iter().filter_map(beyond).collect();
    let [Some(up_n), Some(side_n)] = [0, 1].map(|k| median(beyond.iter().map(|b| b[k]))) else {
        return found;
    };
    if variances.iter().sum::<f64>() <= 0.0 {
        return found;
    }
    let shares = [up_n, side_n].map(|both_n| {
        let share = both_n / variances.iter().sum::<f64>();
        let fingers_n = (variances[0] * share).clamp(-2.0 * of_finger, 2.0 * of_finger);
        (fingers_n, (variances[1] * share).clamp(-of_pusher, of_pusher))
    });
    let error_n = |p: &Prepared| {
        let [up, side] = [p.up(), p.side()].map(Option::unwrap_or_default);
        up * shares[0].0 + side * shares[1].0
    };
    let tared = |w: &&Windowed| at_rest(w, &w.carrying_without(&error_n(&w.prepared))?, model);
    let each: Vec<Signals> = trials.iter().filter_map(tared).collect();
    fill(&mut found, &offsets::over_trials(&each));
    if let Some(w) = trials.first() {
        let [up, side] = axes(&w.prepared);
        found[PUSHER..PUSHER + 3].copy_from_slice((up * shares[0].1 + side * shares[1].1).as_slice());
    }
    found
}

/// What is known of `others` where `found` is not.
fn fill(found: &mut Signals, others: &Signals) {
    for (to, from) in found.iter_mut().zip(others).filter(|(to, _)| !to.is_finite()) {
        *to = *from;
    }
}
