//! The effect `support_anisotropy` against the ellipse of friction and maximum dissipation, by formula.

use crate::common::{G, hard, object, still};
use nalgebra::{Matrix2, SymmetricEigen, UnitQuaternion, Vector2};
use stickslip_shared::contact::{Body, SLOTS};
use stickslip_shared::effects::Effect;
use stickslip_shared::model::*;
use stickslip_shared::real::Vec3;
use stickslip_shared::step::{Drive, State, step, support_under};

const MASS_KG: f64 = 1.2;
const MU: f64 = 0.3;

fn block() -> Scene<f64> {
    let vertices_m = heapless::Vec::from_slice(&[[0.05, -0.03], [0.05, 0.03], [-0.05, 0.03], [-0.05, -0.03]]);
    Scene {
        gravity_m_s2: [0.0, 0.0, -G],
        object: object(Shape::Polygon { vertices_m: vertices_m.unwrap(), height_m: 0.02 }, MASS_KG),
        fingers: None,
        pusher: None,
        support: Some(SupportContact::Patch),
    }
}

fn with(parameters: [f64; 4]) -> Model<f64> {
    let mut model = hard(0.0, 0.0, MU);
    let mut effect = Effect::neutral("support_anisotropy").unwrap();
    effect.parameters[..4].copy_from_slice(&parameters);
    model.effects.push(effect).unwrap();
    model
}

/// Friction on a block turned by `turn_rad` that is thrown over a level table at `v`, world X and Y, N.
fn friction(parameters: [f64; 4], turn_rad: f64, v: [f64; 2]) -> Vector2<f64> {
    let (scene, model) = (block(), with(parameters));
    let turned = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), turn_rad);
    let table = support_under(&scene, &Vec3::zeros(), &turned, &Vec3::z());
    let drive = Drive { dt_s: 1e-3, support: Some(table), ..still(1e-3, 0.0) };
    let mut state: State<f64, SLOTS> = State::held(&scene, &model, &drive, Vec3::zeros(), turned);
    for _ in 0..100 {
        step(&scene, &model, &mut state, &drive);
    }
    // So fast that a step of friction does not turn it.
    let v = v.map(|x| 50.0 * x);
    (state.velocity[0], state.velocity[1]) = (v[0], v[1]);
    state.absolute_m_s = Vec3::new(v[0], v[1], 0.0);
    let out = step(&scene, &model, &mut state, &drive);
    let mut sum = Vector2::zeros();
    for (c, f) in out.contacts.iter().zip(&out.force_n).filter(|(c, _)| c.body == Body::Support) {
        let force = c.axes[1] * f[1] + c.axes[2] * f[2];
        sum += Vector2::new(force.x, force.y);
    }
    sum
}

/// Force of the ellipse `f' M^-2 f = (mu N)^2` that dissipates most at `v`: `-mu N M^2 v / |M v|`, where the tensor of
/// friction `M` has the logarithm `deviator / 2`.
fn on_ellipse([cosine, sine]: [f64; 2], v: [f64; 2]) -> Vector2<f64> {
    let deviator = Matrix2::new(cosine, sine, sine, -cosine);
    let eigen = SymmetricEigen::new(deviator);
    let root = Matrix2::from_diagonal(&eigen.eigenvalues.map(|x| (0.5 * x).exp()));
    let tensor = eigen.eigenvectors * root * eigen.eigenvectors.transpose();
    let along = tensor * Vector2::from(v);
    -(tensor * along) * (MU * MASS_KG * G / along.norm())
}

fn close(seen: Vector2<f64>, expected: Vector2<f64>, what: &str) {
    assert!((seen - expected).norm() < 0.01 * MU * MASS_KG * G, "{what}: {seen:?}, expected {expected:?}");
}

#[test]
fn friction_on_a_grained_table_lies_on_the_ellipse_and_dissipates_most_in_every_direction() {
    for pair in [[0.3, 0.0], [-0.3, 0.0], [0.0, 0.5], [-0.2, -0.4], [0.0, -0.7]] {
        for k in 0..12 {
            let (y, x) = (0.3 + f64::from(k) * std::f64::consts::FRAC_PI_6).sin_cos();
            let v = [0.05 * x, 0.05 * y];
            for turn in [0.0, 0.9, -2.5] {
                let seen = friction([pair[0], pair[1], 0.0, 0.0], turn, v);
                close(seen, on_ellipse(pair, v), &format!("{pair:?} {v:?} {turn}"));
            }
        }
    }
}

#[test]
fn the_grain_of_a_face_turns_with_the_object_and_adds_to_the_tables() {
    let (face, table): ([f64; 2], [f64; 2]) = ([0.4, -0.2], [-0.15, 0.25]);
    for turn in [-3.0, -1.6, -0.4, 0.0, 0.7, 1.5, 2.9] {
        let (s, c) = (2.0_f64 * turn).sin_cos();
        let turned = [face[0] * c - face[1] * s, face[0] * s + face[1] * c];
        let both = [turned[0] + table[0], turned[1] + table[1]];
        for v in [[0.04, 0.01], [-0.02, 0.05], [0.0, -0.03]] {
            let alone = friction([0.0, 0.0, face[0], face[1]], turn, v);
            close(alone, on_ellipse(turned, v), &format!("face, {turn} {v:?}"));
            let seen = friction([table[0], table[1], face[0], face[1]], turn, v);
            close(seen, on_ellipse(both, v), &format!("both, {turn} {v:?}"));
        }
    }
}

#[test]
fn a_grain_changes_nothing_where_the_object_stays_at_rest() {
    for parameters in [[0.8, 0.3, 0.0, 0.0], [0.0, 0.0, -0.5, 0.5]] {
        let held = friction(parameters, 0.3, [0.0; 2]);
        assert!(held.norm() < 1e-3 * MU * MASS_KG * G, "{held:?}");
    }
}
