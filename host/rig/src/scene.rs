//! From a condition to a world and a drive: where everything stands and what moves.
//!
//! The geometry of each primitive is described in `docs/rig.md`.

mod held;
mod table;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use stickslip_data::{ContactSpec, Description, ObjectSpec, Pose};

use super::body::Body;
use super::condition::{Condition, Primitive, Scenario};
use super::drive::{Carrier, Course, Drive, Load, Segment};
use super::fingers::Jaw;
use super::sensors::Equipment;
use super::shape::Shape;
use super::truth::Truth;
use super::world::World;

/// Gap between object and pusher at the start, m.
const GAP_M: f64 = 3e-4;
/// Rest at the start of a recording, s.
const REST_S: f64 = 0.2;
/// Rest at its end, s.
const DWELL_S: f64 = 0.3;
/// Object X of the grasp while pivoting, m.
pub const PIVOT_GRASP_M: f64 = -0.03;
/// How far the gripper presses the object onto the edge before it pivots, and how fast, m and m/s.
const PIVOT_PRESS: (f64, f64) = (4e-4, 5e-3);
/// Time in which motions start and stop, s.
const RAMP_S: f64 = 0.03;

/// Where an object lies in the gripper: offset (m) and turn about Y (about Z on a table, rad).
pub type Placing = (Vector3<f64>, f64);

/// A trial that is ready to run.
pub struct Scene {
    /// Bodies and contacts.
    pub world: World,
    /// What happens.
    pub drive: Drive,
    /// The pusher's pose as told, where it is fixed.
    pub pusher: Option<Pose>,
    /// What is measured.
    pub equipment: Equipment,
}

/// Sets the scene of one trial. `placing` is where the object lies in the gripper.
///
/// # Errors
/// Says which object, contact or value does not suit the primitive.
pub fn set(
    description: &Description,
    object: &ObjectSpec,
    condition: &Condition,
    truth: Truth,
    placing: Placing,
) -> Result<Scene, String> {
    let shape = Shape::of(object)?;
    let builder = Builder { description, object, condition, shape };
    builder.check()?;
    match condition.primitive {
        Primitive::LinearPush => builder.linear_push(truth, placing),
        Primitive::Pivot => builder.pivot(truth, placing),
        Primitive::Roll => builder.roll(truth, placing),
        Primitive::Lift => builder.lift(truth, placing),
        Primitive::PlanarPush => builder.planar_push(truth, placing),
    }
}

struct Builder<'a> {
    description: &'a Description,
    object: &'a ObjectSpec,
    condition: &'a Condition,
    shape: Shape,
}

impl Builder<'_> {
    fn check(&self) -> Result<(), String> {
        let c = self.condition;
        let grasped = c.primitive != Primitive::PlanarPush;
        let speed = if c.primitive == Primitive::Pivot { c.speed_rad_s } else { c.speed_m_s };
        let positive = [("travel", c.travel), ("speed", speed), ("mass_kg", self.object.mass_kg)];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{}: {name} is {value}, it must be positive", c.label));
            }
        }
        if grasped && !(c.grip_n.is_finite() && (0.0..=500.0).contains(&c.grip_n)) {
            return Err(format!("{}: grip_n is {}, it must lie in 0 to 500 N", c.label, c.grip_n));
        }
        if !(c.slope_rad.abs() < 1.2) {
            return Err(format!("{}: slope_rad is {}, it must lie within 1.2", c.label, c.slope_rad));
        }
        Ok(())
    }

    fn body(
        &self,
        truth: &Truth,
        origin: Vector3<f64>,
        attitude: UnitQuaternion<f64>,
    ) -> Result<Body, String> {
        let told = match self.object.inertia_kg_m2 {
            Some(rows) => Matrix3::from_fn(|i, j| rows[i][j]),
            None => self.shape.inertia(self.object.mass_kg),
        };
        let inertia = told * (truth.mass_kg / self.object.mass_kg);
        Body::at_rest(truth.mass_kg, inertia, truth.com_offset_m.into(), origin, attitude)
            .ok_or_else(|| format!("object {}: inertia_kg_m2 is not that of a body", self.object.id))
    }

    fn jaw(&self, truth: &Truth) -> Result<Jaw, String> {
        let side = self.shape.grasped_side().ok_or_else(|| {
            format!("{}: the rig does not grasp the polygon {}", self.condition.label, self.object.id)
        })?;
        let fingers = self.description.fingers.as_ref();
        let diameter = fingers.and_then(|f| f.diameter_m).unwrap_or(0.0);
        let grip = self.condition.grip_n * (1.0 - truth.grip_loss);
        Ok(Jaw::closed(side, diameter / 2.0, grip, self.condition.rest_s, truth))
    }

    fn grip(&self) -> Course {
        let grip = self.condition.grip_n;
        match self.condition.scenario {
            Scenario::DecayingGrip { share, from_s, until_s } => {
                Course::through(vec![(from_s, grip), (until_s, grip * share)])
            }
            _ => Course::constant(grip),
        }
    }

    fn finger_friction(&self) -> Course {
        match self.condition.scenario {
            Scenario::FrictionDrop { share, at_s } => Course::through(vec![(at_s, 1.0), (at_s + 0.2, share)]),
            _ => Course::constant(1.0),
        }
    }

    fn loads(&self, until_s: f64) -> Vec<Load> {
        let load = |force: [f64; 3], knots: Vec<(f64, f64)>| Load {
            force_n: force.into(),
            point_m: Vector3::zeros(),
            course: Course::through(knots),
        };
        match self.condition.scenario {
            Scenario::SuddenLoad { force_n, at_s } => {
                let knots = [(0.0, 0.0), (0.01, 1.0), (0.5, 1.0), (0.51, 0.0)];
                vec![load(force_n, knots.map(|(t, x)| (at_s + t, x)).to_vec())]
            }
            Scenario::Bumps { force_n, from_s } => {
                let count = ((until_s - from_s) / 0.7).max(0.0) as usize;
                let knots = (0..count)
                    .map(|i| from_s + 0.7 * i as f64)
                    .flat_map(|at| [(at, 0.0), (at + 0.02, 1.0), (at + 0.04, 0.0)])
                    .collect();
                vec![load(force_n, knots)]
            }
            _ => Vec::new(),
        }
    }

    fn drive(&self, gripper: Carrier, rod: Option<Carrier>, duration_s: f64) -> Drive {
        Drive {
            gripper,
            rod,
            grip_n: self.grip(),
            commanded_n: None,
            finger_friction: self.finger_friction(),
            loads: self.loads(duration_s - 1.0),
            duration_s,
        }
    }

    /// Rest, motion (with a pause in the middle where wanted), rest.
    fn motion(
        &self,
        start_s: f64,
        length: f64,
        speed: f64,
        twist: (Vector3<f64>, f64),
    ) -> (Vec<Segment>, f64) {
        let half = (length / speed) / 2.0;
        let still = (Vector3::zeros(), 0.0);
        let segment = |until_s: f64, (velocity_m_s, pitch_rate_rad_s): (Vector3<f64>, f64)| Segment {
            until_s,
            velocity_m_s,
            pitch_rate_rad_s,
        };
        let middle = start_s + half;
        let resumed = middle + self.condition.pause_s;
        let end = resumed + half;
        let segments = vec![
            segment(start_s, still),
            segment(middle, twist),
            segment(resumed, still),
            segment(end, twist),
        ];
        (segments, end)
    }

    fn pusher_spec(&self) -> Result<&ContactSpec, String> {
        let name = self.condition.primitive.name();
        self.description
            .pushers
            .get(name)
            .ok_or_else(|| format!("{}: the description has no pushers.{name}", self.condition.label))
    }
}

/// Pusher axes whose X points up and whose Y is world Y.
fn upward_frame() -> Matrix3<f64> {
    Matrix3::from_columns(&[Vector3::z(), Vector3::y(), -Vector3::x()])
}

/// The same as a quaternion w, x, y, z: a quarter turn back about Y.
fn upward_quaternion() -> [f64; 4] {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    [half, 0.0, -half, 0.0]
}
