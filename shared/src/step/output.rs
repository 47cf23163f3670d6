//! What a step produces, and the working memory that it needs.

use super::params::StepParams;
use super::solver::{SolvedBy, Solver};
use crate::cone::{ConeParams, Kept};
use crate::contact::Contacts;
use crate::effects::formula::Fault;
use crate::effects::{FrictionLaw, Reading};
use crate::real::{Real, Vec3};
use crate::solve::{Answer, SolveStatus};
use heapless::Vec;

/// A formula without a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FormulaFault {
    /// Which of the model's formulas, from 0.
    pub number: u8,
    /// Why it has none.
    pub fault: Fault,
}

/// What a step produces besides the next state.
#[derive(Clone, Copy, Debug)]
pub struct StepSummary<R: Real> {
    /// How far the rest can be trusted.
    pub status: SolveStatus,
    /// Which formulation the forces come from.
    pub solved_by: SolvedBy,
    /// Whether the state has moved; if not, nothing else here was reached.
    pub followed: bool,
    /// The formula behind a [`SolveStatus::BadInput`], if it is one.
    pub formula_fault: Option<FormulaFault>,
    /// Error of the momentum balance.
    pub residual_n: R,
    /// Newton steps.
    pub iterations: u32,
    /// Evaluations of the momentum balance.
    pub evaluations: u32,
    /// Contact points handed to the solver.
    pub points: u16,
    /// Contact points times effects: how often an effect was asked for its friction.
    pub hooks: u16,
    /// What the sensors would show at the end of the step.
    pub reading: Reading<R>,
    /// Share of the friction limit used by each finger, force and torsion together (1: slipping).
    pub utilisation: [R; 2],
    /// Mean slip velocity of the object over each finger, carrier axes, m/s.
    pub slip_m_s: [Vec3<R>; 2],
    /// Slip about the patch normal of each finger, rad/s.
    pub spin_rad_s: [R; 2],
    /// Normal force of each body: finger 1, finger 2, pusher, support.
    pub normal_n: [R; 4],
    /// Contact points that did not fit the capacity and were left out.
    pub points_lost: usize,
}

/// Working memory of a step; keeps its contact points, one entry each in the lists.
#[derive(Clone, Debug)]
pub struct Workspace<R: Real, const NC: usize> {
    /// Contact points handed to the solver.
    pub contacts: Contacts<R, NC>,
    pub(super) solver: Solver<R, NC>,
    pub(super) params: StepParams<R>,
}

impl<R: Real, const NC: usize> Workspace<R, NC> {
    /// Factors of the last solve, with which the next begins.
    pub fn kept(&mut self) -> &mut Kept<R> {
        &mut self.solver.kept
    }

    /// Empty.
    // Built in place: it is larger than all else in a tick.
    #[inline(always)]
    pub fn new() -> Self {
        Self { contacts: Vec::new(), solver: Solver::new(), params: StepParams::default() }
    }

    /// Empty, with other constants of step and solver.
    pub fn with(params: StepParams<R>, solver: ConeParams<R>) -> Self {
        let mut own = Self { params, ..Self::new() };
        own.solver.params = solver;
        own
    }

    /// What each contact point answered; none after a step that has not moved.
    #[inline(always)]
    pub fn answers(&self) -> impl Iterator<Item = Answer<R>> {
        self.solver.answers()
    }
}

impl<R: Real, const NC: usize> Default for Workspace<R, NC> {
    fn default() -> Self {
        Self::new()
    }
}

/// What a step produces besides the next state, with every contact point; the summary's
/// fields are read as its own.
#[derive(Clone, Debug)]
pub struct StepOutput<R: Real, const NC: usize> {
    /// All but the contact points.
    pub summary: StepSummary<R>,
    /// Contact points handed to the solver.
    pub contacts: Contacts<R, NC>,
    /// Friction law of each.
    pub friction: Vec<FrictionLaw<R>, NC>,
    /// Force on the object at each, along its axes.
    pub force_n: Vec<[R; 3], NC>,
}

impl<R: Real, const NC: usize> StepOutput<R, NC> {
    /// The contact points that `work` has of the step that ended with `summary`.
    #[must_use]
    pub fn of(summary: StepSummary<R>, work: &Workspace<R, NC>) -> Self {
        Self {
            summary,
            friction: work
                .answers()
                .map(|a| FrictionLaw { mu: a.mu, adhesion_n: a.adhesion_n, viscosity_s_m: R::zero() })
                .collect(),
            force_n: work.answers().map(|a| a.force_n).collect(),
            contacts: work.contacts.clone(),
        }
    }
}

impl<R: Real, const NC: usize> core::ops::Deref for StepOutput<R, NC> {
    type Target = StepSummary<R>;
    fn deref(&self) -> &StepSummary<R> {
        &self.summary
    }
}
