//! Scenes of a held object that meets a plate, an edge or a platform.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};

use super::{Builder, GAP_M, PIVOT_GRASP_M, PIVOT_PRESS, REST_S, Scene, upward_frame, upward_quaternion};
use super::{DWELL_S, Placing};
use crate::drive::{Carrier, Segment};
use crate::sensors::Equipment;
use crate::shape::Shape;
use crate::surroundings::{Feature, Obstacle};
use crate::truth::Truth;
use crate::world::World;
use stickslip_data::Pose;

impl Builder<'_> {
    pub(super) fn linear_push(&self, truth: Truth, placing: Placing) -> Result<Scene, String> {
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

    pub(super) fn pivot(&self, truth: Truth, placing: Placing) -> Result<Scene, String> {
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

    pub(super) fn roll(&self, truth: Truth, placing: Placing) -> Result<Scene, String> {
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
}
