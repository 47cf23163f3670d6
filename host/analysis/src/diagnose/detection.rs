//! What the data could have shown: how strong an effect that was not found may be, and which effects this
//! plan cannot tell apart.
//!
//! Each strength of each effect is switched on alone, at its typical size, on the model that came out. What
//! its change of the features leaves once friction, what was fitted and constant sensor errors have made up
//! for what they can is its column; where the limit comes out far below that size, the column is taken at a smaller one. From the
//! columns follow, without fitting any effect,
//! - limits: the strength `a` that the residuals ask for, and 1.96 of its standard errors (over conditions,
//!   or by the noise, whichever is larger); at least the strength at which some channel would miss by
//!   [`RELEVANT`] run spreads in a phase, because what is weaker is not called an effect; a ninth more, since
//!   the law of an effect may be wrong by [`FORM`];
//! - classes: effects one of whose columns lies within 15 degrees of the space that the other's columns span
//!   (principal angles, Bjorck and Golub 1973).

use std::collections::BTreeMap;

use nalgebra::{DMatrix, SymmetricEigen};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use stickslip_shared::effects::{Info, MAX_PARAMETERS};

use crate::diagnose::select::Held;
use crate::diagnose::verdict::RELEVANT;
use crate::evidence::tolerance::FORM;
use crate::fit::features::Features;
use crate::fit::gls::{Beside, Gram, Prior};
use crate::fit::phases::{BINS, Phase};
use crate::fit::problem::Problem;
use crate::fit::screen::changes;
use crate::fit::{Solution, clustered_covariance, gls};
use crate::model::candidate::CandidateEffect;

/// Quantile of the normal distribution for 95 %, both sides.
const QUANTILE: f64 = 1.96;
/// Cosine of the angle (15 degrees) below which two columns are one. Half the angle: fewer classes, and names
/// that a tenth of the run spread decides.
const SAME: f64 = 0.966;
/// Directions of an effect that are weaker than this share of its strongest, squared, are none of its own.
const WEAK: f64 = 1e-4;

/// What one strength of an effect may be although nothing was found.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct UpperLimit {
    /// Largest absolute difference from its absence, 95 %; none where the data set no limit within
    /// what is possible.
    pub upper: Option<f64>,
    /// Unit.
    pub unit: &'static str,
    /// Its typical size, by the effect's source.
    pub plausible: f64,
}

/// See the module.
#[derive(Clone, Debug, Default)]
pub struct Detection {
    /// For each effect that is not in the model: its strengths.
    pub limits: BTreeMap<&'static str, BTreeMap<&'static str, UpperLimit>>,
    /// Effects that these trials cannot distinguish.
    pub classes: Vec<Vec<&'static str>>,
}

impl Detection {
    /// Effects that may be there at a typical strength.
    pub fn not_excluded(&self) -> Vec<&'static str> {
        let open = |l: &UpperLimit| l.upper.is_none_or(|upper| upper > l.plausible);
        let each = self.limits.iter().filter(|(_, strengths)| strengths.values().any(open));
        each.map(|(effect, _)| *effect).collect()
    }
}

/// A limit below this share of the size at which its column was taken is too far from it: where that much of an effect loses the
/// grasp, what little of it does says nothing.
const FAR_BELOW: f64 = 0.1;
/// Times that such a column is taken anew.
const ROUNDS: usize = 3;

/// A strength of an effect, in units of its typical size.
struct Column {
    info: &'static Info,
    parameter: usize,
    /// Size of the change, in typical sizes; zero where nothing shows.
    size: f64,
    /// Of each group, for one typical size.
    change: Vec<Features>,
}

impl Column {
    /// Typical size.
    fn unit(&self) -> f64 {
        let p = &self.info.parameters[self.parameter];
        (p.typical - p.neutral).abs()
    }

    /// Largest size that makes sense, in typical sizes.
    fn most(&self) -> f64 {
        let p = &self.info.parameters[self.parameter];
        (p.high - p.neutral).max(p.neutral - p.low) / self.unit()
    }
}

/// Limits and classes around a fitted model; the `invisible` effects are known to change nothing.
pub fn detection(problem: &Problem, held: &Held, invisible: &[&'static str]) -> Detection {
    let mut columns = columns(problem, held, invisible);
    let Solution { residual, columns: known, .. } = &held.solution;
    let beside = |columns: &[Column]| {
        let grams = problem.beside(residual, known, columns.iter().map(|c| c.change.clone()).collect());
        let limit_of = |(k, c): (usize, &Column)| limit(problem, held, c, (&grams, k));
        let limits: Vec<Option<f64>> = columns.par_iter().enumerate().map(limit_of).collect();
        (grams, limits)
    };
    let (mut grams, mut limits) = beside(&columns);
    for _ in 0..ROUNDS {
        let far: Vec<(usize, f64)> = (limits.iter().zip(&columns).enumerate())
            .filter_map(|(k, (upper, c))| Some((k, (*upper)?, c.size)))
            .filter(|(_, upper, size)| *upper < FAR_BELOW * size)
            .map(|(k, upper, size)| (k, (upper * size).sqrt()))
            .collect();
        if far.is_empty() {
            break;
        }
        take(problem, held, &mut columns, &far);
        (grams, limits) = beside(&columns);
    }
    let mut out = Detection::default();
    for (c, upper) in columns.iter().zip(&limits) {
        let p = &c.info.parameters[c.parameter];
        let upper = upper.map(|a| a * c.unit());
        let one = UpperLimit { upper, unit: p.unit, plausible: c.unit() };
        out.limits.entry(c.info.id).or_default().insert(p.name, one);
    }
    let visible: Vec<usize> = (0..columns.len()).filter(|k| limits[*k].is_some()).collect();
    let prior = held.solution.priors(problem, &held.free, visible.len());
    let of_visible: Vec<&Column> = visible.iter().map(|k| &columns[*k]).collect();
    out.classes = match products(&grams.with(&visible), &prior, held.free.len(), visible.len()) {
        Some(products) => classes(&products, &of_visible),
        None => Vec::new(),
    };
    out
}

/// Columns of all strengths of all listed effects that the model does not have.
fn columns(problem: &Problem, held: &Held, invisible: &[&'static str]) -> Vec<Column> {
    let mut out = Vec::new();
    for effect in CandidateEffect::listed().iter().filter(|e| !e.is_excluded_by(&held.solution.model)) {
        let strengths = effect.info.parameters.iter().enumerate().filter(|(_, p)| p.typical != p.neutral);
        for (parameter, _) in strengths {
            let change = held.solution.predicted.iter().map(|p| vec![0.0; p.len()]).collect();
            out.push(Column { info: effect.info, parameter, size: 0.0, change });
        }
    }
    let visible = |(_, c): &(usize, &Column)| !invisible.contains(&c.info.id);
    let typical: Vec<(usize, f64)> = out.iter().enumerate().filter(visible).map(|(k, _)| (k, 1.0)).collect();
    take(problem, held, &mut out, &typical);
    out
}

/// Takes columns anew, each at a size in typical ones.
fn take(problem: &Problem, held: &Held, columns: &mut [Column], at: &[(usize, f64)]) {
    let (model, predicted) = (&held.solution.model, &held.solution.predicted);
    let listed = CandidateEffect::listed();
    let with = |(k, size): &(usize, f64)| {
        let Column { info, parameter, .. } = &columns[*k];
        let mut parameters = [0.0; MAX_PARAMETERS];
        for (x, p) in parameters.iter_mut().zip(info.parameters) {
            // What has no absence only shapes the effect.
            *x = if p.typical == p.neutral { p.typical } else { p.neutral };
        }
        let p = &info.parameters[*parameter];
        parameters[*parameter] = p.neutral + size * (p.typical - p.neutral);
        let effect = listed.iter().find(|e| e.info.code == info.code)?;
        Some(effect.on(model, parameters))
    };
    let models: Vec<_> = at.iter().filter_map(with).collect();
    for ((k, size), change) in at.iter().zip(changes(problem, predicted, &models)) {
        let of_one = |change: &Features| change.iter().map(|x| x / size).collect();
        (columns[*k].size, columns[*k].change) = (*size, change.iter().map(of_one).collect());
    }
}

/// Upper limit of one strength, in typical sizes; none where there is none within what is possible. Its `column` is the
/// `k`th of those beside the model.
fn limit(problem: &Problem, held: &Held, column: &Column, (beside, k): (&Beside, usize)) -> Option<f64> {
    let Held { solution, free, .. } = held;
    let known = free.len();
    let smallest = RELEVANT / shown(problem, held, column, &beside.towards(k))?;
    let grams = beside.with(&[k]);
    let prior = solution.priors(problem, free, 1);
    let asked = gls::solve(grams.iter().map(|g| (1.0, g)), &prior)?[known];
    let by_noise = information(&grams, &prior).cholesky()?.inverse()[(known, known)];
    let over_conditions = clustered_covariance(&grams, &prior, known + 1)[(known, known)];
    let upper = asked.abs() + QUANTILE * by_noise.max(over_conditions).sqrt();
    // The law of an effect may be wrong by as much: then a strength beyond shows as little.
    let upper = upper.max(smallest) / (1.0 - FORM);
    (upper <= column.most()).then_some(upper)
}

/// What the data and the prior tell of the coefficients together; positive definite.
fn information(grams: &[Gram], prior: &Prior) -> DMatrix<f64> {
    let size = prior.len();
    let mut sum = DMatrix::zeros(size, size);
    for g in grams {
        sum += g.matrix.view((0, 0), (size, size));
    }
    for (i, p) in prior.precision.iter().enumerate() {
        sum[(i, i)] += p + 1e-12;
    }
    sum
}

/// By how many run spreads the worst channel of a phase would miss for one typical size; none where nothing
/// shows.
fn shown(problem: &Problem, held: &Held, column: &Column, grams: &[Gram]) -> Option<f64> {
    let Held { solution, free, .. } = held;
    let prior = solution.priors(problem, free, 0);
    let x = gls::solve(grams.iter().map(|g| (1.0, g)), &prior)?;
    let mut left = problem.without_offsets(&column.change, &x.as_slice()[free.len()..]);
    let mut places: BTreeMap<(usize, Phase), (f64, f64)> = BTreeMap::new();
    for (i, (g, row)) in problem.groups.iter().zip(&mut left).enumerate() {
        for f in &problem.whiteners[*g].active {
            let made_up: f64 = solution.columns.iter().zip(&x).map(|(c, x)| c[i][*f] * x).sum();
            let size = (row[*f] - made_up) / problem.single_run[*g][*f];
            if size.is_finite() {
                let place = places.entry((*f / BINS, Phase::of(*f % BINS))).or_default();
                place.0 += size * size;
                place.1 += 1.0;
            }
        }
    }
    let largest = places.values().map(|(sum, n)| sum / n).fold(0.0, f64::max).sqrt();
    (largest > 0.0).then_some(largest)
}

/// Effects that stand in for each other, all within a class alike.
fn classes(products: &DMatrix<f64>, columns: &[&Column]) -> Vec<Vec<&'static str>> {
    let mut effects: Vec<&'static str> = columns.iter().map(|c| c.info.id).collect();
    effects.dedup();
    let bases: Vec<DMatrix<f64>> = effects.iter().map(|id| basis(products, columns, id)).collect();
    // Cosine of the angle between one strength and the space of an effect.
    let within = |k: usize, of: &DMatrix<f64>| {
        (of.transpose() * products.column(k)).norm() / products[(k, k)].max(f64::MIN_POSITIVE).sqrt()
    };
    let closest = |a: usize, b: usize| {
        let own = (0..columns.len()).filter(|k| columns[*k].info.id == effects[a]);
        own.map(|k| within(k, &bases[b])).fold(0.0, f64::max)
    };
    let mut alike = Vec::new();
    for a in 0..effects.len() {
        for b in 0..a {
            let cosine = closest(a, b).max(closest(b, a));
            if cosine > SAME {
                alike.push((cosine, a, b));
            }
        }
    }
    alike.sort_by(|x, y| y.0.total_cmp(&x.0));
    let same = |a: usize, b: usize| alike.iter().any(|(_, x, y)| (*x, *y) == (a.max(b), a.min(b)));
    let mut class: Vec<Vec<usize>> = (0..effects.len()).map(|e| vec![e]).collect();
    for (_, a, b) in &alike {
        let place = |e: &usize| class.iter().position(|c| c.contains(e));
        let (Some(i), Some(j)) = (place(a), place(b)) else { continue };
        if i != j && class[i].iter().all(|x| class[j].iter().all(|y| same(*x, *y))) {
            let moved = class.remove(i.max(j));
            class[i.min(j)].extend(moved);
        }
    }
    class.retain(|c| c.len() > 1);
    class.iter().map(|c| c.iter().map(|e| effects[*e]).collect()).collect()
}

/// Inner products of `more` whitened columns, less what the `known` parameters (friction, what was fitted) and the sensor
/// offsets make up for.
fn products(grams: &[Gram], prior: &Prior, known: usize, more: usize) -> Option<DMatrix<f64>> {
    let whole = information(grams, prior);
    let nuisance: Vec<usize> = (0..prior.len()).filter(|i| !(known..known + more).contains(i)).collect();
    let of = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| whole[(rows[i], columns[j])])
    };
    let own: Vec<usize> = (known..known + more).collect();
    let cross = of(&nuisance, &own);
    Some(of(&own, &own) - cross.transpose() * of(&nuisance, &nuisance).cholesky()?.solve(&cross))
}

/// Orthonormal coordinates (columns by directions) of the space that the columns of effect `id` span.
fn basis(products: &DMatrix<f64>, columns: &[&Column], id: &str) -> DMatrix<f64> {
    let own: Vec<usize> = (0..columns.len()).filter(|k| columns[*k].info.id == id).collect();
    let eigen =
        SymmetricEigen::new(DMatrix::from_fn(own.len(), own.len(), |i, j| products[(own[i], own[j])]));
    let largest = eigen.eigenvalues.max();
    let kept: Vec<usize> =
        (0..own.len()).filter(|k| eigen.eigenvalues[*k] > WEAK * largest && largest > 0.0).collect();
    let mut out = DMatrix::zeros(columns.len(), kept.len());
    for (j, k) in kept.iter().enumerate() {
        for (i, row) in own.iter().enumerate() {
            out[(*row, j)] = eigen.eigenvectors[(i, *k)] / eigen.eigenvalues[*k].sqrt();
        }
    }
    out
}
