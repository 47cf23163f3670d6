//! What runs on the gripper, the same for every board.
//!
//! Two priorities: [`control`] runs a tick every 4 ms and never waits for anything but
//! the clock; [`link`] talks to the host below it. [`board`] holds one module a board; what is above its registers
//! and runs on the host as well, tick and link included, is in `stickslip-unit`: here it is joined to clock, lines and tasks.
#![no_std]

pub mod board;
pub mod control;
mod fast;
pub mod link;
mod moves;
pub mod post_mortem;
pub mod queues;
pub mod stack;
pub mod start;
mod state;

/// Bits a second of the link.
pub const BAUD: u32 = 1_000_000;
/// Without a tick for this long the watchdog resets the board.
pub const WATCHDOG_MS: u32 = 100;
