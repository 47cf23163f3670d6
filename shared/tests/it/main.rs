//! Tests of the crate from outside, in one program: it links once.

mod alarm;
mod angle;
mod bad_input;
mod checksum;
mod common;
mod cone;
mod decide;
mod effect_template;
mod effects_analytic;
mod effects_neutral_and_typical;
mod faces;
mod falling;
mod formula;
mod free_motion;
mod friction;
mod leaps;
mod lift;
mod linear_push;
mod messages;
mod model_package;
mod no_solution;
mod observer;
mod patches;
mod pivot;
mod planar_push;
mod prediction;
mod pyramids;
mod roll;
mod sag;
mod scenes;
mod seated;
mod selftest;
mod soft;
mod stuck_sensor;
mod support_anisotropy;
mod support_pressure;
mod swap;
mod tuning;
mod unsure;
mod witness;

// What the template of an effect calls `crate::contact`, `crate::real` and `crate::effects`.
pub use stickslip_shared::{contact, real};

/// The template and what it calls `super`.
#[path = "../../../docs"]
pub mod effects {
    pub use stickslip_shared::effects::*;

    #[allow(missing_docs)]
    pub mod effect_template;
}
