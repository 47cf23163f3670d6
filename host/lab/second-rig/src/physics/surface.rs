//! Where elements touch the object: depth, normal and contact point, all in the tool's frame.

use nalgebra::{Matrix3, Vector3};

use super::body::Frame;

/// The object's surface in its own frame: a box, or a cylinder along X.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Half sizes of the box, m. For a cylinder y and z are its radius.
    pub half: Vector3<f64>,
    /// Is it a cylinder?
    pub round: bool,
    /// Rise of both faces at +Y and -Y towards +X (the object becomes thicker).
    pub taper: f64,
    /// Relative amplitude of friction along X, and its wave length (m) and phase (rad).
    pub wave: [f64; 3],
}

/// The object as seen from a tool: pose and velocity of its frame in the tool's axes.
#[derive(Clone, Copy, Debug)]
pub struct Relative {
    /// Object axes into tool axes.
    pub rotation: Matrix3<f64>,
    /// Object's origin, m.
    pub position: Vector3<f64>,
    /// Velocity of the object's origin as seen in the turning tool, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity against the tool, rad/s.
    pub spin: Vector3<f64>,
}

impl Relative {
    /// From two frames in world axes.
    pub fn between(tool: &Frame, object: &Frame) -> Self {
        let t: Matrix3<f64> = tool.rotation.to_rotation_matrix().into_inner();
        let o: Matrix3<f64> = object.rotation.to_rotation_matrix().into_inner();
        let arm = object.position - tool.position;
        Self {
            rotation: t.tr_mul(&o),
            position: t.tr_mul(&arm),
            velocity: t.tr_mul(&(object.velocity - tool.velocity - tool.spin.cross(&arm))),
            spin: t.tr_mul(&(object.spin - tool.spin)),
        }
    }

    /// Velocity of the object's material at a point given in tool axes, m/s.
    pub fn velocity_at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.spin.cross(&(point - self.position))
    }
}

/// How elements and object meet.
#[derive(Clone, Copy, Debug)]
pub enum Geometry {
    /// Elements of the tool against the object's face whose outward normal is `sign` times axis
    /// `axis` of the object.
    ToolOnFace {
        /// 0, 1 or 2.
        axis: usize,
        /// 1 or -1.
        sign: f64,
    },
    /// Elements of the object against the tool's plane; `normal` points into the object and the
    /// plane is at `normal . x = distance`.
    ObjectOnPlane {
        /// Unit, tool axes.
        normal: Vector3<f64>,
        /// m.
        distance: f64,
    },
    /// Elements along the axis of a cylinder, against the tool's plane.
    CylinderOnPlane {
        /// Unit, tool axes.
        normal: Vector3<f64>,
        /// m.
        distance: f64,
    },
    /// A vertical rod about the tool's origin against the outline of the box.
    Rod {
        /// m.
        radius_m: f64,
    },
}

/// A contact, in tool axes.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Contact point, m.
    pub point: Vector3<f64>,
    /// Unit normal into the object.
    pub normal: Vector3<f64>,
    /// By how much the bodies overlap, m.
    pub depth: f64,
    /// Along object X, where friction may vary, m.
    pub along_m: f64,
}

/// Deeper than this an element is on the wrong side of the object, m.
const DEEPEST_M: f64 = 4e-3;

impl Geometry {
    /// Contact of an element at `position`; `None` where it is clear by more than `reach_m`.
    #[inline]
    pub fn touch(
        &self,
        position: &Vector3<f64>,
        surface: &Surface,
        object: &Relative,
        reach_m: f64,
    ) -> Option<Touch> {
        match *self {
            Geometry::ToolOnFace { axis, sign } => {
                let p = object.rotation.tr_mul(&(position - object.position));
                let taper = if axis == 1 { surface.taper } else { 0.0 };
                let depth = surface.half[axis] + taper * p.x - sign * p[axis];
                let beside = (0..3).any(|k| k != axis && p[k].abs() > surface.half[k] + taper.abs() * 0.01);
                if depth <= -reach_m || depth > DEEPEST_M || beside {
                    return None;
                }
                let mut normal = object.rotation.column(axis) * -sign;
                if taper != 0.0 {
                    normal = (normal + object.rotation.column(0) * taper).normalize();
                }
                // The pad gives way, the object does not: what acts on it acts at its surface.
                let point = position - normal * depth;
                Some(Touch { point, normal, depth, along_m: p.x })
            }
            Geometry::ObjectOnPlane { normal, distance } => {
                let point = object.position + object.rotation * position;
                let depth = distance - normal.dot(&point);
                (depth > -reach_m && depth < DEEPEST_M).then_some(Touch {
                    point,
                    normal,
                    depth,
                    along_m: position.x,
                })
            }
            Geometry::CylinderOnPlane { normal, distance } => {
                let centre = object.position + object.rotation * position;
                let axis = object.rotation.column(0);
                let across = normal - axis * axis.dot(&normal);
                let point = centre - across.normalize() * surface.half.y;
                let depth = distance - normal.dot(&point);
                (depth > -reach_m && depth < DEEPEST_M).then_some(Touch {
                    point,
                    normal,
                    depth,
                    along_m: position.x,
                })
            }
            Geometry::Rod { radius_m } => {
                let p = object.rotation.tr_mul(&(position - object.position));
                if p.z.abs() > surface.half.z {
                    return None;
                }
                let beyond = [p.x.abs() - surface.half.x, p.y.abs() - surface.half.y];
                let (distance, mut out) = if beyond[0] > 0.0 && beyond[1] > 0.0 {
                    let d = beyond[0].hypot(beyond[1]);
                    (d, Vector3::new(beyond[0] / d, beyond[1] / d, 0.0))
                } else if beyond[0] > beyond[1] {
                    (beyond[0], Vector3::x())
                } else {
                    (beyond[1], Vector3::y())
                };
                out.x *= p.x.signum();
                out.y *= p.y.signum();
                let depth = radius_m - distance;
                (depth > -reach_m && depth < radius_m).then(|| Touch {
                    point: position - object.rotation * out * distance,
                    normal: -(object.rotation * out),
                    depth,
                    along_m: p.x,
                })
            }
        }
    }
}
