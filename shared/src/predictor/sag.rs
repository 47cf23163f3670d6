//! Sag: motion in the grasp along gravity that the plan does not intend, summed along the path.
//!
//! What moves is the object's material point that lay between the pads at the start, so that a
//! turn about the pads is no sag. At each moment the direction of the planned slide `u` (a unit
//! vector; zero where none is planned) leaves `g = d - u (u . d)` of gravity's direction `d`, and
//! the sag is the integral of `g . ds`. A direction counts from when it is in force: what the
//! object did before keeps its value, however the plan goes on.

use super::plan::{Intent, Segment};
use crate::real::{Real, Rotation, Vec3, norm};
use crate::track::Pose;

/// The direction is held until it has changed by so much (rad): sums then carry the noise of two
/// poses, not of every sample, and err by at most half a percent of the path. Doubled: by one
/// percent, 0.15 mm on a slide of 15 mm.
const TURNED_RAD: f64 = 0.005;

/// Direction of the slide that a segment plans, world axes; `None` where it plans none: another
/// intent, or slower than `least_m_s`, below which a finger counts as sticking.
pub fn planned_slide<R: Real>(segment: &Segment, least_m_s: R) -> Option<Vec3<R>> {
    let v = Vec3::from(segment.velocity_m_s.map(|x| R::of(f64::from(x))));
    let speed = norm(&v);
    (segment.intent == Intent::Slide && speed > least_m_s && speed > R::zero()).then(|| v / speed)
}

/// What counts as sag of a motion in the grasp, carrier axes: its product with the motion is the sag.
pub fn unintended_down<R: Real>(
    gravity_m_s2: &[R; 3],
    carrier: &Rotation<R>,
    slide: Option<Vec3<R>>,
) -> Vec3<R> {
    let gravity = Vec3::from(*gravity_m_s2);
    let size = norm(&gravity);
    if !(size > R::of(1e-3)) {
        return Vec3::zeros();
    }
    let mut down = gravity / size;
    if let Some(u) = slide {
        down -= u * u.dot(&down);
    }
    carrier.inverse_transform_vector(&down)
}

/// Motion of the material point that lay between the pads at the start, carrier axes, m.
pub fn slipped<R: Real>(start: &Pose<R>, position_m: &Vec3<R>, rotation: &Rotation<R>) -> Vec3<R> {
    let turn = rotation * start.rotation.inverse();
    position_m - turn.transform_vector(&start.position_m)
}

/// The sum.
#[derive(Clone, Copy, Debug)]
pub struct Sag<R: Real> {
    /// Up to `from_m`.
    before_m: R,
    from_m: Vec3<R>,
    /// Where the point was last seen.
    last_m: Vec3<R>,
    down: Vec3<R>,
}

impl<R: Real> Sag<R> {
    /// None yet; the point is at `at_m`.
    pub fn new(at_m: Vec3<R>) -> Self {
        Self { before_m: R::zero(), from_m: at_m, last_m: at_m, down: Vec3::zeros() }
    }

    /// The point has come to `at_m` while `down` (see [`unintended_down`]) was in force: the sag so far.
    pub fn follow(&mut self, at_m: Vec3<R>, down: &Vec3<R>) -> R {
        if norm(&(down - self.down)) > R::of(TURNED_RAD) {
            self.before_m += self.down.dot(&(self.last_m - self.from_m));
            self.from_m = self.last_m;
            self.down = *down;
        }
        self.last_m = at_m;
        self.before_m + self.down.dot(&(at_m - self.from_m))
    }
}
