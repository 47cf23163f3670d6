//! Tests of the crate from outside, in one program: it links once.

mod balance;
mod bristles;
mod common;
mod effects;
mod files;
mod slip;
