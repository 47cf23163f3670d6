//! Tests of the crate from outside, in one program: it links once.

mod recorded;
mod server;
mod source;
mod state;
mod view;
