//! Host side of stickslip: data sets, replay, streaming, comparison, diagnosis.

pub mod balance;
pub mod blind;
pub mod channels;
pub mod check;
pub mod commands;
pub mod compare;
pub mod dataset;
pub mod device;
pub mod diagnose;
pub mod expression;
pub mod fit;
pub mod import;
pub mod lcp_files;
pub mod lcp_gen;
pub mod lcp_solve;
pub mod log;
pub mod model_file;
pub mod motion;
pub mod noise;
pub mod output;
pub mod phases;
pub mod replay;
pub mod report;
pub mod rig;
pub mod simulate;
pub mod stages;
