//! What runs on the gripper, the same for every board.
//!
//! Two priorities: [`control`] runs a tick every 4 ms and never waits for anything but
//! the clock; [`link`] talks to the host below it. Between them are queues of fixed size
//! ([`queues`]) whose losses are counted ([`stats`]). [`board`] holds one module a board.
#![no_std]

pub mod board;
pub mod control;
pub mod gauges;
pub mod link;
pub mod queue;
pub mod queues;
pub mod slot;
pub mod source;
pub mod stack;
pub mod state;
pub mod stats;
pub mod upload;

/// Bits a second of the link.
pub const BAUD: u32 = 1_000_000;
/// Without a tick for this long the watchdog resets the board.
pub const WATCHDOG_MS: u32 = 100;
