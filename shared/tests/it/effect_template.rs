//! The template that a new effect is copied from (`docs/adding-an-effect.md`) compiles as it stands,
//! against the crate as it is, and the test in it passes.

use crate::effects::effect_template::INFO;

#[test]
fn the_templates_number_and_name_are_free() {
    for listed in stickslip_shared::effects::REGISTRY {
        assert!(listed.code != INFO.code && listed.id != INFO.id, "{}", listed.id);
    }
    for p in INFO.parameters {
        assert!((p.low..=p.high).contains(&p.typical) && (p.low..=p.high).contains(&p.neutral), "{}", p.name);
    }
}
