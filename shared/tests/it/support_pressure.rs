//! The effect `support_pressure` against Coulomb friction integrated over the area, and against statics.

use crate::common::{G, hard, object, still};
use nalgebra::UnitQuaternion;
use stickslip_shared::contact::{Body, SLOTS};
use stickslip_shared::effects::Effect;
use stickslip_shared::model::*;
use stickslip_shared::real::Vec3;
use stickslip_shared::step::{Drive, State, StepOutput, step, support_under};

const MASS_KG: f64 = 1.5;
const MU: f64 = 0.3;
/// Half sides of the face, m.
const HALF_M: [f64; 2] = [0.06, 0.04];

fn block(support: SupportContact<f64>) -> Scene<f64> {
    let [x, y] = HALF_M;
    let vertices_m = heapless::Vec::from_slice(&[[x, -y], [x, y], [-x, y], [-x, -y]]).unwrap();
    Scene {
        gravity_m_s2: [0.0, 0.0, -G],
        object: object(Shape::Polygon { vertices_m, height_m: 0.02 }, MASS_KG),
        fingers: None,
        pusher: None,
        support: Some(support),
    }
}

fn with(parameters: [f64; 4]) -> Model<f64> {
    let mut model = hard(0.0, 0.0, MU);
    let mut effect = Effect::neutral("support_pressure").unwrap();
    effect.parameters[..4].copy_from_slice(&parameters);
    model.effects.push(effect).unwrap();
    model
}

/// On the table at rest, 0.3 s long: loads have to build up before they can be offset.
fn at_rest(scene: &Scene<f64>, model: &Model<f64>) -> (State<f64, SLOTS>, Drive<f64>) {
    let level = UnitQuaternion::identity();
    let table = support_under(scene, &Vec3::zeros(), &level, &Vec3::z());
    let drive = Drive { dt_s: 1e-3, support: Some(table), ..still(1e-3, 0.0) };
    let mut state = State::held(scene, model, &drive, Vec3::zeros(), level);
    for _ in 0..300 {
        step(scene, model, &mut state, &drive);
    }
    (state, drive)
}

/// Thrown over the table at `(v_x, v_y, w)` about the centre of mass: the first step.
fn slide(
    scene: &Scene<f64>,
    model: &Model<f64>,
    [x, y, w]: [f64; 3],
) -> (StepOutput<f64, SLOTS>, State<f64, SLOTS>, Drive<f64>) {
    let (mut state, drive) = at_rest(scene, model);
    (state.velocity[0], state.velocity[1], state.velocity[5]) = (x, y, w);
    state.absolute_m_s = Vec3::new(x, y, 0.0);
    state.absolute_rad_s = Vec3::new(0.0, 0.0, w);
    let out = step(scene, model, &mut state, &drive);
    (out, state, drive)
}

/// Places (object axes) and normal loads of the support's points.
fn loads(out: &StepOutput<f64, SLOTS>) -> Vec<([f64; 2], f64)> {
    let of_table = out.contacts.iter().zip(&out.force_n).filter(|(c, _)| c.body == Body::Support);
    of_table.map(|(c, f)| ([c.lever_m.x, c.lever_m.y], f[0])).collect()
}

/// Turning about points outside the face, where sixteen cells stand for it, and about its middle.
const TWISTS: [[f64; 3]; 5] =
    [[0.05, 0.0, 0.0], [0.0, 0.05, 0.3], [0.03, -0.02, 0.25], [0.0, 0.0, 2.0], [-0.02, 0.01, -0.1]];

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
    let centre = [ox - 0.01 * friction_n[0] / weight, oy - 0.01 * friction_n[1] / weight];
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
    for parameters in [[0.0; 4], [0.006, -0.004, 0.0, 0.0], [0.0, 0.0, 0.5, -0.4], [-0.003, 0.002, -0.3, 0.3]]
    {
        for twist in TWISTS {
            let (out, ..) = slide(&scene, &with(parameters), twist);
            let seen = friction(&out);
            let expected = integrated(parameters, twist, [seen[0], seen[1]]);
            let largest = MU * MASS_KG * G;
            for k in 0..2 {
                let off = (seen[k] - expected[k]).abs();
                assert!(off < 0.03 * largest, "{parameters:?} {twist:?}: {seen:?} {expected:?}");
            }
            // Cells turn about their middles, not their areas.
            let off = (seen[2] - expected[2]).abs();
            assert!(off < 0.08 * moment, "{parameters:?} {twist:?}: {seen:?} {expected:?}");
        }
    }
}

#[test]
fn loads_have_the_told_centre_and_spread_and_never_pull() {
    let scene = block(SupportContact::Patch);
    let second = |of: &[([f64; 2], f64)], k: usize| of.iter().map(|(p, n)| n * p[k] * p[k]).sum::<f64>();
    let rest = [0.0; 3];
    let plain = loads(&slide(&scene, &with([0.0; 4]), rest).0);
    for spread in [[0.4, 0.0], [-0.5, 0.6]] {
        let here = loads(&slide(&scene, &with([0.0, 0.0, spread[0], spread[1]]), rest).0);
        for k in 0..2 {
            let grown = second(&here, k) / second(&plain, k);
            assert!((grown / (1.0 + spread[k]).powi(2) - 1.0).abs() < 1e-3, "{spread:?}: {grown}");
        }
    }
    for offset in [[0.008, 0.0], [-0.004, 0.01], [0.03, 0.02]] {
        let here = loads(&slide(&scene, &with([offset[0], offset[1], 0.0, 0.0]), rest).0);
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
        assert!((place[0] - foot[0]).hypot(place[1] - foot[1]) < 1e-6, "{place:?} {foot:?}");
        assert!((load / (MASS_KG * G) - share).abs() < 1e-3, "{here:?}");
    }
}

#[test]
fn a_sliding_body_only_loses_energy_however_its_load_is_spread() {
    let scene = block(SupportContact::Patch);
    for parameters in [[0.0; 4], [0.006, -0.004, 0.5, -0.4], [-0.01, 0.008, -0.7, 0.8]] {
        let model = with(parameters);
        let (_, mut state, drive) = slide(&scene, &model, [0.3, -0.2, 4.0]);
        let spin = scene.object.inertia_kg_m2[2][2];
        let energy = |s: &State<f64, SLOTS>| {
            0.5 * MASS_KG * s.absolute_m_s.norm_squared() + 0.5 * spin * s.absolute_rad_s.z.powi(2)
        };
        let first = energy(&state);
        let mut before = first;
        for k in 0..300 {
            step(&scene, &model, &mut state, &drive);
            let now = energy(&state);
            assert!(now <= before + 1e-5 * first, "{parameters:?} step {k}: {before} to {now} J");
            before = now;
        }
        assert!(before < 1e-5 * first, "it comes to rest: {before} J");
    }
}
