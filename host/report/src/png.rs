//! SVG drawn by resvg, with a typeface that the program brings: the same picture on every machine.

use std::sync::Arc;

use anyhow::Context;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

/// Pixels for each of the SVG: sharp in print.
const PIXELS: f32 = 2.0;

/// Draws documents.
pub struct Painter {
    options: Options<'static>,
}

impl Painter {
    /// With its one typeface.
    pub fn new() -> Self {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
        let first = fonts.faces().find_map(|face| Some(face.families.first()?.0.clone()));
        let family = first.unwrap_or_default();
        fonts.set_sans_serif_family(family.clone());
        Self { options: Options { fontdb: Arc::new(fonts), font_family: family, ..Options::default() } }
    }

    /// An SVG document as PNG.
    ///
    /// # Errors
    /// What is no SVG, or has no size.
    pub fn png(&self, document: &str) -> anyhow::Result<Vec<u8>> {
        let tree = Tree::from_str(document, &self.options)?;
        let size = tree.size().to_int_size().scale_by(PIXELS).context("it has no size")?;
        let mut pixels = Pixmap::new(size.width(), size.height()).context("it is too large")?;
        resvg::render(&tree, Transform::from_scale(PIXELS, PIXELS), &mut pixels.as_mut());
        Ok(pixels.encode_png()?)
    }
}
