//! Residuals and errors of one trial, for each channel and phase.
//!
//! The *residual* is modelled minus measured as it is, noise included. The *error* is what of it
//! lies beyond a tolerance: for each sample and channel the slack on both sides of the model's
//! value. Sums are kept rather than samples, so that a constant sensor offset found later from
//! the whole data set can still be taken out exactly.

use crate::channels::{COUNT, Signals};
use crate::evidence::contact::clear_of;
use crate::evidence::noise::{Course, FEWEST_SAMPLES, white_noise};
use crate::evidence::offsets;
use crate::evidence::phases::{PHASES, Phase, Phases};
use crate::run::simulate::{Prepared, Simulated};

/// How far below and above the model's value each channel may be without being an error, SI;
/// NaN: any deviation counts.
pub type Slack = [(f64, f64); COUNT];

/// Slacks at some samples (rising); the nearest one holds.
pub type Tolerance = Vec<(usize, Slack)>;

/// Sums of the error over one phase of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Samples in which both model and measurement are known.
    pub samples: u32,
    sum: f64,
    sum_sq: f64,
    low: f64,
    high: f64,
}

impl Cell {
    const EMPTY: Self =
        Self { samples: 0, sum: 0.0, sum_sq: 0.0, low: f64::INFINITY, high: f64::NEG_INFINITY };

    /// Sums of `errors`; NaN: not measured.
    pub fn of(errors: &[f64]) -> Self {
        let mut cell = Self::EMPTY;
        for e in errors.iter().filter(|e| e.is_finite()) {
            cell.samples += 1;
            cell.sum += e;
            cell.sum_sq += e * e;
            cell.low = cell.low.min(*e);
            cell.high = cell.high.max(*e);
        }
        cell
    }

    /// Whether enough samples stand behind it.
    pub fn is_known(&self) -> bool {
        self.samples >= FEWEST_SAMPLES
    }

    /// The same with `offset` added to every error.
    #[must_use]
    pub fn shifted(mut self, offset: f64) -> Self {
        let n = f64::from(self.samples);
        self.sum_sq += offset * (2.0 * self.sum + n * offset);
        self.sum += n * offset;
        self.low += offset;
        self.high += offset;
        self
    }

    /// Mean error.
    pub fn bias(&self) -> f64 {
        self.sum / f64::from(self.samples)
    }

    /// Mean square error.
    pub fn mean_square(&self) -> f64 {
        (self.sum_sq / f64::from(self.samples)).max(0.0)
    }

    /// Largest error, without sign.
    pub fn largest(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

/// Errors of one trial against one model.
#[derive(Clone, Debug)]
pub struct TrialErrors {
    /// Errors by channel and phase; [`error`](Self::error) finds one.
    beyond: Vec<Cell>,
    /// Residuals by channel and phase.
    residual: Vec<Cell>,
    /// Course of the residual: how runs scatter about the model.
    courses: Vec<Course>,
    /// Of the measurement itself.
    measured: Vec<Course>,
    /// Mean of measured minus modelled before contact; NaN where not known. Force and torque only.
    pub offset: Signals,
    /// Mean measurement before contact; NaN where not known. Force and torque only.
    pub rest: Signals,
    /// What the model leaves open of the forces: sum and number of the widths, N.
    pub width_n: (f64, f64),
    /// Standard deviation of the measurement's noise from sample to sample.
    pub white: Signals,
    /// Times at which the phases begin, and the end of the trial.
    pub phase_s: [(f64, f64); 5],
    /// How the phases were found.
    pub phases: Phases,
    /// Samples.
    pub samples: usize,
    /// Steps whose solve did not reach its tolerance.
    pub unsolved: usize,
    /// Largest momentum error of the solver.
    pub residual_n: f64,
}

impl TrialErrors {
    /// Compares `simulated` with the measurement; after contact only what is beyond `tolerance`
    /// counts as error (sensor offset taken out). The tare is not applied yet.
    pub fn of(prepared: &Prepared, simulated: &Simulated, phases: Phases, tolerance: &Tolerance) -> Self {
        let t = &prepared.t_s;
        let size = COUNT * PHASES.len();
        let mut beyond = vec![Cell::EMPTY; size];
        let mut residual = vec![Cell::EMPTY; size];
        let (mut courses, mut measured) = (Vec::with_capacity(size), Vec::with_capacity(size));
        let mut errors = Vec::new();
        let mut rest = [f64::NAN; COUNT];
        let before = clear_of(t, phases.range(Phase::BeforeContact).end);
        let offset = offsets::of_samples(
            prepared.measured[before.clone()].iter().zip(&simulated.signals[before.clone()]),
        );
        let nearest = nearest(tolerance, t.len());
        for channel in 0..COUNT {
            for phase in PHASES {
                let range = if phase == Phase::BeforeContact { before.clone() } else { phases.range(phase) };
                let cell = channel * PHASES.len() + phase as usize;
                errors.clear();
                errors.extend(
                    simulated.signals[range.clone()]
                        .iter()
                        .zip(&prepared.measured[range.clone()])
                        .map(|(model, measured)| model[channel] - measured[channel]),
                );
                courses.push(Course::of(&errors));
                let seen: Vec<f64> =
                    prepared.measured[range.clone()].iter().map(|row| row[channel]).collect();
                measured.push(Course::of(&seen));
                residual[cell] = Cell::of(&errors);
                if phase != Phase::BeforeContact && !tolerance.is_empty() {
                    let known = if offset[channel].is_finite() { offset[channel] } else { 0.0 };
                    for (e, i) in errors.iter_mut().zip(range) {
                        *e = outside(*e + known, tolerance[nearest[i]].1[channel]) - known;
                    }
                }
                beyond[cell] = Cell::of(&errors);
                if phase == Phase::BeforeContact && offset[channel].is_finite() {
                    rest[channel] = measured[cell].mean;
                }
            }
        }
        let at = |i: usize| t.get(i).or(t.last()).copied().unwrap_or(0.0);
        Self {
            beyond,
            residual,
            courses,
            measured,
            offset,
            rest,
            width_n: (0.0, 0.0),
            white: std::array::from_fn(|k| {
                white_noise(prepared.measured.iter().map(|s| s[k])).unwrap_or(0.0)
            }),
            phase_s: PHASES.map(|p| {
                let r = phases.range(p);
                (at(r.start), at(r.end))
            }),
            phases,
            samples: t.len(),
            unsolved: simulated.unsolved,
            residual_n: simulated.worst_residual_n,
        }
    }

    /// Error of `channel` in `phase`: beyond the tolerance.
    pub fn error(&self, channel: usize, phase: Phase) -> &Cell {
        &self.beyond[channel * PHASES.len() + phase as usize]
    }

    /// Residual of `channel` in `phase`: as it is, noise included.
    pub fn residual(&self, channel: usize, phase: Phase) -> &Cell {
        &self.residual[channel * PHASES.len() + phase as usize]
    }

    /// Course of the residual of `channel` in `phase`.
    pub fn course(&self, channel: usize, phase: Phase) -> &Course {
        &self.courses[channel * PHASES.len() + phase as usize]
    }

    /// Course of the measurement of `channel` in `phase`.
    pub fn measured(&self, channel: usize, phase: Phase) -> &Course {
        &self.measured[channel * PHASES.len() + phase as usize]
    }

    /// Takes a constant of each channel out of the measurement.
    pub fn shift(&mut self, tare: &Signals) {
        for (channel, offset) in tare.iter().enumerate().filter(|(_, x)| x.is_finite()) {
            let range = channel * PHASES.len()..(channel + 1) * PHASES.len();
            self.beyond[range.clone()].iter_mut().for_each(|c| *c = c.shifted(*offset));
            self.residual[range.clone()].iter_mut().for_each(|c| *c = c.shifted(*offset));
            self.courses[range].iter_mut().for_each(|c| c.shift(*offset));
        }
    }
}

/// Place of the nearest slack for each of `count` samples.
fn nearest(tolerance: &Tolerance, count: usize) -> Vec<usize> {
    let mut at = 0;
    (0..count)
        .map(|i| {
            while tolerance.get(at + 1).is_some_and(|next| next.0.abs_diff(i) <= tolerance[at].0.abs_diff(i))
            {
                at += 1;
            }
            at
        })
        .collect()
}

/// What is left of a residual (modelled less measured) where the truth may be so far below and
/// above the model's value.
fn outside(residual: f64, (down, up): (f64, f64)) -> f64 {
    if residual > 0.0 && down.is_finite() {
        (residual - down).max(0.0)
    } else if residual < 0.0 && up.is_finite() {
        (residual + up).min(0.0)
    } else {
        residual
    }
}
