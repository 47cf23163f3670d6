//! Model against measurement: errors by channel and phase, where the model fails, and
//! whether another model fails less.
//!
//! Every trial is simulated along its measured drive ([`crate::run::simulate`]) and split into
//! phases ([`crate::evidence::phases`]). Errors are modelled minus measured, after taking out what may
//! be called a sensor offset ([`tare`]), and are measured against the scatter of repetitions
//! ([`noise`]). Lack of fit is an F test of the conditions' mean errors against that scatter
//! ([`statistics`]), corrected for the number of channels and phases looked at.

mod base;
pub mod document;
mod give;
pub mod noise;
pub mod regions;
pub mod rows;
pub mod tare;
pub mod trial;
pub mod verdict;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use std::path::Path;

use rayon::prelude::*;
use stickslip_shared::model::{Base, Model};

use crate::channels::{COUNT, Signals};
use crate::evidence::conditions::{HeldOut, VARIABLES};
use crate::evidence::force_bands::{Band, bands, bands_towards};
use crate::evidence::phases::{PHASES, Phase, Phases, split};
use crate::model::file::{ModelFile, ModelFileError};
use crate::run::simulate::{Prepared, Simulated, prepare};
use document::{Comparison, DataSummary, ModelReport, SCHEMA, Skipped, Trace, TrialRow};
use noise::{Floor, Source};
use stickslip_data::{Dataset, Description, Trial, TrialInfo};
use tare::Tare;
use trial::TrialErrors;

/// Samples of a trial at which the intervals of undetermined forces are found.
const BANDS: usize = 12;
/// The same for a trial that is drawn.
const DRAWN_BANDS: usize = 48;

/// What counts as an error where rigid contact leaves something open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Forces {
    /// What is outside the interval of all force distributions with the same motion, net wrench
    /// and grip, of all paths that cannot be told from the measured one, and of what pads of
    /// real stiffness give way by (see `give.rs`).
    #[default]
    OutsideBand,
    /// The distance to the solution that the model returns, that of least elastic energy.
    AsReturned,
}

/// Family-wise chance of a false alarm.
pub const SIGNIFICANCE: f64 = 0.01;

/// A data set whose trials are read one by one, so that it need not fit memory.
#[derive(Clone, Copy)]
pub struct Data<'a> {
    /// dataset.toml.
    pub description: &'a Description,
    /// trials.csv.
    pub infos: &'a [TrialInfo],
    /// Reads the trial at this place of `infos`.
    pub load: &'a (dyn Fn(usize) -> Result<Trial, String> + Sync),
}

/// Compares a data set that is in memory; see [`compare`].
///
/// # Errors
/// As [`compare`].
pub fn compare_dataset(
    data: &Dataset,
    models: &[NamedModel],
    options: &Options,
) -> anyhow::Result<Comparison> {
    let infos: Vec<TrialInfo> = data.trials.iter().map(|t| t.info.clone()).collect();
    let load = |i: usize| Ok(data.trials[i].clone());
    compare(
        Data { description: &data.description, infos: &infos, load: &load },
        models,
        options,
        &mut |_, _| {},
        &|| {},
    )
}

/// A model and where it comes from.
#[derive(Clone, Debug)]
pub struct NamedModel {
    /// Short name for tables.
    pub name: String,
    /// In words.
    pub origin: String,
    /// The model.
    pub model: Model<f64>,
    /// Instead of it, where each primitive has its own friction (other pushers).
    pub by_primitive: BTreeMap<String, Model<f64>>,
    /// Signals of another engine, by trial; the own model is not run then.
    pub recorded: Option<Arc<BTreeMap<String, Simulated>>>,
}

impl NamedModel {
    /// A model of the own engine.
    pub fn own(name: impl Into<String>, origin: impl Into<String>, model: Model<f64>) -> Self {
        let (name, origin) = (name.into(), origin.into());
        Self { name, origin, model, by_primitive: BTreeMap::new(), recorded: None }
    }

    /// The model in a file, called by the file's name.
    ///
    /// # Errors
    /// Where the file cannot be read or is wrong.
    pub fn read(path: &Path) -> Result<Self, ModelFileError> {
        let model = ModelFile::read(path)?.to_model();
        let name = path.file_stem().map_or_else(|| "model".into(), |s| s.to_string_lossy().into_owned());
        Ok(Self::own(name, path.display().to_string(), model))
    }

    /// The model for trials of `primitive`.
    pub fn of(&self, primitive: &str) -> &Model<f64> {
        self.by_primitive.get(primitive).unwrap_or(&self.model)
    }

    /// Coefficients by contact; with the primitive's name before where they differ.
    fn friction(&self) -> BTreeMap<String, f64> {
        let of = |prefix: &str, model: &Model<f64>| {
            let f = model.friction;
            [("finger", f.finger), ("pusher", f.pusher), ("support", f.support)]
                .map(|(name, value)| (format!("{prefix}{name}"), value))
        };
        match self.by_primitive.is_empty() {
            true => of("", &self.model).into_iter().collect(),
            false => self.by_primitive.iter().flat_map(|(p, m)| of(&format!("{p}."), m)).collect(),
        }
    }

    /// Whether rigid contact leaves forces of it open.
    fn is_rigid(&self) -> bool {
        self.recorded.is_none() && matches!(self.model.base, Base::Hard)
    }

    /// Intervals of the forces that the model leaves open, as far as measurements ask for: all
    /// force distributions with the same motion, and all paths that cannot be told from the
    /// measured one.
    fn bands(
        &self,
        primitive: &str,
        prepared: &Prepared,
        simulated: &Simulated,
        phases: Phases,
        forces: Forces,
    ) -> Vec<(usize, Band)> {
        if !self.is_rigid() || forces == Forces::AsReturned {
            return Vec::new();
        }
        let n = prepared.t_s.len();
        let from = phases.range(Phase::BeforeContact).end.min(n);
        let count = BANDS.min(n - from);
        let at: Vec<usize> = (0..count).map(|k| from + (2 * k + 1) * (n - from) / (2 * count)).collect();
        let (tare, noise) = TrialErrors::tare_and_noise(prepared, simulated, phases);
        let wanted = |i: usize| -> Signals { std::array::from_fn(|c| prepared.measured[i][c] - tare[c]) };
        let model = self.of(primitive);
        let mut bands = bands_towards(prepared, model, &at, &wanted, &noise.map(|s| 3.0 * s));
        for path in prepared.drifted() {
            let moved = path.simulate(model).signals;
            for (sample, band) in &mut bands {
                for (channel, (low, high)) in band.iter_mut().enumerate().skip(6) {
                    let value = moved.get(*sample).map_or(f64::NAN, |row| row[channel]);
                    // `min` and `max` pass over a NaN.
                    (*low, *high) = (low.min(value), high.max(value));
                }
            }
        }
        let give = give::give(prepared);
        for (sample, band) in &mut bands {
            let value = simulated.signals.get(*sample).copied().unwrap_or([f64::NAN; COUNT]);
            let rest = phases.range(Phase::End).contains(sample);
            for (channel, (low, high)) in band.iter_mut().enumerate() {
                let by = give.of(channel, rest);
                // A band that is narrower than that, or not known, is widened to it.
                (*low, *high) = (low.min(value[channel] - by), high.max(value[channel] + by));
            }
        }
        bands
    }

    fn simulate(&self, info: &TrialInfo, prepared: &Prepared) -> Result<Simulated, String> {
        match &self.recorded {
            None => Ok(prepared.simulate(self.of(&info.primitive))),
            Some(all) => {
                all.get(&info.trial).cloned().ok_or_else(|| format!("{} was not run on it", self.name))
            }
        }
    }
}

/// What to compare.
#[derive(Clone, Debug)]
pub struct Options {
    /// Only this trial.
    pub trial: Option<String>,
    /// Only these trials are compared, and none of them is calibrated on.
    pub held_out: HeldOut,
    /// Sensor offsets.
    pub tare: Tare,
    /// Forces that are not determined.
    pub forces: Forces,
}

impl Default for Options {
    fn default() -> Self {
        Self { trial: None, held_out: HeldOut::Nothing, tare: Tare::BeforeContact, forces: Forces::default() }
    }
}

/// Trials that were compared, with the errors of each model.
struct Compared {
    /// Places in the data set.
    places: Vec<usize>,
    phases: Vec<Phases>,
    /// By model, then trial.
    errors: Vec<Vec<TrialErrors>>,
    skipped: Vec<Skipped>,
}

/// Compares `models` with the data. Without a model the base model is calibrated quickly.
/// `begin` is told the name and length of each stage, `tick` when a step of it is done.
///
/// # Errors
/// A trial that is not there, nothing to hold out, no trial that can be simulated.
pub fn compare(
    data: Data,
    models: &[NamedModel],
    options: &Options,
    begin: &mut dyn FnMut(&'static str, usize),
    tick: &(dyn Fn() + Sync),
) -> anyhow::Result<Comparison> {
    let infos = data.infos;
    anyhow::ensure!(!infos.is_empty(), "the data set lists no trials");
    let held_out = options.held_out.mask(infos).map_err(anyhow::Error::msg)?;
    let groups = crate::evidence::conditions::conditions(infos);
    let mut condition_of = vec![0; infos.len()];
    for (c, group) in groups.iter().enumerate() {
        for i in group {
            condition_of[*i] = c;
        }
    }
    let noise = noise::sensor_noise(data.description);
    let mut notes = Vec::new();
    let calibrated;
    let models = if models.is_empty() {
        begin("calibrating", 1);
        calibrated = [base::calibrated(data, &groups, &held_out, &mut notes)];
        tick();
        &calibrated[..]
    } else {
        models
    };
    let chosen = chosen_trials(options, infos, &groups, &condition_of, &held_out)?;
    begin("comparing", chosen.loaded.len());
    let compared = simulate_all(data, &chosen.loaded, models, options.forces, &noise, tick);
    if compared.places.is_empty() {
        let why = compared.skipped.first().map_or("no trial is left", |s| s.reason.as_str());
        anyhow::bail!("no trial can be compared: {why}");
    }
    let reported: Vec<bool> = compared.places.iter().map(|i| chosen.reported.contains(i)).collect();
    anyhow::ensure!(
        reported.iter().any(|r| *r),
        "{}",
        compared.skipped.first().map_or("no trial is left", |s| s.reason.as_str())
    );

    let trials = rows::Trials {
        infos,
        places: &compared.places,
        condition_of: &condition_of,
        reported: &reported,
        noise: &noise,
    };
    let mut reports = Vec::new();
    let mut offsets_and_tares: Vec<_> = Vec::new();
    let mut shifted = compared.errors.clone();
    for errors in &mut shifted {
        let found = tare::offsets(&errors.iter().collect::<Vec<_>>(), data.description, options.tare);
        for (e, tare) in errors.iter_mut().zip(&found.1) {
            e.shift(tare);
        }
        offsets_and_tares.push(found);
    }
    let floors = trials.floors(&shifted);
    let mut tares_of_last = Vec::new();
    for (m, (named, (offsets, tares))) in models.iter().zip(offsets_and_tares).enumerate() {
        let mut errors = trials.rows(&shifted, m, &tares, &floors);
        let shifted = &shifted[m];
        if chosen.single {
            for row in &mut errors {
                row.lack_of_fit = None;
                row.fails = false;
            }
        }
        let (regions, trends, trends_tested) = if chosen.single {
            Default::default()
        } else {
            regions::find(&trials, shifted, &errors, &floors)
        };
        reports.push(ModelReport {
            name: named.name.clone(),
            origin: named.origin.clone(),
            friction: named.friction(),
            effects: named.model.effects.iter().map(effect_name).collect(),
            offsets,
            errors,
            regions,
            trends,
            trends_tested,
            unsolved_steps: shifted.iter().map(|e| e.unsolved).sum(),
            trials: trials.trial_rows(shifted, &floors),
        });
        tares_of_last = tares;
    }
    let trial_rows = &reports[reports.len() - 1].trials;
    let traces = traces(data, &compared, &trials, models, &tares_of_last, &floors, trial_rows, chosen.single);
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
    let changes = if reports.len() > 1 { rows::changes(&reports) } else { Vec::new() };
    notes.extend(verdict::notes(&data_summary, &reports, &compared.skipped, options, chosen.single));
    let summary = verdict::summary(&data_summary, &reports, &changes, chosen.single);
    Ok(Comparison {
        schema: SCHEMA,
        summary,
        notes,
        data: data_summary,
        models: reports,
        changes,
        skipped: compared.skipped,
        traces,
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
) -> anyhow::Result<Chosen> {
    if let Some(id) = &options.trial {
        let at = infos.iter().position(|i| i.trial == *id).ok_or_else(|| {
            let some: Vec<&str> = infos.iter().take(5).map(|i| i.trial.as_str()).collect();
            anyhow::anyhow!("no trial is named `{id}`; there are {} ({} ...)", infos.len(), some.join(", "))
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
    data: Data,
    loaded: &[usize],
    models: &[NamedModel],
    forces: Forces,
    noise: &Signals,
    tick: &(dyn Fn() + Sync),
) -> Compared {
    type One = (Phases, Vec<TrialErrors>);
    let results: Vec<(usize, Result<One, String>)> = loaded
        .par_iter()
        .map(|&i| {
            let one = || -> Result<One, String> {
                let trial = (data.load)(i)?;
                let prepared = prepare(data.description, &trial, i).map_err(|e| e.to_string())?;
                drop(trial);
                let mut phases = None;
                let info = &data.infos[i];
                let errors = models
                    .iter()
                    .map(|m| {
                        let simulated = m.simulate(info, &prepared)?;
                        // The first model settles the phases, so that models compare like with like.
                        let p = *phases.get_or_insert_with(|| split(&prepared, &simulated, noise));
                        let bands = m.bands(&info.primitive, &prepared, &simulated, p, forces);
                        Ok(TrialErrors::with_bands(&prepared, &simulated, p, &bands))
                    })
                    .collect::<Result<_, String>>()?;
                phases.map(|p| (p, errors)).ok_or_else(|| "no model was given".to_owned())
            };
            let result = one();
            tick();
            (i, result)
        })
        .collect();
    let mut out = Compared {
        places: Vec::new(),
        phases: Vec::new(),
        errors: vec![Vec::new(); models.len()],
        skipped: Vec::new(),
    };
    for (i, result) in results {
        match result {
            Ok((phases, errors)) => {
                out.places.push(i);
                out.phases.push(phases);
                for (all, e) in out.errors.iter_mut().zip(errors) {
                    all.push(e);
                }
            }
            Err(reason) => out.skipped.push(Skipped { trial: data.infos[i].trial.clone(), reason }),
        }
    }
    out
}

/// Signals of the worst and the median trial (or of the one chosen), simulated once more.
#[allow(clippy::too_many_arguments)]
fn traces(
    data: Data,
    compared: &Compared,
    trials: &rows::Trials,
    models: &[NamedModel],
    tares: &[Signals],
    floors: &BTreeMap<rows::Key, Floor>,
    rows: &[TrialRow],
    single: bool,
) -> Vec<Trace> {
    let at = |row: &TrialRow| {
        compared.places.iter().position(|i| data.infos[*i].trial == row.trial).unwrap_or_default()
    };
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
    wanted
        .into_iter()
        .filter_map(|(row, role)| {
            let k = at(row);
            let i = compared.places[k];
            let trial = (data.load)(i).ok()?;
            let prepared = prepare(data.description, &trial, i).ok()?;
            let modelled = models
                .iter()
                .map(|m| m.simulate(&data.infos[i], &prepared).map(|s| s.signals))
                .collect::<Result<_, _>>()
                .ok()?;
            let rigid = models.last().filter(|m| m.is_rigid());
            let force_bands =
                rigid.map_or_else(Vec::new, |m| drawn_bands(&prepared, m.of(&data.infos[i].primitive)));
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
            let info = &data.infos[i];
            let levels = VARIABLES.iter().filter_map(|v| {
                let (name, unit) = v.label().split_once(", ").unwrap_or((v.label(), ""));
                v.level(info).map(|l| format!("{name} {l} {unit}").trim_end().to_owned())
            });
            Some(Trace {
                trial: row.trial.clone(),
                role,
                conditions: std::iter::once(info.primitive.replace('_', " "))
                    .chain(levels)
                    .collect::<Vec<_>>()
                    .join(", "),
                t_s: prepared.t_s,
                measured,
                modelled,
                phases: compared.phases[k],
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
