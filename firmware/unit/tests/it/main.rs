//! Tests of the crate from outside, in one program: it links once.

mod ati;
mod bench;
mod bus;
mod deadline;
mod fingers;
mod flash;
mod ft300;
mod host_clock;
mod hub;
mod lines;
mod link;
mod memory;
mod outputs;
mod post_mortem;
mod runs;
mod simulated;
mod stored;
mod upload;
