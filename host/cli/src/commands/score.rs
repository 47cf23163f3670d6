//! `stickslip score DATA`: how early slip and drop are predicted, and how many alarms are false.

use std::path::PathBuf;

use super::arguments::{Drawn, PredictsWith, TunedBy, told};
use stickslip_analysis::score::ObjectPose;
use stickslip_analysis::score::document::{Document, Options, score_tuned};
use stickslip_analysis::score::figures::Case;
use stickslip_analysis::score::traces::{cases, traces};
use stickslip_report::score::{
    LEGEND, MOST, Seen, cells, figures, page, shown, summary, time, time_left, utilisation,
};
use stickslip_report::terminal::{Output, command_line, table};

/// Command line of `stickslip score`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip rig --plan slip-hours --hours 0.5 --out data/hours
  stickslip score data/hours
  stickslip score data/hours --model model.toml --object-pose start --html score.html")]
pub struct Args {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    #[command(flatten)]
    with: PredictsWith,
    #[command(flatten)]
    tuned: TunedBy,
    /// How often the predictor is given the object's measured pose
    #[arg(long, value_enum, default_value = "every")]
    pub object_pose: ObjectPose,
    /// Threshold of the baseline on tangential over normal force
    #[arg(long, default_value_t = 0.3, value_name = "RATIO")]
    pub ratio: f64,
    /// Threshold of the baseline on the tangential force's rate, N/s
    #[arg(long, default_value_t = 20.0, value_name = "N/S")]
    pub rate: f64,
    #[command(flatten)]
    drawn: Drawn,
    /// Print the table of all events and methods, and stated against actual values, too
    #[arg(long, short)]
    pub verbose: bool,
}

/// Scores and reports.
///
/// # Errors
/// Where data or model cannot be read.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    for (option, value) in [("--ratio", args.ratio), ("--rate", args.rate)] {
        anyhow::ensure!(value > 0.0 && value.is_finite(), "{option} is {value}; give a number above zero");
    }
    let index = stickslip_report::data::open(&args.data, output)?;
    let model = args.with.read()?;
    let options = Options { object_pose: args.object_pose, ratio: args.ratio, rate_n_s: args.rate };
    let tuning = args.tuned.read()?;
    let document = score_tuned(&index, &model, &tuning, &options, output)?;
    document.refused.iter().for_each(|refused| output.refused(refused));
    let next = next(args, &document);
    let line = |words: &[String]| command_line(words.iter().map(String::as_str));
    let shown = |trial: &str| line(&replay(args, Some(trial)));
    if args.drawn.any() {
        let drawn = traces(&index, &model, &tuning, &document, MOST);
        let seen = Seen { description: &index.description, drawn: &drawn };
        let html = || page(&document, &seen, &line(&next), &shown);
        args.drawn.write(output, html, || figures(&document, &seen))?;
    }
    print(&document, args.verbose, output);
    output.next(next.iter().map(String::as_str));
    output.document(&document)
}

/// To look at a trial with an event that was missed or late, or with a false alarm; else at the first one.
fn next(args: &Args, d: &Document) -> Vec<String> {
    let missed = cases(d).into_iter().map(|(_, case)| case).find(Case::fails);
    replay(args, missed.as_ref().map(|case| case.trial.as_str()))
}

/// The command that shows a trial: the first where none is named.
fn replay(args: &Args, trial: Option<&str>) -> Vec<String> {
    let mut line = vec!["replay".to_owned(), args.data.display().to_string()];
    line.extend(trial.into_iter().flat_map(|trial| ["--trial".to_owned(), trial.to_owned()]));
    line.extend(args.with.model.iter().flat_map(|m| ["--model".to_owned(), m.display().to_string()]));
    line.extend(args.tuned.words());
    line.extend(["--html".to_owned(), "replay.html".to_owned()]);
    line
}

/// Trials passed over that are named.
const NAMED: usize = 3;

fn print(d: &Document, verbose: bool, output: &Output) {
    for warning in &d.warnings {
        output.note(warning);
    }
    for (trial, why) in d.passed_over.iter().take(NAMED) {
        output.note(format_args!("trial {trial} not scored: {why}"));
    }
    if d.passed_over.len() > NAMED {
        output
            .note(format_args!("{} more trials not scored (--json lists all)", d.passed_over.len() - NAMED));
    }
    output.text(format_args!("{}\n", stickslip_report::score::verdict(d).1));
    output.text(format_args!(
        "{}: {} trials, {} scored; sample unusable in {:.2} % of the ticks",
        d.data.display(),
        d.trials,
        time(d.hours),
        d.doubtful_share * 100.0
    ));
    told(&d.tuned, output);
    for line in summary(d) {
        output.text(format_args!("  {line}"));
    }
    if verbose {
        in_full(d, output);
    } else {
        output.text("\nAll events and methods, what the words mean: --verbose, or --html for the page");
    }
}

fn in_full(d: &Document, output: &Output) {
    output.text("");
    let mut events = table([
        "event",
        "method",
        "events",
        "found",
        "in time",
        "lead 5/50/95 %, ms",
        "false",
        "near",
        "onset error, ms",
    ]);
    for r in shown(&d.rows) {
        events.add_row(cells(r));
    }
    output.table(&events);
    output.text(format_args!("\n{LEGEND}"));
    for c in &d.calibration {
        output.text(format_args!("\n{}", c.method));
        let stated = [
            ("stated utilisation and slip within 0.1 s", utilisation(c)),
            ("stated time left and actual 5/50/95 %", time_left(c)),
        ];
        for (of, shown) in stated {
            if !shown.is_empty() {
                output.text(format_args!("  {of}: {}", shown.join("; ")));
            }
        }
        if let Some([low, middle, high]) = c.grip {
            output.text(format_args!(
                "  grip at which it slipped over the grip stated as just enough, 5/50/95 %: {low:.2} / {middle:.2} / \
                 {high:.2} ({} slips)",
                c.grips
            ));
        }
    }
}
