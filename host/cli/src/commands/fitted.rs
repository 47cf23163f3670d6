//! What `add` and `refit` share: a fitted model is written, and its parameters are shown beside
//! those of before.

use std::path::Path;

use anyhow::Context;
use comfy_table::{Cell, CellAlignment};

use stickslip_analysis::add::Report;
use stickslip_analysis::model::file::ModelFile;
use stickslip_report::terminal::{Output, table};
use stickslip_report::words::{interval, short};

/// The model in the user's file, or the default model where none is named.
///
/// # Errors
/// Where the file cannot be read or is wrong.
pub fn file_or_default(path: Option<&Path>) -> anyhow::Result<ModelFile> {
    Ok(path.map_or_else(|| Ok(ModelFile::default()), ModelFile::read)?)
}

#[derive(schemars::JsonSchema, serde::Serialize)]
/// A model that was fitted and written.
pub(super) struct Written<'a> {
    /// Its file.
    model: &'a Path,
    /// The fit.
    #[serde(flatten)]
    report: &'a Report,
}

/// Writes the model.
///
/// # Errors
/// Where the file cannot be written.
pub fn write(file: &ModelFile, path: &Path) -> anyhow::Result<()> {
    stickslip_data::write_file(path, file.write())
        .with_context(|| format!("{}: cannot be written", path.display()))
}

/// Writes the fitted model to `path`, and prints it against `before`.
///
/// # Errors
/// Where the file cannot be written.
pub fn give(before: &ModelFile, report: &Report, path: &Path, output: &Output) -> anyhow::Result<()> {
    write(&report.model, path)?;
    output.left_out(&report.left_out, report.trials + report.left_out.len(), "all: --json");
    let mut t = table(["parameter", "before", "value", "95 % interval", "unit"]);
    for e in &report.parameters {
        let right = |s: String| Cell::new(s).set_alignment(CellAlignment::Right);
        t.add_row(vec![
            Cell::new(&e.name),
            right(value_of(before, &e.name).map_or_else(|| "-".into(), short)),
            right(short(e.value)),
            Cell::new(interval(e.low, e.high)),
            Cell::new(e.unit),
        ]);
    }
    output.table(&t);
    for note in &report.notes {
        output.text(format_args!("note: {note}"));
    }
    output.text(format_args!("written to {}", path.display()));
    output.document(&Written { model: path, report })
}

/// Value of the parameter `name` (`effect.parameter` or `friction.coefficient`), where `file` has it.
fn value_of(file: &ModelFile, name: &str) -> Option<f64> {
    let (owner, parameter) = name.split_once('.')?;
    if owner == "friction" {
        return match parameter {
            "finger" => Some(file.friction.finger),
            "pusher" => Some(file.friction.pusher),
            _ => Some(file.friction.support),
        };
    }
    let entry = file.effects.iter().find(|e| e.name() == owner)?;
    let place = entry.info()?.parameters.iter().position(|p| p.name == parameter)?;
    entry.values.get(place).copied()
}

/// `compare` of the data with the new model, and with the one before where it was given.
pub fn next_compare(data: &Path, before: Option<&Path>, after: &Path, output: &Output) {
    let mut words = vec!["compare".to_owned(), data.display().to_string()];
    for model in before.into_iter().chain([after]) {
        words.extend(["--model".to_owned(), model.display().to_string()]);
    }
    output.next(words.iter().map(String::as_str));
}
