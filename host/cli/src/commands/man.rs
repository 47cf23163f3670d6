//! `stickslip man DIR`: a page for `man` of each command, from what `--help` prints.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Command;
use clap_mangen::Man;
use schemars::JsonSchema;
use serde::Serialize;
use stickslip_data::Stage;
use stickslip_report::terminal::Output;

/// Arguments of `stickslip man`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  stickslip man ~/.local/share/man/man1
  man stickslip-diagnose")]
pub struct Args {
    /// Folder to write the pages into; made where it does not exist
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Pages for `man` that were written.
#[derive(JsonSchema, Serialize)]
pub(super) struct Report<'a> {
    /// Their folder.
    folder: &'a Path,
    /// Their files.
    pages: Vec<String>,
}

/// Writes a page for `command` and each below it.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn run(args: &Args, command: Command, output: &Output) -> anyhow::Result<()> {
    let folder = &args.folder;
    let at = || folder.display().to_string();
    let mut command = command.disable_help_subcommand(true);
    // Names of pages, `stickslip-board-info`, and of commands as they are typed.
    command.build();
    let mut pages = Vec::new();
    let stage = Stage::within(folder)?;
    write(&command, stage.folder(), &mut pages).with_context(at)?;
    stage.finish()?;
    output.text(format_args!("{} pages in {}", pages.len(), folder.display()));
    output.document(&Report { folder, pages })
}

/// The page of `command` and those below it.
fn write(command: &Command, folder: &Path, pages: &mut Vec<String>) -> std::io::Result<()> {
    let man = Man::new(command.clone());
    let file = man.get_filename();
    let mut page = Vec::new();
    man.render(&mut page)?;
    std::fs::write(folder.join(&file), examples_as_they_are(&String::from_utf8_lossy(&page)))?;
    pages.push(file);
    command.get_subcommands().try_for_each(|below| write(below, folder, pages))
}

/// Lines of examples begin with spaces: they are not filled and hyphenated as text is, so that they can be copied.
fn examples_as_they_are(page: &str) -> String {
    let mut out = String::with_capacity(page.len() + 64);
    let mut example = false;
    for line in page.lines() {
        let next = line.starts_with("  ");
        if next != example {
            out.push_str(if next { ".nf\n" } else { ".fi\n" });
        }
        example = next;
        out.push_str(line);
        out.push('\n');
    }
    out.push_str(if example { ".fi\n" } else { "" });
    out
}
