//! Tests of the crate from outside, in one program: it links once.

mod check_physics;
mod diagnose_statistics;
mod model_against_rig;
mod model_file;
mod module_edges;
mod replay;
mod score;
mod simulated;
