//! The mechanics: one free rigid body between patches of bristles on viscoelastic foundations.

pub mod body;
pub mod foundation;
pub mod friction;
pub mod jaw;
pub mod layout;
pub mod motion;
pub mod patch;
pub mod record;
pub mod slip;
pub mod surface;
pub mod world;
