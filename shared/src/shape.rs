//! Rigid shapes: inertia, flat faces, sample points on faces.
//!
//! A prism and a polygon prism are the same thing here, a convex polygon in object XY
//! extruded along Z (the square prism's polygon is `length x side`). A cylinder has axis X,
//! two round caps and, like the paper's obj3, optionally two flats at +Y and -Y.

use crate::model::{MAX_VERTICES, Object, Shape};
use crate::real::{Real, Rotation, Vec3, max, sqrt};
use heapless::Vec;

/// Most sample points on one face.
pub const MAX_SAMPLES: usize = 16;
/// Rectangles at least so much longer than wide have 8 x 2 points in place of 4 x 4: where a push turns a body about a point
/// of its face, what counts is how densely points follow each other along it. Errors of the turn are alike at this ratio.
const LONG: f64 = 1.75;
/// Middles of so many equal cells of [-1, 1], all moved outwards by as much as gives them its radius of gyration.
const TWO: &[f64] = &[-0.577_350_269_2, 0.577_350_269_2];
const FOUR: &[f64] = &[-0.774_596_669_2, -0.258_198_889_7, 0.258_198_889_7, 0.774_596_669_2];
const EIGHT: &[f64] = &[
    -0.881_917_103_7,
    -0.629_940_788_3,
    -0.377_964_473_0,
    -0.125_988_157_7,
    0.125_988_157_7,
    0.377_964_473_0,
    0.629_940_788_3,
    0.881_917_103_7,
];
/// Gauss's two points on a ray from 0 to 1 whose weight grows along it, with their shares.
const RADIAL: [(f64, f64); 2] = [(0.355_051_025_7, 0.363_917_236_5), (0.844_948_974_3, 0.636_082_763_5)];
/// Number of the end face at +Z (prisms) or +X (cylinders), see [`Face::number`].
pub const END_ABOVE: u8 = 0xfe;
/// Number of the end face at -Z or -X.
pub const END_BELOW: u8 = 0xfd;
/// Stands for a cylinder's round side, which is no flat face.
pub const ROUND: u8 = 0xff;

/// Extent of a flat face about its centre, in its in-plane axes.
#[derive(Clone, Debug)]
pub enum Extent<R: Real> {
    /// Half extents along both axes, m.
    Rectangle([R; 2]),
    /// Radius, m.
    Disc(R),
    /// Corners along both axes, counter-clockwise as seen against the normal, m.
    Polygon(Vec<[R; 2], MAX_VERTICES>),
}

/// A flat face in object axes.
#[derive(Clone, Debug)]
pub struct Face<R: Real> {
    /// Which face of its shape: its edge of the outline, a cylinder's flat at +Y (0) or -Y (1), or an end.
    pub number: u8,
    /// Outward unit normal.
    pub normal: Vec3<R>,
    /// A point of the face from which its extent is measured, m.
    pub centre_m: Vec3<R>,
    /// In-plane unit axes.
    pub axes: [Vec3<R>; 2],
    /// Boundary.
    pub extent: Extent<R>,
}

impl<R: Real> Face<R> {
    /// In-plane coordinates of a point given in object axes, m.
    pub fn local(&self, point_m: &Vec3<R>) -> [R; 2] {
        let d = point_m - self.centre_m;
        [self.axes[0].dot(&d), self.axes[1].dot(&d)]
    }

    /// The point of the plane with in-plane coordinates `at`, in object axes, m.
    pub fn point(&self, at: [R; 2]) -> Vec3<R> {
        self.centre_m + self.axes[0] * at[0] + self.axes[1] * at[1]
    }

    /// Whether the face covers in-plane coordinates `at`.
    pub fn covers(&self, at: [R; 2]) -> bool {
        match &self.extent {
            Extent::Rectangle(h) => at[0].abs() <= h[0] && at[1].abs() <= h[1],
            Extent::Disc(r) => at[0] * at[0] + at[1] * at[1] <= *r * *r,
            Extent::Polygon(corners) => edges(corners).all(|(a, b)| side(a, b, at) >= R::zero()),
        }
    }

    /// The part of the segment `from..to` (in-plane) that lies on the face, as two
    /// parameters in 0..1; `None` where the segment misses it.
    pub fn clip(&self, from: [R; 2], to: [R; 2]) -> Option<[R; 2]> {
        let d = [to[0] - from[0], to[1] - from[1]];
        let mut range = [R::zero(), R::one()];
        // Keeps the part where `offset + t slope >= 0`.
        let mut keep = |offset: R, slope: R| {
            if slope.abs() <= R::of(1e-12) {
                if offset < R::zero() {
                    range[1] = -R::one();
                }
            } else {
                let t = -offset / slope;
                if slope > R::zero() {
                    range[0] = max(range[0], t);
                } else if t < range[1] {
                    range[1] = t;
                }
            }
        };
        match &self.extent {
            Extent::Rectangle(h) => {
                for k in 0..2 {
                    keep(h[k] + from[k], d[k]);
                    keep(h[k] - from[k], -d[k]);
                }
            }
            Extent::Polygon(corners) => {
                for (a, b) in edges(corners) {
                    let offset = side(a, b, from);
                    keep(offset, side(a, b, to) - offset);
                }
            }
            Extent::Disc(r) => {
                let a = d[0] * d[0] + d[1] * d[1];
                let b = from[0] * d[0] + from[1] * d[1];
                let c = from[0] * from[0] + from[1] * from[1] - *r * *r;
                let under = b * b - a * c;
                if !(under >= R::zero()) || !(a > R::zero()) {
                    return None;
                }
                let root = sqrt(under);
                range = [max(range[0], (-b - root) / a), crate::real::min(range[1], (-b + root) / a)];
            }
        }
        (range[0] <= range[1]).then_some(range)
    }

    /// Corners at which a plane touches the face first (object axes, m): the corners of a
    /// polygon, four points on the rim of a disc.
    pub fn corners(&self) -> Vec<Vec3<R>, MAX_VERTICES> {
        let mut out = Vec::new();
        let mut add = |at| {
            let _ = out.push(self.point(at));
        };
        match &self.extent {
            Extent::Rectangle([u, v]) => {
                for at in [[-*u, -*v], [*u, -*v], [*u, *v], [-*u, *v]] {
                    add(at);
                }
            }
            Extent::Disc(r) => {
                let d = *r * R::of(core::f64::consts::FRAC_1_SQRT_2);
                for at in [[-d, -d], [d, -d], [d, d], [-d, d]] {
                    add(at);
                }
            }
            Extent::Polygon(corners) => corners.iter().for_each(|c| add(*c)),
        }
        out
    }

    /// Ten to sixteen sample points with their shares of the area (sum 1): the middle and the radius of gyration are the face's, the
    /// torsional friction of a uniformly pressed face comes out within 1.5 %, the turn of a pushed rectangle within 5 % (2 % rms; tested).
    #[inline(never)]
    pub fn samples(&self) -> Vec<(Vec3<R>, R), MAX_SAMPLES> {
        let mut out = Vec::new();
        match &self.extent {
            Extent::Rectangle(h) => {
                let long = |a: R, b: R| a > b * R::of(LONG);
                let [along, across] = match () {
                    () if long(h[0], h[1]) => [EIGHT, TWO],
                    () if long(h[1], h[0]) => [TWO, EIGHT],
                    () => [FOUR, FOUR],
                };
                for x in along {
                    for y in across {
                        let at = [h[0] * R::of(*x), h[1] * R::of(*y)];
                        let _ = out.push((self.point(at), R::of(1.0 / 16.0)));
                    }
                }
            }
            Extent::Disc(r) => {
                // Two rings with the disc's mean radius and radius of gyration.
                for i in 0..16u8 {
                    let (count, first, radius) =
                        if i < 5 { (5.0, 0.0, 0.317064) } else { (11.0, 5.0, 0.825577) };
                    let angle = R::two_pi() * (R::of(f64::from(i)) - R::of(first)) / R::of(count);
                    let (s, c) = angle.sine_cosine();
                    let d = *r * R::of(radius);
                    let _ = out.push((self.point([d * c, d * s]), R::of(1.0 / 16.0)));
                }
            }
            Extent::Polygon(corners) => {
                let total = edges(corners).fold(R::zero(), |s, (a, b)| s + (a[0] * b[1] - a[1] * b[0]));
                // Those of the face and of its points: as cells, points would lie nearer to the middle than the cells' parts.
                let (mut of_face, mut of_points, mut mean) = (R::zero(), R::zero(), [R::zero(); 2]);
                let dot = |p: [R; 2], q: [R; 2]| p[0] * q[0] + p[1] * q[1];
                let mid = |p: [R; 2], q: [R; 2]| [0, 1].map(|k| (p[k] + q[k]) * R::of(0.5));
                for (a, b) in edges(corners) {
                    let share = (a[0] * b[1] - a[1] * b[0]) / total;
                    of_face += share * (dot(a, a) + dot(b, b) + dot(a, b)) * R::of(1.0 / 6.0);
                    let mut add = |at: [R; 2], share: R| {
                        of_points += share * dot(at, at);
                        mean = [mean[0] + share * at[0], mean[1] + share * at[1]];
                        let _ = out.push((self.point(at), share));
                    };
                    if corners.len() > 4 {
                        for (t, part) in RADIAL {
                            add(mid(a, b).map(|x| x * R::of(t)), share * R::of(part));
                        }
                        continue;
                    }
                    // Centroids of the quarters of the triangle about the middle.
                    let o = [R::zero(); 2];
                    let (oa, ob, ab) = (mid(o, a), mid(o, b), mid(a, b));
                    for [p, q, r] in [[o, oa, ob], [oa, a, ab], [ob, ab, b], [oa, ab, ob]] {
                        let centroid = [0, 1].map(|k| (p[k] + q[k] + r[k]) * R::of(1.0 / 3.0));
                        add(centroid, share * R::of(0.25));
                    }
                }
                let about_mean = mean[0] * mean[0] + mean[1] * mean[1];
                if of_points > about_mean {
                    let stretch = sqrt((of_face - about_mean) / (of_points - about_mean));
                    let middle = self.point(mean);
                    out.iter_mut().for_each(|(at, _)| *at = middle + (*at - middle) * stretch);
                }
            }
        }
        out
    }
}

/// The lateral face of a square prism that a direction points to most: +X, +Y, -X, -Y;
/// `None` where a face at ±Z is closer.
fn prism_side<R: Real>(direction: &Vec3<R>) -> Option<usize> {
    let mut best = None;
    let mut score = direction.z.abs();
    for (k, s) in [direction.x, direction.y, -direction.x, -direction.y].into_iter().enumerate() {
        if s > score {
            score = s;
            best = Some(k);
        }
    }
    best
}

/// Consecutive corners, closing the ring.
fn edges<R: Real>(corners: &[[R; 2]]) -> impl Iterator<Item = ([R; 2], [R; 2])> + '_ {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// Positive where `p` is to the left of `a -> b`.
fn side<R: Real>(a: [R; 2], b: [R; 2], p: [R; 2]) -> R {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

fn rectangle<R: Real>(number: u8, normal: Vec3<R>, distance: R, u: Vec3<R>, half: [R; 2]) -> Face<R> {
    Face {
        number,
        normal,
        centre_m: normal * distance,
        axes: [u, normal.cross(&u)],
        extent: Extent::Rectangle(half),
    }
}

impl<R: Real> Shape<R> {
    /// The outline in object XY and the height of a prism; `None` for a cylinder.
    pub fn outline(&self) -> Option<(Vec<[R; 2], MAX_VERTICES>, R)> {
        match self {
            Shape::Prism { length_m, side_m } => {
                let (x, y) = (*length_m * R::of(0.5), *side_m * R::of(0.5));
                Vec::from_slice(&[[x, -y], [x, y], [-x, y], [-x, -y]]).ok().map(|v| (v, *side_m))
            }
            Shape::Polygon { vertices_m, height_m } => Some((vertices_m.clone(), *height_m)),
            Shape::Cylinder { .. } => None,
        }
    }

    /// The flat face whose outward normal is closest to `direction` (object axes);
    /// `None` where a cylinder's round side is closer.
    pub fn face_towards(&self, direction: &Vec3<R>) -> Option<Face<R>> {
        let half = R::of(0.5);
        match self {
            Shape::Cylinder { length_m, diameter_m, across_flats_m } => {
                let (x, y, z) = (direction.x, direction.y, direction.z);
                let across = sqrt(y * y + z * z);
                if x.abs() >= across {
                    let normal =
                        Vec3::new(if x < R::zero() { -R::one() } else { R::one() }, R::zero(), R::zero());
                    let u = Vec3::y();
                    return Some(Face {
                        number: if x < R::zero() { END_BELOW } else { END_ABOVE },
                        normal,
                        centre_m: normal * (*length_m * half),
                        axes: [u, normal.cross(&u)],
                        extent: Extent::Disc(*diameter_m * half),
                    });
                }
                let flat = *across_flats_m < *diameter_m && y.abs() > R::of(0.9) * across;
                flat.then(|| {
                    let normal =
                        Vec3::new(R::zero(), if y < R::zero() { -R::one() } else { R::one() }, R::zero());
                    let width = sqrt(*diameter_m * *diameter_m - *across_flats_m * *across_flats_m);
                    let number = u8::from(y < R::zero());
                    let extent = [*length_m * half, width * half];
                    rectangle(number, normal, *across_flats_m * half, Vec3::x(), extent)
                })
            }
            // The hot case: faces along the axes, without outline and roots.
            Shape::Prism { length_m, side_m } if prism_side(direction).is_some() => {
                let (x, y) = (*length_m * half, *side_m * half);
                let (one, zero) = (R::one(), R::zero());
                let side = |number: u8, n: [R; 2], reach: R, width: R| {
                    let normal = Vec3::new(n[0], n[1], zero);
                    rectangle(number, normal, reach, Vec3::new(-n[1], n[0], zero), [width, y])
                };
                prism_side(direction).map(|k| match k {
                    0 => side(0, [one, zero], x, y),
                    1 => side(1, [zero, one], y, x),
                    2 => side(2, [-one, zero], x, y),
                    _ => side(3, [zero, -one], y, x),
                })
            }
            Shape::Prism { .. } | Shape::Polygon { .. } => {
                let (outline, height) = self.outline()?;
                let mut best: Option<Face<R>> = None;
                let mut score = direction.z.abs();
                for (number, (a, b)) in edges(&outline).enumerate() {
                    let d = [b[0] - a[0], b[1] - a[1]];
                    let length = sqrt(d[0] * d[0] + d[1] * d[1]);
                    if !(length > R::zero()) {
                        continue;
                    }
                    let normal = Vec3::new(d[1] / length, -d[0] / length, R::zero());
                    let s = normal.dot(direction);
                    if s > score {
                        score = s;
                        let u = Vec3::new(d[0] / length, d[1] / length, R::zero());
                        best = Some(Face {
                            number: number as u8,
                            normal,
                            centre_m: Vec3::new((a[0] + b[0]) * half, (a[1] + b[1]) * half, R::zero()),
                            axes: [u, normal.cross(&u)],
                            extent: Extent::Rectangle([length * half, height * half]),
                        });
                    }
                }
                best.or_else(|| Some(Self::cap(&outline, height, direction.z < R::zero())))
            }
        }
    }

    /// The face of this number; `None` where there is none.
    pub fn face(&self, number: u8) -> Option<Face<R>> {
        let round = matches!(self, Shape::Cylinder { .. });
        let sign = if number == END_BELOW { -R::one() } else { R::one() };
        let towards = match (number, self.outline()) {
            (ROUND, _) => return None,
            (END_ABOVE | END_BELOW, _) if round => Vec3::x() * sign,
            (END_ABOVE | END_BELOW, _) => Vec3::z() * sign,
            (flat, None) => Vec3::y() * if flat == 0 { R::one() } else { -R::one() },
            (edge, Some((outline, _))) => {
                let (a, b) = edges(&outline).nth(usize::from(edge))?;
                Vec3::new(b[1] - a[1], a[0] - b[0], R::zero())
            }
        };
        self.face_towards(&towards).filter(|f| f.number == number)
    }

    fn cap(outline: &Vec<[R; 2], MAX_VERTICES>, height: R, below: bool) -> Face<R> {
        let z = height * R::of(0.5);
        let (normal, second) = if below { (-Vec3::z(), -Vec3::y()) } else { (Vec3::z(), Vec3::y()) };
        // Mirrored axes need the reverse order to stay counter-clockwise.
        let mut corners: Vec<[R; 2], MAX_VERTICES> = Vec::new();
        for c in outline {
            // As many as the outline, which has the same capacity.
            let _ = corners.push([c[0], if below { -c[1] } else { c[1] }]);
        }
        if below {
            corners.reverse();
        }
        let number = if below { END_BELOW } else { END_ABOVE };
        Face {
            number,
            normal,
            centre_m: normal * z,
            axes: [Vec3::x(), second],
            extent: Extent::Polygon(corners),
        }
    }

    /// Closest point of the surface to `point` (both in object axes, m), the outward unit
    /// normal there, and the signed distance (negative inside).
    pub fn closest(&self, point: &Vec3<R>) -> (Vec3<R>, Vec3<R>, R) {
        let half = R::of(0.5);
        let zero = R::zero();
        match self {
            Shape::Cylinder { length_m, diameter_m, .. } => {
                let radius = *diameter_m * half;
                let r = sqrt(point.y * point.y + point.z * point.z);
                let beyond = point.x.abs() - *length_m * half;
                let outward = if r > zero { Vec3::new(zero, point.y / r, point.z / r) } else { Vec3::z() };
                if beyond > r - radius {
                    let normal = Vec3::new(if point.x < zero { -R::one() } else { R::one() }, zero, zero);
                    (point - normal * beyond, normal, beyond)
                } else {
                    (point - outward * (r - radius), outward, r - radius)
                }
            }
            Shape::Prism { .. } | Shape::Polygon { .. } => {
                let Some((outline, height)) = self.outline() else {
                    return (*point, Vec3::z(), zero);
                };
                let above = point.z.abs() - height * half;
                let (at, normal, distance) = closest_on_outline(&outline, [point.x, point.y]);
                if above > distance {
                    let normal = Vec3::new(zero, zero, if point.z < zero { -R::one() } else { R::one() });
                    (point - normal * above, normal, above)
                } else {
                    (Vec3::new(at[0], at[1], point.z), Vec3::new(normal[0], normal[1], zero), distance)
                }
            }
        }
    }

    /// Distance from the centre to the side of the object along `direction` (object axes,
    /// unit), m.
    pub fn reach(&self, direction: &Vec3<R>) -> R {
        match self.face_towards(direction) {
            Some(face) => {
                let along = face.normal.dot(direction);
                face.normal.dot(&face.centre_m) / along
            }
            None => match self {
                Shape::Cylinder { diameter_m, .. } => {
                    let across = sqrt(direction.y * direction.y + direction.z * direction.z);
                    *diameter_m * R::of(0.5) / max(across, R::of(1e-3))
                }
                _ => R::zero(),
            },
        }
    }
}

fn closest_on_outline<R: Real>(outline: &[[R; 2]], p: [R; 2]) -> ([R; 2], [R; 2], R) {
    let zero = R::zero();
    let mut outside: Option<([R; 2], [R; 2], R)> = None;
    let mut inside = ([zero; 2], [R::one(), zero], R::of(-1e9));
    let mut is_inside = true;
    for (a, b) in edges(outline) {
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = sqrt(d[0] * d[0] + d[1] * d[1]);
        if !(length > zero) {
            continue;
        }
        let normal = [d[1] / length, -d[0] / length];
        let t = crate::real::clamp(
            ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / (length * length),
            zero,
            R::one(),
        );
        let at = [a[0] + t * d[0], a[1] + t * d[1]];
        let gap = [p[0] - at[0], p[1] - at[1]];
        let distance = sqrt(gap[0] * gap[0] + gap[1] * gap[1]);
        let height = normal[0] * (p[0] - a[0]) + normal[1] * (p[1] - a[1]);
        if height > zero {
            is_inside = false;
        }
        if height > inside.2 {
            inside = (at, normal, height);
        }
        if outside.as_ref().is_none_or(|o| distance < o.2) {
            // At a corner the normal points from the corner to the tip.
            let n = if distance > R::of(1e-9) { [gap[0] / distance, gap[1] / distance] } else { normal };
            outside = Some((at, n, distance));
        }
    }
    match outside {
        Some(o) if !is_inside => o,
        _ => inside,
    }
}

/// Inertia about the centre of mass in object axes, kg m².
///
/// Polygon: exact for a uniform prism whose outline is given about its centroid.
pub fn inertia<R: Real>(shape: &Shape<R>, mass_kg: R) -> [[R; 3]; 3] {
    let zero = R::zero();
    let twelfth = mass_kg * R::of(1.0 / 12.0);
    match shape {
        Shape::Prism { length_m, side_m } => {
            let (l, s) = (*length_m * *length_m, *side_m * *side_m);
            diagonal([twelfth * (s + s), twelfth * (l + s), twelfth * (l + s)])
        }
        Shape::Cylinder { length_m, diameter_m, across_flats_m } => {
            // Second moments of the disc |y| < h that the flats leave, over its area.
            let (r, h) = (*diameter_m * R::of(0.5), *across_flats_m * R::of(0.5));
            let h = crate::real::clamp(h, zero, r);
            let (r2, edge) = (r * r, sqrt(r * r - h * h));
            let segment = r2 * h.atan2(edge);
            let area = R::of(2.0) * (h * edge + segment);
            let yy = R::of(0.5) * (r2 * segment - h * edge * (r2 - R::of(2.0) * h * h));
            let zz = R::of(1.0 / 3.0) * h * edge * edge * edge + R::of(0.5) * r2 * (h * edge + segment);
            let per = mass_kg / max(area, R::of(1e-12));
            let (yy, zz) = (yy * per, zz * per);
            let xx = twelfth * *length_m * *length_m;
            diagonal([yy + zz, xx + zz, xx + yy])
        }
        Shape::Polygon { vertices_m, height_m } => {
            let (mut area, mut xx, mut yy, mut xy) = (zero, zero, zero, zero);
            for (a, b) in edges(vertices_m) {
                let c = a[0] * b[1] - a[1] * b[0];
                area += c;
                xx += c * (a[0] * a[0] + a[0] * b[0] + b[0] * b[0]);
                yy += c * (a[1] * a[1] + a[1] * b[1] + b[1] * b[1]);
                xy += c * (R::of(2.0) * (a[0] * a[1] + b[0] * b[1]) + a[0] * b[1] + b[0] * a[1]);
            }
            let per = mass_kg / max(area.abs(), R::of(1e-12));
            let (xx, yy, xy) = (
                xx.abs() * per * R::of(1.0 / 6.0),
                yy.abs() * per * R::of(1.0 / 6.0),
                xy * per * R::of(1.0 / 12.0),
            );
            let zz = twelfth * *height_m * *height_m;
            [[yy + zz, -xy, zero], [-xy, xx + zz, zero], [zero, zero, xx + yy]]
        }
    }
}

fn diagonal<R: Real>(d: [R; 3]) -> [[R; 3]; 3] {
    let z = R::zero();
    [[d[0], z, z], [z, d[1], z], [z, z, d[2]]]
}

/// `R I R'`: the inertia of `object` in the axes that `rotation` leads to.
pub fn rotated_inertia<R: Real>(object: &Object<R>, rotation: &Rotation<R>) -> [[R; 3]; 3] {
    let m = rotation.to_rotation_matrix();
    let m = m.matrix();
    let mut half = [[R::zero(); 3]; 3];
    let mut out = half;
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                half[i][j] += m[(i, k)] * object.inertia_kg_m2[k][j];
            }
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                out[i][j] += half[i][k] * m[(j, k)];
            }
        }
    }
    out
}
