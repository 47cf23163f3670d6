//! `stickslip replay DATA --trial ID`: the predictor over a recorded trial, as the board runs it.

use std::path::{Path, PathBuf};

use super::arguments::{Drawn, OneTrial, TunedBy, told};
use super::package::at_board_rate;
use anyhow::Context;
use stickslip_shared::predictor::{Limits, MAX_SEGMENTS, Prediction};

use stickslip_analysis::run::replay::Span;
use stickslip_analysis::run::replay::{self, ReplayError, feed, first_difference, hash};
use stickslip_analysis::run::series;
use stickslip_analysis::run::simulate::prepare;
use stickslip_analysis::run::summary::{Against, Document};
use stickslip_analysis::tuning::{Changed, changed, in_words};
use stickslip_data::series::SeriesWriter;
use stickslip_device::log::{self, Entry};
use stickslip_device::records::read_predictions;
use stickslip_report::replay::{Shown, figures, page};
use stickslip_report::terminal::{Output, command_line, table};

/// Arguments of `stickslip replay`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip replay data/demo --trial linear_push-obj4-g20-v10-s0-r1
  stickslip replay data/demo --trial linear_push-obj4-g20-v10-s0-r1 --against run.mcap
  stickslip replay data/demo --trial linear_push-obj4-g20-v10-s0-r1 --model model.toml --html replay.html
  stickslip replay data/demo --predictor predictor.toml")]
pub struct Args {
    #[command(flatten)]
    of: OneTrial,
    #[command(flatten)]
    tuned: TunedBy,
    /// Write the predictions to a log
    #[arg(long, value_name = "FILE.mcap")]
    pub log: Option<PathBuf>,
    /// Compare with the predictions in this log bit for bit
    #[arg(long, value_name = "FILE.mcap")]
    pub against: Option<PathBuf>,
    /// Write the time series of measurement, model and prediction, one row a sample
    #[arg(long, value_name = "FILE.csv|FILE.parquet")]
    pub series: Option<PathBuf>,
    #[command(flatten)]
    drawn: Drawn,
    /// Print when each flag and each doubt is up, and how the solver fared, too
    #[arg(long, short)]
    pub verbose: bool,
}

/// Replays and reports.
///
/// # Errors
/// Where data, model or log cannot be read, or the log differs from the replay.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let index = stickslip_report::data::open(&args.of.data, output)?;
    let model = args.of.with.read()?;
    let tuning = args.tuned.read()?;
    let (at, info, trial) = at_board_rate(&index, args.of.trial.as_deref(), output)?;
    let feed = feed(&index.description, &trial)?;
    if feed.crowded {
        output.note(format_args!(
            "trial {}: its motion has more segments than a plan holds ({MAX_SEGMENTS}); different ones were joined, and the flag \
             'unexpected' is unreliable. Split the record into trials of one stroke each",
            info.trial
        ));
    }
    let bar = output.progress(feed.samples.len() as u64, "replaying");
    let limits = Limits::default();
    let replayed = replay::run_tuned(&feed, &model, limits, &tuning, at, |samples| bar.inc(samples as u64))
        .map_err(|why| ReplayError::Refused { trial: info.trial.clone(), why })?;
    bar.finish_and_clear();
    let tuned = changed(&tuning);
    if let Some(path) = &args.log {
        let meta = log_meta(&info.trial, &tuned);
        write_log(path, &feed.scene, &model, meta, &feed.samples, &replayed.predictions)?;
    }
    let t_s: Vec<f64> = trial.samples.iter().map(|s| s.t_s).collect();
    let against = match &args.against {
        Some(path) => Some(read_against(path, &replayed.predictions)?),
        None => None,
    };
    if let Some(path) = &args.series {
        let prepared = prepare(&index.description, &trial, at)?;
        let simulated = prepared.simulate(&model);
        let mut series = series::signals(&info.trial, &prepared, &[("model", &simulated)]);
        series::add_predictions(&mut series, &replayed.predictions);
        let mut writer = SeriesWriter::create(path)?;
        writer.write(&series)?;
        writer.finish()?;
        output.note(format_args!("time series written to {}", path.display()));
    }
    let document = Document { tuned, ..Document::new(&info.trial, &t_s, &feed.plan, &replayed, against) };
    if args.drawn.any() {
        let next = command_line(next(args).iter().map(String::as_str));
        let (scenery, spans) = match prepare(&index.description, &trial, at) {
            Ok(p) if p.t_s.len() <= LONGEST_DRAWN => {
                stickslip_report::replay::drawn(&index.description, &p, &p.simulate(&model))
            }
            _ => Default::default(),
        };
        let (description, samples, predictions) =
            (&index.description, trial.samples.as_slice(), replayed.predictions.as_slice());
        let shown = Shown { description, t_s: &t_s, samples, predictions, scenery, spans, next: &next };
        args.drawn.write(output, || page(&document, &shown), || figures(&document, &shown))?;
    }
    print(&document, args.verbose, output);
    output.next(next(args).iter().map(String::as_str));
    output.document(&document)?;
    if let Some(a) = &document.against {
        let why = match document.tuned.is_empty() {
            true => "",
            false => ", whose predictor has other numbers than a board's",
        };
        anyhow::ensure!(a.equal, "{}: the log differs from the replay{why}", a.file);
    }
    Ok(())
}

/// A longer record's bench is not drawn: the model would have to be run along all of it.
const LONGEST_DRAWN: usize = 20_000;

/// The same trial's measured forces against the model's.
fn next(args: &Args) -> Vec<String> {
    let mut line = vec!["compare".to_owned(), args.of.data.display().to_string()];
    line.extend(args.of.trial.iter().flat_map(|t| ["--trial".to_owned(), t.clone()]));
    line.extend(args.of.with.model.iter().flat_map(|m| ["--model".to_owned(), m.display().to_string()]));
    line.extend(["--html".to_owned(), "compare.html".to_owned()]);
    line
}

/// What a log says of its run.
fn log_meta(trial: &str, changed: &[Changed]) -> serde_json::Value {
    let mut meta = serde_json::json!({ "trial": trial, "device": "host replay" });
    if !changed.is_empty() {
        meta["predictor"] = in_words(changed).into();
    }
    meta
}

fn write_log(
    path: &Path,
    scene: &stickslip_shared::model::Scene<f32>,
    model: &stickslip_shared::model::Model<f64>,
    meta: serde_json::Value,
    samples: &[stickslip_shared::wire::Sample],
    predictions: &[Prediction],
) -> anyhow::Result<()> {
    let header = log::Header {
        scene: postcard::to_allocvec(scene)?,
        model: postcard::to_allocvec(&model.cast::<f32>())?,
        meta,
    };
    let mut writer = log::Writer::create(path, &header)?;
    for (sample, prediction) in samples.iter().zip(predictions) {
        let ns = u64::from(sample.t_us) * 1000;
        writer.record(ns, Entry::Sample(sample))?;
        writer.record(ns, Entry::Prediction(prediction))?;
    }
    Ok(writer.sync()?)
}

fn read_against(path: &Path, predictions: &[Prediction]) -> anyhow::Result<Against> {
    let contents = log::read(path)?;
    let logged = read_predictions(&contents.records)
        .with_context(|| format!("{}: a prediction in it cannot be read", path.display()))?;
    anyhow::ensure!(!logged.is_empty(), "{}: the log contains no predictions", path.display());
    let first_difference = first_difference(&logged, predictions);
    Ok(Against {
        file: path.display().to_string(),
        predictions: logged.len(),
        missing: predictions.len().saturating_sub(logged.len()),
        hash: format!("{:08x}", hash(logged.iter().map(|(_, p)| p))),
        equal: first_difference.is_none(),
        first_difference,
        lost: contents.loss(),
    })
}

fn print(d: &Document, verbose: bool, output: &Output) {
    output.text(format_args!("{}\n", stickslip_report::replay::sentence(d)));
    output.text(format_args!("trial {}: {} ticks, hash {}", d.trial, d.ticks, d.hash));
    told(&d.tuned, output);
    let p = &d.prediction;
    let measured = p.peak_measured_utilisation.map_or_else(|| "not measured".into(), |u| format!("{u:.2}"));
    output.text(format_args!(
        "  friction used: at most {:.2} by the model, {measured} by the sensors; slip up to {:.1} mm/s",
        p.peak_utilisation,
        p.peak_slip_m_s * 1e3
    ));
    let summed = summed(&d.flags);
    for (flag, spans) in summed.iter().take(FLAGS_SHOWN) {
        output.text(format_args!("  {flag}: {spans}"));
    }
    let mut doubts: Vec<(&str, usize)> = Vec::new();
    for span in &d.doubts {
        let doubt = span.flag.trim_start_matches("doubt: ");
        match doubts.iter_mut().find(|(known, _)| *known == doubt) {
            Some((_, ticks)) => *ticks += span.ticks,
            None => doubts.push((doubt, span.ticks)),
        }
    }
    if !doubts.is_empty() {
        let each: Vec<String> = doubts.iter().map(|(doubt, ticks)| format!("{doubt} in {ticks}")).collect();
        output.text(format_args!("  doubts, in ticks of {}: {}", d.ticks, each.join(", ")));
    }
    if verbose {
        in_full(d, output);
    } else {
        output.text("\nEach flag and doubt, the solver: --verbose, or --html for the page");
    }
    if let Some(a) = &d.against {
        match &a.first_difference {
            None => output.text(format_args!(
                "{}: {} predictions, all equal bit for bit{}",
                a.file,
                a.predictions,
                if a.missing > 0 {
                    format!("; {} ticks are not in the log", a.missing)
                } else {
                    String::new()
                }
            )),
            Some(f) => output.text(format_args!(
                "{}: tick {} differs first, in output word {}: log {:08x}, replay {:08x}",
                a.file, f.tick, f.word, f.logged, f.replayed
            )),
        }
        if let Some(lost) = &a.lost {
            output.text(format_args!("{}: {lost}", a.file));
        }
    }
}

/// Flags that are listed without `--verbose`.
const FLAGS_SHOWN: usize = 5;

/// Each flag once, as it first rises, with when it is up; both fingers in one line where they agree.
fn summed(spans: &[Span]) -> Vec<(String, String)> {
    let mut flags: Vec<&str> = Vec::new();
    for span in spans {
        if !flags.contains(&span.flag) {
            flags.push(span.flag);
        }
    }
    let mut rows: Vec<(String, String)> = Vec::new();
    for flag in flags {
        let of: Vec<&Span> = spans.iter().filter(|s| s.flag == flag).collect();
        let (Some(first), Some(last)) = (of.first(), of.last()) else { continue };
        let until = last.falls_s.map_or_else(|| "the end".to_owned(), |t| format!("{t:.3} s"));
        let pauses = match of.len() {
            1 => String::new(),
            times => format!(", up {times} times"),
        };
        let when = format!("from {:.3} s to {until}{pauses}", first.rises_s);
        match rows.last_mut() {
            Some((known, same)) if *same == when && flag == known.replace("finger 1", "finger 2") => {
                *known = known.replace("finger 1", "fingers 1 and 2");
            }
            _ => rows.push((flag.to_owned(), when)),
        }
    }
    // What is foreseen and what slips first: the rest is circumstance.
    let told = |flag: &str| !(flag.contains("slip") || flag.contains("drop"));
    rows.sort_by_key(|(flag, _)| told(flag));
    rows
}

fn in_full(d: &Document, output: &Output) {
    let ticks: Vec<String> =
        d.solver.ticks.iter().map(|(k, n)| format!("{} {n}", k.replace('_', " "))).collect();
    output.text(format_args!(
        "\nsolver: {}; momentum residual at most {:.1e} N; Newton steps {:.1} a tick, at most {}",
        ticks.join(", "),
        d.solver.worst_residual_n,
        d.solver.mean_iterations,
        d.solver.most_iterations
    ));
    if d.solver.cone_instead_share > 0.0 {
        output.text(format_args!(
            "pyramids not solved within their work budget, cone used instead: {:.1} % of the ticks",
            100.0 * d.solver.cone_instead_share
        ));
    }
    if let Some(w) = &d.solver.witness {
        output.text(format_args!(
            "the other formulation: {} of {} steps solved by both, points stick and slide alike in {} of them ({:.2} %)",
            w.compared,
            w.asked,
            w.alike,
            100.0 * f64::from(w.alike) / f64::from(w.compared.max(1))
        ));
    }
    let mut shown = table(["flag", "rises, s", "falls, s", "ticks"]);
    for s in d.flags.iter().chain(&d.doubts) {
        let falls = s.falls_s.map_or_else(|| "-".to_owned(), |t| format!("{t:.3}"));
        shown.add_row([s.flag.to_owned(), format!("{:.3}", s.rises_s), falls, s.ticks.to_string()]);
    }
    output.table(&shown);
}
