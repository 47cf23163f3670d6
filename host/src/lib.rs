//! Host side of stickslip: data sets, replay, streaming, comparison, diagnosis.

pub mod balance;
pub mod channels;
pub mod check;
pub mod commands;
pub mod dataset;
pub mod device;
pub mod import;
pub mod lcp_files;
pub mod lcp_gen;
pub mod log;
pub mod noise;
pub mod diagnose;
pub mod fit;
pub mod lcp_solve;
pub mod motion;
pub mod output;
pub mod rig;
pub mod simulate;
pub mod stages;
