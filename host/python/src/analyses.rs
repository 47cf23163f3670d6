//! The facade's functions for Python.
//!
//! Each runs on its own thread ([`watched`]), reports as the command of its name with `--json`, and takes the
//! command's defaults.

use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{Context, ensure};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use stickslip_analysis as analysis;
use stickslip_analysis::calibrate::Share;
use stickslip_analysis::compare::tare::Tare;
use stickslip_analysis::compare::{Forces, NamedModel};
use stickslip_analysis::diagnose::report::Verdict;
use stickslip_analysis::evidence::conditions::HeldOut;
use stickslip_analysis::model::candidate::{self, CandidateEffect};
use stickslip_analysis::model::file::{EffectEntry, ModelFile};
use stickslip_analysis::model::names;
use stickslip_analysis::run::replay::{
    self as replaying, ReplayError, at_board_rate, feed, interpolated_poses,
};
use stickslip_analysis::run::series;
use stickslip_analysis::run::simulate::prepare;
use stickslip_analysis::run::summary::Document;
use stickslip_analysis::{Progress, score as scoring, suggest as suggesting};
use stickslip_data::Stage;
use stickslip_report as pages;
use stickslip_shared::predictor::{Checked, Limits, MAX_SEGMENTS};

use crate::dataset::Dataset;
use crate::errors::choice;
use crate::model::{Model, candidates, file_of};
use crate::report::Report;
use crate::run::watched;

/// A callable that hears of progress.
type Told<'a, 'py> = Option<&'a Bound<'py, PyAny>>;

/// Names of the effects that a model can have.
#[pyfunction]
pub fn effect_names() -> Vec<&'static str> {
    names::listed().collect()
}

#[pyfunction]
pub fn check(py: Python<'_>, data: &Dataset, told: Told<'_, '_>) -> PyResult<Report> {
    let index = Arc::clone(&data.index);
    watched(py, told, move |progress| {
        let report = analysis::check(&index, progress);
        let document = Report::new("check", &report)?;
        Ok(document.page(move || {
            let trials = pages::signals::examples(&index);
            pages::signals::page(&report, &index.description, &trials, "stickslip.calibrate(data)")
        }))
    })
}

#[pyfunction]
pub fn calibrate(
    py: Python<'_>,
    data: &Dataset,
    model: Option<&Model>,
    share: f64,
    primitive: Option<String>,
    told: Told<'_, '_>,
) -> PyResult<Report> {
    if !(share > 0.0 && share <= 1.0) {
        return Err(PyValueError::new_err(format!("share is {share}; give a share above 0 and at most 1")));
    }
    let (whole, file) = (data.whole(), file_of(model));
    watched(py, told, move |progress| {
        let data = whole(progress);
        let options = analysis::calibrate::Options { share: Share::of(share), primitive, pads: true };
        let found = analysis::calibrate(&data, &file, &options, progress)
            .with_context(|| data.folder.display().to_string())?;
        let mut report = Report::new("calibrate", &found)?.model(found.model.clone(), "calibrated");
        for one in &found.primitives {
            report = report.model(found.model_of(one), &one.primitive);
        }
        Ok(report)
    })
}

#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn compare(
    py: Python<'_>,
    data: &Dataset,
    models: Vec<Py<Model>>,
    trial: Option<String>,
    held_out: Option<&str>,
    tare: bool,
    force_bands: bool,
    told: Told<'_, '_>,
) -> PyResult<Report> {
    let held_out = held_out.map_or(Ok(HeldOut::Nothing), HeldOut::from_str).map_err(PyValueError::new_err)?;
    if trial.is_some() && held_out != HeldOut::Nothing {
        return Err(PyValueError::new_err("give trial or held_out, not both"));
    }
    let models: Vec<NamedModel> = models.iter().map(|model| model.get().named()).collect();
    let index = Arc::clone(&data.index);
    watched(py, told, move |progress| {
        // With the traces of the page, some megabytes: to make them later is to compare once more.
        let options = analysis::compare::Options {
            trial,
            held_out,
            drawn: pages::compare::DRAWN,
            tare: if tare { Tare::BeforeContact } else { Tare::None },
            forces: if force_bands { Forces::OutsideBand } else { Forces::AsReturned },
        };
        let comparison = analysis::compare(&index, &models, &options, progress)
            .with_context(|| index.folder.display().to_string())?;
        let report = Report::new("compare", &comparison)?;
        Ok(report.page(move || pages::compare::page(&comparison, "stickslip.diagnose(data, model)")))
    })
}

#[pyfunction]
pub fn diagnose(
    py: Python<'_>,
    data: &Dataset,
    model: Option<&Model>,
    formulas: Option<PathBuf>,
    told: Told<'_, '_>,
) -> PyResult<Report> {
    let (whole, index, file) = (data.whole(), Arc::clone(&data.index), file_of(model));
    watched(py, told, move |progress| {
        let (file, formulas) = file.proposals(formulas.as_deref())?;
        let data = whole(progress);
        let found = analysis::diagnose(&data, &file, &candidates(&formulas), progress)?;
        let mut report = Report::new("diagnose", &found)?;
        if matches!(found.verdict, Verdict::Effect | Verdict::Ambiguous) {
            let known: Vec<EffectEntry> = file.effects.iter().chain(&formulas).cloned().collect();
            let mut better = ModelFile::of_model(&found.model, &known);
            better.set_intervals(found.parameters.iter().map(|(name, v)| (name.as_str(), [v.low, v.high])));
            report = report.model(better, "better");
        }
        let single = |set: &&Vec<&'static str>| set.len() == 1;
        let next = match (found.verdict, found.ambiguous_with.iter().find(single), found.effects.as_slice()) {
            (Verdict::Ambiguous, Some(other), [one]) => {
                format!("stickslip.suggest(data, model, between=({one:?}, {:?}))", other[0])
            }
            (Verdict::Effect | Verdict::Ambiguous, ..) => {
                "stickslip.compare(data, [model, diagnosis.model])".to_owned()
            }
            _ => "stickslip.compare(data, model)".to_owned(),
        };
        let (name, given) = (data.description.name.clone(), file.to_model());
        // Both models are run along the trials when the page is asked for.
        Ok(report.page(move || {
            let traces = pages::diagnose::traces(&index, given.clone(), &found, &());
            let traces = traces.as_ref().map_err(ToString::to_string);
            pages::diagnose::html(&found, &name, &next, traces)
        }))
    })
}

/// A fitted model and its report.
fn fitted(name: &str, found: &analysis::add::Report, model: &str) -> anyhow::Result<Report> {
    Ok(Report::new(name, found)?.model(found.model.clone(), model))
}

#[pyfunction]
pub fn add(
    py: Python<'_>,
    data: &Dataset,
    effects: Vec<String>,
    model: Option<&Model>,
    formulas: Option<PathBuf>,
    told: Told<'_, '_>,
) -> PyResult<Report> {
    let (whole, file) = (data.whole(), file_of(model));
    watched(py, told, move |progress| {
        ensure!(!effects.is_empty(), "name the effect to add; stickslip.effect_names() lists them");
        let (before, formulas) = file.proposals(formulas.as_deref())?;
        let known: Vec<EffectEntry> = formulas.iter().chain(&before.effects).cloned().collect();
        let new = effects.iter().map(|name| candidate::named(name, &known)).collect::<Result<Vec<_>, _>>()?;
        let found = analysis::add(&whole(progress), &before, &new, progress)?;
        fitted("add", &found, "better")
    })
}

#[pyfunction]
pub fn refit(py: Python<'_>, data: &Dataset, model: &Model, told: Told<'_, '_>) -> PyResult<Report> {
    let (whole, file) = (data.whole(), model.file.clone());
    watched(py, told, move |progress| {
        fitted("refit", &analysis::refit(&whole(progress), &file, progress)?, "refitted")
    })
}

#[pyfunction]
pub fn suggest(
    py: Python<'_>,
    data: &Dataset,
    model: Option<&Model>,
    between: Vec<String>,
    formulas: Option<PathBuf>,
    runs: Option<usize>,
    told: Told<'_, '_>,
) -> PyResult<Report> {
    let (whole, file) = (data.whole(), file_of(model));
    watched(py, told, move |progress| {
        let (file, formulas) = file.proposals(formulas.as_deref())?;
        let mut named = Vec::new();
        for name in &between {
            named.extend(CandidateEffect::of(&candidate::named(name, &formulas)?));
        }
        let options = suggesting::Options { between: named, own: candidates(&formulas), runs };
        options.check(&file)?;
        let found = analysis::suggest(&whole(progress), &file, &options, progress)?;
        Report::new("suggest", &found)
    })
}

#[pyfunction]
pub fn score(
    py: Python<'_>,
    data: &Dataset,
    model: Option<&Model>,
    object_pose: &str,
    ratio: f64,
    rate_n_s: f64,
    told: Told<'_, '_>,
) -> PyResult<Report> {
    for (option, value) in [("ratio", ratio), ("rate_n_s", rate_n_s)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(PyValueError::new_err(format!("{option} is {value}; give a number above zero")));
        }
    }
    let object_pose = choice("object_pose", object_pose)?;
    let (index, model) = (Arc::clone(&data.index), file_of(model).to_model());
    watched(py, told, move |progress| {
        let options = scoring::document::Options { object_pose, ratio, rate_n_s };
        let document = analysis::score(&index, &model, &options, progress)?;
        let replay = |trial: &str| format!("stickslip.replay(data, {trial:?}, model)");
        let failing = scoring::traces::cases(&document).into_iter().find(|(_, case)| case.fails());
        let next =
            failing.map_or_else(|| "stickslip.replay(data)".to_owned(), |(_, case)| replay(&case.trial));
        // The predictor runs along the trials that are drawn when the page is asked for.
        Ok(Report::new("score", &document)?.page(move || {
            let (tuning, most) = (Checked::default(), pages::score::MOST);
            let drawn = scoring::traces::traces(&index, &model, &tuning, &document, most);
            let seen = pages::score::Seen { description: &index.description, drawn: &drawn };
            pages::score::page(&document, &seen, &next, &replay)
        }))
    })
}

/// The report of a replay, and what is worth knowing of the trial.
#[pyfunction]
pub fn replay(
    py: Python<'_>,
    data: &Dataset,
    trial: Option<String>,
    model: Option<&Model>,
    told: Told<'_, '_>,
) -> PyResult<(Report, Vec<String>)> {
    let (index, model) = (Arc::clone(&data.index), file_of(model).to_model());
    watched(py, told, move |progress| {
        let (at, info) = index.find(trial.as_deref())?;
        let (trial, every) = at_board_rate(index.read_trial(info)?);
        let name = info.trial.clone();
        let mut notes: Vec<String> =
            interpolated_poses(&trial).into_iter().map(|text| format!("trial {name}: {text}")).collect();
        if every > 1 {
            notes
                .push(format!("trial {name}: the predictor takes a sample every 4 ms: one in {every} of it"));
        }
        let fed = feed(&index.description, &trial)?;
        if fed.crowded {
            notes.push(format!(
                "trial {name}: its motion has more pieces than the {MAX_SEGMENTS} of a plan: cut the record into \
                 trials of one stroke each"
            ));
        }
        progress.begin("replaying", fed.samples.len());
        let replayed = replaying::run(&fed, &model, Limits::default(), at, |samples| progress.step(samples))
            .map_err(|why| ReplayError::Refused { trial: name.clone(), why })?;
        let t_s: Vec<f64> = trial.samples.iter().map(|s| s.t_s).collect();
        let document = Document::new(&name, &t_s, &fed.plan, &replayed, None);
        let report = Report::new("replay", &document)?;
        let predictions = Arc::new(replayed.predictions);
        let shown = Arc::clone(&predictions);
        let trial = Arc::new(trial);
        let (drawn, again, run) = (Arc::clone(&index), Arc::clone(&trial), model.clone());
        let report = report.page(move || {
            let prepared = prepare(&drawn.description, &again, at).ok();
            let (scenery, spans) = prepared.map_or_else(Default::default, |prepared| {
                pages::replay::drawn(&drawn.description, &prepared, &prepared.simulate(&run))
            });
            let next = "stickslip.compare(data, model)";
            let (description, samples) = (&drawn.description, again.samples.as_slice());
            let (t_s, predictions) = (t_s.as_slice(), shown.as_slice());
            let shown = pages::replay::Shown { description, t_s, samples, predictions, scenery, spans, next };
            pages::replay::page(&document, &shown)
        });
        let report = report.series(move || {
            let prepared = prepare(&index.description, &trial, at)?;
            let simulated = prepared.simulate(&model);
            let mut series = series::signals(&name, &prepared, &[("model", &simulated)]);
            series::add_predictions(&mut series, &predictions);
            Ok(series)
        });
        Ok((report, notes))
    })
}

/// Into the folder `out`, or into memory.
#[pyfunction]
pub fn simulate(
    py: Python<'_>,
    data: &Dataset,
    model: Option<&Model>,
    out: Option<PathBuf>,
    tables: &str,
    told: Told<'_, '_>,
) -> PyResult<Report> {
    let tables = choice("tables", tables)?;
    let (index, model) = (Arc::clone(&data.index), file_of(model).to_model());
    watched(py, told, move |progress: &dyn Progress| match out {
        Some(out) => {
            let stage = Stage::begin(&out)?;
            let report = analysis::simulate(&index, &model, stage.folder(), tables, progress)?;
            stage.finish()?;
            Report::new("simulate", &report)
        }
        None => {
            let (report, data) = analysis::simulate::in_memory(&index, &model, progress)?;
            Ok(Report::new("simulate", &report)?.data(data))
        }
    })
}
