//! Linear complementarity problems: find `z` with `w = M z + q`, `z >= 0`, `w >= 0`, `z'w = 0`.
//!
//! Contact with Coulomb friction, stepped with impulses and friction pyramids (Stewart and
//! Trinkle 1996), is such a problem. Two solvers share one interface and one certificate:
//! [`dense`] solves any `M` (Lemke's method), [`contact`] solves the problem of a few bodies
//! from its factors in the space of their velocities, with a cost linear in the contacts.
//! [`fallback`] joins them. What an answer is worth is said by [`residual`] and by nothing else.

// Small dense arithmetic: one index walks through several arrays of the same const length.
#![allow(clippy::needless_range_loop)]

pub mod contact;
pub mod dense;
pub mod factors;
pub mod fallback;
pub mod residual;
pub mod step;

use crate::real::Real;
pub use crate::solve::{Defect, SolveStatus};

/// Which way an answer was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Nothing to do: `z = 0`, or no attempt was made.
    Trivial,
    /// The active set of the previous problem, verified.
    Warm,
    /// The active set of the previous problem, repaired.
    Repaired,
    /// The velocities followed from open contacts.
    Velocities,
    /// Lemke's pivots on the matrix as given.
    Lemke,
    /// Lemke's pivots after this many restarts on a perturbed matrix.
    Restarted(u8),
}

/// What comes with every answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report<R> {
    /// How it ended.
    pub status: SolveStatus,
    /// What is wrong with the numbers, where that is [`SolveStatus::BadInput`].
    pub defect: Option<Defect>,
    /// Scaled residual (see [`residual`]), or an upper bound of it; dimensionless.
    pub residual: R,
    /// Pivots of Lemke's method, or factorisations in the space of velocities.
    pub pivots: u32,
    /// Which way was taken.
    pub path: Path,
}

/// An answer that cannot be read without deciding what to do when it is none.
#[must_use]
#[derive(Clone, Copy, Debug)]
pub struct Outcome<'a, T: ?Sized, R> {
    answer: &'a T,
    report: Report<R>,
}

impl<R: Real> Report<R> {
    /// No answer yet.
    pub(crate) fn nothing() -> Self {
        let residual = R::of(f64::INFINITY);
        Self { status: SolveStatus::Numerical, defect: None, residual, pivots: 0, path: Path::Trivial }
    }

    /// Refused before solving.
    pub(crate) fn refused(defect: Defect) -> Self {
        Self { status: SolveStatus::BadInput, defect: Some(defect), ..Self::nothing() }
    }
}

impl<'a, T: ?Sized, R: Real> Outcome<'a, T, R> {
    pub(crate) fn new(answer: &'a T, report: Report<R>) -> Self {
        Self { answer, report }
    }

    /// The answer, only where it is certified.
    pub fn solved(&self) -> Option<&'a T> {
        match self.report.status {
            SolveStatus::Solved => Some(self.answer),
            _ => None,
        }
    }

    /// The best answer there is, with the report that marks it.
    pub fn best(&self) -> (&'a T, Report<R>) {
        (self.answer, self.report)
    }

    /// SolveStatus, residual, cost and path.
    pub fn report(&self) -> Report<R> {
        self.report
    }
}

/// Largest scaled residual that counts as solved: 1e-8 in f64. In f32 the rounding of the
/// sums alone is near 1e-6, and 2e-5 is what the solvers can promise.
pub fn tolerance<R: Real>() -> R {
    if R::EPSILON.to_f64() < 1e-12 { R::of(1e-8) } else { R::of(2e-5) }
}
