//! Tests of the crate from outside, in one program: it links once.

mod check_physics;
mod contact;
mod diagnose_groups;
mod diagnose_posterior;
mod diagnose_statistics;
mod diagnose_verdict;
mod model_against_rig;
mod model_file;
mod module_edges;
mod pads;
mod replay;
mod score;
mod simulated;
mod sparse_pushes;
