//! What the newest finished look-ahead foresees, counted from now, and the next one begun.

use super::advance::Worst;
use super::ahead::{Ahead, Course};
use super::context::Context;
use super::describe::direction;
use super::plan::{Intent, Segment};
use super::tracked::Tracked;
use super::types::{Prediction, Sample, Slip, validity};
use crate::contact::SLOTS;
use crate::real::Real;
use crate::step::{Drive, Workspace};

impl<R: Real> Context<R> {
    /// Goes on with the look-ahead, begins a new one where the work allows, and tells what the
    /// newest finished one foresees, from now.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn look_ahead(
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
            params: &self.params.ahead,
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
