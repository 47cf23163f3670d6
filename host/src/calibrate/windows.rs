//! A trial reduced to what calibration needs: means over windows of its motion.

use std::ops::Range;

use stickslip_shared::model::Model;

use super::determined::Remark;
use crate::channels::{COUNT, Quantity, Signals, quantity};
use crate::dataset::{Description, Trial};
use crate::simulate::{Prepared, SceneError, prepare};

/// Windows over the motion of one trial.
const WINDOWS: usize = 12;
/// Samples that the model steps over at once: forces are those of a quasi-static push.
const STRIDE: usize = 3;
/// Fewest samples at rest from which offsets are taken.
const REST: usize = 20;

/// See the module.
pub struct Windowed {
    /// Its name.
    pub trial: String,
    /// Ready to simulate.
    pub prepared: Prepared,
    /// Means of the measured channels over each window, NaN where nothing was measured.
    pub measured: Vec<Signals>,
    windows: Vec<Range<usize>>,
    rest: Range<usize>,
}

impl Windowed {
    /// Prepares and windows a trial; no windows where nothing moves.
    pub fn new(description: &Description, trial: &Trial, ordinal: usize) -> Result<Self, SceneError> {
        let prepared = prepare(description, trial, ordinal)?;
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
        // The last samples at rest may see the onset through the smoothing of the motion.
        let rest = 0..first.saturating_sub(REST / 2);
        Ok(Self { trial: trial.info.trial.clone(), prepared, measured, windows, rest })
    }

    /// The model's means over the same windows and over the same samples as measured.
    pub fn model(&self, model: &Model<f64>) -> Vec<Signals> {
        let simulated = self.prepared.simulate_every(model, STRIDE).signals;
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

/// Median over the trials of what each wrench channel shows at rest beyond the model. A
/// pusher that touches at rest bears an unknown load: it is left alone.
pub fn tare(trials: &[&Windowed], model: &Model<f64>) -> ([f64; COUNT], Vec<Remark>) {
    let mut seen: Vec<Vec<f64>> = vec![Vec::new(); COUNT];
    for w in trials.iter().filter(|w| w.rest.len() >= REST) {
        let simulated = w.prepared.simulate_every(model, w.rest.len());
        let (Some(m), Some(n)) = (simulated.signals.first(), simulated.normal_n.first()) else { continue };
        let measured = mean(&w.prepared.measured[w.rest.clone()]);
        for c in 6..COUNT {
            let offset = measured[c] - m[c];
            if offset.is_finite() && (c < 18 || n[2] == 0.0) {
                seen[c].push(offset);
            }
        }
    }
    let mut offsets = [0.0; COUNT];
    for (o, values) in offsets.iter_mut().zip(&mut seen) {
        values.sort_by(f64::total_cmp);
        *o = values.get(values.len() / 2).copied().unwrap_or(0.0);
    }
    let remark = seen.iter().skip(6).all(Vec::is_empty).then_some(Remark::NoRest);
    (offsets, remark.into_iter().collect())
}

/// What each channel's residual is divided by: a twentieth of what its quantity does, so
/// that no quantity's unit decides, and never less than its resolution.
pub fn scales(trials: &[&Windowed], offsets: &[f64; COUNT]) -> [f64; COUNT] {
    let body = |c: usize| (c / 6, quantity(c) as usize);
    let resolution = |q: Quantity| -> f64 {
        match q {
            Quantity::Position => 5e-5,
            Quantity::Rotation => 1e-3,
            Quantity::Force => 0.05,
            Quantity::Torque => 1e-3,
        }
    };
    std::array::from_fn(|c| {
        let mut sum = (0.0, 0.0);
        for w in trials {
            for row in &w.measured {
                for k in (0..COUNT).filter(|k| body(*k) == body(c)) {
                    let x = row[k] - offsets[k];
                    if x.is_finite() {
                        sum = (sum.0 + x * x, sum.1 + 1.0);
                    }
                }
            }
        }
        let size = if sum.1 > 0.0 { (sum.0 / sum.1).sqrt() } else { 0.0 };
        resolution(quantity(c)).max(0.05 * size)
    })
}
