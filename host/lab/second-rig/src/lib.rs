//! An independent second reality: a rigid object between viscoelastic pads whose bristles slide one
//! after the other, and the plans, hidden effects, sensors and files around it. It writes data sets
//! in the format `stickslip-dataset/1` and shares no code with the other crates.
//!
//! See `docs/lab/second-rig.md` for equations, distributions and limits.

pub mod dataset;
pub mod families;
pub mod hidden;
pub mod physics;
pub mod plan;
pub mod random;
pub mod reality;
pub mod sensors;
pub mod trial;
pub mod write;

use std::path::PathBuf;

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No such effect.
    #[error("no hidden effect is called '{0}'; `stickslip-second-rig effects` lists them")]
    UnknownEffect(String),
    /// No such family.
    #[error("no family is called '{0}'; `stickslip-second-rig families` lists them")]
    UnknownFamily(String),
    /// A strength that is no number.
    #[error("--effect {0}: write NAME or NAME=LEVEL, the level a positive number (1 is typical)")]
    BadEffect(String),
    /// The key would give the answer away.
    #[error("the key {0} lies inside the data set; choose a file outside it")]
    KeyInside(PathBuf),
    /// A file.
    #[error("cannot write {path}: {source}")]
    Write {
        /// Where.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A table.
    #[error("cannot write a table: {0}")]
    Csv(#[from] csv::Error),
    /// dataset.toml.
    #[error("cannot write dataset.toml: {0}")]
    Toml(#[from] toml::ser::Error),
    /// The key.
    #[error("cannot write the key: {0}")]
    Json(#[from] serde_json::Error),
}
