//! Gauss-Newton on whitened features: the loss of [`crate::fit::gls`] over the free parameters,
//! constant sensor errors profiled out.

use nalgebra::DMatrix;
use stickslip_shared::model::Model;

use crate::fit::features::{FEATURES, Features};
use crate::fit::free::Free;
use crate::fit::gls::{self, FIXED, Gram, Prior};
use crate::fit::problem::{Problem, difference};
use crate::fit::sensing;

/// Dampings tried in a step, each ten times the one before: past the edge at which a contact
/// lets go a full step is worthless, however short the way to go is.
const DAMPINGS: usize = 6;

/// What moves all features together by less than a tenth of a standard deviation over its whole range, squared, is not
/// seen: a channel that was not measured, a law that is off. It stays where it is.
const UNSEEN: f64 = 0.01;

/// Where Gauss-Newton ended.
#[derive(Clone, Debug)]
pub struct Solution {
    /// With the best values.
    pub model: Model<f64>,
    /// Gram matrices around it (parameters, offsets, residual).
    pub grams: Vec<Gram>,
    /// Coarse prediction of each group at it.
    pub predicted: Vec<Features>,
    /// Residual of each group at it.
    pub residual: Vec<Features>,
    /// Sensitivities of the groups' features, one list for each free parameter.
    pub columns: Vec<Vec<Features>>,
    /// Free parameters that stand at an edge, where a linear model says nothing of them.
    pub at_edge: Vec<bool>,
    /// Fitted sensor offsets.
    pub offsets: Vec<f64>,
    /// Loss at the start and here.
    pub loss: (f64, f64),
    /// Iterations made.
    pub iterations: usize,
}

impl Solution {
    /// The same for the groups at `places` of those in use only, so that it belongs to [`Problem::restricted`].
    #[must_use]
    pub fn restricted(&self, places: &[usize]) -> Self {
        let of = |all: &[Features]| -> Vec<Features> { places.iter().map(|p| all[*p].clone()).collect() };
        Self {
            model: self.model.clone(),
            grams: places.iter().map(|p| self.grams[*p].clone()).collect(),
            predicted: of(&self.predicted),
            residual: of(&self.residual),
            columns: self.columns.iter().map(|c| of(c)).collect(),
            at_edge: self.at_edge.clone(),
            offsets: self.offsets.clone(),
            ..*self
        }
    }

    /// As [`Problem::priors`], with the parameters held that stand at an edge.
    pub fn priors(&self, problem: &Problem, free: &[Free], more: usize) -> Prior {
        let mut out = problem.priors(free, more);
        for (p, _) in out.precision.iter_mut().zip(&self.at_edge).filter(|(_, edge)| **edge) {
            *p = FIXED;
        }
        out
    }
}

/// Loss minimised over the offsets, and the offsets.
fn profile(problem: &Problem, residual: &[Features]) -> (f64, Vec<f64>) {
    gls::least(&problem.grams(residual, &[]), &problem.priors(&[], 0))
}

/// Columns of the sensitivities of the groups' features to `free`.
pub fn sensitivities(
    problem: &Problem,
    model: &Model<f64>,
    predicted: &[Features],
    free: &[Free],
) -> Vec<Vec<Features>> {
    // The models with the parameters moved, what they predict and by how much they were moved.
    let with = |moves: &[(&Free, f64)]| -> Vec<(f64, Vec<Features>)> {
        let moved = |(f, step): &(&Free, f64)| {
            let mut changed = model.clone();
            f.set(&mut changed, f.get(model) + step);
            changed
        };
        let changed: Vec<Model<f64>> = moves.iter().map(moved).collect();
        let sensed = |k: &usize| sensing::is_sensed(moves[*k].0);
        let simulated: Vec<Model<f64>> =
            (0..moves.len()).filter(|k| !sensed(k)).map(|k| changed[k].clone()).collect();
        let mut simulated = problem.predict_each(&simulated).into_iter();
        let of_move = |k: usize| {
            let with = match sensed(&k) {
                true => sensing::moved(predicted, model, &changed[k]),
                false => simulated.next().unwrap_or_default(),
            };
            (moves[k].0.get(&changed[k]) - moves[k].0.get(model), with)
        };
        (0..moves.len()).map(of_move).collect()
    };
    let size = |all: &[Features]| -> f64 {
        problem.groups.iter().zip(all).map(|(g, r)| problem.whiteners[*g].square(r)).sum()
    };
    let changed = |with: &[Features]| -> f64 {
        size(&with.iter().zip(predicted).map(|(w, p)| difference(w, p, 1.0)).collect::<Vec<_>>())
    };
    let here = size(&problem.residual(predicted));
    let forth: Vec<(&Free, f64)> = free.iter().map(|f| (f, f.step(model))).collect();
    let mut steps = with(&forth);
    // A small step that changes more than there is to explain has passed the edge at which a
    // contact lets go: the other side tells how things change on this one.
    let sizes: Vec<f64> = steps.iter().map(|(_, with)| changed(with)).collect();
    let beyond: Vec<usize> =
        (0..free.len()).filter(|k| sizes[*k] > here + (problem.groups.len() * FEATURES) as f64).collect();
    let back: Vec<(&Free, f64)> = beyond.iter().map(|k| (forth[*k].0, -forth[*k].1)).collect();
    for (k, back) in beyond.iter().zip(with(&back)) {
        if back.0 != 0.0 && changed(&back.1) < sizes[*k] {
            steps[*k] = back;
        }
    }
    let column = |(step, with): &(f64, Vec<Features>)| -> Vec<Features> {
        let step = if *step == 0.0 { f64::INFINITY } else { *step };
        with.iter().zip(predicted).map(|(w, p)| difference(w, p, step)).collect()
    };
    steps.iter().map(column).collect()
}

/// Which of `free` stand at an edge: moved by its share of the step `x` alone, an effect's parameter changes
/// the (whitened) features otherwise than its column says by more than the column says. A face that lies flat
/// lifts off one of its ends whichever way it tilts, by as much however little it tilts.
fn at_edges(
    problem: &Problem,
    (model, predicted): (&Model<f64>, &[Features]),
    free: &[Free],
    columns: &[Vec<Features>],
    x: &[f64],
) -> Vec<bool> {
    let moved = |k: usize| {
        let mut changed = model.clone();
        free[k].set(&mut changed, free[k].get(model) + x[k]);
        let step = free[k].get(&changed) - free[k].get(model);
        let may_be = step != 0.0 && matches!(free[k], Free::Effect { .. }) && !sensing::is_sensed(&free[k]);
        may_be.then_some((k, step, changed))
    };
    let moved: Vec<(usize, f64, Model<f64>)> = (0..free.len()).filter_map(moved).collect();
    let models: Vec<Model<f64>> = moved.iter().map(|(.., model)| model.clone()).collect();
    let mut out = vec![false; free.len()];
    for ((k, step, _), with) in moved.iter().zip(problem.predict_each(&models)) {
        let (mut told, mut wrong) = (0.0, 0.0);
        for (i, with) in with.iter().enumerate() {
            let w = &problem.whiteners[problem.groups[i]];
            let (did, says) =
                (w.apply(&difference(with, &predicted[i], 1.0)), w.apply(&columns[*k][i]) * *step);
            told += says.norm_squared();
            wrong += (did - says).norm_squared();
        }
        out[*k] = wrong > told;
    }
    out
}

/// Broyden's update: `columns` become such that they tell how predictions changed (from the first to the second of
/// `predicted`) as the parameters `moved`, each column by its share of the step; `sizes` are the columns' squares.
/// Predictions are rough: a step shorter than those with which sensitivities are taken (`rough`, the square of one
/// in units of the noise) tells less.
pub fn follow(
    columns: &mut [Vec<Features>],
    (before, after): (&[Features], &[Features]),
    moved: &[f64],
    (sizes, rough): (&[f64], f64),
) {
    let square: f64 = moved.iter().zip(sizes).map(|(x, s)| x * x * s).sum();
    if square <= 0.0 {
        return;
    }
    for (i, (before, after)) in before.iter().zip(after).enumerate() {
        for f in 0..FEATURES {
            let told: f64 =
                columns.iter().zip(moved).filter(|(_, x)| **x != 0.0).map(|(c, x)| c[i][f] * x).sum();
            let wrong = after[f] - before[f] - told;
            if wrong.is_finite() {
                for ((c, x), s) in columns.iter_mut().zip(moved).zip(sizes) {
                    c[i][f] += wrong * x * s / (square + rough);
                }
            }
        }
    }
}

/// What the prior of `free` costs.
fn penalty(problem: &Problem, model: &Model<f64>, free: &[Free]) -> f64 {
    free.iter().filter_map(|f| problem.prior(f).map(|(m, p)| p * (m - f.get(model)).powi(2))).sum()
}

/// A model, what it predicts and how well that fits.
#[derive(Clone, Debug)]
pub struct Place {
    /// The model.
    pub model: Model<f64>,
    predicted: Vec<Features>,
    residual: Vec<Features>,
    offsets: Vec<f64>,
    /// What a fit minimises.
    pub loss: f64,
}

impl Place {
    /// `model`, of which the `free` parameters have priors.
    pub fn of(problem: &Problem, model: Model<f64>, free: &[Free]) -> Self {
        let predicted = problem.predict(&model);
        let residual = problem.residual(&predicted);
        let (loss, offsets) = profile(problem, &residual);
        let loss = loss + penalty(problem, &model, free);
        Self { model, predicted, residual, offsets, loss }
    }
}

/// Gauss-Newton with Levenberg damping from `model`.
pub fn solve(problem: &Problem, model: &Model<f64>, free: &[Free], iterations: usize) -> Solution {
    descend(problem, Place::of(problem, model.clone(), free), free, iterations, &[]).end(problem, free)
}

/// As [`descend`] from where `on` ended, whose sensitivities are at hand; it may take as long as if those of the
/// parameters beyond the first `known` were not.
pub fn go_on(problem: &Problem, on: Solution, free: &[Free], iterations: usize, known: usize) -> Descent {
    let Solution { model, grams, predicted, residual, columns, offsets, loss, .. } = on;
    let from = Place { model, predicted, residual, offsets, loss: loss.1 };
    Descent::from(from, columns, grams, known > 0).down(problem, free, (iterations, known))
}

/// Gauss-Newton with Levenberg damping from a place; the sensitivities of the first parameters are `known` near enough.
///
/// Sensitivities are taken anew where the old ones lead no further, and for [`Descent::end`]; in between they follow what
/// the steps showed (Broyden's update): a step costs one prediction, not one for each parameter. It ends after the
/// predictions of so many full steps as `iterations` says, or where nothing is gained.
pub fn descend(
    problem: &Problem,
    from: Place,
    free: &[Free],
    iterations: usize,
    known: &[Vec<Features>],
) -> Descent {
    let mut columns = known.to_vec();
    columns.extend(sensitivities(problem, &from.model, &from.predicted, &free[known.len()..]));
    let grams = problem.grams(&from.residual, &columns);
    Descent::from(from, columns, grams, !known.is_empty()).down(problem, free, (iterations, known.len()))
}

/// Where a fit has come to. What is only compared by its loss needs no sensitivities there, which cost a prediction for
/// each parameter.
#[derive(Clone, Debug)]
pub struct Descent {
    /// The best so far.
    pub place: Place,
    /// Loss at the start.
    start: f64,
    /// Sensitivities, and the Gram matrices with them.
    columns: Vec<Vec<Features>>,
    grams: Vec<Gram>,
    /// The sensitivities are not those at this place.
    is_old: bool,
    /// What stands at an edge, where that was asked.
    held: Option<Vec<bool>>,
    iterations: usize,
}

impl Descent {
    fn from(place: Place, columns: Vec<Vec<Features>>, grams: Vec<Gram>, is_old: bool) -> Self {
        Self { start: place.loss, place, columns, grams, is_old, held: None, iterations: 0 }
    }

    /// Takes the sensitivities anew.
    fn refresh(&mut self, problem: &Problem, free: &[Free]) {
        let Place { model, predicted, residual, .. } = &self.place;
        self.columns = sensitivities(problem, model, predicted, free);
        self.grams = problem.grams(residual, &self.columns);
        self.is_old = false;
    }

    /// As a solution, with the sensitivities where it stands.
    pub fn end(mut self, problem: &Problem, free: &[Free]) -> Solution {
        if self.is_old {
            self.refresh(problem, free);
        }
        let Self { place, start, columns, grams, held, iterations, .. } = self;
        let Place { model, predicted, residual, offsets, loss } = place;
        let at_edge = held.unwrap_or_else(|| vec![false; free.len()]);
        let loss = (start, loss);
        Solution { model, grams, predicted, residual, columns, at_edge, offsets, loss, iterations }
    }

    /// At most so many full steps down, the sensitivities of the first `known` parameters for nothing.
    fn down(mut self, problem: &Problem, free: &[Free], (iterations, known): (usize, usize)) -> Self {
        // How far the parameters that have a prior are from its mean.
        let home = |model: &Model<f64>| -> Vec<f64> {
            free.iter().map(|f| problem.prior(f).map_or(0.0, |(mean, _)| mean - f.get(model))).collect()
        };
        // Predictions that full steps would take, and those made: what sensors do needs none.
        let simulated = |free: &[Free]| free.iter().filter(|f| !sensing::is_sensed(f)).count();
        let budget = iterations * (simulated(free) + 1);
        let mut spent = simulated(&free[known..]);
        let mut damping = 1e-3;
        let n = free.len();
        let prior = problem.priors(free, 0);
        while spent < budget {
            self.iterations += 1;
            let mut damped = prior.clone();
            let nothing = DMatrix::zeros(prior.len() + 1, prior.len() + 1);
            let total: DMatrix<f64> = self.grams.iter().fold(nothing, |a, g| a + &g.matrix);
            let mut accepted = false;
            for _ in 0..DAMPINGS {
                let model = &self.place.model;
                let mut towards = home(model);
                for k in 0..n {
                    let precision = prior.precision[k] + damping * total[(k, k)];
                    // The damping pulls to where we are, the prior to its mean; of what the data do not
                    // tell here it pulls nothing, for on the way there a contact may let go.
                    let told = total[(k, k)] > prior.precision[k];
                    if let Some(d) = towards.get_mut(k) {
                        *d *= if told && precision > 0.0 { prior.precision[k] / precision } else { 0.0 };
                    }
                    let (low, high) = problem.bounds(&free[k]);
                    let seen = prior.precision[k] > 0.0 || total[(k, k)] * (high - low).powi(2) > UNSEEN;
                    let stays = !seen || self.held.as_ref().is_some_and(|h| h[k]);
                    damped.precision[k] = if stays { FIXED } else { precision };
                }
                let Some(x) = gls::solve_towards(self.grams.iter().map(|g| (1.0, g)), &damped, &towards)
                else {
                    break;
                };
                let mut trial = model.clone();
                for (k, f) in free.iter().enumerate() {
                    let (low, high) = problem.bounds(f);
                    f.set(&mut trial, (f.get(model) + f.limited(model, x[k])).clamp(low, high));
                }
                let trial = Place::of(problem, trial, free);
                spent += 1;
                if trial.loss < self.place.loss {
                    let before = std::mem::replace(&mut self.place, trial);
                    let (here, after) = (before.loss, &self.place);
                    accepted = here - after.loss > 1e-3 * here + 0.1;
                    let moved: Vec<f64> =
                        free.iter().map(|f| f.get(&after.model) - f.get(&before.model)).collect();
                    let sizes: Vec<f64> = (0..n).map(|k| total[(k, k)]).collect();
                    let steps = free.iter().zip(&sizes).map(|(f, size)| f.step(&before.model).powi(2) * size);
                    let rough = steps.sum::<f64>() / n as f64;
                    follow(&mut self.columns, (&before.predicted, &after.predicted), &moved, (&sizes, rough));
                    self.is_old = true;
                    damping = (damping * 0.2).max(1e-6);
                    self.grams = problem.grams(&after.residual, &self.columns);
                    break;
                }
                if self.is_old {
                    // Before a shorter step: the same from fresh sensitivities.
                    break;
                }
                match self.held {
                    Some(_) => damping = (damping * 10.0).min(1e3),
                    None => {
                        let Place { model, predicted, .. } = &self.place;
                        let found = at_edges(problem, (model, predicted), free, &self.columns, x.as_slice());
                        damping = if found.contains(&true) { damping } else { damping * 10.0 };
                        self.held = Some(found);
                    }
                }
            }
            if !accepted {
                if !self.is_old {
                    break;
                }
                self.refresh(problem, free);
                spent += simulated(free);
            }
        }
        self
    }
}
