//! In place of the server, where the program was built without it: it cannot be started, and the reason says how to
//! get it.

use anyhow::bail;

use crate::event::Event;
use crate::state::{Alarm, State};

/// A server that there is none of.
pub enum Server {}

impl Server {
    /// Refuses.
    ///
    /// # Errors
    /// Always, with the remedy.
    pub fn start(_address: &str) -> anyhow::Result<Self> {
        bail!(
            "this stickslip was built without the server for Foxglove (--no-default-features): build it with the \
             feature `foxglove`, which is on by default: cargo install --path host/cli"
        )
    }

    /// The port of none.
    #[must_use]
    pub fn port(&self) -> u16 {
        match *self {}
    }

    /// The viewers of none.
    #[must_use]
    pub fn viewers(&self) -> usize {
        match *self {}
    }

    /// Sends to nobody.
    ///
    /// # Errors
    /// None.
    pub fn publish(&mut self, _event: &Event, _state: &State, _raised: &[Alarm]) -> anyhow::Result<()> {
        match *self {}
    }
}
