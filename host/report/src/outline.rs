//! Corners of an object, and the outline of points in a plane.

use nalgebra::Vector3;
use stickslip_shared::model::Shape;

/// Corners of a round face.
const ROUND: usize = 24;

/// Corners of the object about its centre, object axes, m.
#[must_use]
pub fn corners(shape: &Shape<f64>) -> Vec<Vector3<f64>> {
    let both = [-0.5, 0.5];
    let (length, ring): (f64, Vec<[f64; 2]>) = match shape {
        Shape::Polygon { vertices_m, height_m } => {
            return both
                .iter()
                .flat_map(|z| vertices_m.iter().map(move |[x, y]| Vector3::new(*x, *y, z * height_m)))
                .collect();
        }
        Shape::Cylinder { length_m, diameter_m, .. } => {
            let turn = |k: usize| k as f64 * std::f64::consts::TAU / ROUND as f64;
            let ring = (0..ROUND).map(turn).map(|a| [a.cos(), a.sin()].map(|x| 0.5 * diameter_m * x));
            (*length_m, ring.collect())
        }
        Shape::Prism { length_m, side_m } => {
            (*length_m, both.iter().flat_map(|y| both.map(|z| [y * side_m, z * side_m])).collect())
        }
    };
    both.iter().flat_map(|x| ring.iter().map(move |[y, z]| Vector3::new(x * length, *y, *z))).collect()
}

/// Convex outline of points, counter-clockwise (Andrew's monotone chain).
#[must_use]
pub fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turn =
        |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let half = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && turn(a, b, *point) <= 0.0
            {
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter());
    outline.extend(half(&mut points.iter().rev()));
    outline
}
