//! Effects of the object's mass, of gravity, of the table and of what else pulls.

use nalgebra::Vector3;
use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use serde_json::{Map, Value, json};

use super::scale::{Scale, named};
use crate::random::{chance, sign, uniform};
use crate::reality::Reality;

type Out = Map<String, Value>;

pub fn mass(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    r.mass_factor = 1.0 + (0.2 * s.level).min(0.7) * sign(rng);
    if chance(rng, 0.5) {
        r.centre_m[0] = (0.004 * s.level).min(0.012) * sign(rng);
    }
    named([("fraction", r.mass_factor - 1.0), ("com_x_m", r.centre_m[0])])
}

pub fn gravity(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let size = (0.06 * s.level).min(0.3);
    let angle = uniform(rng, -PI, PI);
    r.gravity_tilt = [size * angle.cos(), size * angle.sin()];
    named([("about_x_rad", r.gravity_tilt[0]), ("about_y_rad", r.gravity_tilt[1])])
}

/// Three feet that hold the centre of mass between them, or a heavy side.
pub fn support(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let o = &r.objects[0];
    let (hx, hy) = (0.5 * o.length_m, 0.5 * o.side_m);
    let mut out = Out::new();
    if chance(rng, 0.6) {
        // Weak: feet near the radius of gyration of the face. Strong: close together, or far out.
        let stretch = if chance(rng, 0.5) { 0.577 / (1.0 + 0.5 * s.level) } else { 0.577 + 0.15 * s.level };
        let stretch = stretch.clamp(0.3, 0.95);
        let turn = sign(rng);
        let feet = vec![
            [turn * hx * stretch, 0.0],
            [-turn * hx * stretch, hy * stretch],
            [-turn * hx * stretch, -hy * stretch],
        ];
        out.insert("feet_m".into(), json!(feet));
        r.feet_m = Some(feet);
    } else {
        let share = (0.15 * s.level).min(0.6);
        let angle = uniform(rng, -PI, PI);
        r.centre_m = [share * hx * angle.cos(), share * hy * angle.sin()];
        out.insert("centre_of_mass_m".into(), json!(r.centre_m));
    }
    out
}

pub fn spring(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let k = 150.0 * s.level;
    r.spring_n_m = Vector3::new(k, 0.0, k * uniform(rng, 0.2, 1.0));
    named([("along_x_n_m", k), ("along_z_n_m", r.spring_n_m.z)])
}

pub fn ripple(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let pitch = uniform(rng, 0.002, 0.006);
    // The drive never turns back.
    let amplitude = (1.5e-4 * s.level).min(0.9 * pitch / std::f64::consts::TAU);
    r.ripple = Some([amplitude, pitch]);
    named([("amplitude_m", amplitude), ("pitch_m", pitch)])
}

pub fn cable(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let pull = if s.grasped { 0.8 * s.level } else { 0.25 * s.level };
    let stiffness = pull * uniform(rng, 5.0, 40.0);
    let way = Vector3::new(uniform(rng, 0.2, 1.0), uniform(rng, -0.7, 0.7), uniform(rng, -0.2, 0.9));
    r.cable = Some((pull, stiffness, way.normalize()));
    named([("pull_n", pull), ("stiffness_n_m", stiffness)])
}

pub fn magnet(r: &mut Reality, s: Scale, rng: &mut ChaCha8Rng) -> Out {
    let pull = if s.grasped { 3.0 * s.level } else { 0.5 * s.level };
    // Beside and below, so that it never touches.
    let place = Vector3::new(uniform(rng, -0.03, 0.03), 0.0, -uniform(rng, 0.03, 0.05));
    r.magnet = Some((pull, place));
    named([("pull_at_20_mm_n", pull), ("x_m", place.x), ("z_m", place.z)])
}
