//! The contact solver, and Lemke's method on the dense form where it fails.
//!
//! The board has no room for the dense form; the host has. `N` is the capacity of the dense
//! solver (at least `6 nc + 2`), `SQUARE` at least `(6 nc)^2`.

use super::contact::ContactSolver;
use super::dense::Dense;
use super::factors::{Factors, Impulses};
use super::{Outcome, Report, SolveStatus, residual, tolerance};
use crate::real::{Real, max};

/// Both solvers, and room for the dense form.
pub struct Fallback<R, const NC: usize, const ND: usize, const N: usize, const SQUARE: usize> {
    /// The first to be asked; keeps the warm start.
    pub contact: ContactSolver<R, NC, ND>,
    dense: Dense<R, N>,
    matrix: [R; SQUARE],
    constant: [R; N],
    answer: Impulses<R, NC, ND>,
}

impl<R: Real, const NC: usize, const ND: usize, const N: usize, const SQUARE: usize> Default
    for Fallback<R, NC, ND, N, SQUARE>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<R: Real, const NC: usize, const ND: usize, const N: usize, const SQUARE: usize>
    Fallback<R, NC, ND, N, SQUARE>
{
    /// Empty working memory.
    pub fn new() -> Self {
        Self {
            contact: ContactSolver::new(),
            dense: Dense::new(),
            matrix: [R::zero(); SQUARE],
            constant: [R::zero(); N],
            answer: Impulses::none(),
        }
    }

    /// Solves by the contact solver, then by the dense one; the better answer is returned.
    pub fn solve(&mut self, problem: &Factors<R, NC, ND>) -> Outcome<'_, Impulses<R, NC, ND>, R> {
        let first = self.contact.solve(problem).report();
        if matches!(first.status, SolveStatus::Solved | SolveStatus::BadInput) {
            return self.contact.last(first);
        }
        let n = problem.unknowns();
        let (Some(m), Some(q)) = (self.matrix.get_mut(..n * n), self.constant.get_mut(..n)) else {
            return self.contact.last(first);
        };
        if !problem.write_dense(m, q) {
            return self.contact.last(first);
        }
        let (z, second) = self.dense.solve(m, q).best();
        let pivots = first.pivots.saturating_add(second.pivots);
        if second.residual < first.residual {
            self.answer.read_unknowns(z, problem);
            // Opposite tangents have been paired: what is returned is judged, not what was found.
            let mut paired = [R::zero(); N];
            let mut residual = R::of(f64::INFINITY);
            if let Some(paired) = paired.get_mut(..n) {
                self.answer.write_unknowns(paired);
                residual = max(residual::dense(m, q, paired).value(), second.residual);
            }
            let status = match second.status {
                SolveStatus::Solved if !(residual <= tolerance()) => SolveStatus::Numerical,
                status => status,
            };
            return Outcome::new(&self.answer, Report { pivots, residual, status, ..second });
        }
        // Both failed; a ray of the dense solver says more than a failure.
        let status = if second.status == SolveStatus::Contradiction {
            SolveStatus::Contradiction
        } else {
            first.status
        };
        self.contact.last(Report { pivots, status, ..first })
    }
}
