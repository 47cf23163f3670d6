//! What a contact problem is, what bounds a solve and what it says: the types in front of both
//! solvers, the exact cone ([`crate::cone`]) and complementarity ([`crate::lcp`]).

use crate::model::Formulation;
use crate::real::{Real, Vec3, max};
use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Most contact points of one solve.
pub const MAX_POINTS: usize = 64;
/// Unknowns: linear velocity (3), angular velocity (3), opening speed of the jaw.
pub const DOF: usize = 7;

/// What became of a solve, or, in a prediction, of a tick's: the worst of them. The order of the forms is that of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema)]
pub enum SolveStatus {
    /// The residual is at or below the tolerance.
    #[default]
    Solved,
    /// The bound on the work was reached; the best answer found is returned with its residual.
    IterationLimit,
    /// A number was not finite or out of its range; nothing was solved, and the last good state is kept.
    BadInput,
    /// Rounding won, or the linear system broke down; the best answer found is returned.
    Numerical,
    /// The contacts contradict each other (an object crushed between advancing walls). The
    /// complementarity solvers say so of a ray: for a copositive matrix (every friction problem) there
    /// is then no solution. The time step says so of forces that no rig has, and has not moved anything.
    Contradiction,
}

impl SolveStatus {
    /// As the names of the JSON documents.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::IterationLimit => "iteration_limit",
            Self::BadInput => "bad_input",
            Self::Numerical => "numerical",
            Self::Contradiction => "contradiction",
        }
    }
}

/// What is wrong with the numbers of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Defect {
    /// Lengths do not belong together, or exceed the capacity.
    Size,
    /// A problem without unknowns or without contacts.
    Empty,
    /// A NaN or an infinity.
    NotFinite,
    /// An inverse mass below zero (zero stands for a body that does not move).
    Mass,
    /// A coefficient of friction outside 0 to 10.
    Friction,
    /// A compliance below zero.
    Compliance,
    /// A normal and both tangents are zero: the contact acts on nothing.
    Direction,
}

/// One contact point as the solver sees it.
#[derive(Clone, Copy, Debug)]
pub struct ContactPoint<R: Real> {
    /// From the centre of mass, m.
    pub lever_m: Vec3<R>,
    /// Normal into the object and two tangents, orthonormal.
    pub axes: [Vec3<R>; 3],
    /// Normal speed per unit of jaw opening speed: 1 on a fingertip, otherwise 0.
    pub jaw: R,
    /// Added to the relative velocity along `axes`, m/s (other body's motion, gap, spring memory).
    pub bias_m_s: [R; 3],
    /// Force per relative velocity along `axes`, N s/m; positive.
    pub stiffness_n_s_m: [R; 3],
    /// Friction coefficient along the two tangents; not negative.
    pub mu: [R; 2],
    /// Greatest pull that the contact bears, N; adds to the friction bound.
    pub adhesion_n: R,
    /// Rise of friction with slip speed beyond the bound, N s/m, along the stiffer tangent; not negative.
    pub viscous_n_s_m: R,
}

/// Inertial side of the step.
#[derive(Clone, Copy, Debug)]
pub struct Bodies<R: Real> {
    /// Mass of the object.
    pub mass_kg: R,
    /// Inertia about the centre of mass, in the axes of the contacts.
    pub inertia_kg_m2: [[R; 3]; 3],
    /// Inertia of the jaw's opening motion.
    pub jaw_mass_kg: R,
    /// Step.
    pub dt_s: R,
    /// Velocity that the step would end with if no contact acted, m/s, rad/s, m/s.
    pub free: [R; DOF],
}

/// What a point did in the step before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Before<R> {
    /// No force.
    Open,
    /// Touched without slip.
    Stuck {
        /// Normal force.
        load_n: R,
    },
    /// Slipped.
    Slid {
        /// Normal force.
        load_n: R,
    },
}

/// A point's answer to the velocity found.
#[derive(Clone, Copy, Debug)]
pub struct Answer<R> {
    /// Force on the object along the point's axes (normal, tangents).
    pub force_n: [R; 3],
    /// Relative velocity along the tangents, the point's bias included.
    pub biased_slip_m_s: [R; 2],
    /// As given, along the tangents.
    pub stiffness_n_s_m: [R; 2],
    /// As given, with the rise by viscosity at the slip speed found.
    pub mu: [R; 2],
    /// As given.
    pub adhesion_n: R,
}

/// Result of [`crate::cone::solve`] and of [`crate::lcp::step::solve`]. `velocity` and `force_n` are worth their `status` and `residual_n`.
#[derive(Clone, Debug)]
pub struct Solution<R: Real, const NC: usize> {
    /// m/s, rad/s, m/s at the end of the step.
    pub velocity: [R; DOF],
    /// Force on the object at each point along its axes (normal, tangents).
    pub force_n: Vec<[R; 3], NC>,
    /// How far `velocity` can be trusted.
    pub status: SolveStatus,
    /// Largest error of the momentum balance, N (torques divided by the radius of gyration).
    pub residual_n: R,
    /// Newton steps taken, each with one factorisation.
    pub iterations: u32,
    /// Evaluations of the momentum balance.
    pub evaluations: u32,
}

/// What a solve says besides the forces; `velocity` is worth its `status` and `residual_n`.
#[derive(Clone, Copy, Debug)]
pub struct Solved<R> {
    /// m/s, rad/s, m/s at the end of the step.
    pub velocity: [R; DOF],
    /// How far `velocity` can be trusted.
    pub status: SolveStatus,
    /// Largest error of the momentum balance, N (torques divided by the radius of gyration).
    pub residual_n: R,
    /// Newton steps taken, each with one factorisation.
    pub iterations: u32,
    /// Evaluations of the momentum balance.
    pub evaluations: u32,
}

impl<R: Real, const NC: usize> Solution<R, NC> {
    /// What a solve said, with the force of each point.
    pub(crate) fn of(solved: &Solved<R>, force_n: Vec<[R; 3], NC>) -> Self {
        Self {
            velocity: solved.velocity,
            force_n,
            status: solved.status,
            residual_n: solved.residual_n,
            iterations: solved.iterations,
            evaluations: solved.evaluations,
        }
    }
}

impl<R> Solved<R> {
    /// Work of the solve, in evaluations.
    pub(crate) fn work(&self) -> u32 {
        self.iterations.saturating_mul(FACTORS_WORK).saturating_add(self.evaluations)
    }
}

/// Work of [`SolveBudget::present`]: with what is around it, that of a tick. Of the self-test's ticks 2 in 1,000 hit it.
const PRESENT_WORK: u32 = 104;
/// Work and relative tolerance of [`SolveBudget::look_ahead`].
const LOOK_AHEAD_WORK: u32 = 72;
const LOOK_AHEAD_TOLERANCE: f64 = 1e-3;

/// Contact points of the board's usual scene.
pub(crate) const USUAL_POINTS: u32 = 16;
/// What an evaluation costs besides its points, in points.
pub(crate) const FIXED_POINTS: u32 = 12;

/// Work of a Newton step besides its evaluations: matrix and factors cost four of them.
pub(crate) const FACTORS_WORK: u32 = 4;
/// What a unit of work of the pyramids costs, in the cone's: `make cost` counts 5,000 instructions for a kink or an
/// evaluation and 20,000 for a factorisation with what belongs to it.
pub(crate) const PYRAMIDS_COST: u32 = 2;

/// No solve is bounded below so much work.
pub(crate) const LEAST_WORK: u32 = 16;

/// Answers that a time step follows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Follows {
    /// Those far from solved too: for studies of the solver.
    Any,
    /// Those whose residual [`StepParams`](crate::step::StepParams) bounds.
    Credible,
    /// Those within the tolerance.
    Solved,
}

/// Limits of the iteration.
#[derive(Clone, Copy, Debug)]
pub struct SolveBudget<R: Real> {
    /// Most work, in evaluations of the balance; a Newton step besides its evaluations is four. What has begun may add
    /// three.
    pub max_work: u32,
    /// Residual called solved, as a share of the largest force in the balance.
    pub tolerance: R,
    /// Points for which the work is meant: with more, which cost more, it is lowered.
    pub usual_points: u32,
    /// The answers that a time step follows; otherwise it leaves the state as it was.
    pub follows: Follows,
    /// With this formulation alone, whatever the model asks for; otherwise the cone is solved in place of pyramids that were
    /// not.
    pub only: Option<Formulation>,
}

impl<R: Real> Default for SolveBudget<R> {
    fn default() -> Self {
        Self {
            max_work: 640,
            // f32: what summing some twenty forces leaves; f64: far below any use.
            tolerance: max(R::of(100.0) * R::EPSILON, R::of(1e-10)),
            usual_points: MAX_POINTS as u32,
            follows: Follows::Any,
            only: None,
        }
    }
}

impl<R: Real> SolveBudget<R> {
    /// For the step to the present sample within a tick: bounded in time.
    pub fn present() -> Self {
        Self {
            max_work: PRESENT_WORK,
            usual_points: USUAL_POINTS,
            follows: Follows::Credible,
            ..Self::default()
        }
    }

    /// For steps into the future, which is known far less exactly than a solve: the balance
    /// to a thousandth of the largest force, few iterations.
    pub fn look_ahead() -> Self {
        Self {
            max_work: LOOK_AHEAD_WORK,
            tolerance: R::of(LOOK_AHEAD_TOLERANCE),
            usual_points: USUAL_POINTS,
            follows: Follows::Credible,
            only: None,
        }
    }

    /// Evaluations that are left to a solve beside so many Newton steps.
    pub(crate) fn evaluations_beside(&self, iterations: u32) -> u32 {
        self.max_work.saturating_sub(iterations.saturating_mul(FACTORS_WORK))
    }

    /// The same with at most `work`, but for some.
    pub(crate) fn within(&self, work: u32) -> Self {
        Self { max_work: self.max_work.min(work.max(LEAST_WORK)), ..*self }
    }

    /// The same where a step within a tick does `work` evaluations' worth besides the solve.
    pub(crate) fn beside(&self, work: u32) -> Self {
        if self.usual_points >= MAX_POINTS as u32 {
            return *self;
        }
        self.within(self.max_work.saturating_sub(work).max(self.max_work / 2))
    }

    /// The same with the work for `points` points.
    pub(crate) fn bounded_for(&self, points: usize) -> Self {
        let usual = self.usual_points.saturating_add(FIXED_POINTS);
        let points = (points as u32).saturating_add(FIXED_POINTS);
        if points <= usual {
            return *self;
        }
        Self { max_work: (self.max_work.saturating_mul(usual) / points).max(1), ..*self }
    }
}
