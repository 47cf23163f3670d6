//! What is known of slip, sag and loss of the grasp at one sample, for [`decide`](super::decide).

use super::context::Context;
use super::decide::{Evidence, sooner};
use super::plan::{Intent, Segment};
use super::tracked::Tracked;
use super::types::Prediction;
use crate::model::{FingerContact, Shape};
use crate::observer::Observed;
use crate::observer::motion::Moved;
use crate::real::{Real, Rotation, Vec3, max, min, norm, sqrt};
use crate::track::Pose;

/// What a tick is judged by besides the observer's figures.
pub(super) struct Now {
    /// The plan means motion in the grasp, now or soon.
    pub(super) moves: bool,
    /// Within the horizon.
    pub(super) moves_ahead: bool,
    pub(super) dt_s: f32,
    /// Model and measurement have not parted.
    pub(super) believed: bool,
}

impl<R: Real> Context<R> {
    /// What is known of slip, sag and loss of the grasp, for [`decide`]. Of a held object it learns
    /// how far slips go; of one that moves, the speed of its slip is shown.
    pub(super) fn evidence(
        &self,
        tracked: &mut Tracked<R>,
        p: &mut Prediction,
        observed: &Observed<R>,
        present: &Segment,
        seen: Option<&Pose<R>>,
        now: &Now,
    ) -> Evidence {
        let narrow = |x: R| x.to_f64() as f32;
        let slips = observed.moved.as_ref().map(|m| m.slip_s > R::zero());
        let (mut leaves_in_s, mut next_is_last) = (None, false);
        if present.intent != Intent::Hold {
            // What is meant to move rests nowhere.
            tracked.rest_m = tracked.seen_m;
            if let Some(moved) = observed.moved.as_ref().filter(|m| m.slip_s > R::zero()) {
                for (f, v) in p.finger.iter_mut().zip(&moved.velocity_m_s) {
                    f.slip_speed_m_s = f.slip_speed_m_s.max(narrow(norm(v)));
                }
            }
        } else if tracked.away && seen.is_some() {
            leaves_in_s = Some(0.0);
        } else if let (Some(moved), Some(seen)) = (&observed.moved, seen) {
            let edge_m = self.to_the_edge(tracked, seen);
            leaves_in_s = self
                .leaves_in(moved, &edge_m, &seen.rotation)
                .filter(|t| *t <= self.limits.drop_warning_s.min(self.foresight(moved)));
            tracked.note_slip(moved.slip_s > R::zero(), &seen.rotation);
            next_is_last = tracked.another_is_the_last(&edge_m, &self.params);
            self.sag_ahead(p, tracked, moved);
        }
        Evidence {
            intent: present.intent,
            moves: now.moves,
            moves_ahead: now.moves_ahead,
            dt_s: now.dt_s,
            // Without any wrench the model alone speaks, and the pose.
            blind: observed.finger.iter().all(Option::is_none),
            agrees: now.believed && observed.ratio.is_some_and(|r| self.agrees(p, observed, r)),
            pushing: tracked.pushing,
            slip: p.finger.map(|f| f.slip),
            drop_in_s: p.drop_in_s,
            slips,
            over_s: narrow(observed.over_s),
            limit_in_s: observed.limit_in_s.map(narrow),
            by_grip: observed.by_grip,
            eased: observed.eased,
            steered: tracked.steered(),
            used: observed.ratio.map_or(0.0, |r| narrow(r / max(observed.limit, R::of(1e-6)))),
            leaves_in_s,
            next_is_last,
            sag_m: p.sag_m,
            sag_ahead_m: p.sag_ahead_m,
            rotation_rad: p.rotation_rad,
        }
    }

    /// Whether an object seen there in the gripper has left the pads.
    pub(super) fn out_of_reach(&self, tracked: &Tracked<R>, seen: &Pose<R>) -> bool {
        let edge_m = self.to_the_edge(tracked, seen);
        self.scene.fingers.is_some() && edge_m.as_flattened().iter().any(|left| *left < R::zero())
    }

    /// How far each way (object X and Z) the object can still move until a pad's centre is off
    /// its face.
    fn to_the_edge(&self, tracked: &Tracked<R>, seen: &Pose<R>) -> [[R; 2]; 2] {
        // The grasp point in object axes, and how far the object reaches along each of them.
        let pad = seen.rotation.inverse_transform_vector(&-seen.position_m);
        let first = tracked.start.rotation.inverse_transform_vector(&-tracked.start.position_m);
        // A round side touches along a line: it leaves the pad at its rim.
        let rim = match (&self.scene.object.shape, self.scene.fingers) {
            (
                Shape::Cylinder { diameter_m, across_flats_m, .. },
                Some(FingerContact::Disc { diameter_m: pad } | FingerContact::Line { length_m: pad }),
            ) if *across_flats_m >= *diameter_m => Some(pad * R::of(0.5)),
            _ => None,
        };
        [(Vec3::x(), None), (Vec3::z(), rim)].map(|(axis, rim)| {
            let reach = self.scene.object.shape.reach(&axis);
            let reach = rim.map_or(reach, |rim| min(rim, reach));
            let at = pad.dot(&axis);
            if first.dot(&axis).abs() < reach {
                // The pad goes the other way than the object.
                [reach + at, reach - at]
            } else {
                [R::of(1.0); 2]
            }
        })
    }

    /// How far ahead a slip can be extrapolated.
    fn foresight(&self, moved: &Moved<R>) -> f32 {
        self.params.at_once_s + moved.slip_s.to_f64() as f32 * self.params.extrapolated
    }

    /// The model carries the load that is measured.
    fn agrees(&self, p: &Prediction, observed: &Observed<R>, ratio: R) -> bool {
        let used = (ratio / max(observed.limit, R::of(1e-6))).to_f64() as f32;
        let apart = match observed.moved {
            Some(_) => self.params.share_apart,
            None => self.params.unseen_apart,
        };
        p.finger.iter().all(|f| (f.model_utilisation - used).abs() < apart)
    }

    /// Time until the pads are off the object, if it goes on as it moves now: `d = v t + a t^2 / 2`.
    fn leaves_in(&self, moved: &Moved<R>, edge_m: &[[R; 2]; 2], attitude: &Rotation<R>) -> Option<f32> {
        if !(moved.slip_s > R::zero()) {
            return None;
        }
        let mut soonest: Option<f32> = None;
        let mean = (moved.velocity_m_s[0] + moved.velocity_m_s[1]) * R::of(0.5);
        // Without the turn.
        let velocity = attitude.inverse_transform_vector(&Vec3::new(mean.x, R::zero(), mean.z));
        let speed = norm(&velocity);
        for (v, sides) in [velocity.x, velocity.z].into_iter().zip(edge_m) {
            let way = if v > R::zero() { sides[0] } else { sides[1] };
            let v = v.abs();
            // The gain of speed along this axis.
            let a = if speed > R::zero() { moved.acceleration_m_s2 * v / speed } else { R::zero() };
            let reached = v * v + R::of(2.0) * a * way;
            if v > R::of(f64::from(self.params.leaving_m_s)) && reached > R::zero() {
                let t = R::of(2.0) * max(way, R::zero()) / (v + sqrt(reached));
                soonest = sooner(soonest, Some(t.to_f64() as f32));
            }
        }
        soonest
    }

    /// Sag that the present slip leads to, where that is more than the model's.
    fn sag_ahead(&self, p: &mut Prediction, tracked: &Tracked<R>, moved: &Moved<R>) {
        if !(moved.slip_s > R::zero()) {
            return;
        }
        let down =
            tracked.poses.carrier.rotation.inverse_transform_vector(&Vec3::from(self.scene.gravity_m_s2));
        let size = norm(&down);
        if size > R::of(1e-3) {
            let v = (moved.velocity_m_s[0] + moved.velocity_m_s[1]) * R::of(0.5);
            let sinking = (v.x * down.x + v.z * down.z) / size;
            let to_come = sinking.to_f64() as f32 * self.limits.horizon_s.min(self.foresight(moved));
            p.sag_ahead_m = p.sag_ahead_m.max(p.sag_m + to_come);
        }
    }
}
