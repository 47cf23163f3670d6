//! `stickslip diagnose DATA`: which physical effect a model lacks.

use std::cell::LazyCell;
use std::path::{Path, PathBuf};

use comfy_table::{Cell, CellAlignment};

use super::arguments::Drawn;
use crate::commands::fitted::{file_or_default, write};
use stickslip_analysis::channels::channel_words;
use stickslip_analysis::diagnose;
use stickslip_analysis::diagnose::report::{CandidateReport, Report, Verdict};
use stickslip_analysis::model::candidate::CandidateEffect;
use stickslip_analysis::model::file::{EffectEntry, ModelFile};
use stickslip_report::diagnose::{explains, figures, html, sentence, traces, weaker};
use stickslip_report::terminal::{Output, command_line, table};
use stickslip_report::words::{effects_in_words, identifier_words, interval, parameter_words, short};

/// Arguments of `stickslip diagnose`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip diagnose data/demo
  stickslip diagnose data/demo --model model.toml --html diagnosis.html --out better.toml")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Model to diagnose; its friction and effects are refitted, its formulas that were never
    /// fitted are tried as candidates
    /// [default: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// More formulas to try as candidates
    #[arg(long, value_name = "FILE.toml")]
    pub formula: Option<PathBuf>,
    /// Where an effect is named: write the model with it
    #[arg(long, value_name = "BETTER.toml")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    drawn: Drawn,
    /// Print all effects tried, misfits, limits and classes
    #[arg(long, short)]
    pub verbose: bool,
}

/// Diagnoses and reports.
///
/// # Errors
/// Where data or model cannot be read, no trial can be simulated, or a file not written.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    let whole = file_or_default(args.model.as_deref())?;
    let (file, formulas) = whole.proposals(args.formula.as_deref())?;
    let own: Vec<CandidateEffect> = formulas.iter().filter_map(CandidateEffect::of).collect();
    let dataset = stickslip_report::data::read(&args.data, output)?;
    let mut report = diagnose(&dataset, &file, &own, output)?;
    report.refused = output.all_refused();
    let named = matches!(report.verdict, Verdict::Effect | Verdict::Ambiguous);
    let written = args.out.as_deref().filter(|_| named);
    if let Some(path) = written {
        let known: Vec<EffectEntry> = file.effects.iter().chain(&formulas).cloned().collect();
        let mut better = ModelFile::of_model(&report.model, &known);
        better.set_intervals(report.parameters.iter().map(|(name, v)| (name.as_str(), [v.low, v.high])));
        write(&better, path)?;
    }
    let next = next(args, &report, written);
    let next: Vec<&str> = next.iter().map(String::as_str).collect();
    let name = dataset.description.name.clone();
    // A picture is no reason to lose the diagnosis.
    let traces = LazyCell::new(|| {
        let found = traces(&dataset.into(), file.to_model(), &report, output).map_err(|why| why.to_string());
        found.inspect_err(|why| output.note(format_args!("no traces can be shown: {why}")))
    });
    let line = command_line(next.iter().copied());
    let page = || html(&report, &name, &line, traces.as_ref().map_err(Clone::clone));
    args.drawn.write(output, page, || figures(&report, traces.as_ref().ok()))?;
    print(&report, args.verbose, output);
    match (&args.out, written) {
        (_, Some(path)) => output.text(format_args!("written to {}", path.display())),
        (Some(path), None) => {
            output.note(format_args!("no effect is named: {} is not written", path.display()));
        }
        (None, None) => {}
    }
    output.next(next);
    output.document(&report)
}

/// The command that the verdict asks for.
fn next(args: &Args, report: &Report, written: Option<&Path>) -> Vec<String> {
    let words = |of: &[&str]| of.iter().map(ToString::to_string).collect::<Vec<String>>();
    let data = args.data.display().to_string();
    let model = args.model.as_ref().map(|m| words(&["--model", &m.display().to_string()]));
    let with_model = |mut line: Vec<String>| {
        line.extend(model.clone().unwrap_or_default());
        line
    };
    let with_formula = |mut line: Vec<String>| {
        if let Some(formula) = &args.formula {
            line.extend(words(&["--formula", &formula.display().to_string()]));
        }
        line
    };
    let single = |set: &&Vec<&'static str>| set.len() == 1;
    match (report.verdict, report.ambiguous_with.iter().find(single), report.effects.as_slice()) {
        (Verdict::Ambiguous, Some(other), [one]) => {
            let line = with_formula(with_model(words(&["suggest", &data])));
            [line, words(&["--between", one, "--between", other[0]])].concat()
        }
        (Verdict::Effect | Verdict::Ambiguous, _, effects) => match written {
            Some(path) => {
                let line = with_model(words(&["compare", &data]));
                [line, words(&["--model", &path.display().to_string()])].concat()
            }
            None => {
                let line = [words(&["add", &data]), words(effects)].concat();
                [with_formula(with_model(line)), words(&["--out", "better.toml"])].concat()
            }
        },
        (Verdict::Unexplained, ..) => {
            [with_model(words(&["compare", &data])), words(&["--html", "compare.html"])].concat()
        }
        (Verdict::Inconclusive, ..) if report.candidates.len() > 1 => {
            with_formula(with_model(words(&["suggest", &data])))
        }
        (Verdict::Inconclusive, ..) => words(&["check", &data]),
        (Verdict::NothingMissing, ..) => with_model(words(&["score", &data])),
    }
}

/// Effects and misfits that are listed without `--verbose`.
const LISTED: usize = 3;

fn print(report: &Report, verbose: bool, output: &Output) {
    output.text(sentence(report));
    output.left_out(&report.left_out, report.trials + report.left_out.len(), "all: --verbose or --html");
    if let Some(would_tell) = &report.would_tell {
        output.text(format_args!("What would decide: {}.", effects_in_words(would_tell)));
    }
    if let Some(weaker) = weaker(report) {
        output.text(weaker);
    }
    for c in report.candidates.iter().filter(|c| report.effects.contains(&c.id)) {
        output.text(format_args!("In data, {}: {}.", identifier_words(c.id), c.info.signature));
    }
    output.text(format_args!(
        "\n{} trials of {} conditions; error {:.2} run spreads before, {:.2} after (a perfect model: {:.2}); {:.1} s",
        report.trials,
        report.conditions,
        report.error.before,
        report.error.after,
        report.error.perfect_model,
        report.seconds
    ));
    if verbose {
        print_all(report, output);
    } else {
        print_first(report, output);
    }
    if let Some(e) = &report.suggested_experiment {
        output.text(format_args!("next experiment: {}", e.summary));
    }
}

/// The best candidates and the largest misfits, one a line.
fn print_first(report: &Report, output: &Output) {
    if report.verdict != Verdict::NothingMissing {
        // What is named, and what does as well, before what fits best and is neither.
        let rank = |c: &CandidateReport| match c.id {
            id if report.effects.contains(&id) => 0,
            id if report.ambiguous_with.iter().any(|set| set.contains(&id)) => 1,
            _ => 2,
        };
        let mut listed: Vec<&CandidateReport> = report.candidates.iter().collect();
        listed.sort_by_key(|c| rank(c));
        for (k, c) in listed.into_iter().take(LISTED).enumerate() {
            let strength = c.parameters.iter().filter(|_| k == 0).map(|(name, v)| {
                let unit = if v.unit == "1" { "" } else { v.unit };
                let text = format!(
                    "{} {} ({}) {unit}",
                    parameter_words(name),
                    short(v.value),
                    interval(v.low, v.high)
                );
                text.trim_end().to_owned()
            });
            let strength: Vec<String> = strength.collect();
            let colon = if strength.is_empty() { "" } else { ": " };
            let (share, of_what) = c.own_share();
            let explains = explains(share, &effects_in_words(&of_what));
            output.text(format_args!(
                "  {} {explains}{colon}{}",
                identifier_words(c.id),
                strength.join(", ")
            ));
        }
    }
    for p in report.places.iter().filter(|p| p.before.max(p.after) > 1.0).take(LISTED) {
        output.text(format_args!(
            "  {}, {}: off by {:.1} run spreads before, {:.1} after",
            channel_words(&p.channel),
            p.phase,
            p.before,
            p.after
        ));
    }
    if report.verdict == Verdict::NothingMissing && !report.not_excluded.is_empty() {
        let effects: Vec<String> = report.not_excluded.iter().map(|id| identifier_words(id)).collect();
        output.text(format_args!("  not excluded at typical strength: {}", effects.join(", ")));
    }
    // One of them may be what nothing explains.
    for limit in report.limits.iter().filter(|_| report.verdict == Verdict::Unexplained).take(LISTED) {
        output.text(format_args!("  limit: {}", effects_in_words(limit)));
    }
    output.text(format_args!(
        "All effects tried, misfits, {} limit(s) of these data: --verbose, or --html for the page",
        report.limits.len()
    ));
}

/// Everything, as tables.
fn print_all(report: &Report, output: &Output) {
    let right = |s: String| Cell::new(s).set_alignment(CellAlignment::Right);
    if !report.candidates.is_empty() && report.verdict != Verdict::NothingMissing {
        let mut t = table(["effect", "probability", "explains", "held-out error", "p", "parameters"]);
        for c in &report.candidates {
            let parameters: Vec<String> = c
                .parameters
                .iter()
                .map(|(n, v)| {
                    let unit = if v.unit == "1" { "" } else { v.unit };
                    format!("{n} = {} ({}) {unit}", short(v.value), interval(v.low, v.high))
                })
                .collect();
            t.add_row(vec![
                Cell::new(c.id),
                right(stickslip_report::diagnose::percent(c.probability)),
                right(stickslip_report::diagnose::share(c.own_share().0)),
                right(format!("{:.2}", c.held_out_error)),
                right(format!("{:.1e}", c.p_value)),
                Cell::new(parameters.join("\n")),
            ]);
        }
        output.text("\nEffects tried (error in run spreads):");
        output.table(&t);
    }
    for line in stickslip_report::diagnose::credible(report) {
        output.text(line);
    }
    if !report.places.is_empty() {
        let mut t = table(["where", "phase", "before", "after"]);
        for p in report.places.iter().take(6) {
            let number = |x: f64| right(format!("{x:.1}"));
            let place = Cell::new(channel_words(&p.channel));
            t.add_row(vec![place, Cell::new(p.phase), number(p.before), number(p.after)]);
        }
        output.text("\nSystematic misfit (run spreads):");
        output.table(&t);
    }
    for u in &report.unexplained {
        output.text(format_args!("left: {}", stickslip_report::diagnose::structure_words(u)));
    }
    if matches!(report.verdict, Verdict::NothingMissing | Verdict::Inconclusive) {
        let mut t = table(["effect", "strength", "limit", "typical"]);
        for [effect, name, upper, typical] in stickslip_report::diagnose::limits_on_effects(report) {
            t.add_row(vec![Cell::new(effect), Cell::new(name), right(upper), right(typical)]);
        }
        output.text("\nUpper limits on effects (95 %):");
        output.table(&t);
    }
    for class in &report.classes {
        output.text(format_args!("not separated by these trials: {}", class.join(", ")));
    }
    for one in &report.left_out {
        output.text(format_args!("left out: {one}"));
    }
    for limit in &report.limits {
        output.text(format_args!("limit: {limit}"));
    }
}
