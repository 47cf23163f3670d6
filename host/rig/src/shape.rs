//! Geometry of the objects: mass distribution, and the material points and faces that the
//! contacts are evaluated on.

use nalgebra::{Matrix3, Vector3};

use stickslip_data::ObjectSpec;

/// Shape in object axes (see `docs/dataset.md`), lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Square prism along X.
    Prism {
        /// Along X.
        length: f64,
        /// Along Y and Z.
        side: f64,
    },
    /// Cylinder with axis X, possibly with flats at +Y and -Y.
    Cylinder {
        /// Along X.
        length: f64,
        /// Radius.
        radius: f64,
        /// Half the distance across the flats; the radius where there are none.
        half_flats: f64,
    },
    /// Convex polygon in XY, extruded along Z.
    Polygon {
        /// Corners, counter-clockwise.
        vertices: Vec<[f64; 2]>,
        /// Along Z.
        height: f64,
    },
}

/// What a fingertip presses on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// A flat face at ±`half` on Y, `half_x` by `half_z` about its centre.
    Flat {
        /// Distance of the face from the object's origin.
        half: f64,
        /// Half length along X.
        half_x: f64,
        /// Half width along Z.
        half_z: f64,
    },
    /// A round side about the X axis.
    Round {
        /// Radius.
        radius: f64,
        /// Half length along X.
        half_x: f64,
    },
}

/// A flat rectangular face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Centre.
    pub centre: Vector3<f64>,
    /// Outward normal.
    pub normal: Vector3<f64>,
    /// First in-plane axis and half extent.
    pub first: (Vector3<f64>, f64),
    /// Second in-plane axis and half extent.
    pub second: (Vector3<f64>, f64),
}

impl Shape {
    /// Reads the shape of a data set's object.
    ///
    /// # Errors
    /// Names the key that is missing or wrong.
    pub fn of(spec: &ObjectSpec) -> Result<Self, String> {
        let need = |value: Option<f64>, key: &str| match value {
            Some(x) if x > 0.0 && x.is_finite() => Ok(x),
            Some(x) => Err(format!("object {}: {key} is {x}, give a positive length in metres", spec.id)),
            None => Err(format!("object {}: a {} needs {key}", spec.id, spec.shape)),
        };
        match spec.shape.as_str() {
            "prism" => Ok(Self::Prism {
                length: need(spec.length_m, "length_m")?,
                side: need(spec.side_m, "side_m")?,
            }),
            "cylinder" => {
                let radius = 0.5 * need(spec.side_m, "side_m")?;
                let half_flats = match spec.across_flats_m {
                    Some(_) => (0.5 * need(spec.across_flats_m, "across_flats_m")?).min(radius),
                    None => radius,
                };
                Ok(Self::Cylinder { length: need(spec.length_m, "length_m")?, radius, half_flats })
            }
            "polygon" => {
                let vertices = spec.vertices_m.clone().unwrap_or_default();
                if vertices.len() < 3 || area(&vertices) <= 0.0 {
                    return Err(format!(
                        "object {}: vertices_m needs three or more corners, counter-clockwise",
                        spec.id
                    ));
                }
                Ok(Self::Polygon { vertices, height: need(spec.height_m, "height_m")? })
            }
            other => Err(format!("object {}: shape '{other}' is none of prism, cylinder, polygon", spec.id)),
        }
    }

    /// Inertia about the object's origin for a uniform body of `mass_kg`, kg m².
    pub fn inertia(&self, mass_kg: f64) -> Matrix3<f64> {
        match self {
            Self::Prism { length, side } => {
                let cross = mass_kg * (length * length + side * side) / 12.0;
                Matrix3::from_diagonal(&Vector3::new(mass_kg * side * side / 6.0, cross, cross))
            }
            Self::Cylinder { length, radius, half_flats } => {
                // Second moments of the disc cut at |y| = half_flats, by quadrature.
                let (mut area, mut yy, mut zz) = (0.0, 0.0, 0.0);
                let slices = 400;
                for i in 0..slices {
                    let y = half_flats * ((i as f64 + 0.5) / slices as f64 * 2.0 - 1.0);
                    let half_z = (radius * radius - y * y).max(0.0).sqrt();
                    area += half_z;
                    yy += half_z * y * y;
                    zz += half_z * half_z * half_z / 3.0;
                }
                let (yy, zz) = (mass_kg * yy / area, mass_kg * zz / area);
                let xx = mass_kg * length * length / 12.0;
                Matrix3::from_diagonal(&Vector3::new(yy + zz, xx + zz, xx + yy))
            }
            Self::Polygon { vertices, height } => {
                let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
                for (p, q) in edges(vertices) {
                    let cross = p[0] * q[1] - q[0] * p[1];
                    xx += cross * (p[0] * p[0] + p[0] * q[0] + q[0] * q[0]) / 12.0;
                    yy += cross * (p[1] * p[1] + p[1] * q[1] + q[1] * q[1]) / 12.0;
                    xy += cross * (p[0] * q[1] + 2.0 * p[0] * p[1] + 2.0 * q[0] * q[1] + q[0] * p[1]) / 24.0;
                }
                let per_area = mass_kg / area(vertices);
                let (xx, yy, xy) = (xx * per_area, yy * per_area, xy * per_area);
                let zz = mass_kg * height * height / 12.0;
                Matrix3::new(yy + zz, -xy, 0.0, -xy, xx + zz, 0.0, 0.0, 0.0, xx + yy)
            }
        }
    }

    /// What the fingers press on, or `None` for a polygon, which this rig does not grasp.
    pub fn grasped_side(&self) -> Option<Side> {
        match self {
            Self::Prism { length, side } => {
                Some(Side::Flat { half: side / 2.0, half_x: length / 2.0, half_z: side / 2.0 })
            }
            Self::Cylinder { length, radius, half_flats } if half_flats < radius => {
                let half_z = (radius * radius - half_flats * half_flats).sqrt();
                Some(Side::Flat { half: *half_flats, half_x: length / 2.0, half_z })
            }
            Self::Cylinder { length, radius, .. } => {
                Some(Side::Round { radius: *radius, half_x: length / 2.0 })
            }
            Self::Polygon { .. } => None,
        }
    }

    /// Height of the object's lowest point below its origin when it stands level, m.
    pub fn half_height(&self) -> f64 {
        match self {
            Self::Prism { side, .. } => side / 2.0,
            Self::Cylinder { radius, .. } => *radius,
            Self::Polygon { height, .. } => height / 2.0,
        }
    }

    /// Outline seen from above (object XY), counter-clockwise.
    pub fn outline(&self) -> Vec<[f64; 2]> {
        let rectangle = |x: f64, y: f64| vec![[-x, -y], [x, -y], [x, y], [-x, y]];
        match self {
            Self::Prism { length, side } => rectangle(length / 2.0, side / 2.0),
            Self::Cylinder { length, half_flats, .. } => rectangle(length / 2.0, *half_flats),
            Self::Polygon { vertices, .. } => vertices.clone(),
        }
    }

    /// Points of the end face at -X with their share of its area: a grid that includes the rim.
    pub fn end_face_points(&self) -> Vec<Vector3<f64>> {
        match self {
            Self::Prism { length, side } => {
                grid(4).map(|(u, v)| Vector3::new(-length / 2.0, u * side / 2.0, v * side / 2.0)).collect()
            }
            Self::Cylinder { length, radius, half_flats } => {
                let ring = |share: f64, count: usize| {
                    let (length, half_flats, r) = (*length, *half_flats, radius * share);
                    (0..count).map(move |i| {
                        let angle = std::f64::consts::TAU * (i as f64 + 0.5) / count as f64;
                        let y = (r * angle.cos()).clamp(-half_flats, half_flats);
                        Vector3::new(-length / 2.0, y, r * angle.sin())
                    })
                };
                ring(1.0, 12).chain(ring(0.45, 4)).collect()
            }
            Self::Polygon { vertices, height } => vertices
                .iter()
                .flat_map(|p| [-0.5, 0.5].map(|z| Vector3::new(p[0], p[1], z * height)))
                .collect(),
        }
    }

    /// Points of the lower face (or the generators of a round side) that a table carries.
    pub fn lower_points(&self) -> Vec<Vector3<f64>> {
        let low = -self.half_height();
        match self {
            Self::Prism { length, side } => {
                grid(4).map(|(u, v)| Vector3::new(u * length / 2.0, v * side / 2.0, low)).collect()
            }
            Self::Cylinder { length, .. } => {
                (0..9).map(|i| Vector3::new(length * (i as f64 / 8.0 - 0.5), 0.0, low)).collect()
            }
            Self::Polygon { vertices, .. } => {
                fill(vertices, 24).into_iter().map(|p| Vector3::new(p[0], p[1], low)).collect()
            }
        }
    }

    /// The lower face of a prism, which the line pusher of a pivot presses on.
    pub fn lower_face(&self) -> Option<Face> {
        match self {
            Self::Prism { length, side } => Some(Face {
                centre: Vector3::new(0.0, 0.0, -side / 2.0),
                normal: Vector3::new(0.0, 0.0, -1.0),
                first: (Vector3::x(), length / 2.0),
                second: (Vector3::y(), side / 2.0),
            }),
            _ => None,
        }
    }
}

/// Consecutive corners of a closed outline.
pub fn edges(vertices: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    vertices.iter().copied().zip(vertices.iter().copied().cycle().skip(1))
}

/// Signed area, positive counter-clockwise.
pub fn area(vertices: &[[f64; 2]]) -> f64 {
    edges(vertices).map(|(p, q)| 0.5 * (p[0] * q[1] - q[0] * p[1])).sum()
}

/// `n` by `n` positions from -1 to 1 in both directions.
fn grid(n: usize) -> impl Iterator<Item = (f64, f64)> {
    let at = move |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
    (0..n).flat_map(move |i| (0..n).map(move |j| (at(i), at(j))))
}

/// About `count` points spread evenly over a convex polygon: centres of the cells of a
/// square lattice about its centroid.
fn fill(vertices: &[[f64; 2]], count: usize) -> Vec<[f64; 2]> {
    let pitch = (area(vertices) / count as f64).sqrt();
    let extent = vertices.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let cells = (extent / pitch).ceil() as i64 + 1;
    let inside = |p: &[f64; 2]| {
        edges(vertices).all(|(a, b)| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= 0.0)
    };
    let mut points: Vec<[f64; 2]> = (-cells..=cells)
        .flat_map(|i| (-cells..=cells).map(move |j| [i as f64 * pitch, j as f64 * pitch]))
        .filter(inside)
        .collect();
    // The lattice's own centroid is moved to the polygon's, so that the weight sits right.
    let n = points.len() as f64;
    let mean = points.iter().fold([0.0, 0.0], |m, p| [m[0] + p[0] / n, m[1] + p[1] / n]);
    for p in &mut points {
        p[0] -= mean[0];
        p[1] -= mean[1];
    }
    points
}
