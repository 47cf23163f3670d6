//! What the commands print: text and tables for people, or one JSON document (`--json`).
//!
//! Results go to stdout; progress, notes and errors to stderr. A closed pipe
//! (`stickslip ... | head`) ends the program quietly.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anyhow::Context;
use comfy_table::{ContentArrangement, Table, presets};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use stickslip_analysis::Progress;
use stickslip_analysis::left_out::{self, LeftOut};

use crate::figures::{self, Figure};

/// For whom is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Text, tables and progress bars.
    Human,
    /// One JSON document on stdout.
    Json,
}

/// Where a command prints its results.
#[derive(Debug)]
pub struct Output {
    style: Style,
    schema: Option<String>,
    document_printed: AtomicBool,
    refused: Mutex<BTreeSet<String>>,
    /// Of the computation that is under way.
    bar: Mutex<Option<ProgressBar>>,
}

/// A bar on stderr for each stage; gone as soon as something is printed.
impl Progress for Output {
    fn begin(&self, stage: &'static str, steps: usize) {
        self.finish_bar();
        let new = self.progress(steps as u64, stage);
        *self.bar.lock().unwrap_or_else(PoisonError::into_inner) = Some(new);
    }

    fn step(&self, steps: usize) {
        if let Some(bar) = self.bar.lock().unwrap_or_else(PoisonError::into_inner).as_ref() {
            bar.inc(steps as u64);
        }
    }
}

impl Output {
    /// Prints in `style`.
    #[must_use]
    pub fn new(style: Style) -> Self {
        Output {
            style,
            schema: None,
            document_printed: AtomicBool::new(false),
            refused: Mutex::default(),
            bar: Mutex::default(),
        }
    }

    /// The same for the program and command `name`: its documents say `"schema": "<name>/1"`
    /// first, where they do not bring a schema of their own.
    #[must_use]
    pub fn of(self, name: &str) -> Self {
        Output { schema: Some(format!("{name}/1")), ..self }
    }

    /// The chosen style.
    #[must_use]
    pub fn style(&self) -> Style {
        self.style
    }

    /// A line of text for people; nothing with `--json`.
    pub fn text(&self, text: impl Display) {
        if self.style == Style::Human {
            self.finish_bar();
            print_line(&mut io::stdout().lock(), text);
        }
    }

    /// A table for people; nothing with `--json`. See [`table`].
    pub fn table(&self, table: &Table) {
        // comfy-table pads the last column: no trailing blanks in what users copy.
        let text = table.to_string();
        let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
        self.text(lines.join("\n"));
    }

    /// A remark on stderr in both styles: it is no part of the result.
    pub fn note(&self, text: impl Display) {
        self.finish_bar();
        print_line(&mut io::stderr().lock(), format_args!("note: {text}"));
    }

    /// Data that were refused while the command goes on with the rest: listed once on stderr, and
    /// the exit code is 1 in the end ([`Output::exit_code`]).
    pub fn refused(&self, what: impl Display) {
        let text = what.to_string();
        if self.refused.lock().unwrap_or_else(PoisonError::into_inner).insert(text.clone()) {
            self.finish_bar();
            print_line(&mut io::stderr().lock(), format_args!("refused: {text}"));
        }
    }

    /// The command's JSON document; nothing for people. Call it once.
    ///
    /// # Errors
    /// Where `document` cannot be written as JSON.
    pub fn document<T: Serialize + ?Sized>(&self, document: &T) -> anyhow::Result<()> {
        if self.style == Style::Json {
            let printed = self.document_printed.swap(true, Ordering::Relaxed);
            debug_assert!(!printed, "one JSON document a command");
            print_line(&mut io::stdout().lock(), with_schema(self.schema.as_deref(), document)?);
        }
        Ok(())
    }

    /// How many trials of how many a result leaves out, and why; `more` says where all are listed.
    pub fn left_out(&self, trials: &[LeftOut], all: usize, more: &str) {
        if let Some(sentence) = left_out::sentence(trials, all) {
            self.text(format_args!("{sentence} ({more})"));
        }
    }

    /// What was refused until now; see [`Output::refused`].
    #[must_use]
    pub fn all_refused(&self) -> Vec<String> {
        self.refused.lock().unwrap_or_else(PoisonError::into_inner).iter().cloned().collect()
    }

    /// The command that comes next, as a line to copy; nothing with `--json`.
    pub fn next<'w>(&self, words: impl IntoIterator<Item = &'w str>) {
        self.text(format_args!("\nNext:\n  {}", command_line(words)));
    }

    /// Writes a self-contained page and says where it is.
    ///
    /// # Errors
    /// Where `path` cannot be written.
    pub fn page(&self, path: &Path, html: impl AsRef<[u8]>) -> anyhow::Result<()> {
        stickslip_data::write_file(path, html).with_context(|| format!("cannot write {}", path.display()))?;
        self.note(format_args!("page written to {}", path.display()));
        Ok(())
    }

    /// Writes plots into a new folder and says where it is.
    ///
    /// # Errors
    /// As [`figures::write`].
    pub fn figures(&self, folder: &Path, drawn: &[Figure]) -> anyhow::Result<()> {
        figures::write(folder, drawn)?;
        let kinds = figures::KINDS;
        self.note(format_args!("{} figures written to {} as {kinds}", drawn.len(), folder.display()));
        Ok(())
    }

    /// A progress bar on stderr over `length` steps; hidden with `--json` or without a terminal.
    #[must_use]
    pub fn progress(&self, length: u64, what: &'static str) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(Some(length), self.draw_target());
        let style =
            ProgressStyle::with_template("{msg:<16} [{bar:30}] {human_pos}/{human_len} {per_sec} {eta}");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what);
        bar
    }

    /// A spinner on stderr for work of unknown length; hidden like [`Output::progress`].
    #[must_use]
    pub fn spinner(&self, what: &'static str) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(None, self.draw_target());
        bar.set_message(what);
        bar.enable_steady_tick(Duration::from_millis(120));
        bar
    }

    /// Prints `error: ...` with its causes on stderr; with `--json` also as the document,
    /// where the command printed none.
    pub fn error(&self, error: &anyhow::Error) {
        self.finish_bar();
        print_line(&mut io::stderr().lock(), format_args!("error: {}", chain(error).join(": ")));
        if self.style == Style::Json && !self.document_printed.load(Ordering::Relaxed) {
            let document = serde_json::json!({ "error": chain(error) });
            // A document of strings can always be written.
            let _ = self.document(&document);
        }
    }

    /// Reports a command's error. Exit code 0: done; 1: the command failed, or data were refused.
    #[must_use]
    pub fn exit_code(&self, result: &anyhow::Result<()>) -> ExitCode {
        let refused = self.refused.lock().unwrap_or_else(PoisonError::into_inner).len();
        match result {
            Ok(()) if refused > 0 => {
                let what = format!("{refused} refused, see above; the result is that of the rest");
                print_line(&mut io::stderr().lock(), format_args!("error: {what}"));
                ExitCode::FAILURE
            }
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                self.error(error);
                ExitCode::FAILURE
            }
        }
    }

    fn finish_bar(&self) {
        if let Some(bar) = self.bar.lock().unwrap_or_else(PoisonError::into_inner).take() {
            bar.finish_and_clear();
        }
    }

    fn draw_target(&self) -> ProgressDrawTarget {
        if self.style == Style::Human && io::stderr().is_terminal() {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        }
    }
}

/// `stickslip` with these words, quoted as a shell needs it.
#[must_use]
pub fn command_line<'w>(words: impl IntoIterator<Item = &'w str>) -> String {
    let quoted = words.into_iter().map(|w| shlex::try_quote(w).unwrap_or_else(|_| w.into()));
    quoted.fold("stickslip".to_owned(), |line, word| line + " " + &word)
}

/// The JSON of a document with its schema as the first key; rows become `results`.
///
/// # Errors
/// Where `document` cannot be written as JSON.
pub fn with_schema<T: Serialize + ?Sized>(schema: Option<&str>, document: &T) -> anyhow::Result<String> {
    #[derive(Serialize)]
    struct Object<'a, T: ?Sized> {
        schema: &'a str,
        #[serde(flatten)]
        document: &'a T,
    }
    #[derive(Serialize)]
    struct Rows<'a, T: ?Sized> {
        schema: &'a str,
        results: &'a T,
    }
    use serde_json::Value;
    Ok(match (schema, serde_json::to_value(document)?) {
        (Some(schema), Value::Object(keys)) if !keys.contains_key("schema") => {
            serde_json::to_string_pretty(&Object { schema, document })?
        }
        (Some(schema), Value::Array(_)) => serde_json::to_string_pretty(&Rows { schema, results: document })?,
        _ => serde_json::to_string_pretty(document)?,
    })
}

/// A table with `header`, in the one look that all commands share.
#[must_use]
pub fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table
        .load_preset(presets::ASCII_MARKDOWN)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(header);
    table
}

/// The error and its causes; a cause that its error already tells is left out.
#[must_use]
pub fn chain(error: &anyhow::Error) -> Vec<String> {
    let mut told: Vec<String> = Vec::new();
    for cause in error.chain().map(ToString::to_string) {
        if !told.last().is_some_and(|last| last.contains(&cause)) {
            told.push(cause);
        }
    }
    told
}

fn print_line(stream: &mut impl Write, text: impl Display) {
    if let Err(error) = writeln!(stream, "{text}")
        && error.kind() == io::ErrorKind::BrokenPipe
    {
        // The reader has seen enough.
        std::process::exit(0);
    }
}
