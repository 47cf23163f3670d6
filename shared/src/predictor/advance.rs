//! The model's step from sample to sample, in parts where it is long, and the account of a tick's solves.

use super::ahead;
use crate::cone::{SolveBudget, SolveStatus};
use crate::contact::SLOTS;
use crate::model::{Model, Scene};
use crate::real::{Real, max};
use crate::step::{Drive, SolvedBy, State, StepSummary, Workspace};
use crate::work::{TICK_WORK, Work};

/// Most steps in which a gap is bridged: a tick must end.
const MOST_PARTS: u8 = 3;
/// Work kept for each later part of a step made in parts.
const LATER_WORK: u32 = 40;

/// Steps the model over a drive, in parts where it is long; all parts together are bounded by the
/// work of a tick.
pub(super) fn advance<R: Real>(
    (scene, model): (&Scene<R>, &Model<R>),
    params: &ahead::Params,
    state: &mut State<R, SLOTS>,
    drive: &Drive<R>,
    work: &mut Workspace<R, SLOTS>,
    worst: &mut Worst<R>,
) -> StepSummary<R> {
    let mut parts: u8 = 1;
    // A product in double precision would be the board's only one.
    let longest_s = params.longest_step_s + params.longest_step_s * 0.001;
    while drive.dt_s / R::of(f64::from(parts)) > R::of(f64::from(longest_s)) && parts < MOST_PARTS {
        parts += 1;
    }
    let mut part = *drive;
    part.dt_s = drive.dt_s / R::of(f64::from(parts));
    let present = SolveBudget::present();
    let bounded = |done: &Work, later: u8| match parts {
        1 => present,
        _ => done.bounding(&present, TICK_WORK.saturating_sub(LATER_WORK * u32::from(later))),
    };
    let options = bounded(&worst.work, parts.saturating_sub(1));
    let mut out = crate::step::step_in(scene, model, state, &part, &options, work);
    worst.note(&out);
    for later in (0..parts.saturating_sub(1)).rev() {
        if !out.followed {
            break;
        }
        for m in [&mut part.pusher, &mut part.support].into_iter().flatten() {
            m.position_m += m.velocity_m_s * part.dt_s;
            m.rotation = crate::step::turned(&m.rotation, &(m.angular_rad_s * part.dt_s));
        }
        let options = bounded(&worst.work, later);
        out = crate::step::step_in(scene, model, state, &part, &options, work);
        worst.note(&out);
    }
    out
}

/// The worst of a tick's solves.
pub(super) struct Worst<R> {
    pub(super) status: SolveStatus,
    pub(super) residual_n: R,
    pub(super) iterations: u16,
    /// Of the tick so far.
    pub(super) work: Work,
    /// A step from sample to sample has moved the state.
    pub(super) moved: bool,
    /// A step asked for pyramids and was solved with the cone.
    pub(super) cone_instead: bool,
}

impl<R: Real> Default for Worst<R> {
    fn default() -> Self {
        Self {
            status: SolveStatus::Solved,
            residual_n: R::zero(),
            iterations: 0,
            work: Work::default(),
            moved: false,
            cone_instead: false,
        }
    }
}

impl<R: Real> Worst<R> {
    /// A step of the look-ahead: its status goes with what it foresees.
    pub(super) fn count(&mut self, out: &StepSummary<R>) {
        self.work.add(out);
        self.cone_instead |= out.solved_by == SolvedBy::ConeInstead;
        self.iterations = self.iterations.saturating_add(out.iterations.min(10_000) as u16);
    }

    /// The step from sample to sample.
    pub(super) fn note(&mut self, out: &StepSummary<R>) {
        self.count(out);
        self.moved |= out.followed;
        if out.status != SolveStatus::Solved {
            self.status = out.status;
        }
        self.residual_n = max(self.residual_n, out.residual_n);
    }
}
