//! Scenes on a table: lifting a held object off it, pushing a free one over it.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::{Builder, DWELL_S, GAP_M, Placing, RAMP_S, REST_S, Scene};
use crate::drive::{Carrier, Segment};
use crate::law::FrictionLaw;
use crate::sensors::Equipment;
use crate::shape::{Shape, edges};
use crate::surroundings::{Feature, Obstacle};
use crate::truth::Truth;
use crate::world::World;

impl Builder<'_> {
    pub(super) fn lift(&self, truth: Truth, placing: Placing) -> Result<Scene, String> {
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

    pub(super) fn planar_push(&self, truth: Truth, placing: Placing) -> Result<Scene, String> {
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
    pub(super) fn table(&self, truth: &Truth) -> Result<Obstacle, String> {
        let name = self.condition.primitive.name();
        let spec = self
            .description
            .supports
            .get(name)
            .ok_or_else(|| format!("{}: the description has no supports.{name}", self.condition.label))?;
        let low = -self.shape.half_height();
        let feature = match (&self.shape, spec.contact.as_str(), &spec.points_m) {
            (Shape::Cylinder { length, radius, .. }, "patch", _) => {
                Feature::PlaneOnRound { radius: *radius, half_length: length / 2.0, resistance_m: 0.0 }
            }
            (_, "points", Some(points)) => {
                Feature::PlaneOnPoints(points.iter().map(|p| Vector3::new(p[0], p[1], low)).collect())
            }
            _ => Feature::PlaneOnPoints(self.shape.lower_points()),
        };
        let frame = Matrix3::from_columns(&[Vector3::z(), Vector3::x(), Vector3::y()]);
        let law: FrictionLaw = truth.support;
        Ok(Obstacle::new(feature, frame, Vector3::zeros(), truth.hard_stiffness, law, 0.0))
    }
}
