//! Time of one step on this machine: the paper's scenes, and growth with the number of
//! contacts. `cargo run --release -p stickslip-shared --example step_time`

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::*;
use stickslip_shared::cone::{ConeOptions, ConePoint, DOF, solve};
use stickslip_shared::real::{Real, Vec3};

/// Steps of the linear push take `mean_us`, the least of ten repetitions.
fn push<R: Real>(mu: f64) {
    let (mut best, mut contacts, mut iterations, mut steps) = (f64::MAX, 0, 0, 0);
    for _ in 0..10 {
        (contacts, iterations, steps) = (0, 0, 0);
        let start = Instant::now();
        linear_push::<R>(hard(mu, 0.25, 0.0), 20.0, 0.010, 0.0, 1.5, |s| {
            steps += 1;
            iterations += s.out.iterations;
            contacts = s.out.contacts.len();
        });
        best = best.min(start.elapsed().as_secs_f64() * 1e6 / f64::from(steps));
    }
    let mean = f64::from(iterations) / f64::from(steps);
    let name = core::any::type_name::<R>();
    println!("linear push, mu {mu}, {name}: {best:.2} us a step, {contacts} points, {mean:.2} Newton steps");
}

/// One solve over a patch of `count` points, dragged sideways.
fn patch(count: usize) {
    let mut points: heapless::Vec<ConePoint<f64>, 64> = heapless::Vec::new();
    for i in 0..count {
        let (s, c) = (i as f64 / count as f64 * core::f64::consts::TAU).sin_cos();
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        let point = ConePoint {
            lever_m: Vec3::new(0.007 * c, 0.0125 * side, 0.007 * s),
            axes: [Vec3::new(0.0, -side, 0.0), Vec3::x(), Vec3::new(0.0, 0.0, side)],
            jaw: 1.0,
            bias_m_s: [-5e-4, 0.01, 0.001 * c],
            stiffness_n_s_m: [4e4 / count as f64; 3],
            mu: [0.4; 2],
            adhesion_n: 0.0,
        };
        points.push(point).unwrap();
    }
    let bodies = stickslip_shared::cone::Bodies {
        mass_kg: 0.2,
        inertia_kg_m2: [[2e-5, 0.0, 0.0], [0.0, 2e-4, 0.0], [0.0, 0.0, 2e-4]],
        jaw_mass_kg: 0.3,
        dt_s: 0.004,
        free: [0.0, 0.0, -0.04, 0.0, 0.0, 0.0, -0.5],
    };
    let (mut best, mut iterations) = (f64::MAX, 0);
    for _ in 0..10 {
        let start = Instant::now();
        for _ in 0..500 {
            let s = solve(&points, &bodies, core::hint::black_box(&[0.0; DOF]), &ConeOptions::default());
            iterations = s.iterations;
        }
        best = best.min(start.elapsed().as_secs_f64() * 1e6 / 500.0);
    }
    let each = best / f64::from(iterations + 1);
    println!("solve, {count} points: {best:.2} us, {iterations} Newton steps, {each:.2} us each");
}

fn main() {
    for mu in [0.15, 0.4] {
        push::<f64>(mu);
        push::<f32>(mu);
    }
    for count in [4, 8, 16, 32, 64] {
        patch(count);
    }
}
