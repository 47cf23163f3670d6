//! Pages that people open from a file: self-contained HTML with plots as inline SVG.
//!
//! Nothing is fetched, everything works without JavaScript, and colours follow the
//! reader's light or dark setting.

pub mod compare;
pub mod data;
pub mod diagnose;
pub mod html;
pub mod overlay;
pub mod plot;
pub mod replay;
pub mod score;
pub mod signals;
pub mod terminal;
pub mod words;
