//! `stickslip new FILE...`: a first mapping for recordings that nobody described.

use std::path::{Path, PathBuf};

use anyhow::Context;
use schemars::JsonSchema;
use serde::Serialize;

use stickslip_analysis::check::check;
use stickslip_data::import::recording::guess::guess;
use stickslip_data::import::recording::import;
use stickslip_data::{Dataset, Index};
use stickslip_report::import as page;
use stickslip_report::terminal::{Output, command_line};

/// Arguments of `stickslip new`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  stickslip new push.csv\n  stickslip new raw/obj4_r1_ft.csv raw/obj4_r1_mocap.csv --out raw/mapping.toml --html mapping.html"
)]
pub struct Args {
    /// One file of each recording device: CSV, Parquet or MCAP (a ROS 2 bag may be its folder)
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Mapping file to write; must not exist
    #[arg(long, value_name = "MAPPING.toml", default_value = "mapping.toml")]
    out: PathBuf,
    /// Write a page that shows signals and frames as the guesses have them: what is wrong there is to be corrected
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

#[derive(JsonSchema, Serialize)]
/// A mapping file that was written.
pub(super) struct Report<'a> {
    /// The file.
    out: &'a Path,
    /// Lines marked CHECK.
    guesses: usize,
}

/// Looks at the files and writes the mapping.
///
/// # Errors
/// Files that cannot be read, a mapping that exists.
pub fn run(args: &Args, output: &Output) -> anyhow::Result<()> {
    // Files are named relative to the mapping.
    let folder = args.out.parent().unwrap_or(Path::new(""));
    let shown = |file: &PathBuf| match file.strip_prefix(folder) {
        Ok(inside) => Ok(inside.to_owned()),
        Err(_) if folder.as_os_str().is_empty() => Ok(file.clone()),
        Err(_) => std::path::absolute(file).with_context(|| file.display().to_string()),
    };
    let named = args.files.iter().map(shown).collect::<anyhow::Result<Vec<_>>>()?;
    let pairs: Vec<(&Path, &Path)> =
        args.files.iter().zip(&named).map(|(file, named)| (file.as_path(), named.as_path())).collect();
    let text = guess(&pairs)?;
    let mut file = std::fs::File::create_new(&args.out)
        .with_context(|| format!("{}: cannot be made; choose another name with --out", args.out.display()))?;
    if let Err(error) = std::io::Write::write_all(&mut file, text.as_bytes()) {
        // Half a mapping would be taken for a whole one, and could not be written again.
        let _ = std::fs::remove_file(&args.out);
        return Err(error).with_context(|| args.out.display().to_string());
    }
    let guesses = text.matches("CHECK").count();
    output.text(format_args!(
        "mapping written to {}: {guesses} lines marked CHECK are guesses; correct them in an editor, they say what to look at",
        args.out.display()
    ));
    output.document(&Report { out: &args.out, guesses })?;
    let mapping = args.out.display().to_string();
    let next = ["import", "recording", &mapping, "--out", "data", "--html", "data.html"];
    if let Some(path) = &args.html {
        let import = import(&args.out).with_context(|| {
            format!(
                "{mapping} is written, but there is no page yet: correct it, then `{}`",
                command_line(next)
            )
        })?;
        // What physics does not allow is said of the mapping.
        let data = Dataset { folder: args.out.clone(), ..import.dataset.clone() };
        let report = check(&Index::from(data), output);
        output.page(path, page::page("new", &import, &report, &command_line(next)))?;
    }
    output.next(next);
    Ok(())
}
