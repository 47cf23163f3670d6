//! Contact dynamics, slip prediction and the wire protocol of stickslip.
//!
//! One source for the gripper's microcontroller and for the host: no_std, no allocation,
//! no panic on any input, the same bits on both sides.

#![forbid(unsafe_code)]

pub mod effects;
pub mod lcp;
pub mod model;
pub mod real;
