//! The effect `support_pressure` against Coulomb friction integrated over the area, and against statics.

use crate::common::{G, hard, object};
use nalgebra::UnitQuaternion;
use stickslip_shared::contact::{Body, SLOTS};
use stickslip_shared::effects::Effect;
use stickslip_shared::model::*;
use stickslip_shared::real::{Real, Vec3};
use stickslip_shared::step::{Drive, State, StepOutput, step, support_under};

const MASS_KG: f64 = 1.5;
const MU: f64 = 0.3;
/// Half sides of the face, m.
const HALF_M: [f64; 2] = [0.06, 0.04];

fn block<R: Real>(support: SupportContact<R>) -> Scene<R> {
    let [x, y] = HALF_M;
    let corners = [[x, -y], [x, y], [-x, y], [-x, -y]].map(|v| v.map(R::of));
    let vertices_m = heapless::Vec::from_slice(&corners).unwrap();
    Scene {
        gravity_m_s2: [R::zero(), R::zero(), R::of(-G)],
        object: object(Shape::Polygon { vertices_m, height_m: R::of(0.02) }, MASS_KG),
        fingers: None,
        pusher: None,
        support: Some(support),
    }
}

fn with<R: Real>(parameters: [f64; 4]) -> Model<R> {
    let mut model = hard::<R>(0.0, 0.0, MU);
    let mut effect = Effect::neutral("support_pressure").unwrap();
    for (to, p) in effect.parameters.iter_mut().zip(parameters) {
        *to = R::of(p);
    }
    model.effects.push(effect).unwrap();
    model
}

/// Slides over the table at `(v_x, v_y, w)` about the centre of mass: the second step's contacts and state.
fn slide<R: Real>(
    scene: &Scene<R>,
    model: &Model<R>,
    twist: [f64; 3],
) -> (StepOutput<R, SLOTS>, State<R, SLOTS>) {
    let level = UnitQuaternion::identity();
    let up = Vec3::new(R::zero(), R::zero(), R::one());
    let drive = Drive {
        dt_s: R::of(1e-3),
        carrier: level,
        carrier_m_s: Vec3::zeros(),
        carrier_rad_s: Vec3::zeros(),
        pusher: None,
        support: Some(support_under(scene, &Vec3::zeros(), &level, &up)),
        grip_n: R::zero(),
        trial: R::zero(),
    };
    let mut state = State::held(scene, model, &drive, Vec3::zeros(), level);
    // Loads have to build up before they can be offset.
    for _ in 0..20 {
        step(scene, model, &mut state, &drive);
    }
    let [x, y, w] = twist.map(R::of);
    state.velocity[0] = x;
    state.velocity[1] = y;
    state.velocity[5] = w;
    state.absolute_m_s = Vec3::new(x, y, R::zero());
    state.absolute_rad_s = Vec3::new(R::zero(), R::zero(), w);
    let out = step(scene, model, &mut state, &drive);
    (out, state)
}

/// Places (object axes) and normal loads of the support's points.
fn loads<R: Real>(out: &StepOutput<R, SLOTS>) -> Vec<([f64; 2], f64)> {
    let of_table = out.contacts.iter().zip(&out.force_n).filter(|(c, _)| c.body == Body::Support);
    of_table.map(|(c, f)| ([c.lever_m.x.to_f64(), c.lever_m.y.to_f64()], f[0].to_f64())).collect()
}

/// Force and moment of friction about the centre of mass.
fn friction(out: &StepOutput<f64, SLOTS>) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (c, f) in out.contacts.iter().zip(&out.force_n).filter(|(c, _)| c.body == Body::Support) {
        let force = c.axes[1] * f[1] + c.axes[2] * f[2];
        sum[0] += force.x;
        sum[1] += force.y;
        sum[2] += c.lever_m.x * force.y - c.lever_m.y * force.x;
    }
    sum
}

/// The same of a linear pressure over the stretched face whose resultant lies at `offset` less what friction,
/// which acts `0.01 m` below the centre of mass, moves it; integrated over 400 x 400 cells.
fn integrated([ox, oy, sx, sy]: [f64; 4], twist: [f64; 3], friction_n: [f64; 2]) -> [f64; 3] {
    let half = [HALF_M[0] * (1.0 + sx), HALF_M[1] * (1.0 + sy)];
    let weight = MASS_KG * G;
    let centre = [ox + 0.01 * friction_n[0] / weight, oy + 0.01 * friction_n[1] / weight];
    // p = (1 + 3 c_x x / a^2 + 3 c_y y / b^2) / area has its centre at c.
    let slope = [3.0 * centre[0] / (half[0] * half[0]), 3.0 * centre[1] / (half[1] * half[1])];
    let n = 400;
    let mut sum = [0.0; 3];
    for i in 0..n {
        for j in 0..n {
            let at = |k: usize, i: i32| half[k] * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
            let (x, y) = (at(0, i), at(1, j));
            let load = weight / f64::from(n * n) * (1.0 + slope[0] * x + slope[1] * y);
            assert!(load >= 0.0, "the test's pressure is to press everywhere");
            let v = [twist[0] - twist[2] * y, twist[1] + twist[2] * x];
            let size = v[0].hypot(v[1]).max(1e-12);
            let f = [-MU * load * v[0] / size, -MU * load * v[1] / size];
            sum[0] += f[0];
            sum[1] += f[1];
            sum[2] += x * f[1] - y * f[0];
        }
    }
    sum
}

#[test]
fn wrench_against_twist_is_that_of_the_stretched_and_shifted_pressure() {
    let scene = block(SupportContact::Patch);
    let moment = MU * MASS_KG * G * 0.04;
    for parameters in [[0.0; 4], [0.006, -0.004, 0.0, 0.0], [0.0, 0.0, 0.5, -0.4], [-0.005, 0.003, -0.5, 0.3]]
    {
        for twist in
            [[0.05, 0.0, 0.0], [0.0, 0.05, 0.8], [0.03, -0.02, 1.5], [0.0, 0.0, 2.0], [-0.02, 0.01, -3.0]]
        {
            let (out, _) = slide(&scene, &with(parameters), twist);
            let seen = friction(&out);
            let expected = integrated(parameters, twist, [seen[0], seen[1]]);
            let largest = MU * MASS_KG * G;
            for k in 0..2 {
                // Twelve points stand for the area.
                let off = (seen[k] - expected[k]).abs();
                assert!(off < 0.06 * largest, "{parameters:?} {twist:?}: {seen:?} {expected:?}");
            }
            let off = (seen[2] - expected[2]).abs();
            assert!(off < 0.06 * moment, "{parameters:?} {twist:?}: {seen:?} {expected:?}");
        }
    }
}

#[test]
fn loads_have_the_told_centre_and_spread_and_never_pull() {
    let scene = block(SupportContact::Patch);
    let second = |of: &[([f64; 2], f64)], k: usize| of.iter().map(|(p, n)| n * p[k] * p[k]).sum::<f64>();
    let still = [0.0; 3];
    let plain = loads(&slide(&scene, &with([0.0; 4]), still).0);
    for spread in [[0.4, 0.0], [-0.5, 0.6]] {
        let here = loads(&slide(&scene, &with([0.0, 0.0, spread[0], spread[1]]), still).0);
        for k in 0..2 {
            let grown = second(&here, k) / second(&plain, k);
            assert!((grown / (1.0 + spread[k]).powi(2) - 1.0).abs() < 1e-3, "{spread:?}: {grown}");
        }
    }
    for offset in [[0.008, 0.0], [-0.004, 0.01], [0.03, 0.02]] {
        let here = loads(&slide(&scene, &with([offset[0], offset[1], 0.0, 0.0]), still).0);
        let sum: f64 = here.iter().map(|l| l.1).sum();
        assert!((sum / (MASS_KG * G) - 1.0).abs() < 1e-3, "{sum}");
        assert!(here.iter().all(|l| l.1 >= 0.0), "{here:?}");
        for k in 0..2 {
            let centre = here.iter().map(|(p, n)| n * p[k]).sum::<f64>() / sum;
            assert!((centre - offset[k]).abs() < 1e-4, "{offset:?}: {centre}");
        }
    }
}

#[test]
fn feet_that_are_told_keep_their_places_and_the_loads_of_statics() {
    let feet = [[0.03, 0.0], [-0.02, 0.025], [-0.02, -0.025]];
    let scene = block(SupportContact::Points(heapless::Vec::from_slice(&feet).unwrap()));
    let here = loads(&slide(&scene, &with([0.0, 0.0, 0.6, -0.5]), [0.0; 3]).0);
    for ((place, load), (foot, share)) in here.iter().zip(feet.iter().zip([0.4, 0.3, 0.3])) {
        assert_eq!(place, foot);
        assert!((load / (MASS_KG * G) - share).abs() < 1e-3, "{here:?}");
    }
}

#[test]
fn a_sliding_body_only_loses_energy_however_its_load_is_spread() {
    let scene = block(SupportContact::Patch);
    for parameters in [[0.006, -0.004, 0.5, -0.4], [-0.01, 0.008, -0.7, 0.8]] {
        let model = with(parameters);
        let (_, mut state) = slide(&scene, &model, [0.3, -0.2, 4.0]);
        let level = UnitQuaternion::identity();
        let up = Vec3::new(0.0, 0.0, 1.0);
        let drive = Drive {
            dt_s: 1e-3,
            carrier: level,
            carrier_m_s: Vec3::zeros(),
            carrier_rad_s: Vec3::zeros(),
            pusher: None,
            support: Some(support_under(&scene, &Vec3::zeros(), &level, &up)),
            grip_n: 0.0,
            trial: 0.0,
        };
        let spin = scene.object.inertia_kg_m2[2][2];
        let energy = |s: &State<f64, SLOTS>| {
            0.5 * MASS_KG * s.absolute_m_s.norm_squared() + 0.5 * spin * s.absolute_rad_s.z.powi(2)
        };
        let mut before = energy(&state);
        for k in 0..300 {
            step(&scene, &model, &mut state, &drive);
            let now = energy(&state);
            assert!(now <= before + 1e-9, "{parameters:?} step {k}: {before} to {now} J");
            before = now;
        }
        assert!(before < 1e-6, "it comes to rest: {before} J");
    }
}
