//! The contact problem of a step, solved as the model asks: with the exact cone or with friction pyramids.

use crate::cone::{self, ConeParams, Kept};
use crate::lcp::step::{Past, Paths, Points, PyramidParams};
use crate::model::Formulation;
use crate::real::Real;
use crate::solve::{
    Answer, Bodies, ContactPoint, DOF, FIXED_POINTS, LEAST_WORK, PYRAMIDS_COST, SolveBudget, SolveStatus,
    Solved, USUAL_POINTS,
};

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

/// Working memory of one or the other.
#[derive(Clone, Debug)]
enum Lists<R: Real, const NC: usize> {
    Cone(cone::Workspace<R, NC>),
    Pyramids(Paths<R, NC>),
}

/// Working memory of both, which never solve at a time.
#[derive(Clone, Debug)]
pub(super) struct Solver<R: Real, const NC: usize> {
    /// Factors of the last solve, for the next.
    pub kept: Kept<R>,
    /// How the cone iterates.
    pub params: ConeParams<R>,
    /// Points of the pyramids, which the cone may be asked for instead.
    points: Points<R, NC>,
    lists: Lists<R, NC>,
}

impl<R: Real, const NC: usize> Solver<R, NC> {
    // Built in place: it is larger than all else in a tick.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            kept: Kept::nothing(),
            params: ConeParams::default(),
            points: Points::new(),
            lists: Lists::Cone(cone::Workspace::new()),
        }
    }

    /// Begins a problem of `bodies`, without points.
    pub fn begin(&mut self, formulation: Formulation, bodies: &Bodies<R>) {
        match (formulation, &self.lists) {
            (Formulation::Cone, Lists::Pyramids(_)) => self.lists = Lists::Cone(cone::Workspace::new()),
            (Formulation::Lcp, Lists::Cone(_)) => self.lists = Lists::Pyramids(Paths::new()),
            _ => {}
        }
        self.forget();
        if let Lists::Cone(cone) = &mut self.lists {
            cone.begin(bodies);
        }
    }

    /// Adds a point, and what it did in the step before.
    #[inline(always)]
    pub fn add(&mut self, point: &ContactPoint<R>, past: Past<R>) {
        // The capacities are that of the contacts: these cannot fail.
        match &mut self.lists {
            Lists::Cone(cone) => {
                cone.add(point);
                cone.expect(past.before);
            }
            Lists::Pyramids(_) => self.points.add(point, Some(past)),
        }
    }

    /// Solves for the velocity at the end of the step, from `guess`: with pyramids where they are asked for, and
    /// with the cone where they are not solved within half of the work, or where there is none for both
    /// (and not [`SolveBudget::only`] the pyramids are asked for).
    #[inline(never)]
    pub fn solve(
        &mut self,
        bodies: &Bodies<R>,
        guess: &[R; DOF],
        budget: &SolveBudget<R>,
        params: &PyramidParams<R>,
    ) -> (Solved<R>, SolvedBy) {
        let paths = match &mut self.lists {
            Lists::Cone(cone) => {
                let solved = cone.solve(bodies, guess, budget, &self.params, &mut self.kept);
                return (solved, SolvedBy::Cone);
            }
            Lists::Pyramids(paths) => paths,
        };
        let (price, unit) = price(self.points.count());
        // Half of the work, or what the cone's least leaves of it.
        let cone_instead = budget.only.is_none();
        let share = match cone_instead {
            true => (budget.max_work / 2).min(budget.max_work.saturating_sub(LEAST_WORK)),
            false => budget.max_work,
        };
        let max_work = (share * unit / price).saturating_sub(SETUP_WORK);
        let mut first = Solved {
            velocity: *guess,
            status: SolveStatus::Numerical,
            residual_n: R::zero(),
            iterations: 0,
            evaluations: 0,
        };
        if !cone_instead || max_work >= LEAST_PYRAMIDS_WORK {
            let bounded = SolveBudget { max_work, ..*budget };
            first = paths.solve(&mut self.points, bodies, guess, &bounded, params, &mut self.kept);
            first.iterations = (first.iterations * price).div_ceil(unit);
            first.evaluations = ((first.evaluations + SETUP_WORK) * price).div_ceil(unit);
            if first.status == SolveStatus::Solved || !cone_instead {
                return (first, SolvedBy::Pyramids);
            }
        }
        let budget = budget.within(budget.max_work.saturating_sub(first.work()));
        let mut second = self.hand_over(bodies, guess, &budget).unwrap_or(first);
        second.iterations = second.iterations.saturating_add(first.iterations);
        second.evaluations = second.evaluations.saturating_add(first.evaluations);
        (second, SolvedBy::ConeInstead)
    }

    /// Solves the cone with the points of the pyramids.
    #[cold]
    #[inline(never)]
    fn hand_over(
        &mut self,
        bodies: &Bodies<R>,
        guess: &[R; DOF],
        budget: &SolveBudget<R>,
    ) -> Option<Solved<R>> {
        self.lists = Lists::Cone(cone::Workspace::new());
        let Lists::Cone(cone) = &mut self.lists else { return None };
        cone.begin(bodies);
        for (point, before) in self.points.iter() {
            cone.add(point);
            if let Some(before) = before {
                cone.expect(before);
            }
        }
        Some(cone.solve(bodies, guess, budget, &self.params, &mut self.kept))
    }

    /// What each point answered, in the order in which they were added.
    #[inline(always)]
    pub fn answers(&self) -> impl Iterator<Item = Answer<R>> {
        let (cone, pyramids) = match &self.lists {
            Lists::Cone(cone) => (Some(cone), &[][..]),
            Lists::Pyramids(paths) => (None, paths.answers()),
        };
        // One loop for both: its body is large where it is used.
        let count = cone.map_or(pyramids.len(), cone::Workspace::count);
        (0..count).filter_map(move |k| match cone {
            Some(cone) => cone.answer(k),
            None => pyramids.get(k).copied(),
        })
    }

    /// Forgets the points, and what they answered.
    pub fn forget(&mut self) {
        self.points.forget();
        match &mut self.lists {
            Lists::Cone(cone) => cone.forget(),
            Lists::Pyramids(paths) => paths.forget(),
        }
    }
}

/// What the pyramids' rows and answers cost beyond the cone's whatever is solved, in their units.
const SETUP_WORK: u32 = 1;

/// With less work pyramids are not tried: a balance where nothing changes, and one factorisation where something does.
const LEAST_PYRAMIDS_WORK: u32 = 6;

/// What so many units of the pyramids' work cost, in so many of the cone's: all of it goes with the number of points, the
/// cone's has a part that does not. Neither is zero, which the compiler must see: it divides by them.
fn price(points: usize) -> (u32, u32) {
    let points = (points as u32).max(USUAL_POINTS);
    let price = PYRAMIDS_COST * points * (USUAL_POINTS + FIXED_POINTS);
    let unit = USUAL_POINTS * (points + FIXED_POINTS);
    (price.max(1), unit.max(1))
}
