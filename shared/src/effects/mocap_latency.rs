//! The object's pose arrives late.
//!
//! `x' = x - latency v`, and the rotation turned back by `latency omega`, with the object's
//! absolute velocity: the tracked object trails, the robot's own pose does not. Along a recorded trial, where what was
//! before is known, commands show where the object was instead (`host/analysis/src/run/late.rs`).

use super::law::{Law, Reading, StepContext};
use crate::effect::{Info, MAX_PARAMETERS, Parameter, Role};
use crate::real::Real;
use crate::rotation::turned;

/// See the module.
pub struct MocapLatency;

/// Description.
pub const INFO: Info = Info {
    id: "mocap_latency",
    code: 24,
    summary: "motion capture shows the object late",
    signature: "pose errors in proportion to speed that vanish at rest and do not grow with distance",
    on_robot: "nothing moves otherwise: the pose comes late, and slip detected from it is late by as much",
    source: "Merriaux et al. 2017, latency of Vicon systems",
    role: Role::Delay,
    parameters: &[Parameter::new("latency_s", "s", 0.02, 0.0, [-0.2, 0.2], "delay of the object's pose")],
};

impl<R: Real> Law<R> for MocapLatency {
    fn pose_late_s(&self, p: &[R; MAX_PARAMETERS]) -> R {
        p[0]
    }

    fn sense(&self, p: &[R; MAX_PARAMETERS], c: &StepContext<R>, reading: &mut Reading<R>) {
        if p[0] == R::zero() {
            return;
        }
        reading.position_m -= c.velocity_m_s * p[0];
        reading.rotation = turned(&reading.rotation, &(c.angular_rad_s * -p[0]));
    }
}
