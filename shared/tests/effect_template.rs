//! The template that a new effect is copied from (`docs/adding-an-effect.md`) compiles as it stands,
//! against the crate as it is, and the test in it passes.

// What the template calls `crate::contact` and `crate::real`.
pub use stickslip_shared::{contact, real};

/// What it calls `super` and `crate::effects`.
#[path = "../../docs"]
pub mod effects {
    pub use stickslip_shared::effects::*;

    pub mod effect_template;
}

use effects::effect_template::INFO;

#[test]
fn the_templates_number_and_name_are_free() {
    for listed in stickslip_shared::effects::REGISTRY {
        assert!(listed.code != INFO.code && listed.id != INFO.id, "{}", listed.id);
    }
    for p in INFO.parameters {
        assert!((p.low..=p.high).contains(&p.typical) && (p.low..=p.high).contains(&p.neutral), "{}", p.name);
    }
}
