//! The trials that a page draws.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::document::{Trace, TrialRow};
use super::inputs::load;
use super::models::NamedModel;
use super::noise::Floor;
use super::rows;
use crate::channels::{COUNT, Signals};
use crate::evidence::carried;
use crate::evidence::conditions::{VARIABLES, in_words};
use crate::evidence::force_bands::{Band, bands};
use crate::evidence::phases::{PHASES, Phases};
use crate::run::bench::Bench;
use crate::run::simulate::{Prepared, prepare};
use stickslip_data::Index;
use stickslip_shared::model::Model;

/// Samples at which the intervals of undetermined forces are found.
const DRAWN_BANDS: usize = 48;

/// Signals of the worst and the median trial (or of the one chosen), and of the worst run of further
/// conditions, `most` trials in all: simulated once more.
#[allow(clippy::too_many_arguments)]
pub fn traces(
    data: &Index,
    places: &[usize],
    phases: &[Phases],
    trials: &rows::Trials,
    models: &[NamedModel],
    tares: &[Signals],
    floors: &BTreeMap<rows::Key, Floor>,
    rows: &[TrialRow],
    single: bool,
    most: usize,
) -> Vec<Trace> {
    let at =
        |row: &TrialRow| places.iter().position(|i| data.trials[*i].trial == row.trial).unwrap_or_default();
    let mut ranked: Vec<&TrialRow> = rows.iter().filter(|r| r.multiples.is_some()).collect();
    if ranked.is_empty() {
        ranked = rows.iter().collect();
    }
    ranked.sort_by(|a, b| b.multiples.unwrap_or(0.0).total_cmp(&a.multiples.unwrap_or(0.0)));
    let mut wanted: Vec<(&TrialRow, &'static str)> = Vec::new();
    match ranked.as_slice() {
        [] => {}
        [only] => wanted.push((only, if single { "chosen trial" } else { "only trial" })),
        [worst, ..] => {
            wanted.push((worst, "worst trial"));
            wanted.push((ranked[ranked.len() / 2], "median trial"));
        }
    }
    let bands = wanted.len();
    let mut shown: BTreeSet<usize> = wanted.iter().map(|(row, _)| row.condition).collect();
    for row in &ranked {
        if wanted.len() < most && shown.insert(row.condition) {
            wanted.push((row, "worst of its condition"));
        }
    }
    wanted
        .into_par_iter()
        .enumerate()
        .filter_map(|(place, (row, role))| {
            let k = at(row);
            let i = places[k];
            let trial = load(data, i).0.ok()?;
            let prepared = carried::at_an_edge(prepare(&data.description, &trial, i).ok()?);
            let modelled = models
                .iter()
                .map(|m| m.simulate(&data.trials[i], &prepared).map(|s| s.signals))
                .collect::<Result<_, _>>()
                .ok()?;
            // The intervals cost more than the simulation.
            let rigid = models.last().filter(|m| m.is_rigid() && place < bands);
            let force_bands =
                rigid.map_or_else(Vec::new, |m| drawn_bands(&prepared, m.of(&data.trials[i].primitive)));
            let bench = Bench::of(&prepared);
            let mut measured = prepared.measured;
            for row in &mut measured {
                for (x, tare) in row.iter_mut().zip(&tares[k]) {
                    *x -= tare;
                }
            }
            let primitive = trials.primitive(k);
            let band = (0..COUNT)
                .map(|c| {
                    PHASES.map(|p| floors.get(&(primitive.to_owned(), c, p)).map_or(f64::NAN, |f| f.rms))
                })
                .collect();
            let info = &data.trials[i];
            let levels: Vec<_> = VARIABLES.into_iter().filter_map(|v| Some((v, v.level(info)?))).collect();
            Some(Trace {
                trial: row.trial.clone(),
                role,
                conditions: in_words(info),
                primitive: info.primitive.clone(),
                condition: row.condition,
                levels,
                multiples: row.multiples,
                bench,
                t_s: prepared.t_s,
                measured,
                modelled,
                phases: phases[k],
                band,
                force_bands,
            })
        })
        .collect()
}

/// Both ends of the intervals at samples spread over a trial, and their times.
fn drawn_bands(prepared: &Prepared, model: &Model<f64>) -> Vec<(f64, Band)> {
    let n = prepared.t_s.len();
    let count = DRAWN_BANDS.min(n);
    let at: Vec<usize> = (0..count).map(|k| k * (n - 1) / (count - 1).max(1)).collect();
    bands(prepared, model, &at).into_iter().map(|(i, band)| (prepared.t_s[i], band)).collect()
}
