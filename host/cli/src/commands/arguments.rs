//! Options that several commands have, each described once.

use std::path::PathBuf;

use stickslip_analysis::model::file::model_or_default;
use stickslip_analysis::tuning::{Changed, in_words, tuning_or_default};
use stickslip_report::figures::Figure;
use stickslip_report::terminal::Output;
use stickslip_shared::model::Model;
use stickslip_shared::predictor::Checked;

/// The model that a command predicts with.
#[derive(Debug, clap::Args)]
pub struct PredictsWith {
    /// Contact model [default: hard contact, friction 0.40 (fingers), 0.25 (pusher), 0.30 (support)]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
}

impl PredictsWith {
    /// The model of the file, or the default.
    ///
    /// # Errors
    /// Where the file cannot be read or is wrong.
    pub fn read(&self) -> anyhow::Result<Model<f64>> {
        Ok(model_or_default(self.model.as_deref())?)
    }
}

/// The numbers that a command's predictor has.
#[derive(Debug, clap::Args)]
pub struct TunedBy {
    /// Numbers of the predictor [default: those of `stickslip predictor`, which a board has]
    #[arg(long, value_name = "PREDICTOR.toml")]
    pub predictor: Option<PathBuf>,
}

impl TunedBy {
    /// The numbers of the file, or the defaults.
    ///
    /// # Errors
    /// Where the file cannot be read or is wrong.
    pub fn read(&self) -> anyhow::Result<Checked<f32>> {
        Ok(tuning_or_default(self.predictor.as_deref())?)
    }

    /// As words of a command that comes next.
    pub fn words(&self) -> impl Iterator<Item = String> + '_ {
        self.predictor.iter().flat_map(|p| ["--predictor".to_owned(), p.display().to_string()])
    }
}

/// What differs from the defaults, where anything does.
pub fn told(changed: &[Changed], output: &Output) {
    if !changed.is_empty() {
        output.text(format_args!("predictor: {}", in_words(changed)));
    }
}

/// A recorded trial, and the model that a command predicts it with.
#[derive(Debug, clap::Args)]
pub struct OneTrial {
    /// Folder of the data set (holds dataset.toml)
    pub data: PathBuf,
    /// Trial [default: the first]
    #[arg(long, value_name = "ID")]
    pub trial: Option<String>,
    #[command(flatten)]
    pub with: PredictsWith,
}

/// What is drawn of a report.
#[derive(Debug, clap::Args)]
pub struct Drawn {
    /// Write a page with all plots; it needs no network
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Write every plot as SVG and PNG into a new folder
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
}

impl Drawn {
    /// Whether anything is drawn.
    #[must_use]
    pub fn any(&self) -> bool {
        self.html.is_some() || self.figures.is_some()
    }

    /// Writes what was asked for.
    ///
    /// # Errors
    /// Where a file cannot be written, or the folder has content.
    pub fn write(
        &self,
        output: &Output,
        page: impl FnOnce() -> String,
        figures: impl FnOnce() -> Vec<Figure>,
    ) -> anyhow::Result<()> {
        self.html.as_ref().map_or(Ok(()), |path| output.page(path, page()))?;
        self.figures.as_ref().map_or(Ok(()), |folder| output.figures(folder, &figures()))
    }
}
