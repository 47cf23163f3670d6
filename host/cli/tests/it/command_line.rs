//! The command line as a whole.

use clap::CommandFactory;
use stickslip_cli::commands::Cli;

#[test]
fn the_command_line_is_consistent_and_every_command_shows_an_example() {
    crate::common::is_consistent(Cli::command());
}
