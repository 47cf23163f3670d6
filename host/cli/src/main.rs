//! The `stickslip` command: parses the arguments and dispatches.

use std::process::ExitCode;

fn main() -> ExitCode {
    stickslip_cli::commands::main()
}
