//! The `stickslip` command: what users run, one module a command.

pub mod commands;
pub mod grip_loop;
pub mod interrupt;
pub mod moving;
