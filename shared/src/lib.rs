//! Contact dynamics, slip prediction and the wire protocol of stickslip.
//!
//! One source for the gripper's microcontroller and for the host: no_std, no allocation,
//! no panic on any input, the same bits on both sides.
//!
//! From the bottom up: [`real`] the scalar, [`shape`] rigid bodies, [`model`] what is
//! known and what is calibrated, [`contact`] where bodies touch, [`solve`] what a
//! contact problem is, [`cone`] its forces with the exact cone, [`lcp`] as complementarity, [`effects`] what may be added to the base model, [`step`] the time
//! step.
#![no_std]
#![forbid(unsafe_code)]

pub mod angle;
pub mod cone;
pub mod contact;
pub mod effects;
pub mod health;
pub mod lcp;
mod look_ahead;
pub mod model;
pub mod observer;
pub mod predictor;
pub mod probe;
pub mod real;
pub mod selftest;
pub mod shape;
pub mod solve;
pub mod step;
pub mod track;
pub mod wire;
mod work;
