//! Pages that people open from a file, figures, and what commands print.
//!
//! A page is self-contained: nothing is fetched. Its text, tables and static figures need no script; traces
//! and the moving bench are drawn by the script inside it. Colours follow the reader's light or dark setting.

pub mod bars;
pub mod bench;
pub mod compare;
mod conditions;
pub mod data;
pub mod diagnose;
mod diagnosis;
mod experiment;
pub mod figures;
pub mod html;
pub mod import;
mod limits;
pub mod outline;
pub mod overlay;
mod packed;
pub mod plot;
#[cfg(feature = "png")]
mod png;
mod predicted;
pub mod replay;
pub mod score;
pub mod signals;
mod signature;
pub mod terminal;
pub mod viewer;
mod warned;
pub mod words;
