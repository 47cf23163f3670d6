//! Complementarity problems on the host: files, generators, and solving with a judge.

pub mod files;
pub mod generate;
pub mod solve;
