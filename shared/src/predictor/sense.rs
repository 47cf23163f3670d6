//! What the sensors tell of one sample: checked, tared, and observed together with the planned motion.

use super::context::Context;
use super::params::Params;
use super::patch::patch_arm;
use super::plan::{Intent, Segment};
use super::tracked::Tracked;
use super::types::{Sample, validity};
use crate::observer::{Observed, Seen};
use crate::real::{Real, Vec3, max, norm};
use crate::step::{Drive, StepSummary};
use crate::track::Pose;

impl<R: Real> Context<R> {
    /// Checks the sensors and takes from them what they tell.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn observe(
        &mut self,
        tracked: &mut Tracked<R>,
        out: &StepSummary<R>,
        sample: &Sample<R>,
        drive: &Drive<R>,
        present: &Segment,
        seen: Option<&Pose<R>>,
        effects: R,
        doubt: &mut u32,
    ) -> Observed<R> {
        let (usable, bits) = self.health.check(sample, &self.limits);
        *doubt |= bits;
        let at_rest =
            apart(&[present.velocity_m_s, present.angular_rad_s], &[[0.0; 3]; 2], &self.params) < 0.5;
        // An object that stands on a table loads the fingers with the grip alone.
        let mut expected = out.reading.finger;
        if tracked.support.is_some() {
            expected = [[R::zero(); 6]; 2];
            expected[0][1] = -sample.grip_cmd_n;
            expected[1][1] = sample.grip_cmd_n;
        }
        if self.observer.tare(&usable, &expected, at_rest) {
            *doubt |= validity::BIASED;
        }
        let wrenches = self.observer.corrected(&usable);
        if let [Some(a), Some(b)] = &wrenches {
            let holding = present.intent == Intent::Hold && !tracked.pushing;
            let allowed = R::of(f64::from(self.params.unbalanced_n))
                + sample.grip_cmd_n.abs() * R::of(f64::from(self.params.unbalanced_share));
            let left = if holding { a[1] + b[1] } else { R::zero() };
            if self.health.biased(left, allowed) {
                *doubt |= validity::BIASED;
            }
            let (mut miss, mut size) = (R::zero(), R::zero());
            let [f1, f2] = &out.reading.finger;
            // Along X and Z.
            for (measured, model) in [(a[0] + b[0], f1[0] + f2[0]), (a[2] + b[2], f1[2] + f2[2])] {
                miss += (measured - model).abs();
                size += max(measured.abs(), model.abs());
            }
            let parted = seen.is_some_and(|s| {
                norm(&(s.position_m - tracked.state.position_m)) > R::of(f64::from(self.params.pose_apart_m))
            });
            let apart = miss
                > size * R::of(f64::from(self.params.load_apart_share))
                    + R::of(f64::from(self.params.load_apart_n))
                || parted;
            tracked.apart = if apart { tracked.apart.saturating_add(1) } else { 0 };
        }
        if tracked.apart >= 3 {
            *doubt |= validity::MODEL;
        }
        let points_m = seen.filter(|_| !tracked.away).map(|s| {
            let turn = s.rotation * tracked.start.rotation.inverse();
            let half = tracked.state.jaw_half_m;
            let about_y = turn.into_inner().j * R::of(2.0) * patch_arm(&self.scene);
            [half, -half].map(|y| {
                let pad = Vec3::new(R::zero(), y, R::zero());
                let moved = s.position_m + turn.transform_vector(&(pad - tracked.start.position_m)) - pad;
                Vec3::new(moved.x, about_y, moved.z)
            })
        });
        // The planned motion changes: so does the load, for a while.
        let motion = [present.velocity_m_s, present.angular_rad_s];
        tracked.settling_s -= drive.dt_s;
        if apart(&motion, &tracked.motion, &self.params) > 1.0 {
            tracked.settling_s = R::of(f64::from(self.params.settling_s));
            tracked.motion = motion;
        }
        let soon = self.plan.at(sample.t_s.to_f64() as f32 + self.params.plan_late_s);
        let soon =
            soon.is_some_and(|s| apart(&[s.velocity_m_s, s.angular_rad_s], &motion, &self.params) > 1.0);
        if soon {
            tracked.settling_s = max(tracked.settling_s, drive.dt_s);
        }
        tracked.gaining_s -= drive.dt_s;
        if let Some(gripper) = &sample.gripper {
            let noise_m2 = tracked.gripper.noise_m2();
            if tracked.acceleration.gains(gripper.position_m, noise_m2, drive.dt_s) {
                tracked.gaining_s = R::of(f64::from(self.params.inertia_s));
            }
        }
        let up = -drive.carrier.inverse_transform_vector(&Vec3::from(self.scene.gravity_m_s2));
        let bears = |w: &[[R; 6]; 2]| {
            let sum = |i: usize| w[0][i] + w[1][i];
            Vec3::new(sum(0), sum(1), sum(2)).dot(&up) / norm(&up)
        };
        let bearing_n = match &wrenches {
            [Some(a), Some(b)] if norm(&up) > R::of(1e-3) => {
                Some([bears(&[*a, *b]), bears(&out.reading.finger)])
            }
            _ => None,
        };
        let observed = self.observer.observe(&Seen {
            wrenches: &wrenches,
            grip_n: sample.grip_cmd_n,
            points_m,
            gripper_m_s: drive
                .carrier
                .inverse_transform_vector(&tracked.acceleration.velocity_m_s(drive.dt_s)),
            arm_m: self.torsion_arm_m,
            bearing_n,
            steered: tracked.steered(),
            accelerates: soon
                || tracked.settling_s > R::of(f64::from(self.params.settling_s - self.params.gaining_s)),
            effects,
            sliding: self.sliding,
            dt_s: drive.dt_s,
        });
        if observed.unseen {
            *doubt |= validity::POSE;
        }
        observed
    }
}

/// How far two motions (m/s, rad/s) are apart: 1 is another motion.
fn apart(a: &[[f32; 3]; 2], b: &[[f32; 3]; 2], params: &Params) -> f32 {
    let of = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).fold(0.0f32, |m, (a, b)| m.max((a - b).abs()));
    (of(&a[0], &b[0]) / params.other_motion_m_s).max(of(&a[1], &b[1]) / params.other_motion_rad_s)
}
