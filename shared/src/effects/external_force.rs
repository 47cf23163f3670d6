//! Something that no sensor measures pulls at the object: a cable, a hose, a magnet in the room.
//!
//! `F = F0 - k u` in world axes, at the point `at_x` on object X, and with it the torque `r x F` about the centre. `u` is how
//! far that point has moved in the room since the trial began: `u += (v + w x r) dt` in each step. A taut cable keeps its
//! force (`k` zero), a spring or a magnet nearby does not.
//!
//! A wrong mass is the same as long as the object keeps its attitude and no run is fast ([`super::mass_error`]).

use super::law::{Law, Loads, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, MEMORY, Parameter, Role};
use crate::real::{Real, Vec3};

/// See the module.
pub struct ExternalForce;

/// Description.
pub const INFO: Info = Info {
    id: "external_force",
    code: 27,
    summary: "something that no sensor measures pulls at the object (a cable, a hose, a magnet)",
    signature: "the measured forces and the weight do not sum to zero, in any direction, also at rest and whatever the grip",
    on_robot: "the object bears a load that is not its own: look for what touches or attracts it, or plan the grip for both",
    source: "rigid body statics",
    role: Role::Plain,
    parameters: &[
        Parameter::new("x_n", "N", 0.5, 0.0, [-50.0, 50.0], "force along world X at the start of a trial"),
        Parameter::new("y_n", "N", 0.5, 0.0, [-50.0, 50.0], "the same along world Y"),
        Parameter::new("z_n", "N", 0.5, 0.0, [-50.0, 50.0], "the same along world Z, upwards"),
        Parameter::new(
            "stiffness_n_m",
            "N/m",
            20.0,
            0.0,
            [-1000.0, 1000.0],
            "how it falls, along the way, as the object moves in the room",
        ),
        Parameter::new("at_x_m", "m", 0.0, 0.0, [-0.2, 0.2], "where it acts along object X, from the centre")
            .tried_at(&[0.04, -0.04]),
    ],
};

impl<R: Real> Law<R> for ExternalForce {
    fn loads(
        &self,
        p: &[R; MAX_PARAMETERS],
        c: &StepContext<R>,
        memory: &mut [R; MEMORY],
        loads: &mut Loads<R>,
    ) {
        let arm = c.rotation.transform_vector(&Vec3::new(p[4], R::zero(), R::zero()));
        let mut force = Vec3::new(p[0], p[1], p[2]);
        if p[3] != R::zero() {
            let velocity = c.velocity_m_s + c.angular_rad_s.cross(&arm);
            let step = c.carrier.transform_vector(&(velocity * c.dt_s));
            for ((moved, step), force) in memory.iter_mut().zip(step.iter()).zip(force.iter_mut()) {
                *moved += *step;
                *force -= p[3] * *moved;
            }
        }
        if force != Vec3::zeros() {
            let force = c.carrier.inverse_transform_vector(&force);
            loads.force_n += force;
            loads.torque_nm += arm.cross(&force);
        }
    }
}
