//! Constants of the iteration that were tuned on recorded and on hostile problems. They change the
//! way to the answer and its cost, not the answer: what is solved is certified by its residual.

use crate::real::Real;

/// See the module. Dimensionless, or counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeParams<R: Real> {
    /// 0.04: share of the merit (sum of squares of the residual) below which a step was so good that
    /// the same factors are tried again: five steps with them cost as much as new ones. Doubled: a few
    /// more evaluations that end in new factors all the same.
    pub good_share: R,
    /// 3: most steps that reuse the factors of the last one. Doubled: no change but in long polishes,
    /// which new factors end sooner.
    pub polish_steps: u8,
    /// 8: most evaluations of a line search after the first. Doubled: the worst solve costs up to
    /// twice the evaluations; hardly a search needs more than four.
    pub search_steps: u8,
    /// 12: Newton steps on the real problem before friction bounds are held. Doubled: cycles, which the
    /// fixed point ends, take twice as long to be given up.
    pub first_steps: u32,
    /// 6: Newton steps on the real problem after each update of the bounds. Doubled: as above.
    pub later_steps: u32,
    /// 20: Newton steps on the convex problem with bounds held; it has one minimum and a descent that
    /// cannot stall, so it ends by itself. Doubled: no change.
    pub frozen_steps: u32,
    /// 2: full steps taken although they need not descend, where friction couples strongly to the
    /// normal force. Doubled: the fixed point begins later where Newton's method diverges.
    pub trusted_steps: u8,
    /// 0.5: share of the first slope to which a line search brings it down. Doubled (1): every full step
    /// is taken, and contacts that close throw the iteration about.
    pub search_share: R,
    /// 0.2: least relaxation of the friction bounds' update. Doubled: bounds may oscillate.
    pub min_relaxation: R,
    /// 32: roundings of the largest velocity times the stiffness that the residual's tolerance allows
    /// for. Doubled: rigid contacts count as solved with twice the leftover that `f32` cannot avoid.
    pub roundings: R,
}

impl<R: Real> Default for ConeParams<R> {
    fn default() -> Self {
        Self {
            good_share: R::of(0.04),
            polish_steps: 3,
            search_steps: 8,
            first_steps: 12,
            later_steps: 6,
            frozen_steps: 20,
            trusted_steps: 2,
            search_share: R::of(0.5),
            min_relaxation: R::of(0.2),
            roundings: R::of(32.0),
        }
    }
}
