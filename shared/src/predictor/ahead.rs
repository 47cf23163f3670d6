//! The contact model run ahead along the plan, as far as the tick's work allows.
//!
//! Mostly the whole horizon is done within one tick. Where its contact problems are expensive (a
//! slip that begins, a contact that opens), the rest is done in the next ticks from where it
//! stopped, so that no tick is late; what it foresees is then some ticks old, and its times
//! are told from now. The work is counted in evaluations of the momentum balance, not in
//! time: both sides stop at the same place.

use super::plan::{Plan, Segment};
use super::sag::{Sag, planned_slide, slipped, unintended_down};
use crate::cone::{SolveBudget, SolveStatus};
use crate::contact::SLOTS;
use crate::model::{Model, Scene};
use crate::real::{Real, Vec3, clamp, max, norm};
use crate::solve::Follows;
use crate::step::{State, StepSummary, Workspace, turned};
use crate::track::{Pose, Poses, drive_between};
use crate::tuning::tuned;
use crate::work::{TICK_WORK, Work};

tuned! {
    /// What was chosen in it.
    pub struct Params {
        /// Steps over the horizon: as many as fit into a tick where no contact opens. Doubled: the look-ahead takes
        /// two ticks, and what it foresees is 4 ms older.
        steps: u8 = 5, 1.0 to 50.0;
        /// Longest single step of the model, s. Doubled: impacts and the begin of a slip are dated twice as coarsely.
        longest_step_s: f32 = 0.02, 0.001 to 0.1;
        /// An object that falls moves at least this fast in the grasp, m/s, ... Doubled: a loss of the grasp is
        /// foreseen one step later.
        falls_m_s: f32 = 0.05, 0.0 to 10.0;
        /// ... and gains at least this, m/s^2: a fifth of gravity. Doubled: objects that pads brake are not lost.
        falls_m_s2: f32 = 2.0, 0.0 to 1000.0;
    }
}

/// What does not change on the way.
pub(crate) struct Course<'a, R: Real> {
    pub scene: &'a Scene<R>,
    pub model: &'a Model<R>,
    pub plan: &'a Plan,
    pub params: &'a Params,
    /// In force where the plan tells nothing.
    pub present: &'a Segment,
    pub horizon_s: R,
    pub slip_m_s: R,
    pub trial: R,
    pub support: Option<Pose<R>>,
    pub reference_m: Vec3<R>,
    /// Object in the grasp when it was first seen.
    pub start: Pose<R>,
}

/// What a look-ahead found; times since it began.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foreseen<R: Real> {
    /// Time stamp at which it began.
    pub began_s: R,
    pub peak_utilisation: [f32; 2],
    /// `None`: not within the horizon.
    pub slip_after_s: [Option<f32>; 2],
    pub slip: [Vec3<R>; 2],
    pub drop_after_s: Option<f32>,
    /// Sag that comes until the end of the horizon, m.
    pub sag_m: R,
    /// A step was not solved within its iterations.
    pub marked: bool,
}

/// A look-ahead under way.
#[derive(Clone, Debug)]
pub(crate) struct Ahead<R: Real> {
    state: State<R, SLOTS>,
    pusher: Option<Pose<R>>,
    pusher_m_s: Option<Vec3<R>>,
    departure_n: R,
    carrier: Pose<R>,
    ahead_s: R,
    speed_m_s: R,
    sag: Sag<R>,
    /// The next step was begun in the last tick, which had too little work left for it.
    waited: bool,
    found: Foreseen<R>,
}

impl<R: Real> Ahead<R> {
    /// Begins one in `place`, from the present on. `pusher_m_s`: velocity, world; `departure_n`: grip commanded beyond
    /// the plan's, which goes on.
    pub fn begin(
        place: &mut Option<Self>,
        state: &State<R, SLOTS>,
        poses: &Poses<R>,
        start: &Pose<R>,
        t_s: R,
        pusher_m_s: Option<Vec3<R>>,
        departure_n: R,
    ) {
        *place = Some(Self {
            state: state.clone(),
            pusher: poses.pusher,
            pusher_m_s,
            departure_n,
            carrier: poses.carrier,
            ahead_s: R::zero(),
            speed_m_s: norm(&Vec3::new(state.velocity[0], state.velocity[1], state.velocity[2])),
            sag: Sag::new(slipped(start, &state.position_m, &state.rotation)),
            waited: false,
            found: Foreseen {
                began_s: t_s,
                peak_utilisation: [0.0; 2],
                slip_after_s: [None; 2],
                slip: [Vec3::zeros(); 2],
                drop_after_s: None,
                sag_m: R::zero(),
                marked: false,
            },
        });
    }

    /// Goes on until the horizon is reached (then what it found is returned) or the work is
    /// used up.
    pub fn go_on(
        &mut self,
        course: &Course<'_, R>,
        work: &mut Work,
        space: &mut Workspace<R, SLOTS>,
        mut note: impl FnMut(&StepSummary<R>),
    ) -> Option<Foreseen<R>> {
        let params = course.params;
        let steps = R::of(f64::from(params.steps.max(1)));
        let dt = clamp(course.horizon_s / steps, R::of(1e-3), R::of(f64::from(params.longest_step_s)));
        let held = course.scene.fingers.is_some();
        while self.ahead_s < course.horizon_s {
            if !work.room() {
                return None;
            }
            let t_s = self.found.began_s + self.ahead_s;
            let segment = course.plan.at(t_s.to_f64() as f32).unwrap_or(course.present);
            let widen = |a: [f32; 3]| Vec3::from(a.map(|x| R::of(f64::from(x))));
            let (linear, angular) = (widen(segment.velocity_m_s), widen(segment.angular_rad_s));
            let carrier = self.carrier;
            let next_carrier = Pose {
                position_m: carrier.position_m + linear * dt,
                rotation: turned(&carrier.rotation, &(angular * dt)),
            };
            let next_pusher = match (self.pusher, self.pusher_m_s) {
                (Some(p), Some(v)) => Some(Pose { position_m: p.position_m + v * dt, ..p }),
                _ => None,
            };
            let from = Poses { t_s: R::zero(), carrier, pusher: self.pusher, support: course.support };
            let to = Poses { t_s: dt, carrier: next_carrier, pusher: next_pusher, support: course.support };
            let grip = max(R::of(f64::from(segment.grip_n)) + self.departure_n, R::zero());
            let Some(drive) = drive_between(&from, &to, &course.reference_m, grip, course.trial) else {
                break;
            };
            let whole = SolveBudget::look_ahead();
            let mut options = work.bounding(&whole, TICK_WORK);
            // What the rest of this tick's work does not solve is begun anew in the next, once.
            let waits = options.max_work < whole.max_work && !self.waited;
            if waits {
                options.follows = Follows::Solved;
            }
            let out =
                crate::step::step_in(course.scene, course.model, &mut self.state, &drive, &options, space);
            note(&out);
            work.add(&out);
            work.step_ahead();
            self.waited = waits && !matches!(out.status, SolveStatus::Solved | SolveStatus::BadInput);
            if self.waited {
                return None;
            }
            self.found.marked |= out.status != SolveStatus::Solved;
            if !out.followed {
                // No forces were found: nothing is foreseen beyond, a loss of the grasp neither.
                break;
            }
            self.ahead_s += dt;
            let when = self.ahead_s.to_f64() as f32;
            let found = &mut self.found;
            for k in 0..2 {
                found.peak_utilisation[k] = found.peak_utilisation[k].max(out.utilisation[k].to_f64() as f32);
                if found.slip_after_s[k].is_none() && norm(&out.slip_m_s[k]) > course.slip_m_s {
                    found.slip_after_s[k] = Some(when);
                    found.slip[k] = out.slip_m_s[k];
                }
            }
            let [n1, n2, ..] = out.normal_n;
            let lost = !(n1 > R::zero()) || !(n2 > R::zero());
            // Falling: fast relative to the gripper, and faster yet.
            let [vx, vy, vz, ..] = self.state.velocity;
            let speed = norm(&Vec3::new(vx, vy, vz));
            let falling = speed > R::of(f64::from(params.falls_m_s))
                && (speed - self.speed_m_s) / dt > R::of(f64::from(params.falls_m_s2));
            self.speed_m_s = speed;
            if held && (lost || falling) {
                found.drop_after_s = found.drop_after_s.or(Some(when));
            }
            let down = unintended_down(
                &course.scene.gravity_m_s2,
                &next_carrier.rotation,
                planned_slide(segment, course.slip_m_s),
            );
            let at_m = slipped(&course.start, &self.state.position_m, &self.state.rotation);
            found.sag_m = self.sag.follow(at_m, &down);
            self.carrier = next_carrier;
            self.pusher = next_pusher;
        }
        Some(self.found)
    }
}
