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

use crate::cone::{Kept, SolveBudget, SolveStatus};
use crate::contact::{Body, SLOTS};
use crate::health::Health;
use crate::look_ahead::{Ahead, Course, Foreseen, LONGEST_STEP_S, TICK_WORK, Work};
use crate::model::{FingerContact, Model, Scene, Shape};
use crate::observer::motion::Moved;
use crate::observer::{Observed, Observer, Seen};
use crate::real::{Real, Rotation, Vec3, max, min, norm, sqrt};
use crate::step::{Drive, State, StepSummary, Workspace};
use crate::track::{PathFilter, Pose, Poses, Settling, drive_between, seat, support_pose};
use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Most segments of a plan.
pub const MAX_SEGMENTS: usize = 8;
/// Most steps in which a gap is bridged: a tick must end.
const MOST_PARTS: u8 = 3;
/// The epoch moves on after so long.
const EPOCH_US: u32 = 32_000_000;
/// Samples in a row that must show the object elsewhere before the model starts anew there.
const STRAYED_SAMPLES: u8 = 3;
/// A restart keeps jaw and contact memory where the jaw is within this of holding the object, m.
const JAW_KEPT_M: f64 = 1.0e-4;
/// Longest time between two samples that the model bridges; after a longer gap it starts anew.
pub const LONGEST_GAP_S: f64 = 0.1;
/// A warning stays up for so long after its cause was last seen.
const HELD_S: f32 = 0.15;
/// A change of the planned motion moves the load for so long, and a plan may be late by so much.
const SETTLING_S: f64 = 0.1;
const PLAN_LATE_S: f32 = 0.04;
/// Of the first, the time in which the gripper may still gain or lose speed.
const GAINING_S: f64 = 0.04;
/// Without a pose, a slip that lasts longer than most knocks is taken for the loss of the grasp.
const LASTING_S: f64 = 0.03;
/// A slip is extrapolated no further than this multiple of the time for which it has been
/// seen, and a little: most slips that a knock causes end by themselves.
const EXTRAPOLATED: f32 = 4.0;
const AT_ONCE_S: f32 = 0.03;
/// A slip ahead is at least a sample ahead.
const LEAST_AHEAD_S: f32 = 0.004;
/// An object that leaves the grasp moves at least this fast, m/s.
const LEAVING_M_S: f64 = 0.01;
/// A slip shorter than this says nothing of the next one, m.
const EDGE_NOISE_M: f64 = 2.0e-4;
/// The next slip may be longer than the last by so much.
const NEXT_SLIP: f64 = 1.25;
/// Slip and sag that the model alone foresees must be foreseen in so many samples in a row.
const FORESEEN_SAMPLES: u8 = 5;

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
    /// Slip nearer than this, by the trend of the measured load, is flagged.
    pub slip_warning_s: f32,
    /// Loss of a held grasp nearer than this, by the same trend, is flagged.
    pub drop_warning_s: f32,
    /// Range of the fingertip sensors: a force at or beyond it is saturated.
    pub force_range_n: f32,
    /// Range of their torques.
    pub torque_range_nm: f32,
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
            slip_warning_s: 0.25,
            drop_warning_s: 0.5,
            force_range_n: 200.0,
            torque_range_nm: 5.0,
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
    /// Friction coefficient of the fingers, learnt on-line from slips and near slips.
    pub friction: f32,
    /// Object in the grasp, model: position (m) in the gripper frame.
    pub position_m: [f32; 3],
    /// Object in the grasp, model: `w, x, y, z`.
    pub quaternion: [f32; 4],
    /// Model's wrench of each finger on the object.
    pub finger_wrench: [[f32; 6]; 2],
    /// Model's force of the pusher on the object, world axes.
    pub pusher_force_n: [f32; 3],
    /// Worst solver status of the tick: 0 solved, 1 iteration limit, 2 bad input, 3 numerical,
    /// 4 contacts that contradict each other. After 2 and 4 the last good state is kept.
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
    /// The flags cannot be relied on, raised or not: see the validity word.
    pub const UNSURE: u32 = 1 << 9;
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
    /// One finger's wrench is missing: the other stands for both.
    pub const ONE_FINGER: u32 = 1 << 9;
    /// A wrench repeats itself: the sensor is stuck or its link stale. It is not used.
    pub const STUCK: u32 = 1 << 10;
    /// A wrench is at the end of its range. It is not used.
    pub const SATURATED: u32 = 1 << 11;
    /// Constant error: the fingers' normal forces do not cancel while holding, or the start shows
    /// more than a constant error may be.
    pub const BIASED: u32 = 1 << 12;
    /// Model and measured wrench or pose disagree for three samples: slip by the model alone is
    /// not flagged.
    pub const MODEL: u32 = 1 << 13;
    /// A step of the look-ahead ended without reaching its tolerance: what lies beyond it is
    /// a best answer.
    pub const FORESIGHT: u32 = 1 << 14;
    /// No look-ahead is finished yet: only the present is told.
    pub const NO_FORESIGHT: u32 = 1 << 15;
    /// The object's measured pose is far from the model's; it is not used until it stays there.
    pub const POSE: u32 = 1 << 16;

    /// Doubts under which the flags cannot be relied on.
    pub const UNRELIABLE: u32 = SOLVER | SAMPLE | WAITING | WRENCH | ONE_FINGER | STUCK | SATURATED | BIASED;
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
            let (low, high) = (R::of(i.low), R::of(i.high));
            let slack = R::of(1e-6) * (high - low);
            p.finite() && *p >= low - slack && *p <= high + slack
        };
        if !e.parameters.iter().zip(info.parameters).all(inside) {
            return Err(ModelError::EffectParameter);
        }
    }
    Ok(())
}

fn seconds(us: u64) -> f32 {
    us as f32 * 1e-6
}

/// The predictor: parameters, plan and the state of the tracked object.
#[derive(Clone, Debug)]
pub struct Predictor<R: Real> {
    core: Core<R>,
    tracked: Option<Tracked<R>>,
}

/// All but the tracked object: that is large, and is worked on where it lies.
#[derive(Clone, Debug)]
struct Core<R: Real> {
    scene: Scene<R>,
    model: Model<R>,
    limits: Limits,
    /// Its start counted from the epoch.
    plan: Plan,
    /// What time is counted from, since the trial's beginning: `f32` seconds would lose the
    /// sampling time within an hour.
    epoch_us: u64,
    trial: R,
    health: Health<R>,
    observer: Observer<R>,
    /// Friction while sliding over that at rest, by the model's effects.
    sliding: R,
    /// Arm of a finger's torsional friction, the model's effects included, m.
    torsion_arm_m: R,
    last: Prediction,
    /// Of the last tick that stepped.
    work: u32,
}

/// Why a sample was not followed.
enum Unfollowed {
    /// It cannot be used.
    Sample,
    /// Its step had no answer.
    Solver {
        status: SolveStatus,
        /// The state has moved on the way: it is no longer that of the last sample.
        lost: bool,
    },
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
    /// Samples in a row in which model and measurement disagree.
    apart: u8,
    /// Samples in a row whose measured pose has parted from the model's.
    strayed: u8,
    /// The object still settles on what carries it.
    settling: Option<Settling<R>>,
    /// A look-ahead under way.
    ahead: Option<Ahead<R>>,
    /// Factors of the last step, and of the last one of the look-ahead.
    kept: [Kept<R>; 2],
    /// Where the object was last measured without a jump, in the gripper.
    seen_m: Vec3<R>,
    /// What the newest finished one found.
    outlook: Option<Foreseen<R>>,
    /// Samples in a row in which the model of a held grasp foresees slip and the measurement is with it.
    foreseen: u8,
    /// Samples in a row in which the look-ahead sees sag beyond its limit.
    sagging: u8,
    /// Where the object last rested, in the gripper; how far the last slip went, object axes.
    rest_m: Vec3<R>,
    slipped_m: Vec3<R>,
    /// Planned velocity and angular velocity, and how long a change of it still matters.
    motion: [[f32; 3]; 2],
    settling_s: R,
    /// What a held grasp was last warned of.
    slip_warning: Warning,
    drop_warning: Warning,
    gripper: PathFilter<R>,
    pusher: Option<PathFilter<R>>,
}

/// A warning stays up for a while after its cause was last seen: one episode, one alarm.
#[derive(Clone, Copy, Debug, Default)]
struct Warning {
    in_s: f32,
    left_s: f32,
}

impl Warning {
    /// Time left by what is seen now, or what is left of the last warning.
    fn hold(&mut self, seen: Option<f32>, dt_s: f32) -> Option<f32> {
        match seen {
            Some(in_s) => *self = Self { in_s, left_s: HELD_S },
            None => self.left_s -= dt_s,
        }
        (self.left_s > 0.0).then_some(self.in_s)
    }
}

impl<R: Real> Tracked<R> {
    /// How far the object has come in this slip, or came in the last one.
    fn note_slip(&mut self, slips: bool, attitude: &Rotation<R>) {
        let way = self.seen_m - self.rest_m;
        if slips {
            self.slipped_m = attitude.inverse_transform_vector(&way);
        } else {
            self.rest_m += way * R::of(0.1);
        }
    }

    /// One more slip as long as the last takes the pads' centres off the object: `edge_m` is
    /// the way left each way.
    fn another_is_the_last(&self, edge_m: &[[R; 2]; 2]) -> bool {
        [self.slipped_m.x, self.slipped_m.z].iter().zip(edge_m).any(|(moved, sides)| {
            let way = if *moved > R::zero() { sides[0] } else { sides[1] };
            moved.abs() > R::of(EDGE_NOISE_M) && moved.abs() * R::of(NEXT_SLIP) > way
        })
    }
}

impl<R: Real> Predictor<R> {
    /// A predictor that waits for its first sample.
    pub fn new(scene: Scene<R>, model: Model<R>, limits: Limits) -> Result<Self, ModelError> {
        validate(&scene, &model)?;
        Ok(Self::of_valid(scene, model, limits))
    }

    /// The same of what [`validate`] has let through.
    pub fn of_valid(scene: Scene<R>, model: Model<R>, limits: Limits) -> Self {
        Self {
            core: Core {
                health: Health::default(),
                observer: Observer::new(model.friction.finger),
                sliding: sliding_share(&model),
                torsion_arm_m: torsion_arm(&model, patch_arm(&scene)),
                scene,
                model,
                limits,
                plan: Plan::default(),
                epoch_us: 0,
                trial: R::zero(),
                last: Prediction { drop_in_s: -1.0, ..Prediction::default() },
                work: 0,
            },
            tracked: None,
        }
    }

    /// Work of the last tick that stepped, in evaluations of the momentum balance: what bounds
    /// the look-ahead, and what a search for the dearest tick counts.
    pub fn work(&self) -> u32 {
        self.core.work
    }

    /// Replaces the plan from the next tick on.
    pub fn set_plan(&mut self, plan: Plan) {
        self.core.plan = plan;
        self.core.plan.start_s -= seconds(self.core.epoch_us);
    }

    /// Place of the trial in its data set (wear goes with it).
    pub fn set_trial(&mut self, trial: R) {
        self.core.trial = trial;
    }

    /// Forgets the tracked object; the next sample with an object pose starts anew.
    pub fn restart(&mut self) {
        self.tracked = None;
        self.core.plan.start_s += seconds(self.core.epoch_us);
        self.core.epoch_us = 0;
    }

    /// One tick with a sample from the line. Its time stamp may wrap around (every 71 minutes).
    pub fn take(&mut self, sample: &crate::wire::Sample) -> Prediction {
        // The stamp's 32 bits are the lowest of the epoch's 64.
        let mut since_us = sample.t_us.wrapping_sub(self.core.epoch_us as u32);
        if self.tracked.is_none() || (EPOCH_US..=u32::MAX / 2).contains(&since_us) {
            self.move_epoch(since_us);
            since_us = 0;
        }
        // Beyond half the range it lies before the epoch.
        self.tick(&sample.at(R::of(f64::from(since_us.cast_signed())) * R::of(1e-6)))
    }

    /// Counts time from `by_us` later on.
    fn move_epoch(&mut self, by_us: u32) {
        let by_s = seconds(u64::from(by_us));
        self.core.epoch_us = self.core.epoch_us.wrapping_add(u64::from(by_us));
        self.core.plan.start_s -= by_s;
        if let Some(tracked) = &mut self.tracked {
            let by_s = R::of(f64::from(by_s));
            tracked.poses.t_s -= by_s;
            if let Some(outlook) = &mut tracked.outlook {
                outlook.began_s -= by_s;
            }
            // One under way would end with the times it began with: it is begun anew.
            tracked.ahead = None;
        }
    }

    /// Forgets what was learnt about friction: the next object or finger is another one.
    pub fn reset_friction(&mut self) {
        self.core.observer.reset_friction();
    }

    /// The scene and model in use; the fingers' friction is the estimate.
    pub fn model(&self) -> (&Scene<R>, &Model<R>) {
        (&self.core.scene, &self.core.model)
    }

    #[cold]
    fn start(&mut self, sample: &Sample<R>) -> Option<()> {
        let object = sample.object?;
        let support = support_pose(&self.core.scene, &object);
        let mut poses = self.core.poses(sample, None)?;
        poses.support = support;
        let reference_m = poses.pusher.map_or_else(Vec3::zeros, |p| p.position_m);
        let later = Poses { t_s: poses.t_s + R::of(0.004), ..poses };
        let drive = drive_between(&poses, &later, &reference_m, sample.grip_cmd_n, self.core.trial)?;
        let local = poses.carrier.to_local(&object);
        self.core.observer = self.core.observer.restarted();
        let mut state =
            State::held(&self.core.scene, &self.core.model, &drive, local.position_m, local.rotation);
        let seat_m = seat(&self.core.scene, &self.core.model, &state, &drive);
        if let Some(p) = &mut poses.pusher {
            p.position_m += seat_m;
        }
        let mut seated = drive;
        if let Some(p) = &mut seated.pusher {
            p.position_m += drive.carrier.inverse_transform_vector(&seat_m);
        }
        let settling = Settling::begin(&self.core.scene, &self.core.model, &mut state, &seated);
        self.tracked = Some(Tracked {
            state,
            poses,
            support,
            seat_m,
            reference_m: reference_m + seat_m,
            start: local,
            pushing: false,
            apart: 0,
            strayed: 0,
            settling,
            ahead: None,
            kept: [Kept::nothing(); 2],
            seen_m: local.position_m,
            outlook: None,
            foreseen: 0,
            sagging: 0,
            rest_m: local.position_m,
            slipped_m: Vec3::zeros(),
            motion: [[0.0; 3]; 2],
            settling_s: R::zero(),
            slip_warning: Warning::default(),
            drop_warning: Warning::default(),
            gripper: PathFilter::new(poses.carrier),
            pusher: poses.pusher.map(PathFilter::new),
        });
        Some(())
    }

    /// One tick. Never panics; work is bounded.
    pub fn tick(&mut self, sample: &Sample<R>) -> Prediction {
        let mut doubt = 0;
        if !sample.t_s.finite() || !sample.grip_cmd_n.finite() {
            return self.core.repeat(validity::SAMPLE);
        }
        let elapsed = self.tracked.as_ref().map(|t| sample.t_s - t.poses.t_s);
        if elapsed.is_some_and(|e| e > R::of(LONGEST_GAP_S)) {
            doubt |= validity::GAP;
            self.tracked = None;
        }
        if self.tracked.is_none() {
            if self.start(sample).is_none() {
                return self.core.repeat(doubt | validity::WAITING);
            }
            self.core.last = Prediction { drop_in_s: -1.0, validity: doubt, ..Prediction::default() };
            return self.core.last;
        }
        if self.settle() {
            return self.core.repeat(doubt | validity::WAITING);
        }
        let Self { core, tracked: place } = self;
        let Some(tracked) = place else { return core.repeat(doubt | validity::WAITING) };
        match core.follow(tracked, sample, doubt) {
            Ok(()) => {}
            Err(Unfollowed::Sample) => return core.repeat(validity::SAMPLE),
            Err(Unfollowed::Solver { status, lost }) => {
                if lost {
                    *place = None;
                }
                core.last =
                    Prediction { solver_status: status_code(status), ..core.repeat(validity::SOLVER) };
            }
        }
        core.last
    }

    /// Settles the object for a tick; `false` where it has nothing to settle.
    fn settle(&mut self) -> bool {
        let Some(Tracked { state, settling, .. }) = &mut self.tracked else { return false };
        let Some(going) = settling else { return false };
        if going.go_on(&self.core.scene, &self.core.model, state, TICK_WORK, &mut Workspace::new()) {
            *settling = None;
        }
        true
    }
}

impl<R: Real> Core<R> {
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

    fn repeat(&mut self, doubt: u32) -> Prediction {
        Prediction {
            validity: self.last.validity | doubt,
            flags: self.last.flags | flags::UNSURE,
            ..self.last
        }
    }

    /// The last prediction becomes that for the sample.
    fn follow(
        &mut self,
        tracked: &mut Tracked<R>,
        sample: &Sample<R>,
        mut doubt: u32,
    ) -> Result<(), Unfollowed> {
        let raw = self.poses(sample, Some(tracked)).ok_or(Unfollowed::Sample)?;
        let poses = self.denoised(raw, tracked);
        let drive =
            drive_between(&tracked.poses, &poses, &tracked.reference_m, sample.grip_cmd_n, self.trial)
                .ok_or(Unfollowed::Sample)?;
        self.model.friction.finger = self.observer.assumed_friction();
        let mut work = Workspace::new();
        *work.kept() = tracked.kept[0];
        let mut worst = Worst::default();
        let mut out = advance(&self.scene, &self.model, &mut tracked.state, &drive, &mut work, &mut worst);
        if matches!(out.status, SolveStatus::BadInput | SolveStatus::Contradiction) {
            // Numbers that no rig has: the last good state is kept for the next sample, and
            // after a gap's length of such samples the model starts anew. (It does so at once
            // where a gap was bridged in parts and the later ones failed.)
            self.work = worst.work.done();
            tracked.gripper = PathFilter::new(tracked.poses.carrier);
            tracked.pusher = tracked.poses.pusher.map(PathFilter::new);
            return Err(Unfollowed::Solver { status: out.status, lost: worst.moved });
        }
        tracked.kept[0] = *work.kept();
        let effects = self.effects_on_friction(&work, &load_of(sample, &out));
        tracked.poses = poses;
        if out.points_lost > 0 {
            doubt |= validity::POINTS_LOST;
        }
        tracked.pushing = out.normal_n[2] > R::zero();
        if let Some(object) = sample.object {
            let measured = poses.carrier.to_local(&object);
            let strayed = self.correct(tracked, &measured);
            tracked.strayed = if strayed { tracked.strayed.saturating_add(1) } else { 0 };
            // What slides leaves the model step by step, a wild pose jumps.
            let limit = R::of(f64::from(self.limits.divergence_m));
            let jumped = !(norm(&(measured.position_m - tracked.seen_m)) <= limit);
            if !(strayed && jumped) {
                tracked.seen_m = measured.position_m;
            }
            if strayed && jumped && tracked.strayed < STRAYED_SAMPLES {
                // One wild pose is the camera's error; an object does not jump there and back.
                doubt |= validity::POSE;
            } else if strayed {
                tracked.strayed = 0;
                tracked.seen_m = measured.position_m;
                tracked.ahead = None;
                tracked.outlook = None;
                doubt |= validity::DIVERGED;
                self.restart_at(tracked, &drive, &measured);
                out.reading.position_m = measured.position_m;
                out.reading.rotation = measured.rotation;
            }
        }
        let plan = self.plan.at(sample.t_s.to_f64() as f32).copied();
        let present = plan.unwrap_or_else(|| present_motion(&drive, sample));
        if plan.is_none() {
            doubt |= validity::NO_PLAN;
        }
        let object = sample.object.filter(|_| doubt & validity::POSE == 0);
        let seen = object.zip(sample.gripper).map(|(object, gripper)| gripper.to_local(&object));
        let observed =
            self.observe(tracked, &out, sample, &drive, &present, seen.as_ref(), effects, &mut doubt);
        let mut p = self.describe(tracked, &out, &observed, &present);
        let model_sag = p.sag_m;
        *work.kept() = tracked.kept[1];
        self.look_ahead(tracked, &drive, sample, &present, &mut p, &mut worst, &mut work, &mut doubt);
        tracked.kept[1] = *work.kept();
        if let Some(seen) = &seen {
            // The model knows what comes, the measurement what is.
            let to_come = p.sag_ahead_m - model_sag;
            p.sag_m = self.sag(tracked, &poses.carrier, &present, &seen.position_m).to_f64() as f32;
            p.sag_ahead_m = p.sag_m + to_come;
            p.rotation_rad = rotation_between(&tracked.start, &seen.rotation).to_f64() as f32;
        }
        if present.intent == Intent::Hold {
            let edge_m = seen.as_ref().map(|seen| (self.to_the_edge(tracked, seen), seen.rotation));
            let grip_n = sample.grip_cmd_n.to_f64() as f32;
            let dt_s = drive.dt_s.to_f64() as f32;
            self.combine(&mut p, tracked, &observed, Now { grip_n, edge_m, doubt, dt_s });
        } else {
            // What is meant to move rests nowhere.
            tracked.rest_m = tracked.seen_m;
            if let Some(moved) = observed.moved.as_ref().filter(|m| m.slip_s > R::zero()) {
                for (f, v) in p.finger.iter_mut().zip(&moved.velocity_m_s) {
                    f.slip_in_s = 0.0;
                    f.slip_speed_m_s = f.slip_speed_m_s.max(norm(v).to_f64() as f32);
                }
            }
        }
        let sags = self.sags(&p, tracked, &observed);
        judge(&mut p, present.intent, &self.limits, sags, tracked.pushing);
        if worst.status != SolveStatus::Solved {
            doubt |= validity::SOLVER;
        }
        if doubt & validity::UNRELIABLE != 0 {
            p.flags |= flags::UNSURE;
        }
        p.validity = doubt;
        p.solver_status = status_code(worst.status);
        self.work = worst.work.done();
        p.solver_residual_n = worst.residual_n.to_f64() as f32;
        p.solver_iterations = worst.iterations;
        self.last = p;
        Ok(())
    }

    /// Draws the model's object towards the measured pose where no contact resists; `true`
    /// where the two have parted.
    fn correct(&self, tracked: &mut Tracked<R>, measured: &Pose<R>) -> bool {
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
        // A second's time constant at 250 Hz: pose noise of 30 micrometres stays below 0.1.
        state.position_m += error * R::of(0.004);
        false
    }

    fn restart_at(&self, tracked: &mut Tracked<R>, drive: &Drive<R>, measured: &Pose<R>) {
        let (scene, model) = (&self.scene, &self.model);
        let mut state = State::held(scene, model, drive, measured.position_m, measured.rotation);
        state.memory = tracked.state.memory;
        state.time_s = tracked.state.time_s;
        // Fingers that have closed on nothing, or were forced apart, are seated anew.
        let jaw_m = tracked.state.jaw_half_m + tracked.state.jaw_m - state.jaw_half_m - state.jaw_m;
        if jaw_m.abs() < R::of(JAW_KEPT_M) {
            state.jaw_half_m = tracked.state.jaw_half_m;
            state.jaw_m = tracked.state.jaw_m;
            state.slots = tracked.state.slots;
        }
        tracked.state = state;
    }

    /// Checks the sensors and takes from them what they tell.
    #[allow(clippy::too_many_arguments)]
    fn observe(
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
        let at_rest = apart(&[present.velocity_m_s, present.angular_rad_s], &[[0.0; 3]; 2]) < 0.5;
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
            let allowed = R::of(1.0) + sample.grip_cmd_n.abs() * R::of(0.15);
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
            let parted =
                seen.is_some_and(|s| norm(&(s.position_m - tracked.state.position_m)) > R::of(0.0015));
            let apart = miss > size * R::of(0.3) + R::of(0.5) || parted;
            tracked.apart = if apart { tracked.apart.saturating_add(1) } else { 0 };
        }
        if tracked.apart >= 3 {
            *doubt |= validity::MODEL;
        }
        let points_m = seen.map(|s| {
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
        if apart(&motion, &tracked.motion) > 1.0 {
            tracked.settling_s = R::of(SETTLING_S);
            tracked.motion = motion;
        }
        let soon = self.plan.at(sample.t_s.to_f64() as f32 + PLAN_LATE_S);
        let soon = soon.is_some_and(|s| apart(&[s.velocity_m_s, s.angular_rad_s], &motion) > 1.0);
        if soon {
            tracked.settling_s = max(tracked.settling_s, drive.dt_s);
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
        self.observer.observe(&Seen {
            wrenches: &wrenches,
            grip_n: sample.grip_cmd_n,
            points_m,
            arm_m: self.torsion_arm_m,
            bearing_n,
            steered: tracked.settling_s > R::zero(),
            accelerates: soon || tracked.settling_s > R::of(SETTLING_S - GAINING_S),
            effects,
            sliding: self.sliding,
            dt_s: drive.dt_s,
        })
    }

    /// What the model's effects make of the fingers' friction limit under a load along `load`
    /// (carrier axes, any length): a factor on the base coefficient.
    fn effects_on_friction(&self, work: &Workspace<R, SLOTS>, load: &Vec3<R>) -> R {
        let (mut limit, mut normal) = (R::zero(), R::zero());
        for (c, answer) in work.contacts.iter().zip(work.answers()) {
            if matches!(c.body, Body::Finger1 | Body::Finger2) {
                let [force_n, ..] = answer.force_n;
                let bound = max(force_n + answer.adhesion_n, R::zero());
                limit += coefficient_along(&answer.mu, c.axes[1].dot(load), c.axes[2].dot(load)) * bound;
                normal += max(force_n, R::zero());
            }
        }
        let base = self.model.friction.finger * normal;
        if base > R::zero() { limit / base } else { R::one() }
    }

    fn describe(
        &self,
        tracked: &Tracked<R>,
        out: &StepSummary<R>,
        observed: &Observed<R>,
        present: &Segment,
    ) -> Prediction {
        let mut p = Prediction { drop_in_s: -1.0, ..Prediction::default() };
        let narrow = |x: R| x.to_f64() as f32;
        for (k, f) in p.finger.iter_mut().enumerate() {
            f.model_utilisation = narrow(out.utilisation[k]);
            f.measured_utilisation = match observed.finger[k] {
                Some(r) if observed.limit > R::zero() => narrow(r / observed.limit),
                _ => f32::NAN,
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
            f.slip_in_s = -1.0;
            p.finger_wrench[k] = out.reading.finger[k].map(narrow);
        }
        let r = &out.reading;
        p.position_m = [narrow(r.position_m.x), narrow(r.position_m.y), narrow(r.position_m.z)];
        let q = r.rotation.quaternion();
        p.quaternion = [narrow(q.w), narrow(q.i), narrow(q.j), narrow(q.k)];
        p.pusher_force_n = [narrow(r.pusher[0]), narrow(r.pusher[1]), narrow(r.pusher[2])];
        p.sag_m = narrow(self.sag(tracked, &tracked.poses.carrier, present, &tracked.state.position_m));
        p.rotation_rad = narrow(rotation_between(&tracked.start, &tracked.state.rotation));
        p.friction = narrow(self.observer.friction());
        p
    }

    /// Motion in the grasp along gravity since the start; while sliding, only that across the slide.
    fn sag(&self, tracked: &Tracked<R>, carrier: &Pose<R>, present: &Segment, position_m: &Vec3<R>) -> R {
        let mut down = Vec3::from(self.scene.gravity_m_s2);
        if present.intent == Intent::Slide {
            let v = Vec3::from(present.velocity_m_s.map(|x| R::of(f64::from(x))));
            let square = v.norm_squared();
            if square > R::of(1e-8) {
                down -= v * (v.dot(&down) / square);
            }
        }
        let size = norm(&down);
        if !(size > R::of(1e-3)) {
            return R::zero();
        }
        let down = carrier.rotation.inverse_transform_vector(&(down / size));
        down.dot(&(position_m - tracked.start.position_m))
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

    /// Brings together what the model foresees and what is measured of a held grasp.
    ///
    /// Slip now is what the pose shows; slip ahead needs a proven trend, or a model that
    /// agrees with the measured load and foresees slip from the plan. To be near the limit
    /// is neither.
    fn combine(&self, p: &mut Prediction, tracked: &mut Tracked<R>, observed: &Observed<R>, now: Now<R>) {
        // Without any wrench the model alone speaks, and the pose.
        let blind = observed.finger.iter().all(Option::is_none);
        let agrees =
            now.doubt & validity::MODEL == 0 && observed.ratio.is_some_and(|r| self.agrees(p, observed, r));
        let foresees = p.finger.iter().any(|f| f.slip_in_s >= 0.0) && (agrees || blind);
        tracked.foreseen = if foresees { tracked.foreseen.saturating_add(1) } else { 0 };
        let mut ahead = within(observed.limit_in_s, self.limits.slip_warning_s);
        let mut drop = within(observed.limit_in_s, self.limits.drop_warning_s);
        if tracked.foreseen >= FORESEEN_SAMPLES {
            let soonest =
                p.finger.iter().filter(|f| f.slip_in_s >= 0.0).map(|f| f.slip_in_s).reduce(f32::min);
            ahead = sooner(ahead, soonest);
            drop = sooner(drop, Some(p.drop_in_s).filter(|t| *t >= 0.0));
        }
        let slips = match &observed.moved {
            Some(moved) => moved.slip_s > R::zero(),
            None if blind => foresees,
            None => observed.over_s > R::zero(),
        };
        if let (Some(moved), Some(edge)) = (&observed.moved, &now.edge_m) {
            let (edge_m, attitude) = edge;
            let leaves = self
                .leaves_in(moved, edge_m, attitude)
                .filter(|t| *t <= self.limits.drop_warning_s.min(foresight(moved)));
            drop = sooner(drop, leaves);
            tracked.note_slip(moved.slip_s > R::zero(), attitude);
            if tracked.another_is_the_last(edge_m) {
                drop = sooner(drop, Some(self.limits.drop_warning_s));
            }
            self.sag_ahead(p, tracked, moved);
        } else if slips && (blind || observed.over_s > R::of(LASTING_S)) {
            // Nobody sees how fast it goes.
            drop = sooner(drop, Some(self.limits.horizon_s));
        }
        ahead = tracked.slip_warning.hold(ahead, now.dt_s);
        for f in &mut p.finger {
            f.slip_in_s = if slips { 0.0 } else { ahead.map_or(-1.0, |t| t.max(LEAST_AHEAD_S)) };
            if !slips {
                f.slip_speed_m_s = 0.0;
            }
        }
        p.drop_in_s = tracked.drop_warning.hold(drop, now.dt_s).unwrap_or(-1.0);
        let enough = observed.least_limit * R::of(f64::from(self.limits.target_utilisation.max(0.05)));
        if let Some(ratio) = observed.ratio
            && enough > R::zero()
        {
            p.holding_grip_n = now.grip_n * (ratio / enough).to_f64() as f32;
        }
    }

    /// The model carries the load that is measured.
    fn agrees(&self, p: &Prediction, observed: &Observed<R>, ratio: R) -> bool {
        let used = (ratio / max(observed.limit, R::of(1e-6))).to_f64() as f32;
        p.finger.iter().all(|f| (f.model_utilisation - used).abs() < 0.1)
    }

    /// Sag beyond its limit: there is, comes with a slip under way, or was foreseen for some
    /// samples in a row (a single look-ahead may be older than a change of the motion).
    fn sags(&self, p: &Prediction, tracked: &mut Tracked<R>, observed: &Observed<R>) -> bool {
        let ahead = p.sag_ahead_m > self.limits.sag_m;
        tracked.sagging = if ahead { tracked.sagging.saturating_add(1) } else { 0 };
        let slips = observed.moved.is_some_and(|m| m.slip_s > R::zero());
        p.sag_m > self.limits.sag_m || ahead && (slips || tracked.sagging >= FORESEEN_SAMPLES)
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
            if v > R::of(LEAVING_M_S) && reached > R::zero() {
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
            let to_come = sinking.to_f64() as f32 * self.limits.horizon_s.min(foresight(moved));
            p.sag_ahead_m = p.sag_ahead_m.max(p.sag_m + to_come);
        }
    }

    /// Goes on with the look-ahead, begins a new one where the work allows, and tells what the
    /// newest finished one foresees, from now.
    #[allow(clippy::too_many_arguments)]
    fn look_ahead(
        &self,
        tracked: &mut Tracked<R>,
        drive: &Drive<R>,
        sample: &Sample<R>,
        present: &Segment,
        p: &mut Prediction,
        worst: &mut Worst<R>,
        work: &mut Workspace<R, SLOTS>,
        doubt: &mut u32,
    ) {
        let course = Course {
            scene: &self.scene,
            model: &self.model,
            plan: &self.plan,
            present,
            horizon_s: R::of(f64::from(self.limits.horizon_s)),
            slip_m_s: R::of(f64::from(self.limits.slip_m_s)),
            trial: self.trial,
            support: tracked.support,
            reference_m: tracked.reference_m,
        };
        let mut done = worst.work;
        let mut begun = false;
        while done.room() && !begun {
            if tracked.ahead.is_none() {
                begun = true;
                // A grip command that departs from the plan goes on doing so.
                let departure_n = sample.grip_cmd_n - R::of(f64::from(present.grip_n));
                let pusher_m_s = drive.pusher.map(|m| {
                    let v = m.velocity_m_s + drive.carrier_m_s + drive.carrier_rad_s.cross(&m.position_m);
                    drive.carrier.transform_vector(&v)
                });
                let Tracked { ahead, state, poses, .. } = &mut *tracked;
                Ahead::begin(ahead, state, poses, sample.t_s, pusher_m_s, departure_n);
            }
            let Some(ahead) = &mut tracked.ahead else { break };
            if let Some(found) = ahead.go_on(&course, &mut done, work, |out| worst.count(out)) {
                tracked.outlook = Some(found);
                tracked.ahead = None;
            }
        }
        for f in &mut p.finger {
            f.peak_utilisation = f.model_utilisation;
            if f.slip_speed_m_s > self.limits.slip_m_s {
                f.slip_in_s = 0.0;
            }
        }
        p.sag_ahead_m = p.sag_m;
        match &tracked.outlook {
            None => *doubt |= validity::NO_FORESIGHT,
            Some(found) => {
                let age_s = (sample.t_s - found.began_s).to_f64() as f32;
                // Foreseen for a moment that has come without it: it is due.
                let from_now =
                    |after_s: f32| if after_s < 0.0 { after_s } else { (after_s - age_s).max(0.004) };
                for (k, f) in p.finger.iter_mut().enumerate() {
                    f.peak_utilisation = f.peak_utilisation.max(found.peak_utilisation[k]);
                    if f.slip_in_s < 0.0 && found.slip_after_s[k] >= 0.0 {
                        f.slip_in_s = from_now(found.slip_after_s[k]);
                        f.slip_direction_rad = direction(&found.slip[k]);
                    }
                }
                if p.drop_in_s < 0.0 {
                    p.drop_in_s = from_now(found.drop_after_s);
                }
                // What it adds: the model may have been drawn elsewhere since. Sag is in each
                // carrier's axes: gravity has turned with it.
                let sag = |carrier, position_m| self.sag(tracked, carrier, present, position_m);
                let to_come = sag(&found.carrier, &found.position_m) - sag(&found.from.0, &found.from.1);
                p.sag_ahead_m = p.sag_m + to_come.to_f64() as f32;
                if found.marked {
                    *doubt |= validity::FORESIGHT;
                }
            }
        }
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

/// Friction while sliding over that at rest, by the model's effects.
fn sliding_share<R: Real>(model: &Model<R>) -> R {
    model.effects.iter().fold(R::one(), |share, e| {
        share * crate::effects::law::<R>(e.code).map_or_else(R::one, |law| law.sliding_share(&e.parameters))
    })
}

/// Arm of a finger's torsional friction by the shape of its patch: torsion limit over force limit.
fn patch_arm<R: Real>(scene: &Scene<R>) -> R {
    match scene.fingers {
        Some(FingerContact::Disc { diameter_m }) => diameter_m * R::of(1.0 / 3.0),
        Some(FingerContact::Line { length_m }) => length_m * R::of(0.5),
        _ => R::zero(),
    }
}

/// The same with the model's effects.
fn torsion_arm<R: Real>(model: &Model<R>, arm_m: R) -> R {
    model.effects.iter().fold(arm_m, |arm_m, e| {
        crate::effects::law::<R>(e.code).map_or(arm_m, |law| law.torsion_arm(&e.parameters, arm_m))
    })
}

/// Force of both fingers on the object: measured, or else the model's.
fn load_of<R: Real>(sample: &Sample<R>, out: &StepSummary<R>) -> Vec3<R> {
    let sum = |[a, b]: [&[R; 6]; 2]| Vec3::new(a[0] + b[0], R::zero(), a[2] + b[2]);
    let [f1, f2] = &out.reading.finger;
    match &sample.finger {
        [Some(a), Some(b)] if sum([a, b]).norm_squared().finite() => sum([a, b]),
        _ => sum([f1, f2]),
    }
}

/// Coefficient of an elliptic cone in the direction of a load with the components `a` and `b`
/// along the tangents; the mean where it has none.
fn coefficient_along<R: Real>(mu: &[R; 2], a: R, b: R) -> R {
    let size = sqrt(a * a + b * b);
    if mu[0] == mu[1] || !(size > R::of(1e-6)) || !(min(mu[0], mu[1]) > R::zero()) {
        return (mu[0] + mu[1]) * R::of(0.5);
    }
    let (a, b) = (a / mu[0], b / mu[1]);
    size / sqrt(a * a + b * b)
}

/// As it goes over the wire.
fn status_code(status: SolveStatus) -> u8 {
    match status {
        SolveStatus::Solved => 0,
        SolveStatus::IterationLimit => 1,
        SolveStatus::BadInput => 2,
        SolveStatus::Numerical => 3,
        SolveStatus::Contradiction => 4,
    }
}

/// Work kept for each later part of a step made in parts.
const LATER_WORK: u32 = 40;

/// Steps the model over a drive, in parts where it is long; all parts together are bounded by the
/// work of a tick.
fn advance<R: Real>(
    scene: &Scene<R>,
    model: &Model<R>,
    state: &mut State<R, SLOTS>,
    drive: &Drive<R>,
    work: &mut Workspace<R, SLOTS>,
    worst: &mut Worst<R>,
) -> StepSummary<R> {
    let mut parts: u8 = 1;
    while drive.dt_s / R::of(f64::from(parts)) > R::of(LONGEST_STEP_S * 1.001) && parts < MOST_PARTS {
        parts += 1;
    }
    let mut part = *drive;
    part.dt_s = drive.dt_s / R::of(f64::from(parts));
    let present = SolveBudget::present();
    let bounded = |done: &Work, later: u8| match parts {
        1 => present,
        _ => done.bounding(&present, TICK_WORK.saturating_sub(LATER_WORK * u32::from(later))),
    };
    let options = bounded(&worst.work, parts.saturating_sub(1));
    let mut out = crate::step::step_in(scene, model, state, &part, &options, work);
    worst.note(&out);
    for later in (0..parts.saturating_sub(1)).rev() {
        if matches!(out.status, SolveStatus::BadInput | SolveStatus::Contradiction) {
            break;
        }
        for m in [&mut part.pusher, &mut part.support].into_iter().flatten() {
            m.position_m += m.velocity_m_s * part.dt_s;
            m.rotation = crate::step::turned(&m.rotation, &(m.angular_rad_s * part.dt_s));
        }
        let options = bounded(&worst.work, later);
        out = crate::step::step_in(scene, model, state, &part, &options, work);
        worst.note(&out);
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

fn rotation_between<R: Real>(start: &Pose<R>, now: &Rotation<R>) -> R {
    let q = (start.rotation.inverse() * now).into_inner();
    let vector = sqrt(q.i * q.i + q.j * q.j + q.k * q.k);
    R::of(2.0) * vector.atan2(q.w.abs())
}

/// What a held grasp is judged by besides the observer's figures.
struct Now<R: Real> {
    grip_n: f32,
    /// See [`Predictor::to_the_edge`]; the object's attitude in the gripper.
    edge_m: Option<([[R; 2]; 2], Rotation<R>)>,
    doubt: u32,
    dt_s: f32,
}

/// How far two velocities (m/s, rad/s) are apart: 1 is 10 mm/s or 0.1 rad/s on an axis.
fn apart(a: &[[f32; 3]; 2], b: &[[f32; 3]; 2]) -> f32 {
    let of = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).fold(0.0f32, |m, (a, b)| m.max((a - b).abs()));
    (of(&a[0], &b[0]) * 100.0).max(of(&a[1], &b[1]) * 10.0)
}

/// How far ahead a slip can be extrapolated.
fn foresight<R: Real>(moved: &Moved<R>) -> f32 {
    AT_ONCE_S + moved.slip_s.to_f64() as f32 * EXTRAPOLATED
}

fn within<R: Real>(t: Option<R>, most: f32) -> Option<f32> {
    t.map(|t| t.to_f64() as f32).filter(|t| *t <= most)
}

fn sooner(a: Option<f32>, b: Option<f32>) -> Option<f32> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        _ => a.or(b),
    }
}

/// Sets the flags from the figures.
fn judge(p: &mut Prediction, intent: Intent, limits: &Limits, sag: bool, pushing: bool) {
    let mut set = 0;
    let (slip, ahead) = ([flags::SLIP_1, flags::SLIP_2], [flags::SLIP_AHEAD_1, flags::SLIP_AHEAD_2]);
    let mut any = false;
    for k in 0..2 {
        let f = &p.finger[k];
        if f.slip_speed_m_s > limits.slip_m_s || f.slip_in_s == 0.0 {
            set |= slip[k];
        } else if f.slip_in_s >= 0.0 {
            set |= ahead[k];
        }
        any |= f.slip_in_s >= 0.0;
    }
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
    status: SolveStatus,
    residual_n: R,
    iterations: u16,
    /// Of the tick so far.
    work: Work,
    /// A step from sample to sample has moved the state.
    moved: bool,
}

impl<R: Real> Default for Worst<R> {
    fn default() -> Self {
        Self {
            status: SolveStatus::Solved,
            residual_n: R::zero(),
            iterations: 0,
            work: Work::default(),
            moved: false,
        }
    }
}

impl<R: Real> Worst<R> {
    /// A step of the look-ahead: its status goes with what it foresees.
    fn count(&mut self, out: &StepSummary<R>) {
        self.work.add(out);
        self.iterations = self.iterations.saturating_add(out.iterations.min(10_000) as u16);
    }

    /// The step from sample to sample.
    fn note(&mut self, out: &StepSummary<R>) {
        self.count(out);
        self.moved |= !matches!(out.status, SolveStatus::BadInput | SolveStatus::Contradiction);
        if out.status != SolveStatus::Solved {
            self.status = out.status;
        }
        self.residual_n = max(self.residual_n, out.residual_n);
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
        let rest = [
            self.sag_m,
            self.sag_ahead_m,
            self.rotation_rad,
            self.drop_in_s,
            self.holding_grip_n,
            self.friction,
        ];
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
