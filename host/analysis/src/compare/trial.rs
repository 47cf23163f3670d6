//! Errors of one trial: modelled minus measured, for each channel and phase.
//!
//! Sums are kept rather than errors, so that a constant sensor offset found later from the
//! whole data set can still be taken out exactly.

use crate::channels::{COUNT, Quantity, Signals, quantity};
use crate::evidence::force_bands::Band;
use crate::evidence::noise::{Course, FEWEST_SAMPLES, white_noise};
use crate::evidence::phases::{PHASES, Phase, Phases};
use crate::run::simulate::{Prepared, Simulated};

/// Fewer samples than this before contact give no tare.
const FEWEST_TARE_SAMPLES: u32 = 5;

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
    /// By channel and phase; [`raw`](Self::raw) finds one.
    cells: Vec<Cell>,
    /// The same, whether rigid contact leaves the force open or not: how runs scatter.
    errors: Vec<Course>,
    /// Of the measurement itself.
    measured: Vec<Course>,
    /// Mean of measured minus modelled before contact; NaN where not known. Force and torque only.
    pub offset: Signals,
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
    /// Compares `simulated` with the measurement. The tare is not applied yet.
    pub fn of(prepared: &Prepared, simulated: &Simulated, phases: Phases) -> Self {
        Self::with_bands(prepared, simulated, phases, &[])
    }

    /// As [`Self::of`]; after contact a force counts only as far as it is outside the `bands`
    /// (of the simulation, at some samples, rising; the nearest one holds), sensor offset
    /// taken out.
    pub fn with_bands(
        prepared: &Prepared,
        simulated: &Simulated,
        phases: Phases,
        bands: &[(usize, Band)],
    ) -> Self {
        let t = &prepared.t_s;
        let mut cells = vec![Cell::EMPTY; COUNT * PHASES.len()];
        let (mut whole, mut measured) = (Vec::with_capacity(cells.len()), Vec::with_capacity(cells.len()));
        let mut errors = Vec::new();
        let mut offset = [f64::NAN; COUNT];
        let nearest = nearest(bands, t.len());
        for channel in 0..COUNT {
            for phase in PHASES {
                let range = phases.range(phase);
                errors.clear();
                errors.extend(
                    simulated.signals[range.clone()]
                        .iter()
                        .zip(&prepared.measured[range])
                        .map(|(model, measured)| model[channel] - measured[channel]),
                );
                whole.push(Course::of(&errors));
                let seen: Vec<f64> =
                    prepared.measured[phases.range(phase)].iter().map(|row| row[channel]).collect();
                measured.push(Course::of(&seen));
                if phase != Phase::BeforeContact && !bands.is_empty() {
                    let known = if offset[channel].is_finite() { offset[channel] } else { 0.0 };
                    for (e, i) in errors.iter_mut().zip(phases.range(phase)) {
                        let (sample, band) = &bands[nearest[i]];
                        let value = simulated.signals[*sample][channel];
                        *e = outside(*e + known, band[channel], value) - known;
                    }
                }
                let cell = Cell::of(&errors);
                if phase == Phase::BeforeContact
                    && cell.samples >= FEWEST_TARE_SAMPLES
                    && matches!(quantity(channel), Quantity::Force | Quantity::Torque)
                {
                    offset[channel] = -cell.bias();
                }
                cells[channel * PHASES.len() + phase as usize] = cell;
            }
        }
        let at = |i: usize| t.get(i).or(t.last()).copied().unwrap_or(0.0);
        Self {
            cells,
            errors: whole,
            measured,
            offset,
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

    /// Mean measured less modelled before contact of each channel, and the noise of each: what
    /// is needed to judge forces against bands.
    pub fn tare_and_noise(prepared: &Prepared, simulated: &Simulated, phases: Phases) -> (Signals, Signals) {
        let of = Self::of(prepared, simulated, phases);
        (of.offset.map(|o| if o.is_finite() { o } else { 0.0 }), of.white)
    }

    /// Errors of `channel` in `phase`, without a tare.
    pub fn raw(&self, channel: usize, phase: Phase) -> &Cell {
        &self.cells[channel * PHASES.len() + phase as usize]
    }

    /// Course of the error of `channel` in `phase`, forces that are not determined counted too.
    pub fn error(&self, channel: usize, phase: Phase) -> &Course {
        &self.errors[channel * PHASES.len() + phase as usize]
    }

    /// Course of the measurement of `channel` in `phase`.
    pub fn measured(&self, channel: usize, phase: Phase) -> &Course {
        &self.measured[channel * PHASES.len() + phase as usize]
    }

    /// Takes a constant of each channel out of the measurement.
    pub fn shift(&mut self, tare: &Signals) {
        for (channel, offset) in tare.iter().enumerate().filter(|(_, x)| x.is_finite()) {
            let range = channel * PHASES.len()..(channel + 1) * PHASES.len();
            self.cells[range.clone()].iter_mut().for_each(|c| *c = c.shifted(*offset));
            self.errors[range.clone()].iter_mut().for_each(|c| c.shift(*offset));
            self.measured[range].iter_mut().for_each(|c| c.shift(-offset));
        }
    }
}

/// Place of the nearest band for each of `count` samples.
fn nearest(bands: &[(usize, Band)], count: usize) -> Vec<usize> {
    let mut at = 0;
    (0..count)
        .map(|i| {
            while bands.get(at + 1).is_some_and(|next| next.0.abs_diff(i) <= bands[at].0.abs_diff(i)) {
                at += 1;
            }
            at
        })
        .collect()
}

/// What is left of an error (modelled less measured) where the model's force may be anything
/// in a band around its `value`.
fn outside(error: f64, (low, high): (f64, f64), value: f64) -> f64 {
    let (down, up) = (value - low, high - value);
    if error > 0.0 && down.is_finite() {
        (error - down).max(0.0)
    } else if error < 0.0 && up.is_finite() {
        (error + up).min(0.0)
    } else {
        error
    }
}
