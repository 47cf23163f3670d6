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
//! `follow.rs` is the tick's sequence; each of its parts is a file of the folder.

mod advance;
pub mod ahead;
pub mod alarm;
mod clock;
mod context;
pub mod decide;
mod describe;
mod evidence;
mod follow;
mod late;
mod outlook;
pub mod params;
mod patch;
pub mod plan;
pub(crate) mod sag;
mod sense;
mod start;
mod tracked;
pub mod tuning;
pub mod types;
pub mod validate;
mod witness;

pub use params::Params;
pub use plan::{Intent, MAX_SEGMENTS, Plan, Segment};
pub use tuning::{Checked, Tuning};
pub use types::{FingerPrediction, HASH_START, Limits, Prediction, Sample, Slip, flags, validity};
pub use validate::{Limit, ModelError, validate, validate_limits};
pub use witness::Testimony;

use crate::cone::Kept;
use crate::effect::MEMORY;
use crate::health::Health;
use crate::model::{MAX_EFFECTS, Model, Scene};
use crate::observer::Observer;
use crate::real::Real;
use crate::step::Workspace;
use crate::track;
use crate::work::TICK_WORK;
use clock::Clock;
use context::Context;
use follow::Unfollowed;
use patch::of_effects;
use tracked::Tracked;

/// No gripper presses harder; what says so is no sample.
const MOST_GRIP_N: f64 = 1e4;

/// The predictor: parameters, plan and the state of the tracked object.
#[derive(Clone, Debug)]
pub struct Predictor<R: Real> {
    context: Context<R>,
    tracked: Option<Tracked<R>>,
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
        let [sliding, late_s, torsion_arm_m] = of_effects(&scene, &model);
        Self {
            context: Context {
                health: Health::default(),
                observer: Observer::new(model.friction.finger),
                sliding,
                late_s,
                torsion_arm_m,
                scene,
                model,
                limits,
                params: Params::default(),
                track: track::Params::default(),
                plan: Plan::default(),
                clock: Clock::default(),
                trial: R::zero(),
                last: Prediction::default(),
                work: 0,
                testimony: Testimony::default(),
            },
            tracked: None,
        }
    }

    /// The same with other numbers than the default ones: before the first sample.
    #[must_use]
    pub fn with_tuning(mut self, tuning: &Checked<R>) -> Self {
        let Tuning { predictor, observer, health, track } = *tuning.get();
        self.context.params = predictor;
        self.context.observer = Observer::with(self.context.model.friction.finger, observer);
        self.context.health = Health::new(health);
        self.context.track = track;
        self
    }

    /// Goes on with another scene, model and limits, which [`validate()`] has let through, in the midst of a
    /// run: the plan, the friction learnt and, where the scene is the same, the tracked object stay.
    pub fn swap(&mut self, scene: Scene<R>, model: Model<R>, limits: Limits) {
        let Self { context, tracked } = self;
        if context.scene != scene {
            // Another object, or another rig: it is seen anew at its next pose.
            *tracked = None;
        }
        if let Some(tracked) = tracked {
            if context.model.effects != model.effects || context.model.formulas != model.formulas {
                // What the effects remember is another's.
                tracked.state.memory = [[R::zero(); MEMORY]; MAX_EFFECTS];
            }
            tracked.ahead = None;
            tracked.outlook = None;
            tracked.kept = [Kept::nothing(); 2];
        }
        [context.sliding, context.late_s, context.torsion_arm_m] = of_effects(&scene, &model);
        context.scene = scene;
        context.model = model;
        context.limits = limits;
    }

    /// Work of the last tick that stepped, in evaluations of the momentum balance: what bounds
    /// the look-ahead, and what a search for the dearest tick counts.
    pub fn work(&self) -> u32 {
        self.context.work
    }

    /// What the other formulation said of the steps, where the model asks for it (`Model::witness`).
    pub fn testimony(&self) -> Testimony {
        self.context.testimony
    }

    /// Where the slip warning stands, and what raised it.
    pub fn warning(&self) -> alarm::State {
        self.tracked.as_ref().map_or(alarm::State::Clear, |t| t.alarms.slip.state)
    }

    /// Replaces the plan from the next tick on.
    pub fn set_plan(&mut self, plan: Plan) {
        self.context.plan = plan;
        self.context.plan.start_s -= self.context.clock.epoch_s();
    }

    /// Place of the trial in its data set (wear goes with it).
    pub fn set_trial(&mut self, trial: R) {
        self.context.trial = trial;
    }

    /// Forgets the tracked object; the next sample with an object pose starts anew.
    pub fn restart(&mut self) {
        self.tracked = None;
        self.context.plan.start_s += self.context.clock.epoch_s();
        self.context.clock = Clock::default();
    }

    /// One tick with a sample from the line. Its time stamp may wrap around (every 71 minutes).
    pub fn take(&mut self, sample: &crate::wire::Sample) -> Prediction {
        if let Some(by_us) = self.context.clock.overdue_us(sample.t_us, self.tracked.is_none()) {
            self.move_epoch(by_us);
        }
        self.tick(&sample.at(self.context.clock.time_s(sample.t_us)))
    }

    /// Counts time from `by_us` later on.
    fn move_epoch(&mut self, by_us: u32) {
        let by_s = self.context.clock.move_on(by_us);
        self.context.plan.start_s -= by_s;
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
        self.context.observer.reset_friction();
    }

    /// The scene and model in use; the fingers' friction is the estimate.
    pub fn model(&self) -> (&Scene<R>, &Model<R>) {
        (&self.context.scene, &self.context.model)
    }

    /// One tick. Never panics; work is bounded.
    pub fn tick(&mut self, sample: &Sample<R>) -> Prediction {
        let mut doubt = 0;
        if !sample.t_s.finite() || !(sample.grip_cmd_n.abs() <= R::of(MOST_GRIP_N)) {
            return self.context.repeat(validity::SAMPLE);
        }
        let elapsed = self.tracked.as_ref().map(|t| sample.t_s - t.poses.t_s);
        if elapsed.is_some_and(|e| e > R::of(f64::from(self.context.params.longest_gap_s))) {
            doubt |= validity::GAP;
            self.tracked = None;
        }
        if self.tracked.is_none() {
            return self.start(sample, doubt);
        }
        if self.settle() {
            return self.context.repeat(doubt | validity::WAITING);
        }
        let Self { context, tracked: place } = self;
        let Some(tracked) = place else { return context.repeat(doubt | validity::WAITING) };
        match context.follow(tracked, sample, doubt) {
            Ok(()) => {}
            Err(Unfollowed::Sample) => return context.repeat(validity::SAMPLE),
            Err(Unfollowed::Solver { status, residual_n, lost }) => {
                if lost {
                    *place = None;
                }
                context.last = Prediction {
                    solver_status: status,
                    solver_residual_n: residual_n,
                    ..context.repeat(validity::SOLVER)
                };
            }
        }
        context.last
    }

    /// A first sample: where the object is seen, it is tracked from now on.
    // A function of its own: its room is not on the stack under a step.
    #[inline(never)]
    fn start(&mut self, sample: &Sample<R>, doubt: u32) -> Prediction {
        self.tracked = self.context.start(sample);
        if self.tracked.is_none() {
            return self.context.repeat(doubt | validity::WAITING);
        }
        // The first sample has nothing behind it to predict from; whether it was measured shows all the same.
        let (_, faults) = self.context.health.check(sample, &self.context.limits);
        let validity = doubt | faults | validity::NO_FORESIGHT;
        let flags = if validity & validity::UNRELIABLE != 0 { flags::UNSURE } else { 0 };
        self.context.last = Prediction { flags, validity, ..Prediction::default() };
        self.context.last
    }

    /// Settles the object for a tick; `false` where it has nothing to settle.
    // Its workspace is the largest thing of a tick: it must not lie beside that of `follow` in one frame.
    #[inline(never)]
    fn settle(&mut self) -> bool {
        let Some(Tracked { state, settling, .. }) = &mut self.tracked else { return false };
        let Some(going) = settling else { return false };
        if going.go_on(&self.context.scene, &self.context.model, state, TICK_WORK, &mut Workspace::new()) {
            *settling = None;
        }
        true
    }
}
