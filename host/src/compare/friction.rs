//! Friction coefficients for a comparison that was given no model: a quick calibration.
//!
//! Least squares (Gauss-Newton in the logarithms, finite differences) on the mean force and
//! torque errors while sliding of at most twelve trials spread over the conditions. It serves to look at a data set; `calibrate` does it properly.

use rayon::prelude::*;
use stickslip_shared::model::{Base, Friction, Model};

use super::tare::{Tare, offsets};
use super::trial::TrialErrors;
use crate::channels::{COUNT, Quantity, Signals, quantity};
use crate::dataset::Sensors;
use crate::phases::{Phase, Phases, split};
use crate::simulate::Prepared;

/// Most trials that are simulated for it.
pub const TRIALS: usize = 12;
/// Samples stepped over at once: 16 ms at 250 Hz.
const STRIDE: usize = 4;
const ROUNDS: usize = 6;
/// Platforms tried first: plastic, rubber, silicone.
const PLATFORMS: [f64; 3] = [0.3, 1.0, 2.5];

/// The hard model without effects, with the coefficients that a user most likely has.
pub fn default_model() -> Model<f64> {
    Model {
        base: Base::Hard,
        friction: Friction { finger: 0.4, pusher: 0.25, support: 0.3 },
        effects: Default::default(),
        formulas: Default::default(),
    }
}

/// A calibrated model, and which coefficients the data did not determine.
#[derive(Clone, Debug)]
pub struct Calibrated {
    /// The hard model.
    pub model: Model<f64>,
    /// Coefficients left at their defaults although their contact exists.
    pub undetermined: Vec<&'static str>,
    /// Trials used.
    pub trials: usize,
}

fn coefficient<'a>(model: &'a mut Model<f64>, name: &str) -> &'a mut f64 {
    match name {
        "finger" => &mut model.friction.finger,
        "pusher" => &mut model.friction.pusher,
        _ => &mut model.friction.support,
    }
}

/// Calibrates on `trials`. `None` where no force was measured.
pub fn calibrate(trials: &[Prepared], sensors: &Sensors, noise: &Signals) -> Option<Calibrated> {
    let mut model = default_model();
    let has = |f: fn(&Prepared) -> bool| trials.iter().any(f);
    let names: Vec<&'static str> = [
        ("finger", has(|t| t.scene.fingers.is_some())),
        ("pusher", has(|t| t.scene.pusher.is_some() && (t.scene.support.is_some() || !t.rests()))),
        ("support", has(Prepared::rests)),
    ]
    .into_iter()
    .filter_map(|(name, there)| there.then_some(name))
    .collect();
    let phases: Vec<Phases> =
        trials.par_iter().map(|t| split(t, &t.simulate_every(&model, STRIDE), noise)).collect();
    let residual = |model: &Model<f64>| residuals(trials, &phases, model, sensors);
    // Whether a cylinder rolls is yes or no: no derivative leads from one to the other.
    if has(|t| t.rests() && t.scene.support.is_none()) {
        let tries = PLATFORMS.map(|support| {
            let mut tried = model.clone();
            tried.friction.support = support;
            (square(&residual(&tried)), tried)
        });
        let best = tries.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        model = best.map_or(model, |b| b.1);
    }
    let mut now = residual(&model);
    if now.iter().all(|r| *r == 0.0) {
        return None;
    }
    let mut columns = Vec::new();
    for _ in 0..ROUNDS {
        columns = names
            .iter()
            .map(|name| {
                const STEP: f64 = 0.05;
                let mut moved = model.clone();
                *coefficient(&mut moved, name) *= STEP.exp();
                residual(&moved).iter().zip(&now).map(|(a, b)| (a - b) / STEP).collect::<Vec<f64>>()
            })
            .collect();
        let Some(step) = gauss_newton(&columns, &now) else { break };
        let mut better = None;
        for share in [1.0, 0.5, 0.25] {
            let mut moved = model.clone();
            for (name, s) in names.iter().zip(&step) {
                let c = coefficient(&mut moved, name);
                *c = (*c * (share * s.clamp(-0.7, 0.7)).exp()).clamp(0.01, 5.0);
            }
            let next = residual(&moved);
            if square(&next) < square(&now) {
                better = Some((moved, next));
                break;
            }
        }
        let Some((moved, next)) = better else { break };
        let gain = 1.0 - square(&next) / square(&now);
        (model, now) = (moved, next);
        if gain < 1e-3 {
            break;
        }
    }
    let largest = columns.iter().map(|c| square(c)).fold(0.0, f64::max);
    let undetermined = names
        .iter()
        .zip(&columns)
        .filter(|(_, c)| square(c) < 1e-6 * largest || largest == 0.0)
        .map(|(name, _)| *name)
        .collect();
    Some(Calibrated { model, undetermined, trials: trials.len() })
}

/// Mean errors while sliding (of trials that never slide: while sticking) in units of a tenth
/// of a newton or two millinewton metres; 0 where not known.
fn residuals(trials: &[Prepared], phases: &[Phases], model: &Model<f64>, sensors: &Sensors) -> Vec<f64> {
    let mut errors: Vec<TrialErrors> = trials
        .par_iter()
        .zip(phases)
        .map(|(t, p)| TrialErrors::of(t, &t.simulate_every(model, STRIDE), *p))
        .collect();
    let (_, tares) = offsets(&errors.iter().collect::<Vec<_>>(), sensors, Tare::BeforeContact);
    let mut out = Vec::new();
    for ((e, tare), t) in errors.iter_mut().zip(&tares).zip(trials) {
        e.shift(tare);
        // Sideways forces of a rigid grasp that is stuck to the pusher hang on micrometres of the
        // gripper's path, not on friction.
        let planar = t.scene.fingers.is_some() && !t.rests();
        for channel in (0..COUNT).filter(|c| !planar || matches!(c % 6, 0 | 2 | 4)) {
            // A hard contact takes up its load at once, real ones within milliseconds: while
            // forces rise, stiffness shows and not friction.
            for phase in [Phase::Sliding, Phase::Sticking] {
                let slides = e.raw(channel, Phase::Sliding).is_known();
                let cell = e.raw(channel, phase);
                let used = cell.is_known() && (slides == (phase == Phase::Sliding));
                let scale = match quantity(channel) {
                    Quantity::Force => 0.1,
                    Quantity::Torque => 0.002,
                    Quantity::Position | Quantity::Rotation => continue,
                };
                out.push(if used { cell.bias() / scale } else { 0.0 });
            }
        }
    }
    out
}

fn square(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

/// Step that lowers `residual`, with a little damping so that a coefficient that does not
/// matter stays where it is.
fn gauss_newton(columns: &[Vec<f64>], residual: &[f64]) -> Option<Vec<f64>> {
    let n = columns.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let largest = columns.iter().map(|c| square(c)).fold(0.0, f64::max);
    if !(largest > 0.0) {
        return None;
    }
    let mut a = nalgebra::Matrix3::<f64>::identity();
    let mut b = nalgebra::Vector3::<f64>::zeros();
    for i in 0..n {
        for j in 0..n {
            a[(i, j)] = dot(&columns[i], &columns[j]);
        }
        a[(i, i)] += 1e-6 * largest;
        b[i] = -dot(&columns[i], residual);
    }
    let step = a.cholesky()?.solve(&b);
    Some(step.iter().take(n).copied().collect())
}
