//! What the object touches besides the fingers: the pusher (plate, edge, platform or rod)
//! and the table.

use nalgebra::{Matrix3, Vector3};

use super::body::Body;
use super::drive::Carrier;
use super::fingers::{Loading, relative_twist, to_world};
use super::law::{FrictionLaw, Stiffness};
use super::patch::Patch;
use super::shape::{Face, edges};

/// Angular speed above which rolling resistance is fully there, rad/s.
const ROLLING_SPEED_RAD_S: f64 = 0.02;

/// Contact feature and the part of the object it meets.
#[derive(Clone, Debug)]
pub enum Feature {
    /// A plane against material points of the object (object axes).
    PlaneOnPoints(Vec<Vector3<f64>>),
    /// A plane against a round side about object X: radius and half length.
    PlaneOnRound {
        /// m.
        radius: f64,
        /// m.
        half_length: f64,
        /// Lever of the reaction ahead of the rolling object, m.
        resistance_m: f64,
    },
    /// An edge along the frame's Y against a face of the object.
    EdgeOnFace(Face),
    /// A vertical rod against the object's outline.
    Rod {
        /// m.
        radius: f64,
        /// Object XY, counter-clockwise.
        outline: Vec<[f64; 2]>,
    },
}

/// A pusher or table, fixed or carried.
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// What touches.
    pub feature: Feature,
    /// Axes of the contact frame in the world; the first points into the object.
    pub frame: Matrix3<f64>,
    /// Origin, m.
    pub origin_m: Vector3<f64>,
    /// Stiffness of the whole contact.
    pub stiffness: Stiffness,
    /// Friction.
    pub law: FrictionLaw,
    /// Points.
    pub patch: Patch,
}

impl Obstacle {
    /// Puts the points of `feature` in place. `edge_length_m` is used by an edge only.
    pub fn new(
        feature: Feature,
        frame: Matrix3<f64>,
        origin_m: Vector3<f64>,
        stiffness: Stiffness,
        law: FrictionLaw,
        edge_length_m: f64,
    ) -> Self {
        let patch = match &feature {
            Feature::PlaneOnPoints(points) => Patch::new(points.iter().map(|_| (0.0, 0.0))),
            Feature::PlaneOnRound { half_length, .. } => Patch::line(2.0 * half_length, 12),
            Feature::EdgeOnFace(_) => Patch::line(edge_length_m, 15),
            Feature::Rod { .. } => Patch::new([(0.0, 0.0)]),
        };
        Self { feature, frame, origin_m, stiffness, law, patch }
    }

    /// Force on the object for one step. `carrier` moves the obstacle where it moves.
    pub fn press(&mut self, body: &Body, carrier: Option<&Carrier>, dt_s: f64) -> Loading {
        let still = Vector3::zeros();
        let (velocity, base) = match carrier {
            Some(c) => (c.velocity_m_s, c.origin_m),
            None => (still, self.origin_m),
        };
        let object_axes = body.attitude.to_rotation_matrix().into_inner();
        let origin = body.origin_m();
        let mut frame = self.frame;
        let mut at = base;
        let patch = &mut self.patch;
        let mut rolling = None;
        match &self.feature {
            Feature::PlaneOnPoints(points) => {
                let turn = frame.tr_mul(&object_axes);
                let shift = frame.tr_mul(&(origin - at));
                for (k, point) in points.iter().enumerate() {
                    let p = turn * point + shift;
                    patch.depth[k] = -p.x;
                    patch.a[k] = p.y;
                    patch.b[k] = p.z;
                }
            }
            Feature::PlaneOnRound { radius, half_length, resistance_m } => {
                let axis = frame.tr_mul(&object_axes.column(0));
                let centre = frame.tr_mul(&(origin - at));
                let down = (-Vector3::x() + axis * axis.x).normalize() * *radius;
                let count = patch.len() as f64;
                for k in 0..patch.len() {
                    let t = half_length * ((2 * k + 1) as f64 / count - 1.0);
                    let p = centre + axis * t + down;
                    patch.depth[k] = -p.x;
                    patch.a[k] = p.y;
                    patch.b[k] = p.z;
                }
                rolling = Some((axis, *resistance_m));
            }
            Feature::EdgeOnFace(face) => {
                let normal = frame.tr_mul(&(object_axes * face.normal));
                let centre = frame.tr_mul(&(origin + object_axes * face.centre - at));
                let first = frame.tr_mul(&(object_axes * face.first.0));
                let second = frame.tr_mul(&(object_axes * face.second.0));
                for k in 0..patch.len() {
                    let (a, b) = (patch.a[k] - centre.y, patch.b[k] - centre.z);
                    let rise = -(normal.y * a + normal.z * b) / normal.x;
                    let p = Vector3::new(rise, a, b);
                    let on_face = first.dot(&p).abs() <= face.first.1
                        && second.dot(&p).abs() <= face.second.1
                        && normal.x < -0.1;
                    patch.depth[k] = if on_face { -(centre.x + rise) } else { -1.0 };
                }
            }
            Feature::Rod { radius, outline } => {
                let local = object_axes.tr_mul(&(at - origin));
                let (nearest, gap) = nearest_on_outline(outline, [local.x, local.y]);
                let out = Vector3::new(local.x - nearest[0], local.y - nearest[1], 0.0);
                patch.depth[0] = radius - gap;
                if gap > 0.0 {
                    let normal = -(object_axes * out) / gap;
                    let up = Vector3::z();
                    frame = Matrix3::from_columns(&[normal, up.cross(&normal), up]);
                    at += normal * *radius;
                }
            }
        }
        let twist = relative_twist(body, &frame, &at, &velocity, &still, &base);
        let mut sum = patch.press(&twist, &self.stiffness, &self.law, dt_s);
        if let Some((axis, lever)) = rolling.filter(|(_, lever)| *lever != 0.0) {
            let rate: f64 = (0..3).map(|i| axis[i] * twist.spin[i]).sum();
            let torque = -lever * sum.force[0] * (rate / ROLLING_SPEED_RAD_S).tanh();
            for (t, d) in sum.torque.iter_mut().zip(axis.iter()) {
                *t += torque * d;
            }
        }
        to_world(&sum, &frame, &at, &body.com_m)
    }
}

/// Nearest point of a closed outline and its distance, negative inside.
fn nearest_on_outline(outline: &[[f64; 2]], p: [f64; 2]) -> ([f64; 2], f64) {
    let mut best = ([0.0, 0.0], f64::INFINITY);
    let mut inside = true;
    for (a, b) in edges(outline) {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let (px, py) = (p[0] - a[0], p[1] - a[1]);
        inside &= dx * py - dy * px >= 0.0;
        let t = ((px * dx + py * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        let q = [a[0] + t * dx, a[1] + t * dy];
        let gap = (p[0] - q[0]).hypot(p[1] - q[1]);
        if gap < best.1 {
            best = (q, gap);
        }
    }
    (best.0, if inside { -best.1 } else { best.1 })
}
