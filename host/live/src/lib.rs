//! What a board predicts, as it happens: for eyes and for programs.
//!
//! [`source`] brings reports from a board, from a board that takes a recorded trial, or from a log played again, and
//! what a board puts on its gripper's bus ([`bus`], Linux);
//! [`state`] keeps what a reader wants to know of them (pure: [`event`]s in, state out); [`view`] draws it in a terminal,
//! [`plain`] says it in a line, [`foxglove`] serves it to viewers (feature `foxglove`; without it the server refuses).

#[cfg(target_os = "linux")]
pub mod bus;
pub mod event;
#[cfg(not(feature = "foxglove"))]
#[path = "no_foxglove.rs"]
pub mod foxglove;
#[cfg(feature = "foxglove")]
pub mod foxglove;
pub mod plain;
pub mod scene;
pub mod source;
pub mod state;
pub mod view;
pub mod words;

/// The longest wait before it is asked whether to stop.
const NAP: std::time::Duration = std::time::Duration::from_millis(50);
/// Where Foxglove looks by default.
pub const FOXGLOVE_ADDRESS: &str = "127.0.0.1:8765";
