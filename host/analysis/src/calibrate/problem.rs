//! The least squares problem of the friction coefficients: logarithms as unknowns, each signal
//! weighed by the error that is left in it.

use levenberg_marquardt::LeastSquaresProblem;
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::effects::{Effect, Parameter};
use stickslip_shared::model::Model;

use super::windows::{SEEN, Seen, Windowed, resolution};
use crate::channels::COUNT;
use crate::evidence::draws::RANGE;
use crate::evidence::statistics::median;

/// Which coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coefficient {
    /// Both fingers.
    Finger,
    /// Pusher or edge.
    Pusher,
    /// Table or platform.
    Support,
}

impl Coefficient {
    /// Its place in a model.
    pub fn of(self, model: &mut Model<f64>) -> &mut f64 {
        match self {
            Self::Finger => &mut model.friction.finger,
            Self::Pusher => &mut model.friction.pusher,
            Self::Support => &mut model.friction.support,
        }
    }
}

/// What is known about a coefficient.
#[derive(Clone, Debug, JsonSchema, Serialize)]
pub struct Estimate {
    /// Which.
    pub coefficient: Coefficient,
    /// Value in the calibrated model. Where `determined` is false, only its bounds mean anything.
    pub value: f64,
    /// Lower end of the 95 % interval (`None`: no bound on that side).
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// Whether the data determine it: bounds on both sides, closer than a factor of 1.65.
    pub determined: bool,
}

/// Relative step of the difference quotients: above the kinks of stick and slip.
pub const STEP: f64 = 0.01;
/// The same of what is found beside friction, standard deviations.
const STEP_NUISANCE: f64 = 0.2;
/// Square of the error, in units of the usual one, at which a trial's say is halved.
const FAR: f64 = 9.0;

/// Something of the model that is assumed and not found: an effect as it may be as well, one standard deviation away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assumed {
    /// Place of the effect in the model; beyond its effects: the model does without.
    pub slot: usize,
    /// As it may be.
    pub effect: Effect<f64>,
}

impl Assumed {
    /// `model` with it so.
    fn on(self, model: &Model<f64>) -> Model<f64> {
        let mut model = model.clone();
        match model.effects.get_mut(self.slot) {
            Some(effect) => *effect = self.effect,
            // Who assumes it sees to the room.
            None => drop(model.effects.push(self.effect)),
        }
        model
    }
}

/// A nuisance parameter of the model: found beside friction, with what is known of it beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nuisance {
    /// Place of its effect in the model.
    pub slot: usize,
    /// Place among the effect's parameters.
    pub parameter: usize,
    /// Its description.
    pub of: &'static Parameter,
    /// What is expected.
    pub expected: f64,
    /// Standard deviation of that, or of its logarithm.
    pub sd: f64,
    /// Whether its logarithm is unknown: a compliance has no sign, and at zero nothing shows which way to go.
    pub logarithm: bool,
    /// Its bounds.
    pub bounds: [f64; 2],
}

/// A nuisance parameter and its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Which.
    pub nuisance: Nuisance,
    /// Lower and upper end.
    pub interval: [f64; 2],
}

impl Nuisance {
    fn in_model(self, model: &mut Model<f64>) -> Option<&mut f64> {
        model.effects.get_mut(self.slot).and_then(|e| e.parameters.get_mut(self.parameter))
    }

    /// Where `model` has it, in standard deviations from what is expected.
    fn departure(self, model: &Model<f64>) -> f64 {
        let value = self.in_model(&mut model.clone()).map_or(self.expected, |v| *v);
        let away = if self.logarithm { (value / self.expected).ln() } else { value - self.expected };
        away / self.sd.max(f64::MIN_POSITIVE)
    }

    /// Its value so many standard deviations from what is expected.
    pub fn value(self, departure: f64) -> f64 {
        let [low, high] = self.bounds;
        let away = departure * self.sd;
        let value = if self.logarithm { self.expected * away.exp() } else { self.expected + away };
        value.clamp(low, high)
    }
}

/// What of a model is not known for certain.
#[derive(Clone, Copy, Debug)]
pub struct Unknown<'a> {
    /// Found beside friction.
    pub nuisances: &'a [Nuisance],
    /// Assumed.
    pub assumed: &'a [Assumed],
}

impl Unknown<'_> {
    /// Nothing.
    pub const NOTHING: Unknown<'static> = Unknown { nuisances: &[], assumed: &[] };
}

/// A least squares problem with fixed weights.
#[derive(Clone)]
pub struct Problem<'a> {
    /// Calibration trials.
    pub trials: &'a [&'a Windowed],
    /// Unknown coefficients.
    pub free: Vec<Coefficient>,
    /// Their logarithms, and after them the departures of what is found beside them, in standard deviations.
    pub at: DVector<f64>,
    /// Weight of each signal in each trial: one over its squared scale.
    pub weights: Vec<[f64; SEEN]>,
    /// Constant errors of the channels.
    pub offsets: &'a [f64; COUNT],
    /// What the coefficients are put into.
    pub base: &'a Model<f64>,
    /// What of it is not known for certain.
    pub unknown: Unknown<'a>,
}

impl<'a> Problem<'a> {
    /// With the coefficients where `base` has them, and equal weights.
    pub fn new(
        trials: &'a [&'a Windowed],
        offsets: &'a [f64; COUNT],
        (base, unknown): (&'a Model<f64>, Unknown<'a>),
        free: Vec<Coefficient>,
    ) -> Self {
        let mut start = base.clone();
        let logarithms = free.iter().map(|c| c.of(&mut start).max(RANGE[0]).ln());
        let departures = unknown.nuisances.iter().map(|b| b.departure(base));
        let at = DVector::from_vec(logarithms.chain(departures).collect());
        Self { trials, free, at, weights: vec![[1.0; SEEN]; trials.len()], offsets, base, unknown }
    }
}

impl Problem<'_> {
    /// The base with the coefficients at the logarithms `at`.
    pub fn model(&self, at: &DVector<f64>) -> Model<f64> {
        let mut model = self.base.clone();
        for (c, x) in self.free.iter().zip(at.iter()) {
            *c.of(&mut model) = x.exp().clamp(RANGE[0], RANGE[1]);
        }
        for (b, x) in self.unknown.nuisances.iter().zip(self.departures(at)) {
            if let Some(value) = b.in_model(&mut model) {
                *value = b.value(*x);
            }
        }
        model
    }

    /// Departures of what is found beside friction, from what is expected.
    pub fn departures<'b>(&self, at: &'b DVector<f64>) -> &'b [f64] {
        at.as_slice().get(self.free.len()..).unwrap_or_default()
    }

    /// Step of the difference quotient of unknown `k`.
    pub fn step(&self, k: usize) -> f64 {
        if k < self.free.len() { STEP } else { STEP_NUISANCE }
    }

    /// Residuals of each trial, not weighted.
    pub fn residuals_at(&self, at: &DVector<f64>) -> Vec<Vec<Seen>> {
        let model = self.model(at);
        let others: Vec<Model<f64>> = self.unknown.assumed.iter().map(|a| a.on(&model)).collect();
        self.trials.par_iter().map(|w| w.residual(self.offsets, &model, &others)).collect()
    }

    fn weighted(&self, at: &DVector<f64>) -> DVector<f64> {
        let each = self.residuals_at(at);
        let values = each.iter().zip(&self.weights).flat_map(|(rows, weights)| {
            rows.iter().flat_map(move |row| {
                row.iter().zip(weights).map(|(r, w)| if r.is_finite() { r * w.sqrt() } else { 0.0 })
            })
        });
        DVector::from_vec(values.chain(self.departures(at).iter().copied()).collect())
    }

    /// Weights from the residuals at the present coefficients.
    pub fn weigh(&mut self) {
        let squares: Vec<Seen> = self.residuals_at(&self.at).iter().map(|r| mean_squares(r)).collect();
        let usual: Seen = std::array::from_fn(|k| {
            let known = squares.iter().map(|s| s[k]).filter(|s| s.is_finite());
            median(known).unwrap_or(0.0).max(resolution(k).powi(2))
        });
        let weight =
            |s: &Seen| std::array::from_fn(|k| 1.0 / (usual[k] * (1.0 + s[k].max(0.0) / (FAR * usual[k]))));
        self.weights = squares.iter().map(weight).collect();
    }
}

/// Mean square of each signal over the windows; NaN where it was not measured.
pub fn mean_squares(rows: &[Seen]) -> Seen {
    std::array::from_fn(|k| {
        let known = rows.iter().map(|r| r[k]).filter(|x| x.is_finite());
        let (sum, count) = known.fold((0.0, 0.0), |(s, n), x| (s + x * x, n + 1.0));
        sum / count
    })
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.at = x.clone();
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.weighted(&self.at))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns: Vec<DVector<f64>> = (0..self.at.len())
            .map(|k| {
                let step = self.step(k);
                let moved = |by: f64| {
                    let mut x = self.at.clone();
                    x[k] += by;
                    self.weighted(&x)
                };
                (moved(step) - moved(-step)) / (2.0 * step)
            })
            .collect();
        Some(DMatrix::from_columns(&columns))
    }
}
