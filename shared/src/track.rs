//! From sampled poses to the drive of a step.
//!
//! The carrier is the gripper where one is measured, otherwise a frame at rest where the
//! object was first seen (planar pushing). A step runs from one sample to the next; its
//! velocities are the differences of the two poses over the time between them.

pub mod params;

pub use params::{AccelerationParams, Params, PathParams, SettlingParams};

use crate::cone::SolveBudget;
use crate::contact::{self, Body, Contacts, SLOTS};
use crate::model::{FingerContact, Model, Scene};
use crate::real::{Real, Rotation, Vec3, max, norm, sqrt};
use crate::solve::Follows;
use crate::step::{Drive, Moving, State, Workspace, support_under, turned};
use crate::window::shift_in;
use crate::work::Work;
use nalgebra::{Quaternion, UnitQuaternion};

/// Position (m) and rotation (local axes to world axes).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<R: Real> {
    /// Origin, world.
    pub position_m: Vec3<R>,
    /// Local axes to world axes.
    pub rotation: Rotation<R>,
}

impl<R: Real> Pose<R> {
    /// From `x, y, z` and `w, x, y, z`. `None` where a number is not finite or beyond any
    /// rig (a kilometre), or the quaternion's norm is off by more than 1 %; otherwise it is
    /// normalised.
    pub fn new(position_m: [R; 3], quaternion: [R; 4]) -> Option<Self> {
        let [w, x, y, z] = quaternion;
        let norm = sqrt(w * w + x * x + y * y + z * z);
        let good = position_m.iter().all(|p| p.abs() <= R::of(1e3)) && (norm - R::one()).abs() <= R::of(0.01);
        good.then(|| Self {
            position_m: Vec3::from(position_m),
            rotation: UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z) / norm),
        })
    }

    /// At the world's origin.
    pub fn identity() -> Self {
        Self { position_m: Vec3::zeros(), rotation: UnitQuaternion::identity() }
    }

    /// `other` as seen from this pose.
    pub fn to_local(&self, other: &Pose<R>) -> Pose<R> {
        Pose {
            position_m: self.rotation.inverse_transform_vector(&(other.position_m - self.position_m)),
            rotation: self.rotation.inverse() * other.rotation,
        }
    }

    /// A pose seen from this one, in the world.
    pub fn to_world(&self, local: &Pose<R>) -> Pose<R> {
        Pose {
            position_m: self.rotation.transform_vector(&local.position_m) + self.position_m,
            rotation: self.rotation * local.rotation,
        }
    }
}

/// The poses of the prescribed bodies at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Poses<R: Real> {
    /// Rises.
    pub t_s: R,
    /// The carrier.
    pub carrier: Pose<R>,
    /// World.
    pub pusher: Option<Pose<R>>,
    /// World; +X is the table's normal.
    pub support: Option<Pose<R>>,
}

/// Velocity (m/s) and angular velocity (rad/s) that lead from one pose to the next, in the
/// axes of the first.
pub fn twist_between<R: Real>(from: &Pose<R>, to: &Pose<R>, dt_s: R) -> (Vec3<R>, Vec3<R>) {
    let local = from.to_local(to);
    let q = local.rotation.quaternion();
    // Vector part of a small rotation: half the angle, to third order.
    let sign = if q.w < R::zero() { -R::of(2.0) } else { R::of(2.0) };
    let turn = Vec3::new(q.i, q.j, q.k) * sign;
    (local.position_m / dt_s, turn / dt_s)
}

/// A prescribed body seen from the carrier.
fn moving<R: Real>(
    from: (&Pose<R>, &Pose<R>),
    to: (&Pose<R>, &Pose<R>),
    dt_s: R,
    reference: &Vec3<R>,
) -> Moving<R> {
    let (carrier, body) = from;
    let start = carrier.to_local(body);
    let end = to.0.to_local(to.1);
    let (_, turn) = twist_between(&start, &end, dt_s);
    Moving {
        position_m: start.position_m,
        rotation: start.rotation,
        velocity_m_s: (end.position_m - start.position_m) / dt_s,
        angular_rad_s: start.rotation.transform_vector(&turn),
        reference_m: carrier.rotation.inverse_transform_vector(&(reference - carrier.position_m)),
    }
}

/// The drive that leads from the poses `from` to the poses `to`. `reference` is the
/// pusher's origin at the first sample (world). `None` where time does not rise.
pub fn drive_between<R: Real>(
    from: &Poses<R>,
    to: &Poses<R>,
    reference: &Vec3<R>,
    grip_n: R,
    trial: R,
) -> Option<Drive<R>> {
    let dt_s = to.t_s - from.t_s;
    if !(dt_s > R::of(1e-6)) {
        return None;
    }
    let (carrier_m_s, carrier_rad_s) = twist_between(&from.carrier, &to.carrier, dt_s);
    let seen = |a: &Option<Pose<R>>, b: &Option<Pose<R>>| match (a, b) {
        (Some(a), Some(b)) => Some(moving((&from.carrier, a), (&to.carrier, b), dt_s, reference)),
        _ => None,
    };
    Some(Drive {
        dt_s,
        carrier: from.carrier.rotation,
        carrier_m_s,
        carrier_rad_s,
        pusher: seen(&from.pusher, &to.pusher),
        support: seen(&from.support, &to.support),
        grip_n,
        trial,
    })
}

/// The pose of the table under an object first seen at `object`, in the world.
pub fn support_pose<R: Real>(scene: &Scene<R>, object: &Pose<R>) -> Option<Pose<R>> {
    scene.support.as_ref()?;
    let gravity = Vec3::from(scene.gravity_m_s2);
    let size = norm(&gravity);
    let up = if size > R::of(1e-3) { -gravity / size } else { Vec3::z() };
    let table = support_under(scene, &object.position_m, &object.rotation, &up);
    Some(Pose { position_m: table.position_m, rotation: table.rotation })
}

/// An object in the grasp (carrier axes) as the closed jaw holds it: midway between the pads, a flat
/// face flush to flat pads, a round one along them. What a pose shows off that is noise, to which
/// rigid pads would answer with forces, and an object that lies on something by rolling on it.
/// Poses that are far off are left as they are.
pub fn between_pads<R: Real>(scene: &Scene<R>, local: &Pose<R>, params: &Params<R>) -> Pose<R> {
    let mut seated = *local;
    if scene.fingers.is_none() || !(local.position_m.y.abs() < params.flush_m) {
        return seated;
    }
    // From the measured direction to the pads': the turn about their cross product.
    let turn = match scene.object.shape.face_towards(&local.rotation.inverse_transform_vector(&Vec3::y())) {
        Some(face) if matches!(scene.fingers, Some(FingerContact::Disc { .. })) => {
            local.rotation.transform_vector(&face.normal).cross(&Vec3::y())
        }
        Some(_) => Vec3::zeros(),
        None => {
            let axis = local.rotation.transform_vector(&Vec3::x());
            axis.cross(&Vec3::new(axis.x, R::zero(), axis.z))
        }
    };
    if norm(&turn) < params.flush_rad {
        seated.rotation = turned(&local.rotation, &turn);
        seated.position_m.y = R::zero();
    }
    seated
}

/// How far the pusher must be moved along its contact normal so that it does not overlap
/// the object at the start (m, world axes; zero where there is a gap). Pose noise of tens
/// of micrometres would otherwise appear as hundreds of newtons.
pub fn seat<R: Real>(
    scene: &Scene<R>,
    model: &Model<R>,
    state: &State<R, SLOTS>,
    drive: &Drive<R>,
) -> Vec3<R> {
    let mut found: Contacts<R, SLOTS> = heapless::Vec::new();
    crate::contact::find(scene, model, state, drive, &mut found);
    let mut deepest = R::zero();
    let mut shift = Vec3::zeros();
    for c in found.iter().filter(|c| c.body == Body::Pusher) {
        if c.gap_m < deepest {
            deepest = c.gap_m;
            shift = c.axes[0] * c.gap_m;
        }
    }
    drive.carrier.transform_vector(&shift)
}

/// Frees a measured path from sensor noise as the samples come: an alpha-beta tracker around
/// the planned velocity.
///
/// Motion capture errs by tens of micrometres a sample; differentiated at 250 Hz that would
/// be as fast as the push. The noise is estimated from third differences; a path without
/// noise (a robot's own encoders) passes unchanged.
#[derive(Clone, Debug)]
pub struct PathFilter<R: Real> {
    params: PathParams<R>,
    pose: Pose<R>,
    /// Departure from the planned velocity, world.
    drift_m_s: Vec3<R>,
    drift_rad_s: Vec3<R>,
    raw: [Vec3<R>; 3],
    seen: u8,
    /// Mean square of the noise, m² per axis.
    noise_m2: R,
}

impl<R: Real> PathFilter<R> {
    /// Begins at the first sample.
    pub fn new(first: Pose<R>, params: PathParams<R>) -> Self {
        Self {
            params,
            pose: first,
            drift_m_s: Vec3::zeros(),
            drift_rad_s: Vec3::zeros(),
            raw: [first.position_m; 3],
            seen: 1,
            noise_m2: R::zero(),
        }
    }

    /// Noise of the path on an axis, m^2.
    pub fn noise_m2(&self) -> R {
        self.noise_m2
    }

    /// The path's pose at a new sample. `planned`: velocity (m/s) and angular velocity
    /// (rad/s), world axes, where the plan tells.
    pub fn follow(&mut self, raw: &Pose<R>, dt_s: R, planned: Option<(Vec3<R>, Vec3<R>)>) -> Pose<R> {
        let [a, b, c] = self.raw;
        let third = raw.position_m - (c - b) * R::of(3.0) - a;
        self.raw = [b, c, raw.position_m];
        let square = third.dot(&third) / R::of(60.0);
        let quiet_m2 = self.params.quiet_m * self.params.quiet_m;
        if self.seen < 4 {
            self.seen += 1;
            self.noise_m2 = max(self.noise_m2, square);
        } else {
            // A start or stop is a few samples of large differences among many: limited.
            let limit = max(self.noise_m2 * self.params.noise_most, quiet_m2 * R::of(0.1));
            self.noise_m2 += (crate::real::min(square, limit) - self.noise_m2) * self.params.noise_share;
        }
        let (linear, angular) = planned.unwrap_or((Vec3::zeros(), Vec3::zeros()));
        let [alpha, beta] =
            if planned.is_some() { self.params.planned_gains } else { self.params.free_gains };
        let (v, w) = (linear + self.drift_m_s, angular + self.drift_rad_s);
        let ahead = Pose {
            position_m: self.pose.position_m + v * dt_s,
            rotation: turned(&self.pose.rotation, &(w * dt_s)),
        };
        let miss = raw.position_m - ahead.position_m;
        let quiet = self.noise_m2 < quiet_m2;
        if quiet || norm(&miss) > self.params.jump_m {
            self.drift_m_s = (raw.position_m - self.pose.position_m) / dt_s - linear;
            self.drift_rad_s = Vec3::zeros();
            self.pose = *raw;
            return *raw;
        }
        let (_, turn) = twist_between(&Pose { rotation: ahead.rotation, ..*raw }, raw, R::one());
        let turn = ahead.rotation.transform_vector(&turn);
        self.drift_m_s += miss * (beta / dt_s);
        self.drift_rad_s += turn * (beta / dt_s);
        self.pose = Pose {
            position_m: ahead.position_m + miss * alpha,
            rotation: turned(&ahead.rotation, &(turn * alpha)),
        };
        self.pose
    }
}

/// Samples in each of three blocks whose means' second difference is the acceleration.
const BLOCK: usize = 4;

/// The gripper's acceleration by its own measured pose: it explains load as inertia, with and without
/// a plan. `a = (p1 - 2 p2 + p3) / T^2` of three blocks' means, `T` a block's time; noise
/// `sigma sqrt(6 / n) / T^2`, delay 1.5 blocks (24 ms at 250 Hz).
#[derive(Clone, Debug)]
pub struct Acceleration<R: Real> {
    params: AccelerationParams<R>,
    /// The newest first.
    raw: [Vec3<R>; 3 * BLOCK],
    seen: u8,
}

impl<R: Real> Acceleration<R> {
    /// Begins at rest.
    pub fn new(first: Vec3<R>, params: AccelerationParams<R>) -> Self {
        Self { params, raw: [first; 3 * BLOCK], seen: 0 }
    }

    /// Velocity over the last sample, world axes.
    pub fn velocity_m_s(&self, dt_s: R) -> Vec3<R> {
        let [a, b, ..] = self.raw;
        (a - b) / dt_s
    }

    /// One sample; `noise_m2`: variance on an axis. Whether the gripper gains or loses speed.
    pub fn gains(&mut self, raw: Vec3<R>, noise_m2: R, dt_s: R) -> bool {
        shift_in(&mut self.raw, raw);
        self.seen = self.seen.saturating_add(1);
        if (self.seen as usize) < 3 * BLOCK {
            return false;
        }
        let n = R::of(BLOCK as f64);
        let block_s = dt_s * n;
        let mut second = Vec3::zeros();
        for (i, p) in self.raw.iter().enumerate() {
            let weight = if i / BLOCK == 1 { -2.0 } else { 1.0 };
            second += (p - raw) * R::of(weight);
        }
        let square = block_s * block_s * n;
        let sigma = sqrt(max(noise_m2, R::zero()) * R::of(6.0) * n);
        norm(&second) > self.params.least_m_s2 * square + sigma * self.params.sigmas
    }
}

/// Lets an object that lies on a table or platform when it is grasped load it with its
/// whole weight: the fingers close on an object at rest, so their friction starts at zero.
/// Local forces depend on history; without this a third of the weight would hang on the
/// fingers from the start.
#[derive(Clone, Copy, Debug)]
pub struct Settling<R: Real> {
    params: SettlingParams<R>,
    drive: Drive<R>,
    /// Object in the carrier before.
    from: Pose<R>,
    left: u8,
}

impl<R: Real> Settling<R> {
    /// `None` where only the fingers hold the object.
    pub fn begin(
        scene: &Scene<R>,
        model: &Model<R>,
        state: &mut State<R, SLOTS>,
        drive: &Drive<R>,
        params: SettlingParams<R>,
    ) -> Option<Self> {
        let gravity = drive.carrier.inverse_transform_vector(&Vec3::from(scene.gravity_m_s2));
        let mut found: Contacts<R, SLOTS> = heapless::Vec::new();
        crate::contact::find(scene, model, state, drive, &mut found);
        let carried = found.iter().any(|c| {
            matches!(c.body, Body::Pusher | Body::Support)
                && c.gap_m < params.touching_m
                && c.axes[0].dot(&gravity) < R::of(-0.5) * norm(&gravity)
        });
        if !carried || scene.fingers.is_none() {
            return None;
        }
        state.absolute_m_s = Vec3::zeros();
        state.absolute_rad_s = Vec3::zeros();
        let from = Pose { position_m: state.position_m, rotation: state.rotation };
        Some(Self { params, drive: *drive, from, left: params.steps })
    }

    /// Steps while half of `most_work` ([`crate::step::StepSummary::work`]) is left, each bounded by what is left;
    /// `true` when the object has settled.
    pub fn go_on(
        &mut self,
        scene: &Scene<R>,
        model: &Model<R>,
        state: &mut State<R, SLOTS>,
        most_work: u32,
        work: &mut Workspace<R, SLOTS>,
    ) -> bool {
        let mut base = Model::base(model.base, model.friction);
        base.friction.finger = R::zero();
        let still = Drive {
            carrier_m_s: Vec3::zeros(),
            carrier_rad_s: Vec3::zeros(),
            pusher: self.drive.pusher.map(at_rest),
            support: self.drive.support.map(at_rest),
            ..self.drive
        };
        let mut done = Work::default();
        while self.left > 0 && done.done() <= most_work / 2 {
            let exact = SolveBudget { follows: Follows::Credible, ..SolveBudget::default() };
            let options = done.bounding(&exact, most_work);
            let out = crate::step::step_in(scene, &base, state, &still, &options, work);
            done.add(&out);
            self.left = self.left.saturating_sub(1);
            let now = self.from.to_local(&Pose { position_m: state.position_m, rotation: state.rotation });
            let (_, turned_rad) = twist_between(&Pose::identity(), &now, R::one());
            // What cannot be solved does not settle.
            let settles = out.followed
                && norm(&now.position_m) < self.params.settled_m
                && norm(&turned_rad) < self.params.settled_rad;
            if !settles {
                let Pose { position_m, rotation } = self.from;
                *state = State::held(scene, model, &self.drive, position_m, rotation);
                self.left = 0;
            }
        }
        if self.left > 0 {
            return false;
        }
        for slot in state.slots.iter_mut().take(2 * contact::FINGER_POINTS) {
            slot.spring_m = [R::zero(); 2];
            slot.slip_m = R::zero();
            slot.rest_s = R::zero();
        }
        let turn = self.drive.carrier_rad_s;
        state.time_s = R::zero();
        state.absolute_m_s = self.drive.carrier_m_s + turn.cross(&state.position_m);
        state.absolute_rad_s = turn;
        true
    }
}

/// [`Settling`] at one go.
pub fn settle<R: Real>(
    scene: &Scene<R>,
    model: &Model<R>,
    state: &mut State<R, SLOTS>,
    drive: &Drive<R>,
    params: SettlingParams<R>,
) {
    if let Some(mut settling) = Settling::begin(scene, model, state, drive, params) {
        settling.go_on(scene, model, state, u32::MAX, &mut Workspace::new());
    }
}

fn at_rest<R: Real>(body: Moving<R>) -> Moving<R> {
    Moving { velocity_m_s: Vec3::zeros(), angular_rad_s: Vec3::zeros(), ..body }
}
