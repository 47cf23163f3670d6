//! The momentum balance of a step, and its inertial side.

use super::params::PyramidParams;
use crate::linear::{Mat7, Vec7};
use crate::real::{Real, abs};
use crate::solve::SolveBudget;

/// A momentum balance: what is left of it, a scale of its terms and what rounding of velocities does to it, N.
pub(super) struct Balance<R> {
    pub rest: Vec7<R>,
    pub scale_n: R,
    pub rounding_n: R,
}

impl<R: Real> Balance<R> {
    pub fn residual_n(&self) -> R {
        let mut most = R::zero();
        for x in &self.rest {
            // A NaN must win: it is the worst residual there is.
            if !(abs(*x) <= most) {
                most = abs(*x);
            }
        }
        most
    }

    /// What may be left of it, N: as exactly as is asked, and as rounding allows.
    pub fn tolerance_n(&self, budget: &SolveBudget<R>, params: &PyramidParams<R>) -> R {
        budget.tolerance * self.scale_n + self.rounding_n * params.roundings * R::EPSILON
    }
}

/// The inertial side; angular velocities are multiplied, lengths divided by the radius of gyration.
pub(super) struct Inertia<R> {
    pub mass: Mat7<R>,
    pub free: Vec7<R>,
    pub rate: R,
}
