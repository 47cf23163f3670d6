//! The contact problem of a step, solved as the model asks: with the exact cone or with friction pyramids.
//!
//! Pyramids need the feature `pyramids`, and 30 KiB of a board's flash. A build without it refuses models that
//! ask for them (`predictor::validate`); the step itself would solve the cone and mark it.

use crate::cone;
#[cfg(feature = "pyramids")]
use crate::lcp::step::Workspace as Pyramids;
use crate::lcp::step::{Past, PyramidParams};
use crate::model::Formulation;
use crate::real::Real;
use crate::solve::{Answer, Bodies, ContactPoint, DOF, SolveBudget, Solved};
#[cfg(feature = "pyramids")]
use crate::solve::{FIXED_POINTS, LEAST_WORK, PYRAMIDS_COST, SolveStatus, USUAL_POINTS};

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
    #[cfg(feature = "pyramids")]
    pub pyramids: Pyramids<R, NC>,
    formulation: Formulation,
}

impl<R: Real, const NC: usize> Solver<R, NC> {
    // Built in place: it is larger than all else in a tick.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            cone: cone::Workspace::new(),
            #[cfg(feature = "pyramids")]
            pyramids: Pyramids::new(),
            formulation: Formulation::Cone,
        }
    }

    /// Begins a problem of `bodies`, without points.
    pub fn begin(&mut self, formulation: Formulation, bodies: &Bodies<R>) {
        self.formulation = formulation;
        self.cone.begin(bodies);
        #[cfg(feature = "pyramids")]
        self.pyramids.forget();
    }

    /// Adds a point, and what it did in the step before.
    #[inline(always)]
    pub fn add(&mut self, point: &ContactPoint<R>, past: Past<R>) {
        // The capacities are that of the contacts: these cannot fail.
        #[cfg(feature = "pyramids")]
        if self.formulation == Formulation::Lcp {
            self.pyramids.add(point, Some(past));
            return;
        }
        self.cone.add(point);
        self.cone.expect(past.before);
    }

    /// Solves for the velocity at the end of the step, from `guess`: with pyramids where they are asked for, and
    /// with the cone where they are not solved within half of the work, or where there is none for both
    /// ([`SolveBudget::cone_instead`]).
    #[inline(never)]
    #[cfg_attr(not(feature = "pyramids"), expect(unused_variables))]
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
        #[cfg(feature = "pyramids")]
        {
            let (price, unit) = price(self.pyramids.count());
            // Half of the work, or what the cone's least leaves of it.
            let share = match budget.cone_instead {
                true => (budget.max_work / 2).min(budget.max_work.saturating_sub(LEAST_WORK)),
                false => budget.max_work,
            };
            let max_work = (share * unit / price).saturating_sub(SETUP_WORK);
            if budget.cone_instead && max_work < LEAST_PYRAMIDS_WORK {
                self.hand_over();
                return (self.cone.solve(bodies, guess, budget), SolvedBy::ConeInstead);
            }
            let bounded = SolveBudget { max_work, ..*budget };
            let mut first = self.pyramids.solve(bodies, guess, &bounded, params, &mut self.cone.kept);
            first.iterations = (first.iterations * price).div_ceil(unit);
            first.evaluations = ((first.evaluations + SETUP_WORK) * price).div_ceil(unit);
            if first.status == SolveStatus::Solved || !budget.cone_instead {
                return (first, SolvedBy::Pyramids);
            }
            self.hand_over();
            let left = budget.max_work.saturating_sub(first.work());
            let mut second = self.cone.solve(bodies, guess, &budget.within(left));
            second.iterations = second.iterations.saturating_add(first.iterations);
            second.evaluations = second.evaluations.saturating_add(first.evaluations);
            (second, SolvedBy::ConeInstead)
        }
        #[cfg(not(feature = "pyramids"))]
        (self.cone.solve(bodies, guess, budget), SolvedBy::ConeInstead)
    }

    /// Gives the cone the points of the pyramids.
    #[cfg(feature = "pyramids")]
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
        #[cfg(feature = "pyramids")]
        let pyramids = self.pyramids.answers();
        #[cfg(not(feature = "pyramids"))]
        let pyramids: &[Answer<R>] = &[];
        // Only one of the two has any. One loop for both: its body is large where it is used.
        let count = self.cone.count().max(pyramids.len());
        (0..count).filter_map(move |k| pyramids.get(k).copied().or_else(|| self.cone.answer(k)))
    }

    /// Forgets the points, and what they answered.
    pub fn forget(&mut self) {
        self.cone.forget();
        #[cfg(feature = "pyramids")]
        self.pyramids.forget();
    }
}

/// What the pyramids' rows and answers cost beyond the cone's whatever is solved, in their units.
#[cfg(feature = "pyramids")]
const SETUP_WORK: u32 = 1;

/// With less work pyramids are not tried: a balance where nothing changes, and one factorisation where something does.
#[cfg(feature = "pyramids")]
const LEAST_PYRAMIDS_WORK: u32 = 6;

/// What so many units of the pyramids' work cost, in so many of the cone's: all of it goes with the number of points, the
/// cone's has a part that does not.
#[cfg(feature = "pyramids")]
fn price(points: usize) -> (u32, u32) {
    let points = (points as u32).max(USUAL_POINTS);
    (PYRAMIDS_COST * points * (USUAL_POINTS + FIXED_POINTS), USUAL_POINTS * (points + FIXED_POINTS))
}
