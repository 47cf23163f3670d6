//! Naming the physical effect that a contact model lacks.

pub mod campaign;
pub mod features;
pub mod gls;
pub mod noise;
pub mod phases;
pub mod problem;
