//! The commands of `stickslip`: one module each, with its `Args` and its `run`.
//!
//! To add one: a module with `pub struct Args` (clap derive, `after_help` with an example)
//! and `pub fn run(args: &Args, output: &Output) -> anyhow::Result<()>`, a variant of
//! `Command` and an arm of its `run`.

pub mod add;
mod arguments;
pub mod board;
mod board_set;
pub mod calibrate;
pub mod check;
pub mod compare;
pub mod completions;
pub mod demo;
pub mod diagnose;
pub mod effects;
mod fitted;
pub mod import;
mod import_recording;
pub mod lcp;
pub mod man;
pub mod monitor;
pub mod new;
mod package;
pub mod predictor;
pub mod refit;
pub mod replay;
pub mod rig;
pub mod schema;
pub mod score;
pub mod simulate;
pub mod stream;
pub mod suggest;
mod telemetry;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use stickslip_report::terminal::{Output, Style};

/// Predicts slip and drop on a robot gripper, and compares contact models with measurements.
#[derive(Debug, Parser)]
#[command(name = "stickslip", version, max_term_width = 100, propagate_version = true)]
pub struct Cli {
    /// Print one JSON document to stdout instead of text
    #[arg(long, global = true)]
    pub json: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Check a data set: contents, errors, warnings, balance of the measured forces
    Check(check::Args),
    /// Find out which physical effect a model lacks, from measurements
    Diagnose(diagnose::Args),
    /// Add an effect to a model and fit it together with the rest
    Add(add::Args),
    /// Fit all parameters of a model that has effects, to other or more data
    Refit(refit::Args),
    /// List the effects that a model can have, or show one: what it is, what it looks like in data
    Effects(effects::Args),
    /// Print the numbers of the predictor as a commented file, with defaults, bounds and what each does
    Predictor(predictor::Args),
    /// Find the experiment that separates two candidate effects best, and the runs it needs
    Suggest(suggest::Args),
    /// Compare models with measurements: errors by channel and phase, where a model fails
    Compare(compare::Args),
    /// Run the predictor over a recorded trial as the board does, and compare with its log
    Replay(replay::Args),
    /// Run all steps on a recorded push and on a bench with a hidden effect
    Demo(demo::Args),
    /// Make a data set with the synthetic rig: the paper's experiments, lifts, planar pushes, hidden effects
    Rig(Box<rig::Args>),
    /// Convert recordings to the data set format: your own by a mapping file, published ones by name
    Import(import::Args),
    /// Look at recordings and write a commented mapping file for `import recording`
    New(new::Args),
    /// Write what a model predicts along recorded trials, as a data set of the same format
    Simulate(simulate::Args),
    /// Fit friction to a small share of the trials and validate it on the rest
    Calibrate(calibrate::Args),
    /// Solve complementarity problems from files or generated ones, and certify the answers
    Lcp(lcp::Args),
    /// Score the predictor: lead times and false alarms for slip and drop, compared with simple thresholds
    Score(score::Args),
    /// Describe the JSON document that a command prints with --json
    Schema(schema::Args),
    /// Print the script with which a shell completes commands and options
    Completions(completions::Args),
    /// Write a page for man of each command
    Man(man::Args),
    /// Set up, watch and check a board: info, load, set, sensors, tare, calibrate, monitor, selftest, log
    Board(board::Args),
    /// Watch what a board predicts as it happens, in the terminal or in Foxglove; or a log played again
    Monitor(monitor::Args),
    /// Stream a recorded trial to a board (or the firmware in QEMU) and watch its predictions
    Stream(stream::Args),
}

impl Command {
    fn run(&self, output: &Output) -> anyhow::Result<()> {
        match self {
            Command::Check(args) => check::run(args, output),
            Command::Diagnose(args) => diagnose::run(args, output),
            Command::Add(args) => add::run(args, output),
            Command::Refit(args) => refit::run(args, output),
            Command::Effects(args) => effects::run(args, output),
            Command::Predictor(args) => predictor::run(args, output),
            Command::Suggest(args) => suggest::run(args, output),
            Command::Compare(args) => compare::run(args, output),
            Command::Replay(args) => replay::run(args, output),
            Command::Demo(args) => demo::run(args, output),
            Command::Rig(args) => rig::run(args, output),
            Command::Import(args) => import::run(args, output),
            Command::New(args) => new::run(args, output),
            Command::Simulate(args) => simulate::run(args, output),
            Command::Calibrate(args) => calibrate::run(args, output),
            Command::Lcp(args) => lcp::run(args, output),
            Command::Score(args) => score::run(args, output),
            Command::Schema(args) => schema::run(args, output),
            Command::Completions(args) => completions::run(args, Cli::command(), output),
            Command::Man(args) => man::run(args, Cli::command(), output),
            Command::Board(args) => board::run(args, output),
            Command::Monitor(args) => monitor::run(args, output),
            Command::Stream(args) => stream::run(args, output),
        }
    }
}

/// Runs the command line of this process.
#[must_use]
pub fn main() -> ExitCode {
    main_of(std::env::args_os())
}

/// Parses a command line (the program's name first), runs the command and reports its error.
/// Exit code 0: done; 1: the command failed; 2: wrong usage.
#[must_use]
pub fn main_of(words: impl Iterator<Item = OsString>) -> ExitCode {
    // Clap prints its own message and exits with 2 on wrong usage.
    let matches = Cli::command().get_matches_from(words);
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let style = if cli.json { Style::Json } else { Style::Human };
    let output = Output::new(style).of(&format!("stickslip-{}", matches.subcommand_name().unwrap_or("")));
    output.exit_code(&cli.command.run(&output))
}
