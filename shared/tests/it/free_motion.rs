//! Motion that has an answer in closed form, in the steps of a tick and of the look-ahead.

use crate::common::{hard, obj4, still, turn};
use nalgebra::UnitQuaternion;
use stickslip_shared::contact::SLOTS;
use stickslip_shared::effects::Effect;
use stickslip_shared::model::{Scene, SupportContact};
use stickslip_shared::real::Vec3;
use stickslip_shared::shape::rotated_inertia;
use stickslip_shared::step::{State, step, support_under};

fn loose(gravity_m_s2: [f64; 3]) -> Scene<f64> {
    Scene { gravity_m_s2, object: obj4(), fingers: None, pusher: None, support: None }
}

#[test]
fn a_body_that_flies_keeps_its_angular_momentum_and_gains_no_energy() {
    let (scene, model, drive) = (loose([0.0; 3]), hard(0.4, 0.3, 0.3), still(0.002, 0.0));
    let mut state: State<f64, SLOTS> =
        State::held(&scene, &model, &drive, Vec3::zeros(), turn([0.0, 0.0, 1.0], 0.3));
    state.absolute_rad_s = Vec3::new(6.0, 3.0, 1.0);
    state.velocity[3..6].copy_from_slice(&[6.0, 3.0, 1.0]);
    let momentum = |s: &State<f64, SLOTS>| {
        let i = rotated_inertia(&scene.object, &s.rotation).map(Vec3::from);
        let w = s.absolute_rad_s;
        Vec3::new(i[0].dot(&w), i[1].dot(&w), i[2].dot(&w))
    };
    let (first, energy) = (momentum(&state), momentum(&state).dot(&state.absolute_rad_s));
    for _ in 0..250 {
        step(&scene, &model, &mut state, &drive);
    }
    let last = momentum(&state);
    assert!((last - first).norm() < 0.02 * first.norm(), "{first:?} -> {last:?}");
    let now = last.dot(&state.absolute_rad_s);
    assert!(now < energy * 1.001 && now > energy * 0.95, "{energy} -> {now}");
}

#[test]
fn viscous_friction_reaches_its_terminal_speed_in_steps_of_20_ms() {
    // Down a slope of 1 : 2 with friction 0.3 and viscosity 50 s/m: 0.2 / 50 = 4 mm/s. The explicit law
    // is stable below 2 ms.
    let mut scene = loose([9.81 * 0.5, 0.0, -9.81]);
    scene.support = Some(SupportContact::Patch);
    let mut model = hard(0.4, 0.3, 0.3);
    let mut effect = Effect::neutral("viscous_friction").expect("it is in the registry");
    effect.parameters[0] = 50.0;
    model.effects.push(effect).expect("room");
    for dt_s in [0.02, 0.004] {
        let mut drive = still(dt_s, 0.0);
        drive.support = Some(support_under(&scene, &Vec3::zeros(), &UnitQuaternion::identity(), &Vec3::z()));
        let mut state: State<f64, SLOTS> =
            State::held(&scene, &model, &drive, Vec3::zeros(), UnitQuaternion::identity());
        let mut speeds = Vec::new();
        for _ in 0..(2.0 / dt_s) as usize {
            step(&scene, &model, &mut state, &drive);
            speeds.push(state.velocity[0]);
        }
        let late = &speeds[speeds.len() / 2..];
        assert!(late.iter().all(|v| (v - 0.004).abs() < 1e-4), "dt {dt_s}: {late:?}");
    }
}
