//! The one place where effects are listed. To add one: write its file beside this one and
//! append a line here, with a number that was never used (it goes over the wire).

use super::{Info, Law, static_friction};
use crate::real::Real;

macro_rules! registry {
    ($($code:literal => $module:ident :: $law:ident),* $(,)?) => {
        /// Descriptions of all effects.
        pub static REGISTRY: &[&Info] = &[$(&$module::INFO),*];

        /// The law with this code; `None` where there is none.
        pub fn law<R: Real>(code: u8) -> Option<&'static dyn Law<R>> {
            match code {
                $($code => Some(&$module::$law),)*
                _ => None,
            }
        }
    };
}

registry! {
    1 => static_friction::StaticFriction,
}
