//! The rig does not stand level.
//!
//! Gravity is turned about world X and Y by small angles, its size kept:
//! `g' = |g| (g + r x g) / |g + r x g|` with `r = (about_x, about_y, 0)`.

use super::law::{Law, Loads, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, Vec3, norm};

/// See the module.
pub struct GravityTilt;

/// Description.
pub const INFO: Info = Info {
    id: "gravity_tilt",
    code: 18,
    summary: "gravity is not along the axis the rig assumes",
    signature: "a constant sideways force in proportion to mass, in all phases, whatever the grip",
    on_robot: "a part of the weight acts sideways: the fingers bear a load in a direction in which the model expects none",
    source: "rigid body statics",
    role: Role::Plain,
    parameters: &[
        Parameter::new("about_x_rad", "rad", 0.05, 0.0, [-0.3, 0.3], "turn about world X"),
        Parameter::new("about_y_rad", "rad", 0.05, 0.0, [-0.3, 0.3], "turn about world Y"),
    ],
};

impl<R: Real> Law<R> for GravityTilt {
    fn loads(&self, p: &[R; MAX_PARAMETERS], _: &StepContext<R>, _: &mut [R; MEMORY], loads: &mut Loads<R>) {
        let g = loads.gravity_m_s2;
        let turned = g + Vec3::new(p[0], p[1], R::zero()).cross(&g);
        let size = norm(&turned);
        if size > R::zero() {
            loads.gravity_m_s2 = turned * (norm(&g) / size);
        }
    }
}
