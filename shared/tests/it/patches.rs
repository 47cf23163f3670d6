//! Contact patches as point arrays, and shapes, against integrals over the real areas.

use crate::common::*;
use heapless::Vec as HVec;
use nalgebra::UnitQuaternion;
use stickslip_shared::contact::{self, Body, Contacts, SLOTS};
use stickslip_shared::model::*;
use stickslip_shared::real::Vec3;
use stickslip_shared::shape::inertia;
use stickslip_shared::step::{Drive, State};

/// Places (m, from the patch centre) and load shares of a disc finger's points, on a ring or as a `torsion` ratio spreads them.
fn disc_points(torsion: Option<f64>) -> Vec<([f64; 2], f64)> {
    let scene = gripped::<f64>(obj4(), None);
    let model = hard(0.4, 0.0, 0.0);
    let drive = Drive {
        dt_s: DT_S,
        carrier: UnitQuaternion::identity(),
        carrier_m_s: Vec3::zeros(),
        carrier_rad_s: Vec3::zeros(),
        pusher: None,
        support: None,
        grip_n: 20.0,
        trial: 0.0,
    };
    let state: State<f64, SLOTS> =
        State::held(&scene, &model, &drive, Vec3::zeros(), UnitQuaternion::identity());
    let mut found: Contacts<f64, SLOTS> = HVec::new();
    assert_eq!(contact::find(&scene, &model, &state, &drive, &mut found), 0);
    found.iter_mut().for_each(|c| c.profile = torsion);
    assert_eq!(contact::spread(&mut found, 0.0), 0);
    found.iter().filter(|c| c.body == Body::Finger1).map(|c| (c.patch_m, c.share)).collect()
}

/// A disc of radius `a` under uniform pressure as a fine polar grid.
fn disc_area(a: f64) -> Vec<([f64; 2], f64)> {
    let (rings, spokes) = (60, 120);
    let mut out = Vec::new();
    for i in 0..rings {
        let (inner, outer) = (f64::from(i) / f64::from(rings), f64::from(i + 1) / f64::from(rings));
        let radius = a * 2.0 / 3.0 * (outer.powi(3) - inner.powi(3)) / (outer.powi(2) - inner.powi(2));
        for j in 0..spokes {
            let (s, c) = ((f64::from(j) + 0.5) / f64::from(spokes) * core::f64::consts::TAU).sin_cos();
            out.push(([radius * c, radius * s], (outer.powi(2) - inner.powi(2)) / f64::from(spokes)));
        }
    }
    out
}

/// Friction force and moment (per mu N) of a patch that turns about the centre `c`.
fn friction(points: &[([f64; 2], f64)], c: [f64; 2]) -> (f64, f64) {
    let (mut f, mut m) = ([0.0; 2], 0.0);
    for (p, share) in points {
        let v = [-(p[1] - c[1]), p[0] - c[0]];
        let size = v[0].hypot(v[1]);
        if size > 1e-12 {
            let g = [share * v[0] / size, share * v[1] / size];
            f = [f[0] + g[0], f[1] + g[1]];
            m += p[0] * g[1] - p[1] * g[0];
        }
    }
    (f[0].hypot(f[1]), m)
}

#[test]
fn a_finger_bears_the_torsional_friction_of_a_uniform_disc() {
    for torsion in [None, Some(0.5), Some(0.8)] {
        let (force, moment) = friction(&disc_points(torsion), [0.0; 2]);
        assert!(force < 1e-12);
        assert!((moment - 2.0 / 3.0 * 0.01).abs() < 1e-9, "{torsion:?}: {moment}");
    }
}

#[test]
fn force_and_torsion_together_are_within_seven_percent_of_the_disc_and_within_three_where_it_is_compliant() {
    let area = disc_area(0.01);
    // Boundary of each limit surface as angle and radius in the plane of f / mu N and
    // moment / (2/3 mu N a), by the distance of the centre of rotation.
    let curve = |patch: &[([f64; 2], f64)], direction: f64| -> Vec<(f64, f64)> {
        (0..4000)
            .map(|i| {
                let d = 0.01 * ((f64::from(i) / 4000.0) * core::f64::consts::FRAC_PI_2 * 0.999).tan();
                let (f, m) = friction(patch, [d * direction.cos(), d * direction.sin()]);
                let m = m / (2.0 / 3.0 * 0.01);
                (m.atan2(f), m.hypot(f))
            })
            .collect()
    };
    let exact = curve(&area, 0.3);
    for (torsion, within) in [(None, 0.07), (Some(0.6), 0.03)] {
        let points = disc_points(torsion);
        for direction in [0.0, 0.2, 0.4, std::f64::consts::FRAC_PI_6, 0.8, std::f64::consts::FRAC_PI_3] {
            for (angle, radius) in curve(&points, direction).iter().step_by(37) {
                let near =
                    exact.iter().min_by(|a, b| (a.0 - angle).abs().total_cmp(&(b.0 - angle).abs())).unwrap();
                if (near.0 - angle).abs() < 0.01 {
                    let off = (radius / near.1 - 1.0).abs();
                    assert!(off < within, "{torsion:?} {direction} {angle}: {radius} {}", near.1);
                }
            }
        }
    }
}

/// Moment of inertia by counting cells of a fine grid.
fn counted(inside: impl Fn([f64; 3]) -> bool, box_m: [f64; 3], mass_kg: f64) -> [[f64; 3]; 3] {
    let n = 60;
    let (mut sum, mut count) = ([[0.0; 3]; 3], 0.0);
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                let at = |i: i32, b: f64| ((f64::from(i) + 0.5) / f64::from(n) - 0.5) * b;
                let p = [at(i, box_m[0]), at(j, box_m[1]), at(k, box_m[2])];
                if inside(p) {
                    count += 1.0;
                    let square = p.iter().map(|x| x * x).sum::<f64>();
                    for a in 0..3 {
                        for b in 0..3 {
                            sum[a][b] += if a == b { square } else { 0.0 } - p[a] * p[b];
                        }
                    }
                }
            }
        }
    }
    sum.map(|r| r.map(|x| x * mass_kg / count))
}

fn close(a: [[f64; 3]; 3], b: [[f64; 3]; 3], tolerance: f64) {
    let scale = a[0][0] + a[1][1] + a[2][2];
    for (x, y) in a.iter().flatten().zip(b.iter().flatten()) {
        assert!((x - y).abs() < tolerance * scale, "{a:?} {b:?}");
    }
}

#[test]
fn inertia_is_that_of_the_counted_volume() {
    let prism = Shape::Prism { length_m: 0.1, side_m: 0.025 };
    close(inertia(&prism, 0.2), counted(|_| true, [0.1, 0.025, 0.025], 0.2), 1e-3);
    let cylinder = Shape::Cylinder { length_m: 0.1, diameter_m: 0.025, across_flats_m: 0.025 };
    let round = |p: [f64; 3]| p[1].hypot(p[2]) < 0.0125;
    close(inertia(&cylinder, 0.2), counted(round, [0.1, 0.025, 0.025], 0.2), 2e-3);
    // A triangle about its centroid.
    let v = [[-0.04, -0.03], [0.05, -0.03], [-0.01, 0.06]];
    let vertices_m = HVec::from_slice(&v).unwrap();
    let triangle = Shape::Polygon { vertices_m, height_m: 0.02 };
    let inside = |p: [f64; 3]| {
        (0..3).all(|i| {
            let (a, b) = (v[i], v[(i + 1) % 3]);
            (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= 0.0
        })
    };
    close(inertia(&triangle, 0.2), counted(inside, [0.12, 0.12, 0.02], 0.2), 5e-3);
}

#[test]
fn a_cylinder_with_flats_has_the_inertia_of_what_is_left() {
    // The paper's obj3.
    let shape = Shape::Cylinder { length_m: 0.1, diameter_m: 0.025, across_flats_m: 0.02 };
    let left = |p: [f64; 3]| p[1].hypot(p[2]) < 0.0125 && p[1].abs() < 0.01;
    close(inertia(&shape, 0.145), counted(left, [0.1, 0.025, 0.025], 0.145), 2e-3);
}
