//! The command line of the lab.

use clap::CommandFactory;
use stickslip_lab::commands::Cli;

#[test]
fn the_command_line_is_consistent_and_every_command_shows_an_example() {
    crate::common::is_consistent(Cli::command());
}
