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
//!
//! Above 600 lines: the tick is one sequence over one state, from the sample to the flags; what can be told apart
//! (types, plan, validation, decisions, sag, parameters) lies in the folder of the same name.

pub mod decide;
pub mod params;
pub mod plan;
pub(crate) mod sag;
pub mod types;
pub mod validate;

pub use params::Params;
pub use plan::{Intent, MAX_SEGMENTS, Plan, Segment};
pub use types::{
    FingerPrediction, HASH_START, Limits, Prediction, Sample, Slip, SolverStatus, flags, validity,
};
pub use validate::{Limit, ModelError, validate, validate_limits};

use crate::cone::{Kept, SolveBudget, SolveStatus};
use crate::contact::{Body, SLOTS};
use crate::effect::MEMORY;
use crate::health::{self, Health};
use crate::look_ahead::{Ahead, Course, Foreseen, LONGEST_STEP_S};
use crate::model::{FingerContact, MAX_EFFECTS, Model, Scene, Shape};
use crate::observer::motion::Moved;
use crate::observer::{self, Observed, Observer, Seen};
use crate::real::{Real, Rotation, Vec3, max, min, norm, sqrt};
use crate::step::{Drive, SolvedBy, State, StepSummary, Workspace};
use crate::track::{
    Acceleration, PathFilter, Pose, Poses, Settling, between_pads, drive_between, seat, support_pose,
};
use crate::work::{TICK_WORK, Work};
use decide::{Alarms, Evidence, decide, sooner};
use sag::{Sag, planned_slide, slipped, unintended_down};

/// Most steps in which a gap is bridged: a tick must end.
const MOST_PARTS: u8 = 3;
/// The epoch moves on after so long.
const EPOCH_US: u32 = 32_000_000;
/// Samples in a row without forces after which the model starts anew where it was last good: the step
/// spans all of them by then.
const MOST_UNSOLVED: u8 = 3;
/// A restart keeps jaw and contact memory where the jaw is within this of holding the object, m.
const JAW_KEPT_M: f64 = 1.0e-4;

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
    params: Params,
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
        residual_n: f32,
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
    /// By the model, and by the measured pose.
    sag: [Sag<R>; 2],
    pushing: bool,
    /// Samples in a row in which model and measurement disagree.
    apart: u8,
    /// Samples in a row whose measured pose has parted from the model's.
    strayed: u8,
    /// Samples in a row whose step was not solved.
    unsolved: u8,
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
    alarms: Alarms,
    /// Where the object last rested, in the gripper; how far the last slip went, object axes.
    rest_m: Vec3<R>,
    slipped_m: Vec3<R>,
    /// Planned velocity and angular velocity, and how long a change of it still matters.
    motion: [[f32; 3]; 2],
    settling_s: R,
    gripper: PathFilter<R>,
    pusher: Option<PathFilter<R>>,
    /// By the gripper's measured pose; for how long what it explains still matters, s.
    acceleration: Acceleration<R>,
    gaining_s: R,
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
    fn another_is_the_last(&self, edge_m: &[[R; 2]; 2], params: &Params) -> bool {
        let (noise_m, next) = (R::of(f64::from(params.edge_noise_m)), R::of(f64::from(params.next_slip)));
        [self.slipped_m.x, self.slipped_m.z].iter().zip(edge_m).any(|(moved, sides)| {
            let way = if *moved > R::zero() { sides[0] } else { sides[1] };
            moved.abs() > noise_m && moved.abs() * next > way
        })
    }
}

impl<R: Real> Predictor<R> {
    /// A predictor that waits for its first sample.
    pub fn new(scene: Scene<R>, model: Model<R>, limits: Limits) -> Result<Self, ModelError> {
        validate(&scene, &model)?;
        validate_limits(&limits)?;
        Ok(Self::of_valid(scene, model, limits))
    }

    /// The same of what [`validate()`] has let through.
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
                params: Params::default(),
                plan: Plan::default(),
                epoch_us: 0,
                trial: R::zero(),
                last: Prediction::default(),
                work: 0,
            },
            tracked: None,
        }
    }

    /// The same with other tuning than the default.
    #[must_use]
    pub fn with_params(mut self, params: Params) -> Self {
        self.core.params = params;
        self
    }

    /// The same with another tuning of the observer than the default: before the first sample.
    #[must_use]
    pub fn with_observer(mut self, params: observer::Params<R>) -> Self {
        self.core.observer = Observer::with(self.core.model.friction.finger, params);
        self
    }

    /// The same with another tuning of the checks of the sensors than the default: before the first sample.
    #[must_use]
    pub fn with_health(mut self, params: health::Params) -> Self {
        self.core.health = Health::new(params);
        self
    }

    /// Goes on with another scene, model and limits, which [`validate()`] has let through, in the midst of a
    /// run: the plan, the friction learnt and, where the scene is the same, the tracked object stay.
    pub fn swap(&mut self, scene: Scene<R>, model: Model<R>, limits: Limits) {
        let Self { core, tracked } = self;
        if core.scene != scene {
            // Another object, or another rig: it is seen anew at its next pose.
            *tracked = None;
        }
        if let Some(tracked) = tracked {
            if core.model.effects != model.effects || core.model.formulas != model.formulas {
                // What the effects remember is another's.
                tracked.state.memory = [[R::zero(); MEMORY]; MAX_EFFECTS];
            }
            tracked.ahead = None;
            tracked.outlook = None;
            tracked.kept = [Kept::nothing(); 2];
        }
        core.sliding = sliding_share(&model);
        core.torsion_arm_m = torsion_arm(&model, patch_arm(&scene));
        core.scene = scene;
        core.model = model;
        core.limits = limits;
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
        let mut poses = self.core.poses(sample, None)?;
        let local = between_pads(&self.core.scene, &poses.carrier.to_local(&object));
        let support = support_pose(&self.core.scene, &poses.carrier.to_world(&local));
        poses.support = support;
        let reference_m = poses.pusher.map_or_else(Vec3::zeros, |p| p.position_m);
        let later = Poses { t_s: poses.t_s + R::of(0.004), ..poses };
        let drive = drive_between(&poses, &later, &reference_m, sample.grip_cmd_n, self.core.trial)?;
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
            sag: [Sag::new(Vec3::zeros()); 2],
            pushing: false,
            apart: 0,
            strayed: 0,
            unsolved: 0,
            settling,
            ahead: None,
            kept: [Kept::nothing(); 2],
            seen_m: local.position_m,
            outlook: None,
            alarms: Alarms::default(),
            rest_m: local.position_m,
            slipped_m: Vec3::zeros(),
            motion: [[0.0; 3]; 2],
            settling_s: R::zero(),
            gripper: PathFilter::new(poses.carrier),
            pusher: poses.pusher.map(PathFilter::new),
            acceleration: Acceleration::new(poses.carrier.position_m),
            gaining_s: R::zero(),
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
        if elapsed.is_some_and(|e| e > R::of(f64::from(self.core.params.longest_gap_s))) {
            doubt |= validity::GAP;
            self.tracked = None;
        }
        if self.tracked.is_none() {
            if self.start(sample).is_none() {
                return self.core.repeat(doubt | validity::WAITING);
            }
            // The first sample has nothing behind it to predict from.
            let validity = doubt | validity::NO_FORESIGHT;
            self.core.last = Prediction { validity, ..Prediction::default() };
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
            Err(Unfollowed::Solver { status, residual_n, lost }) => {
                if lost {
                    *place = None;
                }
                core.last = Prediction {
                    solver_status: status.into(),
                    solver_residual_n: residual_n,
                    ..core.repeat(validity::SOLVER)
                };
            }
        }
        core.last
    }

    /// Settles the object for a tick; `false` where it has nothing to settle.
    // Its workspace is the largest thing of a tick: it must not lie beside that of `follow` in one frame.
    #[inline(never)]
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
        if !out.followed {
            // Numbers that no rig has, or forces that were not found: the last good state is kept for the next sample, and
            // after a gap's length of such samples the model starts anew. (It does so at once
            // where a gap was bridged in parts and the later ones failed.)
            self.work = worst.work.done();
            tracked.gripper = PathFilter::new(tracked.poses.carrier);
            tracked.pusher = tracked.poses.pusher.map(PathFilter::new);
            let unsolved = matches!(out.status, SolveStatus::IterationLimit | SolveStatus::Numerical);
            tracked.unsolved = if unsolved { tracked.unsolved.saturating_add(1) } else { 0 };
            if tracked.unsolved >= MOST_UNSOLVED {
                self.start_again(tracked, &drive, poses);
            }
            let residual_n = out.residual_n.to_f64() as f32;
            return Err(Unfollowed::Solver { status: out.status, residual_n, lost: worst.moved });
        }
        tracked.unsolved = 0;
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
            if strayed && jumped && tracked.strayed < self.params.strayed_samples {
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
        let mut present = plan.unwrap_or_else(|| present_motion(&drive, sample));
        present.intent = self.intended(&present);
        // What was meant to move comes to rest a little later, and a plan may be late.
        let means_motion = |after_s: f32| {
            let then = self.plan.at(sample.t_s.to_f64() as f32 + after_s);
            then.is_some_and(|s| self.intended(s) != Intent::Hold)
        };
        let moves = present.intent != Intent::Hold || means_motion(self.params.plan_late_s);
        let moves_ahead = moves || means_motion(self.limits.horizon_s + self.params.plan_late_s);
        let slide = planned_slide(&present, R::of(f64::from(self.limits.slip_m_s)));
        let down = unintended_down(&self.scene.gravity_m_s2, &poses.carrier.rotation, slide);
        if plan.is_none() {
            doubt |= validity::NO_PLAN;
        }
        let object = sample.object.filter(|_| doubt & validity::POSE == 0);
        let seen = object.zip(sample.gripper).map(|(object, gripper)| gripper.to_local(&object));
        let observed =
            self.observe(tracked, &out, sample, &drive, &present, seen.as_ref(), effects, &mut doubt);
        let mut p = self.describe(tracked, &out, &observed, &present);
        let at_m = slipped(&tracked.start, &tracked.state.position_m, &tracked.state.rotation);
        let model_sag = tracked.sag[0].follow(at_m, &down).to_f64() as f32;
        p.sag_m = model_sag;
        *work.kept() = tracked.kept[1];
        self.look_ahead(tracked, &drive, sample, &present, &mut p, &mut worst, &mut work, &mut doubt);
        tracked.kept[1] = *work.kept();
        if let Some(seen) = &seen {
            // The model knows what comes, the measurement what is.
            let to_come = p.sag_ahead_m - model_sag;
            let at_m = slipped(&tracked.start, &seen.position_m, &seen.rotation);
            p.sag_m = tracked.sag[1].follow(at_m, &down).to_f64() as f32;
            p.sag_ahead_m = p.sag_m + to_come;
            p.rotation_rad = rotation_between(&tracked.start, &seen.rotation).to_f64() as f32;
        }
        let evidence = self.evidence(
            tracked,
            &mut p,
            &observed,
            &present,
            seen.as_ref(),
            &Now {
                moves,
                moves_ahead,
                dt_s: drive.dt_s.to_f64() as f32,
                believed: doubt & validity::MODEL == 0,
            },
        );
        let (verdict, alarms) = decide(&evidence, &tracked.alarms, &self.limits, &self.params);
        tracked.alarms = alarms;
        p.flags = verdict.flags;
        p.drop_in_s = verdict.drop_in_s;
        for (f, slip) in p.finger.iter_mut().zip(verdict.slip) {
            f.slip = slip;
            if present.intent == Intent::Hold && slip != Slip::Now {
                f.slip_speed_m_s = 0.0;
            }
        }
        if present.intent == Intent::Hold {
            let target = self.limits.target_utilisation.max(0.05);
            let enough = observed.least_limit * R::of(f64::from(target));
            if let Some(ratio) = observed.ratio
                && enough > R::zero()
            {
                let grip_n = sample.grip_cmd_n.to_f64() as f32;
                p.holding_grip_n = Some(grip_n * (ratio / enough).to_f64() as f32);
            }
        }
        if worst.status != SolveStatus::Solved {
            doubt |= validity::SOLVER;
        }
        if worst.cone_instead {
            doubt |= validity::CONE_INSTEAD;
        }
        if doubt & validity::UNRELIABLE != 0 {
            p.flags |= flags::UNSURE;
        }
        p.validity = doubt;
        p.solver_status = worst.status.into();
        self.work = worst.work.done();
        p.solver_residual_n = worst.residual_n.to_f64() as f32;
        p.solver_iterations = worst.iterations;
        self.last = p;
        Ok(())
    }

    /// What a segment means: a slide too slow to be one is none.
    fn intended(&self, segment: &Segment) -> Intent {
        match segment.intent {
            Intent::Slide if planned_slide(segment, R::of(f64::from(self.limits.slip_m_s))).is_none() => {
                Intent::Hold
            }
            intent => intent,
        }
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
        state.position_m += error * R::of(f64::from(self.params.pose_gain));
        false
    }

    /// From the present poses, with the object in the grasp as it last was.
    #[cold]
    fn start_again(&self, tracked: &mut Tracked<R>, drive: &Drive<R>, poses: Poses<R>) {
        let State { position_m, rotation, .. } = tracked.state;
        self.restart_at(tracked, drive, &Pose { position_m, rotation });
        tracked.unsolved = 0;
        tracked.poses = poses;
        tracked.gripper = PathFilter::new(poses.carrier);
        tracked.pusher = poses.pusher.map(PathFilter::new);
        tracked.kept = [Kept::nothing(); 2];
        tracked.ahead = None;
        tracked.outlook = None;
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
            tracked.settling_s = R::of(f64::from(self.params.settling_s));
            tracked.motion = motion;
        }
        let soon = self.plan.at(sample.t_s.to_f64() as f32 + self.params.plan_late_s);
        let soon = soon.is_some_and(|s| apart(&[s.velocity_m_s, s.angular_rad_s], &motion) > 1.0);
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
        let gains = tracked.gaining_s > R::zero();
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
            gripper_m_s: drive
                .carrier
                .inverse_transform_vector(&tracked.acceleration.velocity_m_s(drive.dt_s)),
            arm_m: self.torsion_arm_m,
            bearing_n,
            steered: gains || tracked.settling_s > R::zero(),
            accelerates: soon
                || tracked.settling_s > R::of(f64::from(self.params.settling_s - self.params.gaining_s)),
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
        p
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

    /// What is known of slip, sag and loss of the grasp, for [`decide`]. Of a held object it learns
    /// how far slips go; of one that moves, the speed of its slip is shown.
    fn evidence(
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
            leaves_in_s,
            next_is_last,
            sag_m: p.sag_m,
            sag_ahead_m: p.sag_ahead_m,
            rotation_rad: p.rotation_rad,
        }
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
            start: tracked.start,
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
                let Tracked { ahead, state, poses, start, .. } = &mut *tracked;
                Ahead::begin(ahead, state, poses, start, sample.t_s, pusher_m_s, departure_n);
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
                f.slip = Slip::Now;
            }
        }
        p.sag_ahead_m = p.sag_m;
        match &tracked.outlook {
            None => *doubt |= validity::NO_FORESIGHT,
            Some(found) => {
                let age_s = (sample.t_s - found.began_s).to_f64() as f32;
                // Foreseen for a moment that has come without it: it is due.
                let from_now = |after_s: f32| (after_s - age_s).max(self.params.least_ahead_s);
                for (k, f) in p.finger.iter_mut().enumerate() {
                    f.peak_utilisation = f.peak_utilisation.max(found.peak_utilisation[k]);
                    if let (Slip::None, Some(after_s)) = (f.slip, found.slip_after_s[k]) {
                        f.slip = Slip::In(from_now(after_s));
                        f.slip_direction_rad = direction(&found.slip[k]);
                    }
                }
                p.drop_in_s = p.drop_in_s.or(found.drop_after_s.map(from_now));
                // What it adds: the model may have been drawn elsewhere since.
                p.sag_ahead_m = p.sag_m + found.sag_m.to_f64() as f32;
                if found.marked {
                    *doubt |= validity::FORESIGHT;
                }
            }
        }
        let used = p
            .finger
            .iter()
            .fold(0.0f32, |u, f| u.max(f.peak_utilisation).max(f.measured_utilisation.unwrap_or(0.0)));
        let grip = sample.grip_cmd_n.to_f64() as f32;
        p.holding_grip_n = match present.intent {
            Intent::Hold => Some(grip * used / self.limits.target_utilisation.max(0.05)),
            _ => None,
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
        if !out.followed {
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

/// What a tick is judged by besides the observer's figures.
struct Now {
    /// The plan means motion in the grasp, now or soon.
    moves: bool,
    /// Within the horizon.
    moves_ahead: bool,
    dt_s: f32,
    /// Model and measurement have not parted.
    believed: bool,
}

/// How far two velocities (m/s, rad/s) are apart: 1 is 10 mm/s or 0.1 rad/s on an axis.
fn apart(a: &[[f32; 3]; 2], b: &[[f32; 3]; 2]) -> f32 {
    let of = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).fold(0.0f32, |m, (a, b)| m.max((a - b).abs()));
    (of(&a[0], &b[0]) * 100.0).max(of(&a[1], &b[1]) * 10.0)
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
    /// A step asked for pyramids and was solved with the cone.
    cone_instead: bool,
}

impl<R: Real> Default for Worst<R> {
    fn default() -> Self {
        Self {
            status: SolveStatus::Solved,
            residual_n: R::zero(),
            iterations: 0,
            work: Work::default(),
            moved: false,
            cone_instead: false,
        }
    }
}

impl<R: Real> Worst<R> {
    /// A step of the look-ahead: its status goes with what it foresees.
    fn count(&mut self, out: &StepSummary<R>) {
        self.work.add(out);
        self.cone_instead |= out.solved_by == SolvedBy::ConeInstead;
        self.iterations = self.iterations.saturating_add(out.iterations.min(10_000) as u16);
    }

    /// The step from sample to sample.
    fn note(&mut self, out: &StepSummary<R>) {
        self.count(out);
        self.moved |= out.followed;
        if out.status != SolveStatus::Solved {
            self.status = out.status;
        }
        self.residual_n = max(self.residual_n, out.residual_n);
    }
}
