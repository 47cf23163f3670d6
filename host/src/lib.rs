//! Host side of stickslip: data sets, replay, streaming, comparison, diagnosis.

pub mod channels;
pub mod commands;
pub mod compare;
pub mod dataset;
pub mod output;
pub mod phases;
pub mod replay;
pub mod report;
pub mod rig;
pub mod simulate;
