//! Studies and developers' tools: what the project checks about itself, beside what users run.

pub mod blind;
pub mod ceilings;
pub mod commands;
pub mod cost;
pub mod curves;
pub mod degrade;
pub mod findings;
pub mod formulations;
pub mod grasps;
pub mod held;
pub mod hunt;
pub mod mujoco;
pub mod planar;
pub mod precision;
#[cfg(feature = "probe")]
pub mod probe;
pub mod reliability;
pub mod steps;
pub mod tribometer;
