//! Where in the space of conditions the model fails: errors over pairs of conditions, and
//! mean errors that rise or fall with a condition.

use std::collections::{BTreeMap, BTreeSet};

use super::document::{ErrorRow, Region, Trend};
use super::noise::Floor;
use super::rows::{Key, Trials, varied};
use super::trial::TrialErrors;
use crate::channels::quantity;
use crate::evidence::conditions::Variable;
use crate::evidence::phases::Phase;
use crate::evidence::statistics::{holm, regression};

/// Worst rows (of different channels first) for which regions are drawn.
const WORST: usize = 4;
/// Trends above this corrected p are not reported.
const REPORTED_P: f64 = 0.05;

/// Regions of the worst rows, significant trends of all rows, and the number of trends tested.
pub fn find(
    trials: &Trials,
    errors: &[TrialErrors],
    rows: &[ErrorRow],
    floors: &BTreeMap<Key, Floor>,
) -> (Vec<Region>, Vec<Trend>, usize) {
    let mut regions = Vec::new();
    for row in worst(rows) {
        let known = known(trials, errors, row);
        let variables = varied(known.iter().map(|k| trials.info(*k)));
        for (i, y) in variables.iter().enumerate() {
            for x in &variables[i + 1..] {
                regions.push(region(trials, errors, row, floors, &known, (*x, *y)));
            }
        }
    }
    let mut all = Vec::new();
    for row in rows.iter().filter(|r| r.place.phase != Phase::BeforeContact || r.fails) {
        trends(trials, errors, row, &mut all);
    }
    let tested = all.len();
    let p: Vec<f64> = all.iter().map(|t| t.p).collect();
    for (t, corrected) in all.iter_mut().zip(holm(&p)) {
        t.p_corrected = corrected;
    }
    all.retain(|t| t.p_corrected < REPORTED_P);
    let span = |t: &Trend| t.span_multiples.unwrap_or(0.0).abs();
    all.sort_by(|a, b| span(b).total_cmp(&span(a)));
    (regions, all, tested)
}

/// The worst rows, no channel twice.
fn worst(rows: &[ErrorRow]) -> Vec<&ErrorRow> {
    let mut seen = BTreeSet::new();
    rows.iter()
        .filter(|r| r.error.multiples.is_some() && seen.insert((r.place.primitive.clone(), r.index)))
        .take(WORST)
        .collect()
}

fn known(trials: &Trials, errors: &[TrialErrors], row: &ErrorRow) -> Vec<usize> {
    let mut ks = trials.of(&row.place.primitive);
    ks.retain(|k| errors[*k].error(row.index, row.place.phase).is_known());
    ks
}

fn region(
    trials: &Trials,
    errors: &[TrialErrors],
    row: &ErrorRow,
    floors: &BTreeMap<Key, Floor>,
    known: &[usize],
    (x, y): (Variable, Variable),
) -> Region {
    let key = (row.place.primitive.clone(), row.index, row.place.phase);
    let floor = floors.get(&key).map_or(f64::NAN, |f| f.rms);
    let levels = |v: Variable| {
        let mut levels: Vec<(Option<f64>, String)> = Vec::new();
        for k in known {
            let info = trials.info(*k);
            if let Some(text) = v.level(info)
                && !levels.iter().any(|l| l.1 == text)
            {
                levels.push((v.value(info), text));
            }
        }
        levels.sort_by(|a, b| a.0.unwrap_or(0.0).total_cmp(&b.0.unwrap_or(0.0)).then_with(|| a.1.cmp(&b.1)));
        levels.into_iter().map(|l| l.1).collect::<Vec<String>>()
    };
    let (x_levels, y_levels) = (levels(x), levels(y));
    let mut sums = vec![vec![(0.0, 0.0); x_levels.len()]; y_levels.len()];
    for k in known {
        let info = trials.info(*k);
        let place = |v: Variable, levels: &[String]| {
            v.level(info).and_then(|text| levels.iter().position(|l| *l == text))
        };
        if let (Some(i), Some(j)) = (place(x, &x_levels), place(y, &y_levels)) {
            let sum = &mut sums[j][i];
            sum.0 += errors[*k].error(row.index, row.place.phase).mean_square();
            sum.1 += 1.0;
        }
    }
    let mean = |(square, n): (f64, f64)| (n > 0.0).then(|| (square / n).sqrt() / floor);
    let multiples = sums.into_iter().map(|r| r.into_iter().map(mean).collect()).collect();
    Region { place: row.place.clone(), x, y, x_levels, y_levels, multiples }
}

/// Trends of one row's mean error: against each varied number over the conditions' means,
/// and against the order of the runs.
fn trends(trials: &Trials, errors: &[TrialErrors], row: &ErrorRow, out: &mut Vec<Trend>) {
    let known = known(trials, errors, row);
    let bias = |k: usize| errors[k].error(row.index, row.place.phase).bias();
    let groups = trials.repetitions(&known);
    let mut candidates: Vec<(Variable, Vec<(f64, f64)>)> = varied(known.iter().map(|k| trials.info(*k)))
        .into_iter()
        .filter(|v| *v != Variable::Object)
        .map(|v| {
            let points = groups.iter().filter_map(|g| {
                let x = v.value(trials.info(g[0]))?;
                Some((x, g.iter().map(|k| bias(*k)).sum::<f64>() / g.len() as f64))
            });
            (v, points.collect())
        })
        .collect();
    // Runs of one condition share its misfit: only their differences tell of order.
    let within = groups.iter().filter(|g| g.len() > 1).flat_map(|g| {
        let n = g.len() as f64;
        let x = g.iter().map(|k| trials.places[*k] as f64).sum::<f64>() / n;
        let y = g.iter().map(|k| bias(*k)).sum::<f64>() / n;
        g.iter().map(move |k| (trials.places[*k] as f64 - x, bias(*k) - y))
    });
    candidates.push((Variable::Order, within.collect()));
    for (variable, points) in candidates {
        let means = groups.iter().filter(|g| g.len() > 1).count();
        let estimated = if variable == Variable::Order { means + 1 } else { 2 };
        let Some(line) = regression(&points, estimated) else { continue };
        if points.len() < 4 || !line.p.is_finite() {
            continue;
        }
        let low = points.iter().map(|p| p.0).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(|p| p.0).fold(f64::NEG_INFINITY, f64::max);
        out.push(Trend {
            place: row.place.clone(),
            variable,
            slope: line.slope,
            intercept: line.intercept,
            unit: format!("{}/({})", quantity(row.index).unit(), variable.unit()),
            span_multiples: row.noise_floor.map(|f| line.slope * (high - low) / f),
            p: line.p,
            p_corrected: f64::NAN,
            points,
        });
    }
}
