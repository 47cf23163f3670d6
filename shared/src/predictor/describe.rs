//! Model and measurement of one sample as the figures of a [`Prediction`], before anything is decided.

use super::context::Context;
use super::plan::{Intent, Segment};
use super::tracked::Tracked;
use super::types::{Prediction, Sample};
use crate::observer::Observed;
use crate::real::{Real, Rotation, Vec3, norm, sqrt};
use crate::step::StepSummary;
use crate::track::Pose;

impl<R: Real> Context<R> {
    pub(super) fn describe(
        &self,
        tracked: &Tracked<R>,
        out: &StepSummary<R>,
        observed: &Observed<R>,
        present: &Segment,
    ) -> Prediction {
        let mut p = Prediction::default();
        let narrow = |x: R| x.to_f64() as f32;
        for (k, f) in p.finger.iter_mut().enumerate() {
            f.model_utilisation = narrow(out.utilisation[k]);
            f.measured_utilisation = match observed.finger[k] {
                Some(r) if observed.limit > R::zero() => Some(narrow(r / observed.limit)),
                _ => None,
            };
            let mut slip = out.slip_m_s[k];
            if let Some(moved) = &observed.moved
                && present.intent == Intent::Hold
            {
                let now = moved.slip_s > R::zero();
                slip = if now { moved.velocity_m_s[k] } else { Vec3::zeros() };
            }
            f.slip_speed_m_s = narrow(norm(&slip));
            f.slip_direction_rad = direction(&slip);
            p.finger_wrench[k] = out.reading.finger[k].map(narrow);
        }
        let r = &out.reading;
        p.position_m = [narrow(r.position_m.x), narrow(r.position_m.y), narrow(r.position_m.z)];
        let q = r.rotation.quaternion();
        p.quaternion = [narrow(q.w), narrow(q.i), narrow(q.j), narrow(q.k)];
        p.pusher_force_n = [narrow(r.pusher[0]), narrow(r.pusher[1]), narrow(r.pusher[2])];
        p.rotation_rad = narrow(rotation_between(&tracked.start, &tracked.state.rotation));
        p.friction = narrow(self.observer.friction());
        p.friction_least = narrow(self.observer.least_friction());
        p
    }
}

/// Force of both fingers on the object: measured, or else the model's.
pub(super) fn load_of<R: Real>(sample: &Sample<R>, out: &StepSummary<R>) -> Vec3<R> {
    let sum = |[a, b]: [&[R; 6]; 2]| Vec3::new(a[0] + b[0], R::zero(), a[2] + b[2]);
    let [f1, f2] = &out.reading.finger;
    match &sample.finger {
        [Some(a), Some(b)] if sum([a, b]).norm_squared().finite() => sum([a, b]),
        _ => sum([f1, f2]),
    }
}

/// Angle of a slip velocity in the finger plane. Shown to people, so micromath's
/// approximation (about 1e-3 rad) is what is wanted; it is the same on every platform.
pub(super) fn direction<R: Real>(slip_m_s: &Vec3<R>) -> f32 {
    use micromath::F32Ext;
    let (x, z) = (slip_m_s.x.to_f64() as f32, slip_m_s.z.to_f64() as f32);
    if x == 0.0 && z == 0.0 { 0.0 } else { F32Ext::atan2(z, x) }
}

pub(super) fn rotation_between<R: Real>(start: &Pose<R>, now: &Rotation<R>) -> R {
    let q = (start.rotation.inverse() * now).into_inner();
    let vector = sqrt(q.i * q.i + q.j * q.j + q.k * q.k);
    R::of(2.0) * vector.atan2(q.w.abs())
}
