//! The `stickslip-lab` command: parses the arguments and dispatches.

use std::process::ExitCode;

fn main() -> ExitCode {
    stickslip_lab::commands::main()
}
