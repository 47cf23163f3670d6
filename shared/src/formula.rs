//! A user's formula as plain data: checked programs, and what their result changes. The law that
//! it is in a step is in [`crate::effects::formula`].

use crate::program::{FormulaError, Op, Program};
use crate::real::Real;
use serde::{Deserialize, Serialize};

/// What the result changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Target {
    /// Factor on the friction coefficient of the chosen bodies.
    Friction,
    /// Factor on the grip force.
    Grip,
    /// Force on the object along carrier X, N.
    ForceX,
    /// Force on the object along carrier Y, N.
    ForceY,
    /// Force on the object along carrier Z, N.
    ForceZ,
}

/// Checked programs and what they act on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub struct Formula<R: Real> {
    /// What the result changes.
    pub target: Target,
    /// For friction: bit [`crate::contact::Body::index`] set where it applies.
    pub bodies: u8,
    /// What it gives.
    pub program: Program<R>,
    /// What it remembers next; empty where it has no memory.
    pub state: Program<R>,
}

impl<R: Real> Formula<R> {
    /// All bodies.
    pub const ALL_BODIES: u8 = 0b1111;

    /// A formula without memory.
    ///
    /// # Errors
    /// Programs that do not leave exactly one value or break a limit.
    pub fn new(target: Target, bodies: u8, ops: &[Op<R>]) -> Result<Self, FormulaError> {
        Ok(Self { target, bodies, program: Program::new(ops)?, state: Program::none() })
    }

    /// The same formula with a memory whose next value is `ops`.
    ///
    /// # Errors
    /// As [`Formula::new`].
    pub fn with_state(self, ops: &[Op<R>]) -> Result<Self, FormulaError> {
        Ok(Self { state: Program::new(ops)?, ..self })
    }

    /// The same formula in another scalar.
    pub fn cast<S: Real>(&self) -> Formula<S> {
        let (program, state) = (self.program.cast(), self.state.cast());
        Formula { target: self.target, bodies: self.bodies, program, state }
    }

    /// Whether it can run: it may have come over a wire.
    ///
    /// # Errors
    /// The first program that cannot.
    pub fn check(&self) -> Result<(), FormulaError> {
        self.program.check()?;
        if self.remembers() { self.state.check() } else { Ok(()) }
    }

    /// Whether it has a memory.
    pub fn remembers(&self) -> bool {
        !self.state.0.is_empty()
    }
}
