//! `stickslip compare DATA`: where model and measurement differ, and by how much.

use std::path::{Path, PathBuf};

use anyhow::Context;
use comfy_table::{Cell, CellAlignment};
use rayon::prelude::*;

use super::arguments::Drawn;
use stickslip_analysis::compare::document::{Change, Comparison, ErrorRow, Fate, ModelReport, Size};
use stickslip_analysis::compare::noise::Source;
use stickslip_analysis::compare::rows::many_primitives;
use stickslip_analysis::compare::tare::Tare;
use stickslip_analysis::compare::verdict::{place_words, readable, scale};
use stickslip_analysis::compare::{Forces, NamedModel, Options, compare};
use stickslip_analysis::evidence::conditions::HeldOut;
use stickslip_analysis::evidence::phases::PHASES;
use stickslip_analysis::run::series;
use stickslip_analysis::run::simulate::prepare;
use stickslip_data::Index;
use stickslip_data::series::SeriesWriter;
use stickslip_report::compare::{DRAWN, figures, page};
use stickslip_report::terminal::{Output, command_line, table};

/// Arguments of `stickslip compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip compare data/demo --html compare.html
  stickslip compare data/demo --trial linear_push-obj4-g20-v10-s0-r1 --model model.toml
  stickslip compare data/demo --model model.toml --model better.toml --held-out 0.3 --html after.html")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model to compare; give it twice for before and after [default: hard contact, friction
    /// calibrated on at most twelve trials of each primitive]
    #[arg(long = "model", value_name = "MODEL.toml")]
    pub models: Vec<PathBuf>,
    /// Compare only this trial
    #[arg(long, value_name = "ID", conflicts_with = "held_out")]
    pub trial: Option<String>,
    /// Compare only these trials, and calibrate on none of them: a share of the conditions
    /// (0.3), or ids separated by commas
    #[arg(long, value_name = "SHARE|IDS")]
    pub held_out: Option<HeldOut>,
    #[command(flatten)]
    drawn: Drawn,
    /// Print the tables of all channels and phases, and how to read them
    #[arg(long, short)]
    pub verbose: bool,
    /// Write the time series of measurement and models as recorded and as simulated, one row a
    /// sample of each compared trial
    #[arg(long, value_name = "FILE.csv|FILE.parquet")]
    pub series: Option<PathBuf>,
    /// Use the measurements as recorded; without it each trial's mean before contact is subtracted
    /// from its forces and torques
    #[arg(long)]
    pub no_tare: bool,
    /// Count the whole residual as error, also where rigid contact leaves a force undetermined
    /// [default: what is beyond the tolerance]
    #[arg(long)]
    pub no_force_bands: bool,
}

/// Compares and reports.
///
/// # Errors
/// Where data or a model cannot be read, no trial can be compared, or the page not written.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let index = stickslip_report::data::open(&args.data, output)?;
    let models = args.models.iter().map(|path| NamedModel::read(path)).collect::<Result<Vec<_>, _>>()?;
    let options = Options {
        trial: args.trial.clone(),
        held_out: args.held_out.clone().unwrap_or_default(),
        tare: if args.no_tare { Tare::None } else { Tare::BeforeContact },
        forces: if args.no_force_bands { Forces::AsReturned } else { Forces::OutsideBand },
        drawn: if args.drawn.any() { DRAWN } else { 2 },
    };
    let comparison =
        compare(&index, &models, &options, output).with_context(|| args.data.display().to_string())?;
    comparison.refused.iter().for_each(|refused| output.refused(refused));
    let (data, model) =
        (args.data.display().to_string(), args.models.last().map(|m| m.display().to_string()));
    let next = || match &model {
        Some(model) => ["diagnose", &data, "--model", model],
        None => ["calibrate", &data, "--out", "model.toml"],
    };
    if let Some(path) = &args.series {
        let models = comparison.calibrated.as_ref().map_or(&models[..], std::slice::from_ref);
        write_series(&index, models, &options, path, output)?;
    }
    args.drawn.write(output, || page(&comparison, &command_line(next())), || figures(&comparison))?;
    print(&comparison, args.verbose, output);
    output.next(next());
    output.document(&comparison)
}

/// Measured and modelled signals of all compared trials, in their order.
fn write_series(
    index: &Index,
    models: &[NamedModel],
    options: &Options,
    path: &Path,
    output: &Output,
) -> anyhow::Result<()> {
    let held_out = options.held_out.mask(&index.trials).map_err(anyhow::Error::msg)?;
    let only_held_out = held_out.contains(&true);
    let wanted: Vec<usize> = (0..index.trials.len())
        .filter(|i| options.trial.as_ref().is_none_or(|id| *id == index.trials[*i].trial))
        .filter(|i| !only_held_out || held_out[*i])
        .collect();
    let mut writer = SeriesWriter::create(path)?;
    let bar = output.progress(wanted.len() as u64, "writing series");
    let one = |i: &usize| {
        let info = &index.trials[*i];
        let trial = index.read_trial_lenient(info).trial?;
        let prepared = prepare(&index.description, &trial, *i).ok()?;
        let run = |m: &NamedModel| (m.name.clone(), prepared.simulate(m.of(&info.primitive)));
        let runs: Vec<_> = models.iter().map(run).collect();
        let runs: Vec<_> = runs.iter().map(|(name, s)| (name.as_str(), s)).collect();
        Some(series::signals(&info.trial, &prepared, &runs))
    };
    // As many trials in memory as can be simulated at once.
    for some in wanted.chunks(rayon::current_num_threads().max(1)) {
        for series in some.par_iter().map(one).collect::<Vec<_>>().into_iter().flatten() {
            writer.write(&series)?;
        }
        bar.inc(some.len() as u64);
    }
    writer.finish()?;
    bar.finish_and_clear();
    output.note(format_args!("time series written to {}", path.display()));
    Ok(())
}

/// Failures that are listed without `--verbose`.
const LISTED: usize = 5;

fn print(comparison: &Comparison, verbose: bool, output: &Output) {
    output.text(&comparison.summary);
    let (d, skipped) = (&comparison.data, &comparison.skipped);
    output.left_out(skipped, d.trials + skipped.len(), "all: --verbose or --html");
    output.text(format_args!(
        "\n{}: {} trial(s) in {} condition(s), {} repeated{}",
        d.name,
        d.trials,
        d.conditions,
        d.repeated_conditions,
        if d.held_out { "; held out from calibration" } else { "" }
    ));
    for report in &comparison.models {
        output.text(format_args!("model {}: {}", report.name, stickslip_report::compare::describe(report)));
    }
    if !verbose {
        print_worst(comparison, output);
        output.text(format_args!(
            "\nAll channels, phases and {} note(s) on how to read them: --verbose, or --html for the page",
            comparison.notes.len()
        ));
        return;
    }
    if comparison.models.len() > 1 {
        print_changes(comparison, output);
    } else if let Some(report) = comparison.models.first() {
        print_errors(report, output);
    }
    output.text("");
    for one in skipped {
        output.text(format_args!("- left out: {one}"));
    }
    for note in &comparison.notes {
        output.text(format_args!("- {note}"));
    }
}

/// The worst places of the last model, one a line.
fn print_worst(comparison: &Comparison, output: &Output) {
    let Some(report) = comparison.models.last() else { return };
    let many = !report.errors.is_empty() && many_primitives(&report.errors);
    let times =
        |s: &Size| s.multiples.map_or_else(String::new, |m| format!(", {m:.1} times the noise floor"));
    if comparison.models.len() > 1 {
        let size = |c: &Change| c.before.multiples.unwrap_or(0.0).max(c.after.multiples.unwrap_or(0.0));
        let mut shown: Vec<&Change> = comparison.changes.iter().filter(|c| c.fate != Fate::Fits).collect();
        shown.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let more = shown.len().saturating_sub(LISTED);
        for c in shown.into_iter().take(LISTED) {
            output.text(format_args!(
                "  {}: from {} to {}{} ({})",
                place_words(&c.place, many),
                readable(c.before.rms, c.unit),
                readable(c.after.rms, c.unit),
                times(&c.after),
                stickslip_report::compare::fate_words(c.fate)
            ));
        }
        if more > 0 {
            output.text(format_args!("  and {more} more"));
        }
        return;
    }
    let wrong = |r: &&ErrorRow| r.fails || r.sustained == Some(true);
    let more = report.errors.iter().filter(wrong).count().saturating_sub(LISTED);
    for r in report.errors.iter().filter(wrong).take(LISTED) {
        let place = place_words(&r.place, many);
        output.text(format_args!("  {place}: off by {}{}", readable(r.error.rms, r.unit), times(&r.error)));
    }
    if more > 0 {
        output.text(format_args!("  and {more} more"));
    }
}

/// Residuals, and apart from them what is beyond the tolerance.
fn print_errors(report: &ModelReport, output: &Output) {
    let repeated = report.errors.iter().any(|r| r.noise_source == Source::Repetitions);
    let (floor, mark) = match repeated {
        true => (" (times the noise floor; a perfect model has 1.0x)", "* fails"),
        false => ("", "* beyond the sensors' uncertainty for 0.1 s or longer"),
    };
    output.text(format_args!("\nRMS residual, model minus measurement{floor}"));
    output.table(&matrix(report, repeated, &|r| r.residual, &|_| false));
    output.text(format_args!(
        "\nRMS error: the part of the residual beyond the tolerance{}; {mark}",
        if repeated { " (times the noise floor)" } else { "" }
    ));
    let marked = |r: &ErrorRow| if repeated { r.fails } else { r.sustained == Some(true) };
    output.table(&matrix(report, repeated, &|r| r.error, &marked));
}

/// Channels by phases, worst channel first; `marked` cells get a star.
fn matrix(
    report: &ModelReport,
    multiples: bool,
    size: &dyn Fn(&ErrorRow) -> Size,
    marked: &dyn Fn(&ErrorRow) -> bool,
) -> comfy_table::Table {
    let many = report.errors.first().is_some_and(|_| many_primitives(&report.errors));
    let mut channels: Vec<(&str, usize)> = Vec::new();
    let worst = |primitive: &str, index: usize| {
        let rows = report.errors.iter().filter(|r| r.place.primitive == primitive && r.index == index);
        rows.map(|r| (r.fails, r.error.multiples.unwrap_or(0.0)))
            .fold((false, 0.0f64), |a, b| (a.0 || b.0, a.1.max(b.1)))
    };
    for row in &report.errors {
        if !channels.contains(&(&row.place.primitive, row.index)) {
            channels.push((&row.place.primitive, row.index));
        }
    }
    channels.sort_by(|a, b| {
        let (x, y) = (worst(a.0, a.1), worst(b.0, b.1));
        y.0.cmp(&x.0).then(y.1.total_cmp(&x.1))
    });
    let mut shown = table(["channel", "unit", "before contact", "sticking", "onset", "sliding", "end"]);
    for (primitive, index) in channels {
        let rows: Vec<&ErrorRow> =
            report.errors.iter().filter(|r| r.place.primitive == primitive && r.index == index).collect();
        let (factor, unit) = scale(rows[0].unit);
        let name = rows[0].place.channel.rsplit_once('_').map_or("", |n| n.0);
        let name = if many { format!("{primitive} {name}") } else { name.to_owned() };
        let mut cells = vec![Cell::new(name), Cell::new(unit)];
        for phase in PHASES {
            let text = rows.iter().find(|r| r.place.phase == phase).map_or_else(
                || "-".to_owned(),
                |r| format!("{}{}", sized(&size(r), factor, multiples), if marked(r) { "*" } else { "" }),
            );
            cells.push(Cell::new(text).set_alignment(CellAlignment::Right));
        }
        shown.add_row(cells);
    }
    shown
}

/// '0.031 (1.0x)'.
fn sized(size: &Size, factor: f64, multiples: bool) -> String {
    let times = size.multiples.filter(|_| multiples).map_or_else(String::new, |m| format!(" ({m:.1}x)"));
    format!("{:.3}{times}", size.rms * factor)
}

fn print_changes(comparison: &Comparison, output: &Output) {
    let names = [&comparison.models[0].name, &comparison.models[comparison.models.len() - 1].name];
    let many = comparison.changes.first().is_some_and(|_| many_primitives(&comparison.models[0].errors));
    let repeated = comparison.data.noise_floor == Source::Repetitions;
    let mut shown = table(["channel and phase", "unit", "before", "after", "", "residual before", "after"]);
    let interesting = comparison.changes.iter().filter(|c| {
        c.fate != Fate::Fits || c.before.multiples.unwrap_or(0.0).max(c.after.multiples.unwrap_or(0.0)) > 2.0
    });
    let all = interesting.clone().count();
    for c in interesting.take(25) {
        let (factor, unit) = scale(c.unit);
        let cell = |s: &Size| Cell::new(sized(s, factor, repeated)).set_alignment(CellAlignment::Right);
        shown.add_row(vec![
            Cell::new(place_words(&c.place, many)),
            Cell::new(unit),
            cell(&c.before),
            cell(&c.after),
            Cell::new(stickslip_report::compare::fate_words(c.fate)),
            cell(&c.residual_before),
            cell(&c.residual_after),
        ]);
    }
    output.text(format_args!(
        "\nRMS error beyond the tolerance of {}{}, {} against {}; and the whole residual",
        names[0],
        if repeated { " (times the noise floor)" } else { "" },
        names[0],
        names[1]
    ));
    output.table(&shown);
    if all > 25 {
        output.text(format_args!("{} more rows in the JSON document and the page", all - 25));
    }
}
