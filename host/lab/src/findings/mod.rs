//! The statements of the paper's results and discussion, checked one by one: what the paper
//! saw, what a synthetic reality of springs and bristles (`rig`) shows, what the hard and
//! what the soft contact model give on the same trials.
//!
//! Kolbert, Chavan-Dafle and Rodriguez, Experimental validation of contact dynamics for
//! in-hand manipulation (ISER 2016). Friction is the middle of the paper's ranges: 0.4 at
//! the fingers, 0.25 at the pusher. Where the paper is ambiguous about the grip force, both
//! readings are shown.

mod finding;
mod pivoting;
mod pushing;
pub mod pyramids;
mod rolling;
mod runs;

pub use finding::{Finding, Outcome};
pub use runs::{Bench, Run};

/// All statements. Runs the rig for about forty trials: some seconds.
///
/// # Errors
/// Where a trial of the rig cannot be made or simulated, which no user input can cause.
pub fn findings() -> anyhow::Result<Vec<Finding>> {
    let mut all = pushing::findings()?;
    all.extend(pivoting::findings()?);
    all.extend(rolling::findings()?);
    Ok(all)
}
