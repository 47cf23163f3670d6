//! Tests of the crate from outside, in one program: it links once.

#[cfg(target_os = "linux")]
mod bus;
#[cfg(not(feature = "foxglove"))]
mod no_server;
mod recorded;
#[cfg(feature = "foxglove")]
mod server;
mod source;
mod state;
mod view;
