//! Tests of the crate from outside, in one program: it links once.

mod command_line;
#[path = "../../../cli/tests/it/common.rs"]
mod common;
mod degraded;
mod detectors;
mod diagnose_detection;
mod diagnose_inputs;
mod held;
mod hostile_input;
mod house;
mod keys_of_others;
mod lab_bad_input;
mod lcp_solvers;
mod mujoco_export;
mod prediction_bits;
mod probabilities;
mod published;
mod search;
mod worst_cases;
