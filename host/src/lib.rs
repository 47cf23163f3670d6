//! Host side of stickslip: data sets, replay, streaming, comparison, diagnosis.

pub mod dataset;
pub mod lcp_files;
pub mod lcp_gen;
