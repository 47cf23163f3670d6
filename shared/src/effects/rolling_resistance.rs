//! A moment that opposes rolling on the pusher or the support.
//!
//! Each environment body with normal force `N` resists the part of the relative rotation that
//! is not about its normal with at most `N arm` (`arm` the coefficient of rolling resistance,
//! a length: Hertzian hysteresis, Tabor 1955). Before it gives way it acts as a spring over
//! 1.15 degrees of rotation, the model of Dahl 1968, which has no jump at rest and so stays
//! calm in an explicit step; where the step is coarse the spring is softened to remain stable.
//! It remembers the spring's rotation vector.

use super::law::{Law, Loads, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, Vec3, max, norm};

/// Rotation over which the moment builds up, rad.
const RANGE_RAD: f64 = 0.02;

/// See the module.
pub struct RollingResistance;

/// Description.
pub const INFO: Info = Info {
    id: "rolling_resistance",
    code: 19,
    summary: "a moment opposes rolling on the pusher or the support",
    signature: "extra push force in proportion to the normal force while the object rolls or tips, none while it slides flat",
    on_robot: "an object that rolls or tips against its surroundings takes more force than planned, and loads the fingers by it",
    source: "Tabor 1955, rolling friction; Dahl 1968, solid friction model",
    role: Role::Plain,
    parameters: &[Parameter::new(
        "arm_m",
        "m",
        0.001,
        0.0,
        [0.0, 0.01],
        "resisting moment for each newton of normal force",
    )],
};

impl<R: Real> Law<R> for RollingResistance {
    fn loads(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        memory: &mut [R; MEMORY],
        loads: &mut Loads<R>,
    ) {
        if p[0] == R::zero() {
            return;
        }
        let mut load = R::zero();
        let mut rolled = Vec3::zeros();
        for (body, n) in c.environment.iter().zip([c.load_n[2], c.load_n[3]]) {
            load += n;
            rolled += (body.turning_rad_s - body.normal * body.normal.dot(&body.turning_rad_s)) * n;
        }
        if !(load > R::zero()) {
            *memory = [R::zero(); MEMORY];
            return;
        }
        let moment = max(p[0], R::zero()) * load;
        // Stable while dt² moment / (inertia range) < 1; smallest inertia as of a 5 mm radius.
        let coarse = c.dt_s * c.dt_s * moment / (loads.mass_kg * R::of(2.5e-5));
        let range = max(R::of(RANGE_RAD), coarse);
        let [x, y, z, _] = *memory;
        let spring = Vec3::new(x, y, z) + rolled * (c.dt_s / load);
        let size = norm(&spring);
        let spring = if size > range { spring * (range / size) } else { spring };
        *memory = [spring.x, spring.y, spring.z, R::zero()];
        loads.torque_nm -= spring * (moment / range);
    }
}
