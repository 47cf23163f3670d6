//! Tests of the crate from outside, in one program: it links once.

mod rig_controlled;
mod rig_hidden;
mod rig_physics;
