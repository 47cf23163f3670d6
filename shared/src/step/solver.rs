//! The contact problem of a step, solved as the model asks: with the exact cone or with friction pyramids.

use crate::cone;
use crate::lcp::step::{Past, PyramidParams, Workspace as Pyramids};
use crate::model::Formulation;
use crate::real::Real;
use crate::solve::{Answer, Bodies, ContactPoint, DOF, SolveBudget, SolveStatus, Solved};

/// What a unit of work of the pyramids costs, in the cone's: `make cost` counts 5,000 instructions for a kink or an
/// evaluation and 20,000 for a factorisation with what belongs to it.
const PYRAMIDS_COST: u32 = 2;

/// Which formulation the forces of a step come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolvedBy {
    /// The exact cone, as the model asks.
    #[default]
    Cone,
    /// Friction pyramids, as the model asks.
    Pyramids,
    /// The exact cone, because pyramids were not solved within their part of the budget.
    ConeInstead,
}

/// Working memory of both.
#[derive(Clone, Debug)]
pub(super) struct Solver<R: Real, const NC: usize> {
    pub cone: cone::Workspace<R, NC>,
    pub pyramids: Pyramids<R, NC>,
    formulation: Formulation,
}

impl<R: Real, const NC: usize> Solver<R, NC> {
    // Built in place: it is larger than all else in a tick.
    #[inline(always)]
    pub fn new() -> Self {
        Self { cone: cone::Workspace::new(), pyramids: Pyramids::new(), formulation: Formulation::Cone }
    }

    /// Begins a problem of `bodies`, without points.
    pub fn begin(&mut self, formulation: Formulation, bodies: &Bodies<R>) {
        self.formulation = formulation;
        self.cone.begin(bodies);
        self.pyramids.forget();
    }

    /// Adds a point, and what it did in the step before.
    #[inline(always)]
    pub fn add(&mut self, point: &ContactPoint<R>, past: Past<R>) {
        // The capacities are that of the contacts: these cannot fail.
        match self.formulation {
            Formulation::Cone => {
                self.cone.add(point);
                self.cone.expect(past.before);
            }
            Formulation::Lcp => self.pyramids.add(point, Some(past)),
        }
    }

    /// Solves for the velocity at the end of the step, from `guess`.
    #[inline(never)]
    pub fn solve(
        &mut self,
        bodies: &Bodies<R>,
        guess: &[R; DOF],
        budget: &SolveBudget<R>,
        params: &PyramidParams<R>,
    ) -> (Solved<R>, SolvedBy) {
        if self.formulation == Formulation::Cone {
            return (self.cone.solve(bodies, guess, budget), SolvedBy::Cone);
        }
        // Half of the work at most: the cone may have to be solved in their place.
        let bounded = budget.within(budget.work() / 2 / PYRAMIDS_COST);
        let mut first = self.pyramids.solve(bodies, guess, &bounded, params);
        first.iterations = first.iterations.saturating_mul(PYRAMIDS_COST);
        first.evaluations = first.evaluations.saturating_mul(PYRAMIDS_COST);
        if first.status == SolveStatus::Solved {
            return (first, SolvedBy::Pyramids);
        }
        self.hand_over();
        let left = budget.work().saturating_sub(first.work());
        let mut second = self.cone.solve(bodies, guess, &budget.within(left));
        second.iterations = second.iterations.saturating_add(first.iterations);
        second.evaluations = second.evaluations.saturating_add(first.evaluations);
        (second, SolvedBy::ConeInstead)
    }

    /// Gives the cone the points of the pyramids.
    #[cold]
    #[inline(never)]
    fn hand_over(&mut self) {
        for (point, before) in self.pyramids.points() {
            self.cone.add(point);
            if let Some(before) = before {
                self.cone.expect(before);
            }
        }
    }

    /// What each point answered, in the order in which they were added.
    #[inline(always)]
    pub fn answers(&self) -> impl Iterator<Item = Answer<R>> {
        // Only one of the two has any. One loop for both: its body is large where it is used.
        let pyramids = self.pyramids.answers();
        let count = self.cone.count().max(pyramids.len());
        (0..count).filter_map(move |k| pyramids.get(k).copied().or_else(|| self.cone.answer(k)))
    }

    /// Forgets the points, and what they answered.
    pub fn forget(&mut self) {
        self.cone.forget();
        self.pyramids.forget();
    }
}
