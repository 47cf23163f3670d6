//! Marks where parts of a tick begin and end, so that their instructions can be counted on
//! the emulated board (`stickslip cost`). Without the feature `probe` a mark is nothing.

/// A part of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A time step, all of it.
    Step,
    /// Within a step: where the bodies touch, and what the effects change there.
    Contacts,
    /// Within a step: forces and velocity.
    Cone,
}

/// Ends its part where it is dropped.
#[must_use]
pub struct Span(#[cfg_attr(not(feature = "probe"), allow(dead_code))] Part);

/// Begins a part.
#[inline(always)]
pub fn span(part: Part) -> Span {
    #[cfg(feature = "probe")]
    hook::call(part, hook::Edge::Begin);
    Span(part)
}

#[cfg(feature = "probe")]
impl Drop for Span {
    #[inline(always)]
    fn drop(&mut self) {
        hook::call(self.0, hook::Edge::End);
    }
}

#[cfg(feature = "probe")]
pub use hook::{Edge, watch};

#[cfg(feature = "probe")]
mod hook {
    use super::Part;
    use core::cell::Cell;
    use critical_section::Mutex;

    /// Which end of a part.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Edge {
        /// It begins.
        Begin,
        /// It has ended.
        End,
    }

    type Hook = fn(Part, Edge);
    static HOOK: Mutex<Cell<Option<Hook>>> = Mutex::new(Cell::new(None));

    /// Calls `hook` at every mark from now on.
    pub fn watch(hook: fn(Part, Edge)) {
        critical_section::with(|cs| HOOK.borrow(cs).set(Some(hook)));
    }

    #[inline(never)]
    pub(super) fn call(part: Part, edge: Edge) {
        if let Some(hook) = critical_section::with(|cs| HOOK.borrow(cs).get()) {
            hook(part, edge);
        }
    }
}
