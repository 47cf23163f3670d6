//! One tick's sequence: step the model to the sample, correct it, observe, look ahead, decide.

use super::advance::{Worst, advance};
use super::context::Context;
use super::decide::decide;
use super::describe::{load_of, rotation_between};
use super::evidence::Now;
use super::patch::effects_on_friction;
use super::plan::{Intent, Segment};
use super::sag::{planned_slide, slipped, unintended_down};
use super::tracked::Tracked;
use super::types::{Sample, Slip, flags, validity};
use super::witness::Witness;
use crate::cone::Kept;
use crate::cone::SolveStatus;
use crate::health::Repeats;
use crate::real::{Real, Vec3, max, min, norm};
use crate::step::{Drive, Workspace};
use crate::track::{PathFilter, drive_between};

/// Why a sample was not followed.
pub(super) enum Unfollowed {
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

impl<R: Real> Context<R> {
    /// The last prediction becomes that for the sample.
    pub(super) fn follow(
        &mut self,
        tracked: &mut Tracked<R>,
        sample: &Sample<R>,
        mut doubt: u32,
    ) -> Result<(), Unfollowed> {
        let raw = self.poses(sample, Some(tracked)).ok_or(Unfollowed::Sample)?;
        if self.leapt(&tracked.poses, &raw) {
            return Err(Unfollowed::Sample);
        }
        let poses = self.denoised(raw, tracked);
        let drive =
            drive_between(&tracked.poses, &poses, &tracked.reference_m, sample.grip_cmd_n, self.trial)
                .ok_or(Unfollowed::Sample)?;
        self.model.friction.finger = self.observer.assumed_friction();
        let mut work = Workspace::new();
        *work.kept() = tracked.kept[0];
        let mut worst = Worst::default();
        let mut witness = Witness::of(&self.model, &tracked.state);
        let mut out = advance(
            (&self.scene, &self.model),
            &self.params.ahead,
            &mut tracked.state,
            &drive,
            &mut work,
            &mut worst,
        );
        if !out.followed {
            // Numbers that no rig has, or forces that were not found: the last good state is kept for the next sample, and
            // after a gap's length of such samples the model starts anew. (It does so at once
            // where a gap was bridged in parts and the later ones failed.)
            self.work = worst.work.done();
            tracked.gripper = PathFilter::new(tracked.poses.carrier, self.track.path);
            tracked.pusher = tracked.poses.pusher.map(|p| PathFilter::new(p, self.track.path));
            let unsolved = matches!(out.status, SolveStatus::IterationLimit | SolveStatus::Numerical);
            tracked.unsolved = if unsolved { tracked.unsolved.saturating_add(1) } else { 0 };
            if tracked.unsolved >= self.params.unsolved_samples {
                self.start_again(tracked, &drive, poses);
            }
            let residual_n = out.residual_n.to_f64() as f32;
            return Err(Unfollowed::Solver { status: out.status, residual_n, lost: worst.moved });
        }
        if let Some(witness) = &mut witness {
            witness.saw(&self.model, &out, &tracked.state);
        }
        tracked.unsolved = 0;
        tracked.kept[0] = *work.kept();
        let effects = effects_on_friction(&self.model, &work, &load_of(sample, &out));
        tracked.poses = poses;
        if tracked.pusher.is_some() && drive.pusher.is_none() {
            // It was there when the object was first seen: the step was made without it.
            doubt |= validity::POSE;
        }
        if out.points_lost > 0 {
            doubt |= validity::POINTS_LOST;
        }
        tracked.pushing = out.normal_n[2] > R::zero();
        let repeats = sample.object.map_or(Repeats::No, |object| self.health.repeats(&object));
        if repeats != Repeats::No {
            doubt |= validity::POSE;
        }
        // One that is held is late, and better than none.
        let mut object = sample.object.filter(|_| repeats != Repeats::Frozen);
        let is_late = self.late_s != R::zero() && self.scene.fingers.is_some();
        let of_one_moment = is_late.then(|| tracked.waiting.in_grasp(self.late_s, sample, object));
        if of_one_moment == Some(None) {
            object = None;
        }
        tracked.unseen_s += drive.dt_s;
        if let Some(seen) = object {
            let measured = of_one_moment.flatten().unwrap_or_else(|| poses.carrier.to_local(&seen));
            let strayed = self.correct(tracked, &measured);
            tracked.strayed = if strayed { tracked.strayed.saturating_add(1) } else { 0 };
            // What slides leaves the model step by step, a wild pose jumps.
            let limit = R::of(f64::from(self.limits.divergence_m));
            let way_m = norm(&(measured.position_m - tracked.seen_m));
            let jumped = !(way_m <= limit);
            // Nothing leaves the fingers faster than they are carried.
            let off = self.out_of_reach(tracked, &measured);
            let fastest_m_s = R::of(f64::from(self.params.fastest_m_s));
            if strayed && off && !(way_m <= max(limit, fastest_m_s * tracked.unseen_s)) {
                tracked.strayed = 0;
            }
            let wild = strayed && jumped && tracked.strayed < self.params.strayed_samples;
            if !wild {
                tracked.seen_m = measured.position_m;
                tracked.unseen_s = R::zero();
            }
            if wild {
                // One wild pose is the camera's error; an object does not jump there and back.
                doubt |= validity::POSE;
                object = None;
            } else if strayed {
                if tracked.away && !off {
                    tracked.returned();
                    self.observer.forget_motion();
                }
                tracked.away = off;
                tracked.strayed = 0;
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
        let seen = object.zip(sample.gripper).map(|(object, gripper)| gripper.to_local(&object));
        let seen = of_one_moment.flatten().filter(|_| object.is_some()).or(seen);
        let observed =
            self.observe(tracked, &out, sample, &drive, &present, seen.as_ref(), effects, &mut doubt);
        let mut p = self.describe(tracked, &out, &observed, &present);
        let at_m = slipped(&tracked.start, &tracked.state.position_m, &tracked.state.rotation);
        let model_sag = tracked.sag[0].follow(at_m, &down).to_f64() as f32;
        p.sag_m = model_sag;
        *work.kept() = tracked.kept[1];
        self.look_ahead(tracked, &drive, sample, &present, &mut p, &mut worst, &mut work, &mut doubt);
        tracked.kept[1] = *work.kept();
        // A gap is bridged in several steps, which nobody kept.
        if let Some(witness) = &mut witness
            && drive.dt_s <= R::of(f64::from(self.params.ahead.longest_step_s))
        {
            *work.kept() = Kept::nothing();
            let own = (&self.scene, &self.model);
            witness.ask(own, &drive, &mut worst.work, &mut work, &mut self.testimony);
        }
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
            let horizon_s = R::of(f64::from(self.limits.horizon_s));
            let by_forces = observed.ratio.and_then(|_| self.observer.holds(effects, horizon_s));
            let slips = verdict.slip.contains(&Slip::Now);
            p.hold_probability = by_forces.filter(|_| !slips).map(|by_forces| {
                // What the plan adds, by a model that carries the load.
                let peak = p.finger.iter().fold(0.0f32, |u, f| u.max(f.peak_utilisation));
                let needed = self.model.friction.finger * R::of(f64::from(peak));
                let by_plan = if evidence.agrees { self.observer.probability_of(needed) } else { R::one() };
                min(by_forces, by_plan).to_f64() as f32
            });
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
        p.solver_status = worst.status;
        self.work = worst.work.done();
        p.solver_residual_n = worst.residual_n.to_f64() as f32;
        p.solver_iterations = worst.iterations;
        self.last = p;
        Ok(())
    }
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
