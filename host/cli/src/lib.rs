//! The `stickslip` command: what users run, one module a command.

pub mod commands;
