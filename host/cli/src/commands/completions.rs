//! `stickslip completions SHELL`: what the shell needs to complete commands, options and their values.

use std::io::Write;

use clap::Command;
use clap_complete::Shell;
use stickslip_report::terminal::{Output, Style};

/// Arguments of `stickslip completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  stickslip completions bash > ~/.local/share/bash-completion/completions/stickslip
  stickslip completions zsh > ~/.zfunc/_stickslip
  stickslip completions fish > ~/.config/fish/completions/stickslip.fish")]
pub struct Args {
    /// Which shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the script for `command`.
///
/// # Errors
/// With `--json`: a script is no document.
pub fn run(args: &Args, mut command: Command, output: &Output) -> anyhow::Result<()> {
    anyhow::ensure!(output.style() == Style::Human, "completions are a script; leave --json out");
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "stickslip", &mut script);
    match std::io::stdout().lock().write_all(&script) {
        // The reader has seen enough.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        written => Ok(written?),
    }
}
