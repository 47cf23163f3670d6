//! An independent second reality: a rigid object between viscoelastic pads whose bristles slide one
//! after the other, and the plans, hidden effects, sensors and files around it. It writes data sets
//! in the format `stickslip-dataset/1` and shares no code with the other crates.
//!
//! See `docs/lab/second-rig.md` for equations, distributions and limits.

pub mod dataset;
mod error;
pub mod families;
pub mod hidden;
pub mod physics;
pub mod plan;
pub mod random;
pub mod reality;
pub mod scene;
pub mod sensors;
pub mod trial;
pub mod write;

pub use error::Error;
