//! What runs on the gripper, the same for every board.
//!
//! Two priorities: [`control`] runs a tick every 4 ms and never waits for anything but
//! the clock; [`link`] talks to the host below it. Between them are queues of fixed size
//! ([`queues`]) whose losses are counted ([`stats`]). [`board`] holds one module a board; what is above its registers
//! and runs on the host as well is in `stickslip-unit`.
#![no_std]

pub mod board;
pub mod control;
mod fast;
pub mod link;
pub mod post_mortem;
pub mod queue;
pub mod queues;
pub mod sensors;
pub mod slot;
pub mod source;
pub mod stack;
pub mod start;
mod state;
pub mod stats;
pub mod stored;
pub mod upload;

/// Bits a second of the link.
pub const BAUD: u32 = 1_000_000;
/// Without a tick for this long the watchdog resets the board.
pub const WATCHDOG_MS: u32 = 100;
