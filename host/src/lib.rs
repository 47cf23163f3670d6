//! Host side of stickslip: data sets, replay, streaming, comparison, diagnosis.

pub mod calibrate;
pub mod channels;
pub mod commands;
pub mod dataset;
pub mod findings;
pub mod force_bands;
pub mod import;
pub mod lcp_files;
pub mod lcp_gen;
pub mod lcp_solve;
pub mod motion;
pub mod output;
pub mod rig;
pub mod simulate;
