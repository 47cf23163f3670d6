//! Tests of the crate from outside, in one program: it links once.

mod ati;
mod bus;
mod fingers;
mod ft300;
mod host_clock;
mod hub;
mod memory;
mod outputs;
mod post_mortem;
mod simulated;
