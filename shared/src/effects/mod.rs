//! Physical effects that a model may have on top of its base contact law.
//!
//! An effect is one file in this folder: a unit struct that implements [`Law`], whose
//! hooks change loads, grip, geometry, compliance, friction or what the sensors show. It
//! plugs in at one place: the [`registry!`] list below.

use crate::real::Real;
use serde::{Deserialize, Serialize};

/// Most parameters of one effect.
pub const MAX_PARAMETERS: usize = 6;

/// An effect in a model: which, and its parameters (SI units, see its [`Info`]).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "R: Real")]
pub struct Effect<R: Real> {
    /// Stable number of the effect on the wire.
    pub code: u8,
    /// Parameters in the order of its `Info`.
    pub parameters: [R; MAX_PARAMETERS],
}
