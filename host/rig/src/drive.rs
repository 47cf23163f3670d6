//! What is commanded and what happens from outside during a trial: motion of gripper and
//! rod, grip force, loads on the object, changes of friction.

use nalgebra::{UnitQuaternion, Vector3};

/// Largest acceleration of a commanded motion, m/s².
const ACCELERATION_M_S2: f64 = 1.0;
/// Largest angular acceleration of a commanded turn, rad/s².
const ANGULAR_ACCELERATION_RAD_S2: f64 = 10.0;

/// A stretch of commanded motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// When it ends, s.
    pub until_s: f64,
    /// World axes, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// About the Y axis through the body's own origin, rad/s.
    pub pitch_rate_rad_s: f64,
}

/// A body that follows its commands exactly, whatever the forces: robot flange or rod.
#[derive(Clone, Debug)]
pub struct Carrier {
    /// Origin in the world, m.
    pub origin_m: Vector3<f64>,
    /// Angle about world Y, rad.
    pub pitch_rad: f64,
    /// m/s.
    pub velocity_m_s: Vector3<f64>,
    /// About world Y, rad/s.
    pub pitch_rate_rad_s: f64,
    segments: Vec<Segment>,
    next: usize,
}

impl Carrier {
    /// At rest at `origin_m`, about to run through `segments` in order; then it stops.
    pub fn new(origin_m: Vector3<f64>, segments: Vec<Segment>) -> Self {
        Self {
            origin_m,
            pitch_rad: 0.0,
            velocity_m_s: Vector3::zeros(),
            pitch_rate_rad_s: 0.0,
            segments,
            next: 0,
        }
    }

    /// Axes in the world.
    pub fn attitude(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), self.pitch_rad)
    }

    /// Moves on to `t_s + dt_s`, with limited acceleration.
    pub fn advance(&mut self, t_s: f64, dt_s: f64) {
        while self.segments.get(self.next).is_some_and(|s| s.until_s <= t_s) {
            self.next += 1;
        }
        let (velocity, rate) = match self.segments.get(self.next) {
            Some(s) => (s.velocity_m_s, s.pitch_rate_rad_s),
            None => (Vector3::zeros(), 0.0),
        };
        let change = velocity - self.velocity_m_s;
        let most = ACCELERATION_M_S2 * dt_s;
        self.velocity_m_s += change.cap_magnitude(most);
        let most = ANGULAR_ACCELERATION_RAD_S2 * dt_s;
        self.pitch_rate_rad_s += (rate - self.pitch_rate_rad_s).clamp(-most, most);
        self.origin_m += self.velocity_m_s * dt_s;
        self.pitch_rad += self.pitch_rate_rad_s * dt_s;
    }
}

/// A quantity given at some times and linear between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    knots: Vec<(f64, f64)>,
}

impl Course {
    /// The same value for ever.
    pub fn constant(value: f64) -> Self {
        Self { knots: vec![(0.0, value)] }
    }

    /// Through `(time s, value)`, times rising.
    pub fn through(knots: Vec<(f64, f64)>) -> Self {
        Self { knots }
    }

    /// Value at `t_s`; the ends' values outside.
    pub fn at(&self, t_s: f64) -> f64 {
        let after = self.knots.partition_point(|(t, _)| *t <= t_s);
        match (after.checked_sub(1).and_then(|i| self.knots.get(i)), self.knots.get(after)) {
            (Some((t0, x0)), Some((t1, x1))) => x0 + (x1 - x0) * (t_s - t0) / (t1 - t0),
            (Some((_, x)), None) | (None, Some((_, x))) => *x,
            (None, None) => 0.0,
        }
    }
}

/// A force on the object from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// World axes, N; scaled by `course`.
    pub force_n: Vector3<f64>,
    /// Where it acts, object axes, m.
    pub point_m: Vector3<f64>,
    /// Factor over time.
    pub course: Course,
}

/// Everything that drives a trial.
#[derive(Clone, Debug)]
pub struct Drive {
    /// The gripper's motion.
    pub gripper: Carrier,
    /// The pusher's motion where it moves.
    pub rod: Option<Carrier>,
    /// Commanded normal force of each finger, N.
    pub grip_n: Course,
    /// Factor on the fingers' friction (1: unchanged).
    pub finger_friction: Course,
    /// Grip force of each finger that a controller commands instead, N. The gripper then loses the same share of it
    /// that [`Self::grip_n`] loses of its first value: an actuator that fades, fades under any command.
    pub commanded_n: Option<f64>,
    /// Loads on the object.
    pub loads: Vec<Load>,
    /// How long is recorded, s.
    pub duration_s: f64,
}

impl Drive {
    /// Normal force of each finger that the gripper is set to at `t_s`, N.
    pub fn grip_at(&self, t_s: f64) -> f64 {
        let (planned_n, first_n) = (self.grip_n.at(t_s), self.grip_n.at(0.0));
        match self.commanded_n {
            Some(commanded_n) if first_n > 0.0 => commanded_n * planned_n / first_n,
            _ => planned_n,
        }
    }
}
