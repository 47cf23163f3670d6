//! The momentum balance of a step, and its inertial side.

use super::params::PyramidParams;
use crate::linear::{Mat7, Vec7};
use crate::real::{Real, abs, sqrt};
use crate::solve::{Bodies, DOF, SolveBudget};

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
    pub radius_m: R,
    /// Its inverse.
    pub scale: R,
}

impl<R: Real> Inertia<R> {
    /// `None` where masses or the step's time are not above zero.
    pub fn of(bodies: &Bodies<R>) -> Option<Self> {
        let i = &bodies.inertia_kg_m2;
        let rate = R::one() / bodies.dt_s;
        let radius_m = sqrt((i[0][0] + i[1][1] + i[2][2]) / (R::of(3.0) * bodies.mass_kg));
        let scale = R::one() / radius_m;
        if !(rate > R::zero() && radius_m > R::zero() && bodies.jaw_mass_kg > R::zero()) {
            return None;
        }
        let mut mass = [[R::zero(); DOF]; DOF];
        for r in 0..3 {
            mass[r][r] = bodies.mass_kg * rate;
            for c in 0..3 {
                mass[3 + r][3 + c] = i[r][c] * rate * scale * scale;
            }
        }
        mass[6][6] = bodies.jaw_mass_kg * rate;
        Some(Self {
            mass,
            free: turning(&bodies.free, radius_m),
            rate: bodies.mass_kg * rate,
            radius_m,
            scale,
        })
    }

    pub fn scaled(&self, v: &Vec7<R>) -> Vec7<R> {
        turning(v, self.radius_m)
    }

    pub fn unscaled(&self, v: &Vec7<R>) -> Vec7<R> {
        turning(v, self.scale)
    }
}

/// `v` with its angular velocity `by` times as large.
fn turning<R: Real>(v: &Vec7<R>, by: R) -> Vec7<R> {
    [v[0], v[1], v[2], v[3] * by, v[4] * by, v[5] * by, v[6]]
}
