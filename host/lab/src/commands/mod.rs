//! The commands of `stickslip-lab`: one module each, with its `Args` and its `run`.

pub mod blind;
pub mod ceilings;
pub mod cost;
pub mod curves;
pub mod findings;
pub mod formulations;
pub mod grid;
pub mod grip_loop;
pub mod hunt;
pub mod mujoco;
pub mod planar;
pub mod precision;
pub mod reliability;
pub mod steps;
pub mod tribometer;
pub mod warnings;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use stickslip_report::terminal::{Output, Style};

/// Studies and developers' tools of stickslip.
#[derive(Debug, Parser)]
#[command(name = "stickslip-lab", version, max_term_width = 100, propagate_version = true)]
pub struct Cli {
    /// Print one JSON document to stdout instead of text
    #[arg(long, global = true)]
    pub json: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Test the diagnosis on synthetic data with hidden effects, without using the key
    Blind(blind::Args),
    /// Predict planar pushes with friction fitted to a few of them
    Planar(planar::Args),
    /// Fit rigid friction, and a spring in series with friction, to the record of one contact
    Tribometer(tribometer::Args),
    /// Check the paper's statements against the rig, the hard and the soft model
    Findings(findings::Args),
    /// Compare friction pyramids with the exact cone, step by step, on recorded and random trials
    Formulations(formulations::Args),
    /// Simulate every trial of a data set in parallel and time the steps
    Grid(grid::Args),
    /// Close the loop on the rig: objects kept and grip used with the advised grip, against the planned one
    GripLoop(grip_loop::Args),
    /// Simulate recorded trials in MuJoCo and compare with this model and the measurement
    Mujoco(mujoco::Args),
    /// Count the instructions of the tick and its parts on the emulated board
    Cost(cost::Args),
    /// Search for the most expensive and least accurate problems of the solvers and the tick
    Hunt(hunt::Args),
    /// Compare single and double precision of the time step, on recorded and random trials
    Precision(precision::Args),
    /// Draw warnings in time against false alarms: the predictor, a threshold, the force rate, a learnt detector
    Curves(curves::Args),
    /// Compare the slips seen in time with those that the poses' noise lets an oracle see
    Ceilings(ceilings::Args),
    /// Compare stated probabilities of holding with what came of them
    Reliability(reliability::Args),
    /// Judge slip and drop warnings by the key of simulated grasps
    Warnings(warnings::Args),
}

impl Command {
    fn run(&self, output: &Output) -> anyhow::Result<()> {
        match self {
            Command::Blind(args) => blind::run(args, output),
            Command::Planar(args) => planar::run(args, output),
            Command::Tribometer(args) => tribometer::run(args, output),
            Command::Findings(args) => findings::run(args, output),
            Command::Formulations(args) => formulations::run(args, output),
            Command::Grid(args) => grid::run(args, output),
            Command::GripLoop(args) => grip_loop::run(args, output),
            Command::Mujoco(args) => mujoco::run(args, output),
            Command::Cost(args) => cost::run(args, output),
            Command::Hunt(args) => hunt::run(args, output),
            Command::Precision(args) => precision::run(args, output),
            Command::Curves(args) => curves::run(args, output),
            Command::Ceilings(args) => ceilings::run(args, output),
            Command::Reliability(args) => reliability::run(args, output),
            Command::Warnings(args) => warnings::run(args, output),
        }
    }
}

/// Parses the command line, runs the command and reports its error.
/// Exit code 0: done; 1: the command failed; 2: wrong usage.
#[must_use]
pub fn main() -> ExitCode {
    let matches = Cli::command().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let style = if cli.json { Style::Json } else { Style::Human };
    let output = Output::new(style).of(&format!("stickslip-lab-{}", matches.subcommand_name().unwrap_or("")));
    output.exit_code(&cli.command.run(&output))
}
