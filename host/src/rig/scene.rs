//! From a condition to a world and a drive: where everything stands and what moves.
//!
//! The geometry of each primitive is described in `docs/rig.md`.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::dataset::{ContactSpec, Description, ObjectSpec, Pose};

use super::body::Body;
use super::condition::{Condition, Primitive, Scenario};
use super::drive::{Carrier, Course, Drive, Load, Segment};
use super::fingers::Jaw;
use super::law::FrictionLaw;
use super::sensors::Equipment;
use super::shape::{Shape, edges};
use super::surroundings::{Feature, Obstacle};
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
    placing: (Vector3<f64>, f64),
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

    fn linear_push(&self, truth: Truth, placing: (Vector3<f64>, f64)) -> Result<Scene, String> {
        let c = self.condition;
        let length = match &self.shape {
            Shape::Prism { length, .. } | Shape::Cylinder { length, .. } => *length,
            Shape::Polygon { .. } => return Err(format!("{}: a polygon has no end face", c.label)),
        };
        let origin = placing.0;
        let attitude = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), placing.1);
        let direction = Vector3::new(-c.slope_rad.cos(), 0.0, c.slope_rad.sin());
        let (segments, end) = self.motion(REST_S, c.travel, c.speed_m_s, (direction * c.speed_m_s, 0.0));
        let plate = Vector3::new(-length / 2.0 - GAP_M, 0.0, 0.0);
        let [pitch, yaw] = truth.plate_tilt_rad;
        let turn = Rotation3::from_euler_angles(0.0, pitch, yaw).into_inner();
        let points = self.shape.end_face_points();
        let pusher = Obstacle::new(
            Feature::PlaneOnPoints(points),
            turn,
            plate,
            truth.hard_stiffness,
            truth.pusher,
            0.0,
        );
        Ok(Scene {
            drive: self.drive(Carrier::new(Vector3::zeros(), segments), None, end + DWELL_S),
            pusher: Some(Pose { position_m: plate.into(), quaternion: [1.0, 0.0, 0.0, 0.0] }),
            equipment: Equipment { fingers: true, pusher: true, rod_attitude: [1.0, 0.0, 0.0, 0.0] },
            world: World {
                body: self.body(&truth, origin, attitude)?,
                jaw: Some(self.jaw(&truth)?),
                pusher: Some(pusher),
                pusher_reference_m: plate,
                support: None,
                truth,
            },
        })
    }

    fn pivot(&self, truth: Truth, placing: (Vector3<f64>, f64)) -> Result<Scene, String> {
        let c = self.condition;
        let face = self.shape.lower_face().ok_or_else(|| {
            format!("{}: only a prism is pivoted, {} is a {}", c.label, self.object.id, self.object.shape)
        })?;
        if c.pusher_offset_m.abs() > face.first.1 {
            return Err(format!(
                "{}: pusher_offset_m is {}, the object ends at {} m",
                c.label, c.pusher_offset_m, face.first.1
            ));
        }
        let edge = Vector3::new(c.pusher_offset_m, 0.0, face.centre.z - GAP_M);
        let (press, press_speed) = PIVOT_PRESS;
        let pressed = REST_S + (press + GAP_M) / press_speed;
        let down = Vector3::new(0.0, 0.0, -press_speed);
        let turn = (Vector3::zeros(), c.speed_rad_s);
        let (mut segments, end) = self.motion(pressed + REST_S, c.travel, c.speed_rad_s, turn);
        let still = Segment { until_s: REST_S, velocity_m_s: Vector3::zeros(), pitch_rate_rad_s: 0.0 };
        segments.splice(0..0, [still, Segment { until_s: pressed, velocity_m_s: down, ..still }]);
        let gripper = Carrier::new(Vector3::new(PIVOT_GRASP_M, 0.0, 0.0), segments);
        let [tilt, yaw] = truth.plate_tilt_rad;
        let frame = Rotation3::from_euler_angles(tilt, 0.0, yaw).into_inner() * upward_frame();
        let length = self.pusher_spec()?.length_m.unwrap_or(0.0);
        let pusher =
            Obstacle::new(Feature::EdgeOnFace(face), frame, edge, truth.hard_stiffness, truth.pusher, length);
        let attitude = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), placing.1 * 0.2);
        Ok(Scene {
            drive: self.drive(gripper, None, end + DWELL_S),
            pusher: Some(Pose { position_m: edge.into(), quaternion: upward_quaternion() }),
            equipment: Equipment { fingers: true, pusher: true, rod_attitude: [1.0, 0.0, 0.0, 0.0] },
            world: World {
                body: self.body(&truth, placing.0, attitude)?,
                jaw: Some(self.jaw(&truth)?),
                pusher: Some(pusher),
                pusher_reference_m: edge,
                support: None,
                truth,
            },
        })
    }

    fn roll(&self, truth: Truth, placing: (Vector3<f64>, f64)) -> Result<Scene, String> {
        let c = self.condition;
        let Shape::Cylinder { length, radius, half_flats } = self.shape else {
            return Err(format!("{}: only a cylinder rolls, {} does not", c.label, self.object.id));
        };
        if half_flats < radius {
            return Err(format!("{}: {} has flats and does not roll", c.label, self.object.id));
        }
        let forward = Vector3::new(0.0, c.speed_m_s, 0.0);
        let (segments, end) = self.motion(REST_S, c.travel, c.speed_m_s, (forward, 0.0));
        // The object rests on the platform with its weight when the jaw closes.
        let weight = truth.mass_kg * 9.81;
        let origin = Vector3::new(placing.0.x, 0.0, radius - weight / truth.hard_stiffness.normal);
        let gripper = Carrier::new(Vector3::new(0.0, 0.0, radius - placing.0.z), segments);
        let [tilt, _] = truth.plate_tilt_rad;
        let frame = Rotation3::from_euler_angles(0.0, tilt, 0.0).into_inner() * upward_frame();
        let platform = Obstacle::new(
            Feature::PlaneOnRound {
                radius,
                half_length: length / 2.0,
                resistance_m: truth.rolling_resistance_m,
            },
            frame,
            Vector3::zeros(),
            truth.hard_stiffness,
            truth.pusher,
            0.0,
        );
        Ok(Scene {
            drive: self.drive(gripper, None, end + DWELL_S),
            pusher: Some(Pose { position_m: [0.0; 3], quaternion: upward_quaternion() }),
            equipment: Equipment { fingers: true, pusher: false, rod_attitude: [1.0, 0.0, 0.0, 0.0] },
            world: World {
                body: self.body(&truth, origin, UnitQuaternion::identity())?,
                jaw: Some(self.jaw(&truth)?),
                pusher: Some(platform),
                pusher_reference_m: Vector3::zeros(),
                support: None,
                truth,
            },
        })
    }

    fn lift(&self, truth: Truth, placing: (Vector3<f64>, f64)) -> Result<Scene, String> {
        let c = self.condition;
        let height = self.shape.half_height();
        let still = Vector3::zeros();
        let at = |until_s: f64, velocity_m_s: Vector3<f64>| Segment {
            until_s,
            velocity_m_s,
            pitch_rate_rad_s: 0.0,
        };
        let start = REST_S;
        let up = start + c.travel / c.speed_m_s;
        let carried = up + c.hold_s / 2.0;
        // Half-way through the hold the object is carried sideways by as much as it was lifted.
        let across = carried + c.travel / c.speed_m_s;
        let end = up + c.hold_s.max(c.travel / c.speed_m_s + RAMP_S + c.hold_s / 2.0);
        let segments = vec![
            at(start, still),
            at(up, Vector3::z() * c.speed_m_s),
            at(carried, still),
            at(across, Vector3::x() * c.speed_m_s),
        ];
        let support = self.table(&truth)?;
        let weight = truth.mass_kg * 9.81;
        let sunk = weight / truth.hard_stiffness.normal;
        let origin = Vector3::new(placing.0.x, 0.0, height - sunk);
        let gripper = Carrier::new(Vector3::new(0.0, 0.0, height - placing.0.z), segments);
        Ok(Scene {
            drive: self.drive(gripper, None, end + DWELL_S),
            pusher: None,
            equipment: Equipment { fingers: true, pusher: false, rod_attitude: [1.0, 0.0, 0.0, 0.0] },
            world: World {
                body: self.body(&truth, origin, UnitQuaternion::identity())?,
                jaw: Some(self.jaw(&truth)?),
                pusher: None,
                pusher_reference_m: still,
                support: Some(support),
                truth,
            },
        })
    }

    fn planar_push(&self, truth: Truth, placing: (Vector3<f64>, f64)) -> Result<Scene, String> {
        let c = self.condition;
        let outline = self.shape.outline();
        let Some((p, q)) = edges(&outline).nth(c.edge) else {
            return Err(format!("{}: edge {} of {}", c.label, c.edge, outline.len()));
        };
        let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
        let length = dx.hypot(dy);
        if c.pusher_offset_m.abs() >= length / 2.0 {
            return Err(format!(
                "{}: pusher_offset_m is {}, the edge is {length} m long",
                c.label, c.pusher_offset_m
            ));
        }
        let along = Vector3::new(dx / length, dy / length, 0.0);
        let inward = Vector3::new(-along.y, along.x, 0.0);
        let height = self.shape.half_height();
        let radius = self.pusher_spec()?.tip_radius_m.unwrap_or(0.005);
        let contact =
            Vector3::new((p[0] + q[0]) / 2.0, (p[1] + q[1]) / 2.0, height) + along * c.pusher_offset_m;
        let start = contact - inward * (radius + GAP_M);
        let direction = inward * c.slope_rad.cos() + along * c.slope_rad.sin();
        let (segments, end) = self.motion(REST_S, c.travel, c.speed_m_s, (direction * c.speed_m_s, 0.0));
        let weight = truth.mass_kg * 9.81;
        let origin = Vector3::new(0.0, 0.0, height - weight / truth.hard_stiffness.normal);
        let attitude = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), placing.1);
        let rod = Obstacle::new(
            Feature::Rod { radius, outline },
            Matrix3::identity(),
            start,
            truth.hard_stiffness,
            truth.pusher,
            0.0,
        );
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), inward.y.atan2(inward.x));
        let support = self.table(&truth)?;
        Ok(Scene {
            drive: self.drive(
                Carrier::new(Vector3::zeros(), Vec::new()),
                Some(Carrier::new(start, segments)),
                end + DWELL_S,
            ),
            pusher: None,
            equipment: Equipment { fingers: false, pusher: true, rod_attitude: [yaw.w, yaw.i, yaw.j, yaw.k] },
            world: World {
                body: self.body(&truth, origin, attitude)?,
                jaw: None,
                pusher: Some(rod),
                pusher_reference_m: start,
                support: Some(support),
                truth,
            },
        })
    }

    /// A horizontal table at world height zero under the lower face or the point feet.
    fn table(&self, truth: &Truth) -> Result<Obstacle, String> {
        let name = self.condition.primitive.name();
        let spec = self
            .description
            .supports
            .get(name)
            .ok_or_else(|| format!("{}: the description has no supports.{name}", self.condition.label))?;
        let low = -self.shape.half_height();
        let points = match (spec.contact.as_str(), &spec.points_m) {
            ("points", Some(points)) => points.iter().map(|p| Vector3::new(p[0], p[1], low)).collect(),
            _ => self.shape.lower_points(),
        };
        let frame = Matrix3::from_columns(&[Vector3::z(), Vector3::x(), Vector3::y()]);
        let law: FrictionLaw = truth.support;
        Ok(Obstacle::new(
            Feature::PlaneOnPoints(points),
            frame,
            Vector3::zeros(),
            truth.hard_stiffness,
            law,
            0.0,
        ))
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
