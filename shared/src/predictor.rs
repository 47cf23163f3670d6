//! The predictor that both sides run: samples and plan in, slip, sag and drop out.
//!
//! Every tick it
//! 1. steps the contact model from the last sample to this one, driven by the measured
//!    gripper (and pusher) poses, so that the model's object follows the real rig;
//! 2. draws the model's object slowly towards the measured pose where one is given, and
//!    restarts it there when the two have parted (the validity word says so);
//! 3. takes friction utilisation from the measured fingertip wrenches, against the limit
//!    surface of each finger, `sqrt((f_t / mu N)^2 + (tau / mu N rho)^2)` (Howe and
//!    Cutkosky 1996), with `rho` two thirds of the patch radius;
//! 4. looks ahead along the plan in steps of several ticks and notes when a finger begins
//!    to slip, how fast and where to, how far the object sags and turns, and whether the
//!    grasp is lost.
//!
//! In a prehensile push slip is intended. A plan segment says so ([`Intent`]); slip across
//! the intended direction, slip while holding, sag and rotation beyond their limits are
//! flagged as unexpected.

use crate::cone::{ConeOptions, ConeStatus};
use crate::contact::SLOTS;
use crate::model::{FingerContact, Model, Scene, Shape};
use crate::real::{Real, Vec3, clamp, least, most};
use crate::step::{Drive, State, StepSummary, Workspace, step_in};
use crate::track::{PathFilter, Pose, Poses, drive_between, seat, settle, support_pose};
use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Most segments of a plan.
pub const MAX_SEGMENTS: usize = 8;
/// Look-ahead steps over the horizon.
pub const LOOK_AHEAD_STEPS: u8 = 5;
/// Evaluations of the momentum balance that one look-ahead may take, and that each of its
/// steps is sure of: with the bound on the present step they bound the time of a tick.
const LOOK_AHEAD_EVALUATIONS: u32 = 60;
const LEAST_EVALUATIONS: u32 = 4;
/// Longest time between two samples that the model bridges; after a longer gap it starts anew.
pub const LONGEST_GAP_S: f64 = 0.1;
/// Longest single step of the model.
const LONGEST_STEP_S: f64 = 0.02;

/// What a plan segment means to do with the grasp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema)]
pub enum Intent {
    /// The object shall stay where it is in the grasp.
    #[default]
    Hold,
    /// The object shall slide through the grasp along its motion relative to the gripper;
    /// sag across it is not intended.
    Slide,
    /// The object shall turn between the fingers about the gripper's Y axis.
    Pivot,
    /// Any motion in the grasp is intended.
    Free,
}

/// Planned motion of the gripper for some time.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, Schema)]
pub struct Segment {
    /// For how long.
    pub duration_s: f32,
    /// Velocity of the gripper's origin, world axes.
    pub velocity_m_s: [f32; 3],
    /// Angular velocity of the gripper, world axes.
    pub angular_rad_s: [f32; 3],
    /// Grip force of each finger.
    pub grip_n: f32,
    /// What it means to do.
    pub intent: Intent,
}

/// Plan from `start_s` (time stamp of the samples) on; after its end the last segment goes on.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize, Schema)]
pub struct Plan {
    /// Time stamp at which the first segment begins.
    pub start_s: f32,
    /// In order.
    pub segments: Vec<Segment, MAX_SEGMENTS>,
}

impl Plan {
    /// The segment in force at `t_s`; `None` for an empty plan or before its start.
    pub fn at(&self, t_s: f32) -> Option<&Segment> {
        if !(t_s >= self.start_s) {
            return None;
        }
        let mut end = self.start_s;
        for s in &self.segments {
            end += s.duration_s;
            if t_s < end {
                return Some(s);
            }
        }
        self.segments.last()
    }
}

/// Limits beyond which motion in the grasp is flagged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Limits {
    /// How far to look ahead.
    pub horizon_s: f32,
    /// Sag (downward motion in the grasp) that is flagged.
    pub sag_m: f32,
    /// Rotation in the grasp that is flagged while holding or sliding.
    pub rotation_rad: f32,
    /// Slip speed below which a finger counts as sticking.
    pub slip_m_s: f32,
    /// Share of the friction limit that a held grasp shall keep below.
    pub target_utilisation: f32,
    /// Distance between model and measured pose at which the model starts anew.
    pub divergence_m: f32,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            horizon_s: 0.1,
            sag_m: 0.002,
            rotation_rad: 0.05,
            slip_m_s: 0.0005,
            target_utilisation: 0.8,
            divergence_m: 0.003,
        }
    }
}

/// What reaches the predictor each tick. Anything not measured is `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<R: Real> {
    /// Time stamp; rises.
    pub t_s: R,
    /// Grip force commanded, each finger.
    pub grip_cmd_n: R,
    /// World; `None` where nothing is grasped.
    pub gripper: Option<Pose<R>>,
    /// World.
    pub object: Option<Pose<R>>,
    /// World.
    pub pusher: Option<Pose<R>>,
    /// Force (N) and torque (N m) on the object, gripper axes, about the patch centre.
    pub finger: [Option<[R; 6]>; 2],
}

/// State of one finger.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, Schema)]
pub struct FingerPrediction {
    /// Share of the friction limit used now, by the measured wrench (NaN: not measured).
    pub measured_utilisation: f32,
    /// The same by the model.
    pub model_utilisation: f32,
    /// Largest utilisation of the look-ahead.
    pub peak_utilisation: f32,
    /// Slip speed now, by the model; zero while sticking.
    pub slip_speed_m_s: f32,
    /// Direction of slip now or, while sticking, of the predicted slip: angle in the finger
    /// plane from gripper X towards gripper Z.
    pub slip_direction_rad: f32,
    /// Time until slip begins: 0 when slipping, negative when none within the horizon.
    pub slip_in_s: f32,
}

/// Output of one tick.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, Schema)]
pub struct Prediction {
    /// See [`flags`].
    pub flags: u32,
    /// See [`validity`]; zero: nothing to object.
    pub validity: u32,
    /// Finger 1 (+Y), finger 2 (-Y).
    pub finger: [FingerPrediction; 2],
    /// Sag of the object in the grasp since the start.
    pub sag_m: f32,
    /// Sag expected at the end of the horizon.
    pub sag_ahead_m: f32,
    /// Rotation of the object in the grasp since the start.
    pub rotation_rad: f32,
    /// Time until the grasp is lost: negative when not within the horizon.
    pub drop_in_s: f32,
    /// Grip force of each finger that keeps the target utilisation; NaN where the plan means to slide.
    pub holding_grip_n: f32,
    /// Object in the grasp, model: position (m) in the gripper frame.
    pub position_m: [f32; 3],
    /// Object in the grasp, model: `w, x, y, z`.
    pub quaternion: [f32; 4],
    /// Model's wrench of each finger on the object.
    pub finger_wrench: [[f32; 6]; 2],
    /// Model's force of the pusher on the object, world axes.
    pub pusher_force_n: [f32; 3],
    /// Worst solver status of the tick: 0 solved, 1 iteration limit, 2 bad input, 3 numerical.
    pub solver_status: u8,
    /// Largest momentum error of the tick's solves, N.
    pub solver_residual_n: f32,
    /// Newton steps of the tick.
    pub solver_iterations: u16,
}

/// Bits of [`Prediction::flags`].
pub mod flags {
    /// Finger 1 slips now.
    pub const SLIP_1: u32 = 1;
    /// Finger 2 slips now.
    pub const SLIP_2: u32 = 1 << 1;
    /// Finger 1 will slip within the horizon.
    pub const SLIP_AHEAD_1: u32 = 1 << 2;
    /// Finger 2 will slip within the horizon.
    pub const SLIP_AHEAD_2: u32 = 1 << 3;
    /// Slip, now or ahead, that the plan does not intend.
    pub const UNEXPECTED: u32 = 1 << 4;
    /// Sag beyond its limit, now or ahead.
    pub const SAG: u32 = 1 << 5;
    /// Rotation in the grasp beyond its limit.
    pub const ROTATION: u32 = 1 << 6;
    /// The grasp will be lost within the horizon.
    pub const DROP: u32 = 1 << 7;
    /// The object touches the pusher.
    pub const PUSHING: u32 = 1 << 8;
}

/// Bits of [`Prediction::validity`]: reasons to doubt the prediction.
pub mod validity {
    /// A solve ended without reaching its tolerance.
    pub const SOLVER: u32 = 1;
    /// Model and measured pose had parted; the model was restarted at the measurement.
    pub const DIVERGED: u32 = 1 << 1;
    /// The sample was unusable (time did not rise, no gripper pose); the last prediction is repeated.
    pub const SAMPLE: u32 = 1 << 2;
    /// A gap in the samples was too long to bridge; the model was restarted.
    pub const GAP: u32 = 1 << 3;
    /// No fingertip wrench: utilisation is the model's alone.
    pub const NO_WRENCH: u32 = 1 << 4;
    /// No plan: the look-ahead assumes that the present motion goes on.
    pub const NO_PLAN: u32 = 1 << 5;
    /// The model has not started: it waits for a first sample with the object's pose.
    pub const WAITING: u32 = 1 << 6;
    /// Contact points beyond the capacity were left out.
    pub const POINTS_LOST: u32 = 1 << 7;
    /// The measured wrench was not finite.
    pub const WRENCH: u32 = 1 << 8;
}

/// Why scene and model were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum ModelError {
    /// Mass or inertia not positive or not finite.
    Mass,
    /// A length not positive or not finite.
    Geometry,
    /// A friction coefficient negative, above 10 or not finite.
    Friction,
    /// A stiffness or damping negative, zero or not finite.
    Compliance,
    /// An effect that this build does not know.
    UnknownEffect,
    /// An effect's parameter outside its bounds or not finite.
    EffectParameter,
    /// A formula missing, left over or malformed.
    Formula,
    /// Gravity not finite.
    Gravity,
}

/// Refuses what the step cannot work with.
pub fn validate<R: Real>(scene: &Scene<R>, model: &Model<R>) -> Result<(), ModelError> {
    let positive = |x: R| x.finite() && x > R::zero();
    let object = &scene.object;
    let diagonal = (0..3).all(|k| positive(object.inertia_kg_m2[k][k]));
    if !positive(object.mass_kg) || !diagonal || !object.inertia_kg_m2.iter().flatten().all(|x| x.finite()) {
        return Err(ModelError::Mass);
    }
    let shape_good = match &object.shape {
        Shape::Prism { length_m, side_m } => positive(*length_m) && positive(*side_m),
        Shape::Cylinder { length_m, diameter_m, across_flats_m } => {
            positive(*length_m)
                && positive(*diameter_m)
                && positive(*across_flats_m)
                && *across_flats_m <= *diameter_m
        }
        Shape::Polygon { vertices_m, height_m } => {
            positive(*height_m) && vertices_m.len() >= 3 && vertices_m.iter().flatten().all(|x| x.finite())
        }
    };
    let finger_good = match scene.fingers {
        Some(FingerContact::Disc { diameter_m: d } | FingerContact::Line { length_m: d }) => positive(d),
        _ => true,
    };
    if !shape_good || !finger_good {
        return Err(ModelError::Geometry);
    }
    if !scene.gravity_m_s2.iter().all(|x| x.finite()) {
        return Err(ModelError::Gravity);
    }
    let f = &model.friction;
    if [f.finger, f.pusher, f.support].iter().any(|m| !(m.finite() && *m >= R::zero() && *m <= R::of(10.0))) {
        return Err(ModelError::Friction);
    }
    if let crate::model::Base::Soft { normal_n_m, tangential_n_m, damping_s } = model.base
        && (!positive(normal_n_m)
            || !positive(tangential_n_m)
            || !damping_s.finite()
            || damping_s < R::zero())
    {
        return Err(ModelError::Compliance);
    }
    let formulas = model.effects.iter().filter(|e| e.code == crate::effects::formula::CODE).count();
    if formulas != model.formulas.len() || model.formulas.iter().any(|f| f.check().is_err()) {
        return Err(ModelError::Formula);
    }
    for e in &model.effects {
        let info = e.info().ok_or(ModelError::UnknownEffect)?;
        let inside = |(p, i): (&R, &crate::effects::Parameter)| {
            // Bounds are decimal; a value sent as f32 may round just past them.
            let slack = 1e-6 * (i.high - i.low);
            p.finite() && p.to_f64() >= i.low - slack && p.to_f64() <= i.high + slack
        };
        if !e.parameters.iter().zip(info.parameters).all(inside) {
            return Err(ModelError::EffectParameter);
        }
    }
    Ok(())
}

/// The predictor: parameters, plan and the state of the tracked object.
#[derive(Clone, Debug)]
pub struct Predictor<R: Real> {
    scene: Scene<R>,
    model: Model<R>,
    limits: Limits,
    plan: Plan,
    trial: R,
    tracked: Option<Tracked<R>>,
    last: Prediction,
}

/// State of a started predictor.
#[derive(Clone, Debug)]
struct Tracked<R: Real> {
    state: State<R, SLOTS>,
    poses: Poses<R>,
    support: Option<Pose<R>>,
    /// Moves the pusher clear of the object, world.
    seat_m: Vec3<R>,
    reference_m: Vec3<R>,
    start: Pose<R>,
    pushing: bool,
    gripper: PathFilter<R>,
    pusher: Option<PathFilter<R>>,
}

impl<R: Real> Predictor<R> {
    /// A predictor that waits for its first sample.
    pub fn new(scene: Scene<R>, model: Model<R>, limits: Limits) -> Result<Self, ModelError> {
        validate(&scene, &model)?;
        Ok(Self {
            scene,
            model,
            limits,
            plan: Plan::default(),
            trial: R::zero(),
            tracked: None,
            last: Prediction { drop_in_s: -1.0, ..Prediction::default() },
        })
    }

    /// Replaces the plan from the next tick on.
    pub fn set_plan(&mut self, plan: Plan) {
        self.plan = plan;
    }

    /// Place of the trial in its data set (wear goes with it).
    pub fn set_trial(&mut self, trial: R) {
        self.trial = trial;
    }

    /// Forgets the tracked object; the next sample with an object pose starts anew.
    pub fn restart(&mut self) {
        self.tracked = None;
    }

    /// The scene and model in use.
    pub fn model(&self) -> (&Scene<R>, &Model<R>) {
        (&self.scene, &self.model)
    }

    fn poses(&self, sample: &Sample<R>, tracked: Option<&Tracked<R>>) -> Option<Poses<R>> {
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

    /// Takes sensor noise off the prescribed paths.
    fn denoised(&self, raw: Poses<R>, tracked: &mut Tracked<R>) -> Poses<R> {
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

    fn start(&mut self, sample: &Sample<R>) -> Option<()> {
        let object = sample.object?;
        let support = support_pose(&self.scene, &object);
        let mut poses = self.poses(sample, None)?;
        poses.support = support;
        let reference_m = poses.pusher.map_or_else(Vec3::zeros, |p| p.position_m);
        let later = Poses { t_s: poses.t_s + R::of(0.004), ..poses };
        let drive = drive_between(&poses, &later, &reference_m, sample.grip_cmd_n, self.trial)?;
        let local = poses.carrier.to_local(&object);
        let mut state = State::held(&self.scene, &self.model, &drive, local.position_m, local.rotation);
        let seat_m = seat(&self.scene, &self.model, &state, &drive);
        if let Some(p) = &mut poses.pusher {
            p.position_m += seat_m;
        }
        let mut seated = drive;
        if let Some(p) = &mut seated.pusher {
            p.position_m += drive.carrier.inverse_transform_vector(&seat_m);
        }
        settle(&self.scene, &self.model, &mut state, &seated);
        self.tracked = Some(Tracked {
            state,
            poses,
            support,
            seat_m,
            reference_m: reference_m + seat_m,
            start: local,
            pushing: false,
            gripper: PathFilter::new(poses.carrier),
            pusher: poses.pusher.map(PathFilter::new),
        });
        Some(())
    }

    /// One tick. Never panics; work is bounded.
    // A function of its own in the firmware: `make no-panic` follows its calls.
    #[inline(never)]
    pub fn tick(&mut self, sample: &Sample<R>) -> Prediction {
        let mut doubt = 0;
        if !sample.t_s.finite() || !sample.grip_cmd_n.finite() {
            return self.repeat(validity::SAMPLE);
        }
        let elapsed = self.tracked.as_ref().map(|t| sample.t_s - t.poses.t_s);
        if elapsed.is_some_and(|e| e > R::of(LONGEST_GAP_S)) {
            doubt |= validity::GAP;
            self.tracked = None;
        }
        if self.tracked.is_none() {
            if self.start(sample).is_none() {
                return self.repeat(doubt | validity::WAITING);
            }
            self.last = Prediction { drop_in_s: -1.0, validity: doubt, ..Prediction::default() };
            return self.last;
        }
        match self.follow(sample, doubt) {
            Some(p) => {
                self.last = p;
                p
            }
            None => self.repeat(validity::SAMPLE),
        }
    }

    fn repeat(&mut self, doubt: u32) -> Prediction {
        Prediction { validity: self.last.validity | doubt, ..self.last }
    }

    fn follow(&mut self, sample: &Sample<R>, mut doubt: u32) -> Option<Prediction> {
        let mut tracked = self.tracked.take()?;
        let poses = self.poses(sample, Some(&tracked)).map(|raw| self.denoised(raw, &mut tracked));
        let next = poses.and_then(|poses| {
            let from = &tracked.poses;
            let drive = drive_between(from, &poses, &tracked.reference_m, sample.grip_cmd_n, self.trial)?;
            Some((poses, drive))
        });
        let Some((poses, drive)) = next else {
            self.tracked = Some(tracked);
            return None;
        };
        let mut work = Workspace::new();
        let mut out = advance(&self.scene, &self.model, &mut tracked.state, &drive, &mut work);
        let mut worst = Worst::default();
        worst.note(&out);
        tracked.poses = poses;
        if out.points_lost > 0 {
            doubt |= validity::POINTS_LOST;
        }
        tracked.pushing = out.normal_n[2] > R::zero();
        if let Some(object) = sample.object {
            let measured = poses.carrier.to_local(&object);
            if self.correct(&mut tracked, &measured) {
                doubt |= validity::DIVERGED;
                let seen = Self::restarted(&self.scene, &self.model, &tracked, &drive, &measured);
                tracked.state = seen;
                out.reading.position_m = measured.position_m;
                out.reading.rotation = measured.rotation;
            }
        }
        let plan = self.plan.at(sample.t_s.to_f64() as f32).copied();
        let present = plan.unwrap_or_else(|| present_motion(&drive, sample));
        if plan.is_none() {
            doubt |= validity::NO_PLAN;
        }
        let mut p = self.describe(&tracked, &out, sample, &mut doubt);
        self.look_ahead(&tracked, &drive, sample, &present, &mut p, &mut worst, &mut work);
        judge(&mut p, present.intent, &self.limits, tracked.pushing);
        if worst.status != ConeStatus::Solved {
            doubt |= validity::SOLVER;
        }
        p.validity = doubt;
        p.solver_status = match worst.status {
            ConeStatus::Solved => 0,
            ConeStatus::IterationLimit => 1,
            ConeStatus::BadInput => 2,
            ConeStatus::Numerical => 3,
        };
        p.solver_residual_n = worst.residual_n.to_f64() as f32;
        p.solver_iterations = worst.iterations;
        self.tracked = Some(tracked);
        Some(p)
    }

    /// Draws the model's object towards the measured pose where no contact resists; `true`
    /// where the two have parted.
    fn correct(&self, tracked: &mut Tracked<R>, measured: &Pose<R>) -> bool {
        let state = &mut tracked.state;
        let mut error = measured.position_m - state.position_m;
        if error.norm() > R::of(f64::from(self.limits.divergence_m)) {
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
        // A second's time constant at 250 Hz: pose noise of 30 micrometres stays below 0.1.
        state.position_m += error * R::of(0.004);
        false
    }

    fn restarted(
        scene: &Scene<R>,
        model: &Model<R>,
        tracked: &Tracked<R>,
        drive: &Drive<R>,
        measured: &Pose<R>,
    ) -> State<R, SLOTS> {
        let mut state = State::held(scene, model, drive, measured.position_m, measured.rotation);
        state.jaw_half_m = tracked.state.jaw_half_m;
        state.jaw_m = tracked.state.jaw_m;
        state.slots = tracked.state.slots;
        state.memory = tracked.state.memory;
        state.time_s = tracked.state.time_s;
        state
    }

    fn describe(
        &self,
        tracked: &Tracked<R>,
        out: &StepSummary<R>,
        sample: &Sample<R>,
        doubt: &mut u32,
    ) -> Prediction {
        let mut p = Prediction { drop_in_s: -1.0, ..Prediction::default() };
        let narrow = |x: R| x.to_f64() as f32;
        for k in 0..2 {
            let f = &mut p.finger[k];
            f.model_utilisation = narrow(out.utilisation[k]);
            f.measured_utilisation = f32::NAN;
            match sample.finger[k] {
                Some(w) if w.iter().all(|x| x.finite()) => {
                    f.measured_utilisation = narrow(self.utilisation(&w))
                }
                Some(_) => *doubt |= validity::WRENCH,
                None => *doubt |= validity::NO_WRENCH,
            }
            let slip = out.slip_m_s[k];
            f.slip_speed_m_s = narrow(slip.norm());
            f.slip_direction_rad = direction(&slip);
            f.slip_in_s = -1.0;
            p.finger_wrench[k] = out.reading.finger[k].map(narrow);
        }
        let r = &out.reading;
        p.position_m = [narrow(r.position_m.x), narrow(r.position_m.y), narrow(r.position_m.z)];
        let q = r.rotation.quaternion();
        p.quaternion = [narrow(q.w), narrow(q.i), narrow(q.j), narrow(q.k)];
        p.pusher_force_n = [narrow(r.pusher[0]), narrow(r.pusher[1]), narrow(r.pusher[2])];
        p.sag_m = narrow(self.sag(&tracked.start, &tracked.poses.carrier, &tracked.state.position_m));
        p.rotation_rad = narrow(rotation_between(&tracked.start, &tracked.state));
        p
    }

    /// Motion in the grasp along gravity since the start.
    fn sag(&self, start: &Pose<R>, carrier: &Pose<R>, position_m: &Vec3<R>) -> R {
        let gravity = Vec3::from(self.scene.gravity_m_s2);
        let size = gravity.norm();
        if !(size > R::of(1e-3)) {
            return R::zero();
        }
        let down = carrier.rotation.inverse_transform_vector(&(gravity / size));
        down.dot(&(position_m - start.position_m))
    }

    /// Share of a finger's limit surface used by a measured wrench.
    fn utilisation(&self, w: &[R; 6]) -> R {
        let normal = w[1].abs();
        let mu = self.model.friction.finger;
        let limit = mu * normal;
        if !(limit > R::of(1e-6)) {
            return R::zero();
        }
        let tangential = (w[0] * w[0] + w[2] * w[2]).root() / limit;
        let arm = match self.scene.fingers {
            Some(FingerContact::Disc { diameter_m }) => diameter_m * R::of(1.0 / 3.0),
            Some(FingerContact::Line { length_m }) => length_m * R::of(0.5),
            _ => R::zero(),
        };
        let torsion = if arm > R::zero() { w[4] / (limit * arm) } else { R::zero() };
        (tangential * tangential + torsion * torsion).root()
    }

    #[allow(clippy::too_many_arguments)]
    fn look_ahead(
        &self,
        tracked: &Tracked<R>,
        drive: &Drive<R>,
        sample: &Sample<R>,
        present: &Segment,
        p: &mut Prediction,
        worst: &mut Worst<R>,
        work: &mut Workspace<R, SLOTS>,
    ) {
        let horizon = R::of(f64::from(self.limits.horizon_s));
        let dt = clamp(horizon / R::of(f64::from(LOOK_AHEAD_STEPS)), R::of(1e-3), R::of(LONGEST_STEP_S));
        let mut state = tracked.state.clone();
        let mut carrier = tracked.poses.carrier;
        let mut pusher = tracked.poses.pusher;
        let pusher_world = drive.pusher.map(|m| {
            let v = m.velocity_m_s + drive.carrier_m_s + drive.carrier_rad_s.cross(&m.position_m);
            drive.carrier.transform_vector(&v)
        });
        let threshold = R::of(f64::from(self.limits.slip_m_s));
        let mut speed_before = state.absolute_m_s.norm();
        for (f, now) in p.finger.iter_mut().zip([0.0f32; 2]) {
            f.peak_utilisation = f.model_utilisation;
            if f64::from(f.slip_speed_m_s) > threshold.to_f64() {
                f.slip_in_s = now;
            }
        }
        let mut evaluations = LOOK_AHEAD_EVALUATIONS;
        let mut steps_left = u32::from(LOOK_AHEAD_STEPS);
        let mut ahead = R::zero();
        while ahead < horizon {
            let t = (sample.t_s + ahead).to_f64() as f32;
            let segment = self.plan.at(t).unwrap_or(present);
            let widen = |a: [f32; 3]| Vec3::from(a.map(|x| R::of(f64::from(x))));
            let (linear, angular) = (widen(segment.velocity_m_s), widen(segment.angular_rad_s));
            let next_carrier = Pose {
                position_m: carrier.position_m + linear * dt,
                rotation: crate::step::turned(&carrier.rotation, &(angular * dt)),
            };
            let next_pusher = match (pusher, pusher_world) {
                (Some(p), Some(v)) => Some(Pose { position_m: p.position_m + v * dt, ..p }),
                _ => None,
            };
            let from = Poses { t_s: R::zero(), carrier, pusher, support: tracked.support };
            let to = Poses { t_s: dt, carrier: next_carrier, pusher: next_pusher, support: tracked.support };
            let grip = R::of(f64::from(segment.grip_n));
            let Some(next) = drive_between(&from, &to, &tracked.reference_m, grip, self.trial) else {
                break;
            };
            // Every later step keeps what a step needs that goes on as before.
            steps_left = steps_left.saturating_sub(1);
            let options =
                ConeOptions::look_ahead().within(evaluations.saturating_sub(LEAST_EVALUATIONS * steps_left));
            let out = step_in(&self.scene, &self.model, &mut state, &next, &options, work);
            evaluations = evaluations.saturating_sub(out.evaluations).max(LEAST_EVALUATIONS * steps_left);
            worst.note(&out);
            ahead += dt;
            let when = ahead.to_f64() as f32;
            for (k, f) in p.finger.iter_mut().enumerate() {
                let used = out.utilisation[k].to_f64() as f32;
                f.peak_utilisation = f.peak_utilisation.max(used);
                if f.slip_in_s < 0.0 && out.slip_m_s[k].norm() > threshold {
                    f.slip_in_s = when;
                    f.slip_direction_rad = direction(&out.slip_m_s[k]);
                }
            }
            let lost = self.scene.fingers.is_some()
                && (!(out.normal_n[0] > R::zero()) || !(out.normal_n[1] > R::zero()));
            // Falling: fast relative to the gripper and gaining half of gravity.
            let relative = Vec3::new(state.velocity[0], state.velocity[1], state.velocity[2]);
            let speed = relative.norm();
            let gain = (speed - speed_before) / dt;
            let falling = self.scene.fingers.is_some() && speed > R::of(0.05) && gain > R::of(2.0);
            speed_before = speed;
            if (lost || falling) && p.drop_in_s < 0.0 {
                p.drop_in_s = when;
            }
            carrier = next_carrier;
            pusher = next_pusher;
        }
        // Sag in the last carrier's axes: gravity has turned with it.
        p.sag_ahead_m = self.sag(&tracked.start, &carrier, &state.position_m).to_f64() as f32;
        let used = p.finger.iter().fold(0.0f32, |u, f| {
            let measured = if f.measured_utilisation.is_nan() { 0.0 } else { f.measured_utilisation };
            u.max(f.peak_utilisation).max(measured)
        });
        let grip = sample.grip_cmd_n.to_f64() as f32;
        p.holding_grip_n = match present.intent {
            Intent::Hold => grip * used / self.limits.target_utilisation.max(0.05),
            _ => f32::NAN,
        };
    }
}

/// Steps the model over a drive, in parts where it is long.
fn advance<R: Real>(
    scene: &Scene<R>,
    model: &Model<R>,
    state: &mut State<R, SLOTS>,
    drive: &Drive<R>,
    work: &mut Workspace<R, SLOTS>,
) -> StepSummary<R> {
    let mut parts: u8 = 1;
    while drive.dt_s / R::of(f64::from(parts)) > R::of(LONGEST_STEP_S * 1.001) && parts < 16 {
        parts += 1;
    }
    let mut part = *drive;
    part.dt_s = drive.dt_s / R::of(f64::from(parts));
    let options = ConeOptions::present();
    let mut out = step_in(scene, model, state, &part, &options, work);
    for _ in 1..parts {
        for m in [&mut part.pusher, &mut part.support].into_iter().flatten() {
            m.position_m += m.velocity_m_s * part.dt_s;
            m.rotation = crate::step::turned(&m.rotation, &(m.angular_rad_s * part.dt_s));
        }
        out = step_in(scene, model, state, &part, &options, work);
    }
    out
}

/// Without a plan: the gripper goes on as it moves now.
fn present_motion<R: Real>(drive: &Drive<R>, sample: &Sample<R>) -> Segment {
    let linear = drive.carrier.transform_vector(&drive.carrier_m_s);
    let angular = drive.carrier.transform_vector(&drive.carrier_rad_s);
    let narrow = |v: Vec3<R>| [v.x, v.y, v.z].map(|x| x.to_f64() as f32);
    Segment {
        duration_s: 1.0,
        velocity_m_s: narrow(linear),
        angular_rad_s: narrow(angular),
        grip_n: sample.grip_cmd_n.to_f64() as f32,
        intent: Intent::Hold,
    }
}

/// Angle of a slip velocity in the finger plane. Shown to people, so micromath's
/// approximation (about 1e-3 rad) is what is wanted; it is the same on every platform.
fn direction<R: Real>(slip_m_s: &Vec3<R>) -> f32 {
    use micromath::F32Ext;
    let (x, z) = (slip_m_s.x.to_f64() as f32, slip_m_s.z.to_f64() as f32);
    if x == 0.0 && z == 0.0 { 0.0 } else { F32Ext::atan2(z, x) }
}

fn rotation_between<R: Real>(start: &Pose<R>, state: &State<R, SLOTS>) -> R {
    let q = (start.rotation.inverse() * state.rotation).into_inner();
    let vector = (q.i * q.i + q.j * q.j + q.k * q.k).root();
    R::of(2.0) * vector.atan2(q.w.abs())
}

/// Sets the flags from the figures.
fn judge(p: &mut Prediction, intent: Intent, limits: &Limits, pushing: bool) {
    let mut set = 0;
    let (slip, ahead) = ([flags::SLIP_1, flags::SLIP_2], [flags::SLIP_AHEAD_1, flags::SLIP_AHEAD_2]);
    let mut any = false;
    for k in 0..2 {
        let f = &p.finger[k];
        if f.slip_speed_m_s > limits.slip_m_s {
            set |= slip[k];
        } else if f.slip_in_s >= 0.0 {
            set |= ahead[k];
        }
        any |= f.slip_in_s >= 0.0;
    }
    let sag = p.sag_m.max(p.sag_ahead_m) > limits.sag_m;
    let turned = p.rotation_rad > limits.rotation_rad;
    if sag && intent != Intent::Free {
        set |= flags::SAG;
    }
    if turned && matches!(intent, Intent::Hold | Intent::Slide) {
        set |= flags::ROTATION;
    }
    let unexpected = match intent {
        Intent::Hold => any,
        Intent::Slide => sag || turned,
        Intent::Pivot => sag,
        Intent::Free => false,
    };
    if unexpected {
        set |= flags::UNEXPECTED;
    }
    if p.drop_in_s >= 0.0 {
        set |= flags::DROP;
    }
    if pushing {
        set |= flags::PUSHING;
    }
    p.flags = set;
}

/// The worst of a tick's solves.
struct Worst<R> {
    status: ConeStatus,
    residual_n: R,
    iterations: u16,
}

impl<R: Real> Default for Worst<R> {
    fn default() -> Self {
        Self { status: ConeStatus::Solved, residual_n: R::zero(), iterations: 0 }
    }
}

impl<R: Real> Worst<R> {
    fn note(&mut self, out: &StepSummary<R>) {
        if out.status != ConeStatus::Solved {
            self.status = out.status;
        }
        self.residual_n = most(self.residual_n, out.residual_n);
        self.iterations = self.iterations.saturating_add(least(f64::from(out.iterations), 1e4) as u16);
    }
}

impl Prediction {
    /// Every output word, for comparing two sides bit for bit; NaNs are all the same NaN.
    pub fn words(&self) -> impl Iterator<Item = u32> + '_ {
        let bits = |x: f32| x.canonical_bits() as u32;
        let fingers = self.finger.iter().flat_map(move |f| {
            [
                f.measured_utilisation,
                f.model_utilisation,
                f.peak_utilisation,
                f.slip_speed_m_s,
                f.slip_direction_rad,
                f.slip_in_s,
            ]
            .map(bits)
        });
        let rest = [self.sag_m, self.sag_ahead_m, self.rotation_rad, self.drop_in_s, self.holding_grip_n];
        [self.flags, self.validity, u32::from(self.solver_status), u32::from(self.solver_iterations)]
            .into_iter()
            .chain(fingers)
            .chain(rest.into_iter().map(bits))
            .chain(self.position_m.into_iter().map(bits))
            .chain(self.quaternion.into_iter().map(bits))
            .chain(self.finger_wrench.iter().flatten().map(move |x| bits(*x)))
            .chain(self.pusher_force_n.into_iter().map(bits))
            .chain([bits(self.solver_residual_n)])
    }

    /// Hash of every output word (FNV-1a), continued from `before`.
    pub fn hash(&self, before: u32) -> u32 {
        self.words()
            .flat_map(u32::to_le_bytes)
            .fold(before, |h, b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193))
    }
}

/// Where a hash of predictions begins.
pub const HASH_START: u32 = 0x811c_9dc5;
