//! A trial reduced to what calibration needs: means over windows of its motion.
//!
//! Both fingers enter a fit as their sum. How they share a load is not determined while the
//! pads stick: a squeeze from the grasping stays in them, newtons that differ from run to
//! run (`crate::evidence::force_bands`), and no friction coefficient explains it. The sum is fixed by
//! the balance of the object.
//!
//! A rigid grasp that is stuck to something has forces that hang on micrometres of the
//! gripper's path, which nobody measures: the sideways force on an edge that does not slide,
//! for one. Each trial is therefore run a second and third time along paths that drift by some
//! micrometres ([`Prepared::drifted`]); a signal counts by its error against what that changes
//! in it. What contacts that hardly deform, in place of rigid ones, change in it counts alike.

use std::ops::Range;

use nalgebra::Vector3;
use stickslip_shared::model::Model;

use crate::channels::{COUNT, Quantity, Signals, quantity};
use crate::evidence::offsets::fingers_sum;
use crate::evidence::{carried, contact};
use crate::run::scene::SceneError;
use crate::run::simulate::{Carried, Prepared, prepare};
use stickslip_data::{Description, Trial};

/// Windows over the motion of one trial.
const WINDOWS: usize = 12;
/// Samples that the model steps over at once: forces are those of a quasi-static push.
const STRIDE: usize = 3;
/// Signals that a fit sees: the object's six, the wrench of both fingers, the pusher's.
pub const SEEN: usize = 18;
/// One row of them.
pub type Seen = [f64; SEEN];

/// What a fit sees of a row of channels; `as_measured` tells which fingers count.
pub fn seen(row: &Signals, as_measured: &Signals) -> Seen {
    std::array::from_fn(|k| match k {
        0..6 => row[k],
        6..12 => match (as_measured[k].is_finite(), as_measured[k + 6].is_finite()) {
            (true, true) => row[k] + row[k + 6],
            (true, false) => row[k],
            _ => row[k + 6],
        },
        _ => row[k + 6],
    })
}

/// Smallest error of one of them that means anything: below it sensors and the windows'
/// edges decide.
pub fn resolution(k: usize) -> f64 {
    match quantity(k) {
        Quantity::Position => 5e-5,
        Quantity::Rotation => 1e-3,
        Quantity::Force => 0.05,
        Quantity::Torque => 1e-3,
    }
}

/// See the module.
pub struct Windowed {
    /// Its name.
    pub trial: String,
    /// Number that its repetitions share.
    pub condition: usize,
    /// Ready to simulate.
    pub prepared: Prepared,
    /// Means of the measured channels over each window, NaN where nothing was measured.
    pub measured: Vec<Signals>,
    /// Samples at rest before it.
    pub rest: Range<usize>,
    drifted: Vec<Prepared>,
    windows: Vec<Range<usize>>,
}

impl Windowed {
    /// Prepares and windows a trial; no windows where nothing moves.
    pub fn new(
        description: &Description,
        trial: &Trial,
        ordinal: usize,
        condition: usize,
    ) -> Result<Self, SceneError> {
        let prepared = carried::at_an_edge(prepare(description, trial, ordinal)?);
        let moving: Vec<usize> =
            prepared.drive_speed().iter().enumerate().filter(|(_, s)| **s > 1e-5).map(|(i, _)| i).collect();
        let (first, last) = match (moving.first(), moving.last()) {
            (Some(first), Some(last)) => (*first, *last + 1),
            _ => (0, 0),
        };
        let count = WINDOWS.min(last - first);
        let edge = |k: usize| first + k * (last - first) / count.max(1);
        let mut windows: Vec<_> = (0..count).map(|k| edge(k)..edge(k + 1)).collect();
        // A pose that is known at the end only counts there.
        if let Some(w) = windows.last_mut() {
            w.end = prepared.t_s.len();
        }
        let measured = windows.iter().map(|w| mean(&prepared.measured[w.clone()])).collect();
        let contact = contact::measured(&prepared.t_s, &prepared.measured).flatten();
        let rest = contact::clear_of(&prepared.t_s, contact.unwrap_or(first));
        let drifted = prepared.drifted();
        Ok(Self { trial: trial.info.trial.clone(), condition, prepared, drifted, measured, windows, rest })
    }

    /// Whether the object touches an edge at the start, so that nobody knows how its weight is shared.
    pub fn is_at_an_edge(&self) -> bool {
        self.prepared.carried.is_some()
    }

    /// Where it touches an edge: takes the constant error of the fingers' force out of what they bear at rest.
    pub fn tare_carried(&mut self, offsets: &Signals) {
        let [x, y, z, ..] = fingers_sum(offsets);
        if !self.is_at_an_edge() {
            return;
        }
        if let Some(tared) = self.carrying_without(&Vector3::new(x, y, z)) {
            self.drifted = tared.drifted();
            self.prepared = tared;
        }
    }

    /// The trial with the fingers bearing what their sensors show at rest without a constant error (N, carrier axes).
    pub fn carrying_without(&self, error_n: &Vector3<f64>) -> Option<Prepared> {
        let (shown, up) = (carried::shown(&self.prepared)?, self.prepared.up()?);
        let side = self.prepared.side().unwrap_or_default();
        Some(self.prepared.carrying(Carried {
            up_n: (shown.up_n - up.dot(error_n)).min(self.prepared.weight_n()),
            side_n: shown.side_n - side.dot(error_n),
        }))
    }

    /// Residuals over the windows, modelled less measured, `offsets` taken out.
    pub fn plain_residual(&self, offsets: &Signals, model: &Model<f64>) -> Vec<Seen> {
        let difference = |(row, measured): (&Signals, &Signals)| {
            let d = std::array::from_fn(|c| row[c] - (measured[c] - offsets[c]));
            seen(&d, measured)
        };
        self.model(model).iter().zip(&self.measured).map(difference).collect()
    }

    /// Residuals over the windows, modelled less measured, `offsets` taken out, each made
    /// smaller by what a drift, and each of the models `others`, change in it (see the module); NaN where nothing was measured.
    pub fn residual(&self, offsets: &Signals, model: &Model<f64>, others: &[Model<f64>]) -> Vec<Seen> {
        let rows = self.model(model);
        let drifted = self.drifted.iter().map(|p| self.run(p, model));
        let drifted: Vec<Vec<Signals>> = drifted.chain(others.iter().map(|m| self.model(m))).collect();
        let difference = |(i, measured): (usize, &Signals)| {
            let d = std::array::from_fn(|c| rows[i][c] - (measured[c] - offsets[c]));
            let moved = drifted.iter().map(|d| {
                let change = std::array::from_fn(|c| d[i][c] - rows[i][c]);
                seen(&change, measured)
            });
            let moved: Vec<Seen> = moved.collect();
            let r = seen(&d, measured);
            std::array::from_fn(|k| {
                let change = moved.iter().map(|m| m[k] * m[k]).sum::<f64>() / resolution(k).powi(2);
                r[k] / (1.0 + change).sqrt()
            })
        };
        self.measured.iter().enumerate().map(difference).collect()
    }

    /// The model's means over the same windows and over the same samples as measured.
    pub fn model(&self, model: &Model<f64>) -> Vec<Signals> {
        self.run(&self.prepared, model)
    }

    fn run(&self, prepared: &Prepared, model: &Model<f64>) -> Vec<Signals> {
        let simulated = prepared.simulate_every(model, STRIDE).signals;
        let paired = |w: &Range<usize>| {
            let rows = simulated.get(w.clone()).unwrap_or_default();
            let seen = &self.prepared.measured[w.clone()];
            let masked: Vec<Signals> = rows
                .iter()
                .zip(seen)
                .map(|(m, s)| std::array::from_fn(|c| if s[c].is_nan() { f64::NAN } else { m[c] }))
                .collect();
            mean(&masked)
        };
        self.windows.iter().map(paired).collect()
    }
}

/// Mean of what is finite, channel by channel.
fn mean(rows: &[Signals]) -> Signals {
    let mut sum = [0.0; COUNT];
    let mut count = [0.0; COUNT];
    for row in rows {
        for c in 0..COUNT {
            if row[c].is_finite() {
                sum[c] += row[c];
                count[c] += 1.0;
            }
        }
    }
    std::array::from_fn(|c| if count[c] > 0.0 { sum[c] / count[c] } else { f64::NAN })
}
