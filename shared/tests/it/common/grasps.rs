//! Contact problems of a gripped prism against a plane or an edge, drawn at random.
#![allow(dead_code)]

use heapless::Vec as HVec;
use stickslip_shared::real::Vec3;
use stickslip_shared::solve::{Bodies, ContactPoint};

/// Reproducible numbers without a dependency (xorshift, Marsaglia 2003).
pub struct Draw(pub u64);

impl Draw {
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

pub const CAPACITY: usize = 20;
pub type Points<R> = HVec<ContactPoint<R>, CAPACITY>;

/// What pushes on a gripped prism.
#[derive(Clone, Copy, Debug)]
pub enum Push {
    Plane,
    Edge,
}

/// A gripped prism between two six-point pads, against a plane or an edge, with everything
/// drawn at random: loads, sliding or sticking, coefficients up to `mu`.
pub fn random_grasp(draw: &mut Draw, push: Push, mu: f64, spring_n_m: f64) -> (Points<f64>, Bodies<f64>) {
    let (dt, mass) = (0.004, 0.2005);
    let k = spring_n_m * dt;
    let grip_n = draw.within(2.0, 40.0);
    let (finger, pusher) = (draw.within(0.05, mu), draw.within(0.05, mu));
    let mut points = Points::new();
    let mut add = |lever_m: Vec3<f64>, normal: Vec3<f64>, jaw, bias, mu, share: f64| {
        let seed = if normal.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() };
        let t1 = (seed - normal * normal.dot(&seed)).normalize();
        let axes = [normal, t1, normal.cross(&t1)];
        let point = ContactPoint {
            lever_m,
            axes,
            jaw,
            bias_m_s: bias,
            stiffness_n_s_m: [k * share; 3],
            mu: [mu; 2],
            adhesion_n: 0.0,
            viscous_n_s_m: 0.0,
        };
        points.push(point).unwrap();
    };
    let slide = [draw.within(-0.01, 0.01), draw.within(-0.01, 0.01)];
    for side in [1.0, -1.0] {
        for i in 0..6 {
            let (s, c) = (f64::from(i) * core::f64::consts::FRAC_PI_3).sin_cos();
            let bias = [-grip_n / k, slide[0] + draw.within(-1e-3, 1e-3), slide[1]];
            let lever = Vec3::new(0.02 / 3.0 * c, side * 0.0125, 0.02 / 3.0 * s);
            add(lever, Vec3::new(0.0, -side, 0.0), 1.0, bias, finger, 1.0 / 6.0);
        }
    }
    let speed = draw.within(0.0, 0.02);
    let drift = [draw.within(-5e-3, 5e-3), draw.within(-5e-3, 5e-3)];
    match push {
        Push::Plane => {
            for (y, z) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let lever = Vec3::new(-0.05, 0.0125 * y, 0.0125 * z);
                add(lever, Vec3::x(), 0.0, [-speed, drift[0], drift[1]], pusher, 0.25);
            }
        }
        Push::Edge => {
            for y in [1.0, -1.0] {
                let lever = Vec3::new(-0.03, 0.0125 * y, -0.0125);
                add(lever, Vec3::z(), 0.0, [-speed, drift[0], drift[1]], pusher, 0.5);
            }
        }
    }
    let (short, long) = (0.025f64.powi(2), 0.1f64.powi(2));
    let (a, b) = (mass / 6.0 * short, mass / 12.0 * (short + long));
    let mut free = [0.0, 0.0, -G * dt, 0.0, 0.0, 0.0, -2.0 * grip_n * dt / 0.3];
    for (i, f) in free.iter_mut().enumerate().take(6) {
        *f += if i < 3 { draw.within(-0.01, 0.01) } else { draw.within(-0.1, 0.1) };
    }
    let inertia_kg_m2 = [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, b]];
    (points, Bodies { mass_kg: mass, inertia_kg_m2, jaw_mass_kg: 0.3, dt_s: dt, free })
}

pub const G: f64 = 9.81;

pub fn narrow(points: &Points<f64>, bodies: &Bodies<f64>) -> (Points<f32>, Bodies<f32>) {
    let v = |v: &Vec3<f64>| Vec3::new(v.x as f32, v.y as f32, v.z as f32);
    let points = points
        .iter()
        .map(|p| ContactPoint {
            lever_m: v(&p.lever_m),
            axes: [v(&p.axes[0]), v(&p.axes[1]), v(&p.axes[2])],
            jaw: p.jaw as f32,
            bias_m_s: p.bias_m_s.map(|x| x as f32),
            stiffness_n_s_m: p.stiffness_n_s_m.map(|x| x as f32),
            mu: p.mu.map(|x| x as f32),
            adhesion_n: p.adhesion_n as f32,
            viscous_n_s_m: 0.0,
        })
        .collect();
    let bodies = Bodies {
        mass_kg: bodies.mass_kg as f32,
        inertia_kg_m2: bodies.inertia_kg_m2.map(|r| r.map(|x| x as f32)),
        jaw_mass_kg: bodies.jaw_mass_kg as f32,
        dt_s: bodies.dt_s as f32,
        free: bodies.free.map(|x| x as f32),
    };
    (points, bodies)
}
