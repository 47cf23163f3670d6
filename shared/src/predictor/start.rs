//! The tracked object is started at its first pose, drawn towards later ones, and started anew where it has parted
//! from them.

use super::context::Context;
use super::decide::Alarms;
use super::late::Waiting;
use super::sag::Sag;
use super::tracked::Tracked;
use super::types::Sample;
use crate::cone::Kept;
use crate::real::{Real, Vec3, max, norm};
use crate::step::{Drive, State};
use crate::track::{
    Acceleration, PathFilter, Pose, Poses, Settling, between_pads, drive_between, seat, support_pose,
    twist_between,
};

impl<R: Real> Context<R> {
    /// Begins to track the object at its first pose; `None` where that or the gripper's is missing.
    #[cold]
    pub(super) fn start(&mut self, sample: &Sample<R>) -> Option<Tracked<R>> {
        let object = sample.object?;
        let mut poses = self.poses(sample, None)?;
        let local = between_pads(&self.scene, &poses.carrier.to_local(&object), &self.track);
        let support = support_pose(&self.scene, &poses.carrier.to_world(&local));
        poses.support = support;
        let reference_m = poses.pusher.map_or_else(Vec3::zeros, |p| p.position_m);
        let later = Poses { t_s: poses.t_s + R::of(0.004), ..poses };
        let drive = drive_between(&poses, &later, &reference_m, sample.grip_cmd_n, self.trial)?;
        self.observer = self.observer.restarted();
        let mut state = State::held(&self.scene, &self.model, &drive, local.position_m, local.rotation);
        let seat_m = seat(&self.scene, &self.model, &state, &drive);
        if let Some(p) = &mut poses.pusher {
            p.position_m += seat_m;
        }
        let mut seated = drive;
        if let Some(p) = &mut seated.pusher {
            p.position_m += drive.carrier.inverse_transform_vector(&seat_m);
        }
        let settling = Settling::begin(&self.scene, &self.model, &mut state, &seated, self.track.settling);
        Some(Tracked {
            state,
            poses,
            support,
            seat_m,
            reference_m: reference_m + seat_m,
            start: local,
            sag: [Sag::new(Vec3::zeros()); 2],
            pushing: false,
            apart: 0,
            strayed: 0,
            unsolved: 0,
            settling,
            ahead: None,
            kept: [Kept::nothing(); 2],
            seen_m: local.position_m,
            unseen_s: R::zero(),
            away: false,
            outlook: None,
            alarms: Alarms::default(),
            rest_m: local.position_m,
            slipped_m: Vec3::zeros(),
            motion: [[0.0; 3]; 2],
            settling_s: R::zero(),
            gripper: PathFilter::new(poses.carrier, self.track.path),
            pusher: poses.pusher.map(|p| PathFilter::new(p, self.track.path)),
            acceleration: Acceleration::new(poses.carrier.position_m, self.track.acceleration),
            gaining_s: R::zero(),
            waiting: Waiting::new(),
        })
    }

    /// Draws the model's object towards the measured pose where no contact resists; `true`
    /// where the two have parted.
    pub(super) fn correct(&self, tracked: &mut Tracked<R>, measured: &Pose<R>) -> bool {
        let state = &mut tracked.state;
        let mut error = measured.position_m - state.position_m;
        if norm(&error) > R::of(f64::from(self.limits.divergence_m)) {
            return true;
        }
        if self.scene.fingers.is_some() {
            error.y = R::zero();
        }
        if tracked.pushing
            && let Some(pusher) = tracked.poses.pusher
        {
            let n = tracked.poses.carrier.to_local(&pusher).rotation.transform_vector(&Vec3::x());
            error -= n * n.dot(&error);
        }
        if tracked.support.is_some() {
            error = Vec3::zeros();
        }
        state.position_m += error * R::of(f64::from(self.params.pose_gain));
        false
    }

    /// From the present poses, with the object in the grasp as it last was.
    #[cold]
    pub(super) fn start_again(&self, tracked: &mut Tracked<R>, drive: &Drive<R>, poses: Poses<R>) {
        let State { position_m, rotation, .. } = tracked.state;
        self.restart_at(tracked, drive, &Pose { position_m, rotation });
        tracked.unsolved = 0;
        tracked.poses = poses;
        tracked.gripper = PathFilter::new(poses.carrier, self.track.path);
        tracked.pusher = poses.pusher.map(|p| PathFilter::new(p, self.track.path));
        tracked.kept = [Kept::nothing(); 2];
        tracked.ahead = None;
        tracked.outlook = None;
    }

    /// At a measured pose: what the pads remember stays, and the jaw where it is no farther off than it holds.
    pub(super) fn restart_at(&self, tracked: &mut Tracked<R>, drive: &Drive<R>, measured: &Pose<R>) {
        let (scene, model) = (&self.scene, &self.model);
        let mut state = State::held(scene, model, drive, measured.position_m, measured.rotation);
        state.memory = tracked.state.memory;
        state.time_s = tracked.state.time_s;
        // Fingers that have closed on nothing, or were forced apart, are seated anew.
        let jaw_m = tracked.state.jaw_half_m + tracked.state.jaw_m - state.jaw_half_m - state.jaw_m;
        if jaw_m.abs() < R::of(f64::from(self.params.jaw_kept_m)) {
            state.jaw_half_m = tracked.state.jaw_half_m;
            state.jaw_m = tracked.state.jaw_m;
            state.slots = tracked.state.slots;
        }
        tracked.state = state;
    }

    /// The prescribed bodies at a sample; `None` where the gripper is not measured.
    pub(super) fn poses(&self, sample: &Sample<R>, tracked: Option<&Tracked<R>>) -> Option<Poses<R>> {
        let carrier = match (sample.gripper, tracked) {
            (Some(gripper), _) => gripper,
            // Nothing is grasped: a frame at rest where the object was first seen.
            (None, Some(t)) if self.scene.fingers.is_none() => t.poses.carrier,
            (None, None) if self.scene.fingers.is_none() => sample.object?,
            _ => return None,
        };
        let pusher = sample.pusher.map(|p| {
            let shift = tracked.map_or_else(Vec3::zeros, |t| t.seat_m);
            Pose { position_m: p.position_m + shift, rotation: p.rotation }
        });
        Some(Poses { t_s: sample.t_s, carrier, pusher, support: tracked.and_then(|t| t.support) })
    }

    /// Whether gripper or pusher leapt from one sample to the other: what is carried does not, so that such a pose is none.
    pub(super) fn leapt(&self, from: &Poses<R>, to: &Poses<R>) -> bool {
        let [least_s, fastest_m_s, fastest_rad_s] =
            [self.params.least_ahead_s, self.params.fastest_m_s, self.params.fastest_rad_s]
                .map(|x| R::of(f64::from(x)));
        let within_s = max(to.t_s - from.t_s, least_s);
        let leaps = |from: &Pose<R>, to: &Pose<R>| {
            let (speed, turning) = twist_between(from, to, within_s);
            !(norm(&speed) <= fastest_m_s && norm(&turning) <= fastest_rad_s)
        };
        let pushers = from.pusher.as_ref().zip(to.pusher.as_ref());
        leaps(&from.carrier, &to.carrier) || pushers.is_some_and(|(from, to)| leaps(from, to))
    }

    /// Takes sensor noise off the prescribed paths.
    pub(super) fn denoised(&self, raw: Poses<R>, tracked: &mut Tracked<R>) -> Poses<R> {
        let dt = raw.t_s - tracked.poses.t_s;
        if !(dt > R::zero()) {
            return raw;
        }
        let widen = |a: [f32; 3]| Vec3::from(a.map(|x| R::of(f64::from(x))));
        let planned =
            self.plan.at(raw.t_s.to_f64() as f32).map(|s| (widen(s.velocity_m_s), widen(s.angular_rad_s)));
        let carrier = if self.scene.fingers.is_some() {
            tracked.gripper.follow(&raw.carrier, dt, planned)
        } else {
            raw.carrier
        };
        let pusher = match (&mut tracked.pusher, &raw.pusher) {
            (Some(filter), Some(p)) => Some(filter.follow(p, dt, None)),
            _ => raw.pusher,
        };
        Poses { carrier, pusher, ..raw }
    }
}
