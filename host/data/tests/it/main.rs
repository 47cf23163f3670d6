//! Tests of the crate from outside, in one program: it links once.

#[macro_use]
mod rig;

mod bags;
mod clocks;
mod dataset_refusals;
mod dataset_round_trip;
mod imports;
mod long_csv;
mod mapped;
mod memory;
mod published;
mod recordings;
mod schema;
mod separators;
mod series;
