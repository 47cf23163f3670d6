//! Every plot of a page as an SVG file and, with the feature `png`, as a PNG file.

use std::path::Path;

use anyhow::Context;
use stickslip_data::Stage;

use crate::plot::Chart;

/// A plot and the name of its file.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Of the file, without ending.
    pub name: String,
    /// The `<svg>` element.
    pub svg: String,
}

impl Figure {
    /// A chart under `name`; what cannot stand in a file's name becomes a hyphen.
    #[must_use]
    pub fn of(name: &str, chart: &Chart) -> Self {
        Figure::new(name, chart.svg())
    }

    /// A drawing under `name`.
    #[must_use]
    pub fn new(name: &str, svg: String) -> Self {
        let safe = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' };
        let name: String = name.to_lowercase().chars().map(safe).collect();
        let words: Vec<&str> = name.split('-').filter(|w| !w.is_empty()).collect();
        Figure { name: words.join("-"), svg }
    }

    /// The drawing as a document of its own: on white, with its size.
    fn document(&self) -> Option<String> {
        let inside = self.svg.trim().strip_prefix("<svg")?;
        let size = inside.split_once("viewBox=\"0 0 ")?.1.split_once('"')?.0;
        let (wide, high) = size.split_once(' ')?;
        let (head, rest) = inside.split_once('>')?;
        Some(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{wide}\" height=\"{high}\" font-family=\"sans-serif\"{head}>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{rest}\n"
        ))
    }
}

/// What the files are.
pub const KINDS: &str = if cfg!(feature = "png") { "SVG and PNG" } else { "SVG (built without PNG)" };

/// Writes each of `figures` into `folder`, which appears whole or not at all.
///
/// # Errors
/// A folder with content; what cannot be drawn or written.
pub fn write(folder: &Path, figures: &[Figure]) -> anyhow::Result<()> {
    let stage = Stage::begin(folder)?;
    #[cfg(feature = "png")]
    let painter = crate::png::Painter::new();
    for figure in figures {
        let document = figure.document().with_context(|| format!("{}: it has no size", figure.name))?;
        let put = |kind: &str, content: &[u8]| {
            let at = stage.folder().join(format!("{}.{kind}", figure.name));
            std::fs::write(&at, content).with_context(|| format!("cannot write {}", at.display()))
        };
        put("svg", document.as_bytes())?;
        #[cfg(feature = "png")]
        put("png", &painter.png(&document).with_context(|| format!("{}: as PNG", figure.name))?)?;
    }
    Ok(stage.finish()?)
}
