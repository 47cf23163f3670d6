//! The other formulation as a witness: where a tick has work left, the step to the sample is made once more from the same
//! state, with friction pyramids where the model has the cone and the reverse, and both are asked which points stick.
//!
//! What is predicted does not depend on it. Where both solve the step and differ, the forces are not determined by the
//! model (several solutions), or one of the two is wrong: either is worth knowing of a prediction that rests on them.

use crate::contact::SLOTS;
use crate::model::{Formulation, Model, Scene};
use crate::real::Real;
use crate::solve::{SolveBudget, SolveStatus};
use crate::step::{Drive, SolvedBy, State, StepSummary, Workspace, step_in};
use crate::work::Work;

/// What the witness said since the predictor was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Testimony {
    /// Steps from sample to sample for which it was asked.
    pub asked: u32,
    /// Of them those that both formulations solved, each by itself; the tick had no work left for the others, or one of the
    /// two was not solved.
    pub compared: u32,
    /// Of those the ones in which every loaded point sticks or slides in both alike.
    pub alike: u32,
}

/// Which points are loaded, and which of them slide: a bit each.
#[derive(Clone, Copy, Debug)]
struct Touch {
    loaded: u64,
    sliding: u64,
}

impl Touch {
    fn of<R: Real>(state: &State<R, SLOTS>) -> Self {
        let bits = |what: fn(R, R) -> bool| {
            state.slots.iter().zip(0_u32..).fold(0, |bits, (slot, k)| {
                bits | u64::from(what(slot.load_n, slot.speed_m_s)).checked_shl(k).unwrap_or(0)
            })
        };
        Self { loaded: bits(|load, _| load > R::zero()), sliding: bits(|_, speed| speed > R::zero()) }
    }

    fn is_like(self, other: Self) -> bool {
        self.loaded & other.loaded & (self.sliding ^ other.sliding) == 0
    }
}

/// A step that the other formulation may be asked about.
pub(super) struct Witness<R: Real> {
    before: State<R, SLOTS>,
    after: Option<Touch>,
}

impl<R: Real> Witness<R> {
    /// Where the model asks for one, before the step.
    pub fn of(model: &Model<R>, before: &State<R, SLOTS>) -> Option<Self> {
        model.witness.then(|| Self { before: before.clone(), after: None })
    }

    /// After the step.
    pub fn saw(&mut self, model: &Model<R>, out: &StepSummary<R>, after: &State<R, SLOTS>) {
        let own = match model.formulation {
            Formulation::Cone => SolvedBy::Cone,
            Formulation::Lcp => SolvedBy::Pyramids,
        };
        let solved = out.status == SolveStatus::Solved && out.solved_by == own;
        self.after = solved.then(|| Touch::of(after));
    }

    /// Makes the step with the other formulation, within the work that is left.
    #[inline(never)]
    pub fn ask(
        &mut self,
        (scene, model): (&Scene<R>, &Model<R>),
        drive: &Drive<R>,
        work: &mut Work,
        space: &mut Workspace<R, SLOTS>,
        said: &mut Testimony,
    ) {
        said.asked = said.asked.saturating_add(1);
        let Some(own) = self.after else { return };
        let (formulation, by) = match model.formulation {
            Formulation::Cone => (Formulation::Lcp, SolvedBy::Pyramids),
            Formulation::Lcp => (Formulation::Cone, SolvedBy::Cone),
        };
        if !work.has_room(formulation) {
            return;
        }
        work.witness();
        let alone = SolveBudget { only: Some(formulation), ..SolveBudget::present() };
        let options = work.bounding_tick(&alone);
        let out = step_in(scene, model, &mut self.before, drive, &options, space);
        work.add(&out);
        if out.status == SolveStatus::Solved && out.solved_by == by {
            said.compared = said.compared.saturating_add(1);
            said.alike = said.alike.saturating_add(u32::from(own.is_like(Touch::of(&self.before))));
        }
    }
}
