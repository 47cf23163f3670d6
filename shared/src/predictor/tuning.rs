//! All numbers that were chosen in the predictor, and the check without which it takes none.

use super::params::Params;
use crate::real::Real;
use crate::tuning::{OutOfBounds, check, tuned};
use crate::{health, observer, track};

tuned! {
    /// What was chosen in the predictor, table by table. Its defaults belong to 250 Hz, poses within 30 micrometres and forces
    /// within 0.02 N.
    pub struct Tuning<R> {
        /// Decisions: gaps, the measured against the modelled, plans, warnings.
        predictor: Params = Params::default();
        /// What the forces and the measured pose say of the grasp.
        observer: observer::Params<R> = observer::Params::default();
        /// Which sensors can be believed.
        health: health::Params = health::Params::default();
        /// From sampled poses to a motion: noise of paths, acceleration, an object that settles.
        track: track::Params<R> = track::Params::default();
    }
}

/// A tuning whose every number is within its bounds: no other reaches the predictor, so that none makes it divide by zero or
/// loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Checked<R: Real>(Tuning<R>);

impl<R: Real> Checked<R> {
    /// The numbers.
    pub fn get(&self) -> &Tuning<R> {
        &self.0
    }
}

impl<R: Real> Tuning<R> {
    /// Fit for a predictor.
    ///
    /// # Errors
    /// The first number that is not within its bounds.
    pub fn checked(mut self) -> Result<Checked<R>, OutOfBounds> {
        check(&mut self)?;
        Ok(Checked(self))
    }
}
