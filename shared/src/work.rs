//! The work of a tick, counted in evaluations of the momentum balance, not in time: both sides stop
//! at the same place.

use crate::model::Formulation;
use crate::real::Real;
use crate::solve::PYRAMIDS_COST;
use crate::solve::{FACTORS_WORK, FIXED_POINTS, LEAST_WORK, SolveBudget, USUAL_POINTS};
use crate::step::StepSummary;

/// Work with which a tick ends: what is left of it bounds a step of the look-ahead, or of settling. A unit takes at most 2,850
/// instructions of the emulated board, what a tick does besides its steps 40,000 to 60,000 (docs/lab/tick-cost.md): with
/// three units that a solve may add, 388,000 of the 400,000 that a tick may take.
pub(crate) const TICK_WORK: u32 = 112;
/// Work beyond which the look-ahead waits for the next tick.
const ENOUGH_WORK: u32 = 68;
/// Work beyond which not even a first step is begun: no more than its least is left.
const MOST_WORK: u32 = TICK_WORK - AROUND_WORK - LEAST_WORK;
/// Work of a step around its solve; each effect adds half a unit a contact point.
const AROUND_WORK: u32 = 8;
/// Work of a witness besides its step: the state of before kept, the solvers' memory changed over, what both did compared
/// (6,000 instructions).
const WITNESS_WORK: u32 = 2;

impl<R: Real> StepSummary<R> {
    /// Work of the step, in evaluations of the momentum balance of 16 points.
    pub fn work(&self) -> u32 {
        let solve = self.iterations.saturating_mul(FACTORS_WORK).saturating_add(self.evaluations);
        let around = solve.saturating_add(AROUND_WORK);
        // Fewer points are not counted as cheaper: searches are longer where contacts come and go.
        let points = u32::from(self.points).max(USUAL_POINTS).saturating_add(FIXED_POINTS);
        let scaled = around.saturating_mul(points) / (USUAL_POINTS + FIXED_POINTS);
        scaled.saturating_add(u32::from(self.hooks) / 2)
    }
}

/// Work done in a tick.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Work {
    done: u32,
    steps_ahead: u8,
}

impl Work {
    /// Books a step.
    pub fn add<R: Real>(&mut self, out: &StepSummary<R>) {
        self.done = self.done.saturating_add(out.work());
    }

    /// Books that a step of the look-ahead was one.
    pub fn step_ahead(&mut self) {
        self.steps_ahead = self.steps_ahead.saturating_add(1);
    }

    /// In evaluations of the momentum balance of 16 points.
    pub fn done(&self) -> u32 {
        self.done
    }

    /// `options` for a next step that ends within `most` in all: an expensive one does not make the tick
    /// late, but is marked.
    pub fn bounding<R: Real>(&self, options: &SolveBudget<R>, most: u32) -> SolveBudget<R> {
        options.within(most.saturating_sub(self.done.saturating_add(AROUND_WORK)))
    }

    /// [`Self::bounding`] by the work of a tick.
    pub fn bounding_tick<R: Real>(&self, options: &SolveBudget<R>) -> SolveBudget<R> {
        self.bounding(options, TICK_WORK)
    }

    /// Books what a witness does besides its step.
    pub fn witness(&mut self) {
        self.done = self.done.saturating_add(WITNESS_WORK);
    }

    /// Whether this tick has room for a witness, on which nothing depends: the least solve in this formulation.
    pub fn has_room(&self, formulation: Formulation) -> bool {
        let least = match formulation {
            Formulation::Cone => LEAST_WORK,
            Formulation::Lcp => PYRAMIDS_COST * LEAST_WORK,
        };
        self.done + WITNESS_WORK + AROUND_WORK + least <= TICK_WORK
    }

    /// Whether this tick has room for a step of the look-ahead. One is done in nearly every
    /// tick, so that it gets on however expensive the present is.
    pub fn room(&self) -> bool {
        self.done < if self.steps_ahead == 0 { MOST_WORK } else { ENOUGH_WORK }
    }
}
