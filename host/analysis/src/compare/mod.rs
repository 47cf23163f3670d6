//! Model against measurement: errors by channel and phase, where the model fails, and
//! whether another model fails less.
//!
//! Every trial is simulated along its measured drive ([`crate::run::simulate`]) and split into
//! phases ([`crate::evidence::phases`]). Residuals are modelled minus measured, after taking out what
//! may be called a sensor offset ([`tare`]); an error is what of them is beyond the tolerance
//! ([`models`]). Both are measured against the scatter of repetitions ([`noise`]). Lack of fit is an F
//! test of the conditions' mean errors against that scatter ([`crate::evidence::statistics`]),
//! corrected for the number of channels and phases looked at.
//!
//! A model's own figures depend on the model and the data alone. Before and after are judged by one
//! tolerance, that of the first model: one that leaves more open gains nothing by it.

mod base;
pub mod document;
pub mod inputs;
pub mod models;
pub mod noise;
pub mod regions;
pub mod rows;
pub mod tare;
mod traces;
pub mod trial;
pub mod verdict;

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use crate::channels::Signals;
use crate::evidence::carried;
use crate::evidence::conditions::HeldOut;
use crate::evidence::phases::{Phases, split};
use crate::left_out::LeftOut;
use crate::progress::Progress;
use crate::run::simulate::{Simulated, prepare};
use document::{Comparison, DataSummary, ErrorRow, ModelReport, SCHEMA};
use noise::Source;
use rows::Part;
use stickslip_data::{Index, TrialInfo};
use trial::TrialErrors;

use inputs::load;
pub use inputs::{CompareError, Forces, Options, SIGNIFICANCE};
pub use models::NamedModel;

/// Trials that were compared, with the errors of each model.
struct Compared {
    /// Places in the data set.
    places: Vec<usize>,
    /// By model, then trial: within the model's own tolerance.
    errors: Vec<Vec<TrialErrors>>,
    /// The last model's within the tolerance and the phases of the first; empty for one model.
    paired: Vec<TrialErrors>,
    /// By primitive: which coefficients of friction its trials have.
    frictions: BTreeMap<String, [bool; 3]>,
    skipped: Vec<LeftOut>,
    /// What could not be read.
    refused: Vec<String>,
}

/// Compares `models` with the data. Without a model the base model is calibrated quickly.
/// A step of `progress` is a trial.
///
/// # Errors
/// A trial that is not there, nothing to hold out, no trial that can be simulated.
pub fn compare(
    data: &Index,
    models: &[NamedModel],
    options: &Options,
    progress: &dyn Progress,
) -> Result<Comparison, CompareError> {
    let infos = data.trials.as_slice();
    if infos.is_empty() {
        return Err(CompareError::Empty);
    }
    let held_out = options.held_out.mask(infos).map_err(CompareError::HeldOut)?;
    let groups = crate::evidence::conditions::conditions(infos);
    let condition_of = crate::evidence::conditions::condition_of(infos);
    let chosen = chosen_trials(options, infos, &groups, &condition_of, &held_out)?;
    let mut notes = Vec::new();
    let mut with_sensors = data.clone();
    with_sensors.description = base::with_sensors(data, &mut notes);
    let data = &with_sensors;
    let noise = noise::sensor_noise(&data.description);
    let mut calibrated = None;
    if models.is_empty() {
        progress.begin("calibrating", 1);
        calibrated = Some(base::calibrated(data, &groups, &held_out, &mut notes));
        progress.step(1);
    }
    let models = calibrated.as_ref().map_or(models, std::slice::from_ref);
    progress.begin("comparing", chosen.loaded.len());
    let compared = simulate_all(data, &chosen.loaded, models, options.forces, &noise, progress);
    let reported: Vec<bool> = compared.places.iter().map(|i| chosen.reported.contains(i)).collect();
    if !reported.iter().any(|r| *r) {
        let why = compared.skipped.first().map_or("no trial is left".into(), ToString::to_string);
        return Err(CompareError::NoTrial(why));
    }

    let trials = rows::Trials {
        infos,
        places: &compared.places,
        condition_of: &condition_of,
        reported: &reported,
        noise: &noise,
        sensors: &data.description.sensors,
        tare: options.tare,
    };
    // Takes the offsets out; returns them, and what was taken out of each trial.
    let tared = |errors: &mut [TrialErrors]| {
        let found = tare::offsets(&errors.iter().collect::<Vec<_>>(), &data.description, options.tare);
        for (e, tare) in errors.iter_mut().zip(&found.1) {
            e.shift(tare);
        }
        found
    };
    let rows_of = |errors: &[TrialErrors], tares: &[Signals], part: Part| -> Vec<ErrorRow> {
        let mut rows = trials.rows(errors, tares, &trials.floors(errors), part);
        if chosen.single {
            for row in &mut rows {
                row.lack_of_fit = None;
                row.fails = false;
            }
        }
        rows
    };
    let mut reports = Vec::new();
    let mut shifted = compared.errors;
    let mut of_first = None;
    let mut of_last = Vec::new();
    for (named, errors) in models.iter().zip(&mut shifted) {
        let (offsets, tares) = tared(errors);
        let floors = trials.floors(errors);
        let rows = rows_of(errors, &tares, Part::Error);
        let (regions, trends, trends_tested) =
            if chosen.single { Default::default() } else { regions::find(&trials, errors, &rows, &floors) };
        of_first.get_or_insert_with(|| (rows.clone(), rows_of(errors, &tares, Part::Residual)));
        let (sum, count) = errors.iter().fold((0.0, 0.0), |a, e| (a.0 + e.width_n.0, a.1 + e.width_n.1));
        reports.push(ModelReport {
            name: named.name.clone(),
            origin: named.origin.clone(),
            friction: named.friction(&compared.frictions),
            only_bounded: named.only_bounded.clone(),
            effects: named.model.effects.iter().map(effect_name).collect(),
            open_force_n: (count > 0.0).then(|| sum / count),
            offsets,
            errors: rows,
            regions,
            trends,
            trends_tested,
            unsolved_steps: errors.iter().map(|e| e.unsolved).sum(),
            trials: trials.trial_rows(errors, &floors),
        });
        of_last = tares;
    }
    let (mut changes, mut tallies) = (Vec::new(), Vec::new());
    if let (Some((errors, residuals)), false) = (of_first, compared.paired.is_empty()) {
        let mut paired = compared.paired;
        let (_, tares) = tared(&mut paired);
        changes = rows::changes(&errors, &rows_of(&paired, &tares, Part::Error), Part::Error);
        let without = rows::changes(&residuals, &rows_of(&paired, &tares, Part::Residual), Part::Residual);
        tallies = vec![rows::tally(&changes, Part::Error), rows::tally(&without, Part::Residual)];
    }
    let last = &shifted[shifted.len() - 1];
    let phases: Vec<Phases> = last.iter().map(|e| e.phases).collect();
    let floors = trials.floors(last);
    let trial_rows = &reports[reports.len() - 1].trials;
    let traces = traces::traces(
        data,
        &compared.places,
        &phases,
        &trials,
        models,
        &of_last,
        &floors,
        trial_rows,
        chosen.single,
        options.drawn,
    );
    let sources: BTreeSet<Source> = reports[0].errors.iter().map(|r| r.noise_source).collect();
    let noise_floor = [Source::Repetitions, Source::SensorNoise]
        .into_iter()
        .find(|s| sources.contains(s))
        .unwrap_or(Source::Unknown);
    let present: BTreeSet<usize> =
        compared.places.iter().zip(&reported).filter(|(_, r)| **r).map(|(i, _)| condition_of[*i]).collect();
    let repeats = |c: &&usize| compared.places.iter().filter(|i| condition_of[**i] == **c).count() > 1;
    let data_summary = DataSummary {
        name: data.description.name.clone(),
        trials: reported.iter().filter(|r| **r).count(),
        conditions: present.len(),
        repeated_conditions: present.iter().filter(repeats).count(),
        held_out: options.held_out != HeldOut::Nothing,
        noise_floor,
        significance: SIGNIFICANCE,
    };
    notes.extend(verdict::notes(&data_summary, &reports, options, chosen.single));
    let summary = verdict::summary(&data_summary, &reports, (&changes, &tallies), chosen.single);
    Ok(Comparison {
        schema: SCHEMA,
        summary,
        notes,
        data: data_summary,
        models: reports,
        changes,
        tallies,
        skipped: compared.skipped,
        refused: compared.refused,
        traces,
        calibrated,
    })
}

fn effect_name(effect: &stickslip_shared::effects::Effect<f64>) -> String {
    effect.info().map_or_else(|| format!("unknown effect {}", effect.code), |i| i.id.to_owned())
}

/// What is loaded, and what of it is reported.
struct Chosen {
    loaded: Vec<usize>,
    reported: BTreeSet<usize>,
    single: bool,
}

fn chosen_trials(
    options: &Options,
    infos: &[TrialInfo],
    groups: &[Vec<usize>],
    condition_of: &[usize],
    held_out: &[bool],
) -> Result<Chosen, CompareError> {
    if let Some(id) = &options.trial {
        let at = infos.iter().position(|i| i.trial == *id).ok_or_else(|| {
            let some: Vec<&str> = infos.iter().take(5).map(|i| i.trial.as_str()).collect();
            CompareError::NoSuchTrial { id: id.clone(), count: infos.len(), some: some.join(", ") }
        })?;
        // Its repetitions give the noise floor.
        let loaded = groups[condition_of[at]].clone();
        return Ok(Chosen { loaded, reported: BTreeSet::from([at]), single: true });
    }
    let any = held_out.iter().any(|h| *h);
    let loaded: Vec<usize> = (0..infos.len()).filter(|i| !any || held_out[*i]).collect();
    Ok(Chosen { reported: loaded.iter().copied().collect(), loaded, single: false })
}

fn simulate_all(
    data: &Index,
    loaded: &[usize],
    models: &[NamedModel],
    forces: Forces,
    noise: &Signals,
    progress: &dyn Progress,
) -> Compared {
    type One = (Vec<TrialErrors>, Option<TrialErrors>, [bool; 3]);
    let results: Vec<(usize, Result<One, String>, Option<String>)> = loaded
        .par_iter()
        .map(|&i| {
            let (trial, refused) = load(data, i);
            let one = || -> Result<One, String> {
                let trial = trial?;
                let prepared = prepare(&data.description, &trial, i).map_err(|e| LeftOut::from(&e).reason)?;
                let prepared = carried::at_an_edge(prepared);
                drop(trial);
                let info = &data.trials[i];
                let bare = |simulated: &Simulated, phases| {
                    TrialErrors::of(&prepared, simulated, phases, &Vec::new())
                };
                // The intervals of `model` as far as the residuals of `other` ask for them.
                let tolerance = |model: &NamedModel,
                                 (own, phases): (&Simulated, Phases),
                                 other: &Simulated| {
                    if forces == Forces::AsReturned {
                        return Vec::new();
                    }
                    let of = bare(other, phases);
                    let tare = of.offset.map(|o| if o.is_finite() { o } else { 0.0 });
                    let wanted = |i: usize| -> Signals {
                        let value = |s: &Simulated, c: usize| s.signals.get(i).map_or(f64::NAN, |row| row[c]);
                        std::array::from_fn(|c| {
                            value(own, c) + prepared.measured[i][c] - tare[c] - value(other, c)
                        })
                    };
                    model.tolerance(&info.primitive, &prepared, (own, phases), &wanted, &of.white)
                };
                let mut first: Option<(Simulated, Phases)> = None;
                let mut paired = None;
                let mut errors = Vec::with_capacity(models.len());
                for (m, model) in models.iter().enumerate() {
                    let simulated = model.simulate(info, &prepared)?;
                    let phases = split(&prepared, &simulated, noise);
                    let own = tolerance(model, (&simulated, phases), &simulated);
                    let mut of = TrialErrors::of(&prepared, &simulated, phases, &own);
                    if forces == Forces::OutsideBand {
                        of.width_n = model.open_force_n(&info.primitive, &prepared, phases);
                    }
                    errors.push(of);
                    if m > 0
                        && m + 1 == models.len()
                        && let Some((base, phases)) = &first
                    {
                        let common = tolerance(&models[0], (base, *phases), &simulated);
                        paired = Some(TrialErrors::of(&prepared, &simulated, *phases, &common));
                    }
                    first.get_or_insert((simulated, phases));
                }
                Ok((errors, paired, prepared.frictions()))
            };
            let result = one();
            progress.step(1);
            (i, result, refused)
        })
        .collect();
    let mut out = Compared {
        places: Vec::new(),
        errors: vec![Vec::new(); models.len()],
        paired: Vec::new(),
        frictions: BTreeMap::new(),
        skipped: Vec::new(),
        refused: data.errors.iter().map(ToString::to_string).collect(),
    };
    for (i, result, refused) in results {
        out.refused.extend(refused);
        match result {
            Ok((errors, paired, frictions)) => {
                let of_it = out.frictions.entry(data.trials[i].primitive.clone()).or_default();
                of_it.iter_mut().zip(frictions).for_each(|(any, has)| *any |= has);
                out.places.push(i);
                out.paired.extend(paired);
                for (all, e) in out.errors.iter_mut().zip(errors) {
                    all.push(e);
                }
            }
            Err(reason) => out.skipped.push(LeftOut { trial: data.trials[i].trial.clone(), reason }),
        }
    }
    out
}
