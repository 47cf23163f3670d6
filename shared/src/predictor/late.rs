//! Poses of one moment, where the model knows that the object's arrives late.
//!
//! A pose that is `L` late shows the object where it was `L` ago. Put together with the gripper's present pose, it seems to
//! move in the grasp by `L v` in every move at `v`, and a move of 0.5 m/s with poses 5 ms late looks as a slip of 2.5 mm.
//! The gripper's poses are kept, and the object's is seen from where the gripper was `L` ago, between two samples. Where `L` is
//! negative, an earlier pose of the object is taken: never one between two, whose noise would be less than that of a pose, and
//! hardly differ from sample to sample. A slip is seen as late as the poses are.

use super::types::Sample;
use crate::real::{Real, Vec3};
use crate::rotation::turned;
use crate::track::Pose;
use crate::window::shift_in;

/// Poses of the gripper that are kept: 0.12 s at 250 Hz. What is later is seen as if it were so much late.
const GRIPPERS: usize = 32;
/// Poses of the object that are kept: 32 ms at 250 Hz, by which poses may be early.
const OBJECTS: usize = 8;

/// A pose and when it was taken, s.
type Timed<R> = (R, Pose<R>);

/// Poses that wait for those of their moment, the newest first.
#[derive(Clone, Debug)]
pub(super) struct Waiting<R: Real> {
    grippers: [Option<Timed<R>>; GRIPPERS],
    objects: [Option<Timed<R>>; OBJECTS],
    /// Of the last object's pose that was used.
    used_s: Option<R>,
}

impl<R: Real> Waiting<R> {
    pub(super) fn new() -> Self {
        Self { grippers: [None; GRIPPERS], objects: [None; OBJECTS], used_s: None }
    }

    /// The object as it was seen from the gripper at one moment; `None` where there is no pose that was not used before.
    pub(super) fn in_grasp(
        &mut self,
        late_s: R,
        sample: &Sample<R>,
        object: Option<Pose<R>>,
    ) -> Option<Pose<R>> {
        if let Some(gripper) = sample.gripper {
            shift_in(&mut self.grippers, Some((sample.t_s, gripper)));
        }
        if let Some(object) = object {
            shift_in(&mut self.objects, Some((sample.t_s, object)));
        }
        // By half a sample the gripper is foreseen: to wait for the next one would take a whole.
        let mut times = self.grippers.iter().flatten().map(|(at_s, _)| *at_s);
        let last_s = times.next()?;
        let soon_s = last_s + (last_s - times.next().unwrap_or(last_s)) * R::of(0.5);
        let (at_s, object) = *self.objects.iter().flatten().find(|(at_s, _)| !(*at_s - late_s > soon_s))?;
        if self.used_s == Some(at_s) {
            return None;
        }
        let gripper = self.gripper_at(at_s - late_s)?;
        self.used_s = Some(at_s);
        Some(gripper.to_local(&object))
    }

    /// The gripper, between two samples or a little after the last.
    fn gripper_at(&self, t_s: R) -> Option<Pose<R>> {
        let mut after: Option<&Timed<R>> = None;
        let mut known = self.grippers.iter().flatten().peekable();
        while let Some(pose) = known.next() {
            let before = if pose.0 > t_s { None } else { Some(pose) };
            match (before, after, known.peek()) {
                (Some(before), Some(after), _) => return Some(between(before, after, t_s)),
                (Some(last), None, Some(before)) => return Some(between(before, last, t_s)),
                (Some(only), None, None) => return Some(only.1),
                (None, ..) => after = Some(pose),
            }
        }
        // Later than what is kept.
        let [.., oldest] = &self.grippers;
        oldest.map(|(_, pose)| pose)
    }
}

fn between<R: Real>(a: &Timed<R>, b: &Timed<R>, t_s: R) -> Pose<R> {
    let share = (t_s - a.0) / (b.0 - a.0);
    let (a, b) = (&a.1, &b.1);
    let turn = (b.rotation * a.rotation.inverse()).into_inner();
    let side = if turn.w < R::zero() { -R::one() } else { R::one() };
    let by_rad = Vec3::new(turn.i, turn.j, turn.k) * (R::of(2.0) * side * share);
    Pose {
        position_m: a.position_m + (b.position_m - a.position_m) * share,
        rotation: turned(&a.rotation, &by_rad),
    }
}
