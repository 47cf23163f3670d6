//! Contact dynamics, slip prediction and the wire protocol of stickslip.
//!
//! One source for the gripper's microcontroller and for the host: no_std, no allocation,
//! no panic on any input, the same bits on both sides.
//!
//! From the bottom up: [`real`] the scalar, [`effect`] and [`formula`] effects as data, [`model`]
//! what is known and what is calibrated, [`shape`] rigid bodies, [`state`] what a step changes and
//! what is imposed on it, [`contact`] where bodies touch, [`solve`] what a contact problem is,
//! [`cone`] its forces with the exact cone, [`lcp`] as complementarity, [`effects`] the laws that may
//! be added to the base model, [`step`] the time step. No module imports one above it.
#![no_std]
#![forbid(unsafe_code)]

pub mod angle;
pub mod cone;
pub mod contact;
pub mod effect;
pub mod effects;
pub mod formula;
pub mod health;
pub mod lcp;
mod linear;
pub mod model;
pub mod observer;
pub mod on_board;
pub mod predictor;
pub mod probe;
pub mod program;
pub mod real;
pub mod rotation;
pub mod shape;
pub mod solve;
pub mod state;
pub mod step;
pub mod track;
pub mod tuning;
mod window;
pub mod wire;
mod work;
