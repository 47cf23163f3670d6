//! `stickslip import recording`: anyone's recordings by a mapping file.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;

use stickslip_analysis::check::check;
use stickslip_data::import::{BadRow, recording};
use stickslip_data::{Index, Stage, TableFormat};
use stickslip_report::import as page;
use stickslip_report::signals;
use stickslip_report::terminal::{Output, command_line};

/// Arguments of every import.
#[derive(Debug, clap::Args)]
pub(super) struct Files {
    /// The raw file; for `recording` the mapping file
    pub(super) file: PathBuf,
    /// Folder to write the data set into; new or empty
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Format of the tables
    #[arg(long, alias = "tables", value_enum, default_value_t)]
    pub(super) format: TableFormat,
}

/// Arguments of `stickslip import recording`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    files: Files,
    /// Write a page that shows signals, frames and clocks as they were understood
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

/// What a mapping gave, for `--json`.
#[derive(JsonSchema, Serialize)]
/// Recordings that were imported by a mapping.
pub(super) struct RecordingReport<'r> {
    /// Folder of the data set.
    out: &'r Path,
    /// Trials.
    trials: usize,
    /// Rows of all trials.
    samples: usize,
    /// What was assumed of each signal.
    signals: &'r [recording::Signal],
    /// Mean that `tare_s` took off, N and N m: trial, signal, wrench.
    tares: &'r [(String, String, [f64; 6])],
    /// Clocks that were estimated, by trial and stream.
    offsets: &'r [recording::Offset],
    /// Noise of sensors that the mapping does not state, taken from the data: key of `[sensors]`, SI.
    noise: &'r [(&'static str, f64)],
    /// The trials follow each other as their time stamps do; otherwise as their names or the table do.
    in_time_order: bool,
    /// Trials and rows of the table that were left out, with the reason.
    refused: &'r [String],
    /// Rows that could not be used, by file.
    bad_rows: &'r [(PathBuf, BadRow)],
    /// Errors that the physics checks of `check` found.
    physics: Vec<String>,
}

/// # Errors
/// A mapping that cannot be used; after the data are written, physics that does not allow them.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let Args { files, html } = args;
    let import = recording::import(&files.file)?;
    let recording::Import {
        dataset, signals, refused, bad_rows, tares, offsets, noise, in_time_order, ..
    } = &import;
    let stage = Stage::begin(&files.out)?;
    stickslip_data::write_as(dataset, stage.folder(), files.format)?;
    stage.finish()?;
    output.text("What was assumed:");
    for signal in signals {
        output.text(format_args!(
            "  {} of {}, {:.1} Hz: {} in {}; {}{}, {:.0} % of rows",
            signal.signal.replace('_', " "),
            signal.stream,
            signal.rate_hz,
            signal.named_columns(),
            signal.units,
            if signal.frame.is_empty() { String::new() } else { format!("{}; ", signal.frame) },
            signal.base,
            signal.filled * 100.0,
        ));
    }
    if let Some(line) = page::noise_line(noise) {
        output.text(format_args!("  {line}"));
    }
    output.text(format_args!("  {}", page::order_line(*in_time_order)));
    for line in page::clock_lines(offsets) {
        output.text(format_args!("  {line}"));
    }
    for (trial, signal, offset) in tares.iter().take(5) {
        let offset: Vec<String> = offset.iter().map(|value| format!("{value:.4}")).collect();
        output.text(format_args!("tare of {signal} in {trial}: [{}] N, N m", offset.join(", ")));
    }
    if tares.len() > 5 {
        output.text(format_args!("and {} more tares; --json lists all", tares.len() - 5));
    }
    for (file, row) in bad_rows.iter().take(20) {
        match row.reason.contains(&format!("line {}", row.line)) {
            true => output.refused(&row.reason),
            false => output.refused(format_args!("{} line {}: {}", file.display(), row.line, row.reason)),
        }
    }
    if bad_rows.len() > 20 {
        output.refused(format_args!("and {} more rows; --json lists all", bad_rows.len() - 20));
    }
    for why in refused {
        output.refused(why);
    }
    let samples = dataset.trials.iter().map(|trial| trial.samples.len()).sum();
    output.text(format_args!("{}: {} trials, {samples} samples", files.out.display(), dataset.trials.len()));
    // Swapped fingers, millimetres, turned signs: physics sees them at once.
    let index = Index::open(&files.out)?;
    let report = check(&index, output);
    let physics: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
    let data = files.out.display().to_string();
    let mapping = files.file.display().to_string();
    let next = match physics.is_empty() {
        true => ["check", &data].to_vec(),
        false => ["import", "recording", &mapping, "--out", "ANOTHER_FOLDER"].to_vec(),
    };
    if let Some(path) = html {
        output.page(path, page::page("import", &import, &report, &command_line(next.iter().copied())))?;
    }
    for finding in &physics {
        output.text(format_args!("physics: {finding}"));
    }
    output.left_out(&report.left_out, report.trials, &format!("all: stickslip check {data}"));
    if !report.suspects.is_empty() {
        output.text(format_args!("{}", signals::verdict(&report).1));
    }
    output.document(&RecordingReport {
        out: &files.out,
        trials: dataset.trials.len(),
        samples,
        signals,
        tares,
        offsets,
        noise,
        in_time_order: *in_time_order,
        refused,
        bad_rows,
        physics: physics.clone(),
    })?;
    anyhow::ensure!(
        physics.is_empty(),
        "{} physics error(s): correct units, axes, acts_on or clocks in {} and import again into another folder; \
         where the mapping is right, a sensor or the stated mass is not: `stickslip check {}`",
        physics.len(),
        files.file.display(),
        files.out.display()
    );
    output.next(next);
    Ok(())
}
