//! What measurements show, each notion once: conditions and repetitions, stages and phases of a
//! trial, contact, sensor offsets, pads, noise, balance of the forces, tolerances of a rigid model.

pub mod balance;
pub mod carried;
pub mod conditions;
pub mod contact;
pub mod draws;
pub mod force_bands;
pub mod noise;
pub mod offsets;
pub mod overhang;
pub mod pads;
pub mod phases;
pub mod pose_clock;
pub mod pusher_bias;
pub mod sensors;
pub mod stages;
pub mod statistics;
pub mod tolerance;
