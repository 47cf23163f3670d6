//! Pushing an object over a table with a point.

use crate::common::*;
use crate::on_both_formulations;
use nalgebra::UnitQuaternion;
use stickslip_shared::model::*;
use stickslip_shared::real::Vec3;

const MASS_KG: f64 = 1.5;

fn block(support: SupportContact<f64>) -> Scene<f64> {
    let vertices_m =
        heapless::Vec::from_slice(&[[0.05, -0.04], [0.05, 0.04], [-0.05, 0.04], [-0.05, -0.04]]).unwrap();
    Scene {
        gravity_m_s2: [0.0, 0.0, -G],
        object: object(Shape::Polygon { vertices_m, height_m: 0.02 }, MASS_KG),
        fingers: None,
        pusher: Some(PusherContact::Point { tip_radius_m: 0.005 }),
        support: Some(support),
    }
}

/// Pushes along +X at `offset_m` from the centre.
fn push(
    by: Formulation,
    scene: Scene<f64>,
    mu: f64,
    mu_pusher: f64,
    offset_m: f64,
    seconds: f64,
    each: impl FnMut(&Seen<'_, f64>),
) {
    push_at(by, scene, mu, mu_pusher, [offset_m, 0.0], seconds, each);
}

/// The same, from the middle of the edge and above the table.
fn push_at(
    by: Formulation,
    scene: Scene<f64>,
    mu: f64,
    mu_pusher: f64,
    [offset_m, height_m]: [f64; 2],
    seconds: f64,
    each: impl FnMut(&Seen<'_, f64>),
) {
    let play = Play {
        scene,
        model: hard_by(by, 0.0, mu_pusher, mu),
        gripper: &|_| pose(Vec3::zeros(), UnitQuaternion::identity()),
        pusher: Some(&|t| pose(at(-0.0551 + 0.02 * t, offset_m, height_m), UnitQuaternion::identity())),
        object: pose(at(0.0, 0.0, 0.01), UnitQuaternion::identity()),
        grip_n: 0.0,
        seconds,
    };
    play.run(each);
}

fn three_feet() -> SupportContact<f64> {
    SupportContact::Points(
        heapless::Vec::from_slice(&[[0.03, 0.0], [-0.02, 0.025], [-0.02, -0.025]]).unwrap(),
    )
}

on_both_formulations! {
    a_central_push_takes_mu_times_weight_and_goes_straight,
    a_rod_that_does_not_slide_holds_nothing_down_at_whatever_height_it_pushes,
    what_would_tip_over_narrow_feet_is_held_by_friction_of_the_rod,
    three_feet_bear_the_loads_of_statics,
    an_eccentric_push_turns_the_object_by_the_limit_surface,
}

fn a_central_push_takes_mu_times_weight_and_goes_straight(by: Formulation) {
    for support in [SupportContact::Patch, three_feet()] {
        let mut last = (0.0, 0.0, 0.0);
        push(by, block(support), 0.25, 0.2, 0.0, 1.0, |s| {
            assert!(s.imbalance_n.norm() < 1e-6, "{}", s.imbalance_n);
            last = (s.out.reading.pusher[0], s.world.position_m.y, s.world.rotation.angle());
        });
        let expected = 0.25 * MASS_KG * G;
        assert!((last.0 - expected).abs() < 0.01 * expected, "{} {expected}", last.0);
        assert!(last.1.abs() < 1e-6 && last.2 < 1e-4, "{last:?}");
    }
}

fn a_rod_that_does_not_slide_holds_nothing_down_at_whatever_height_it_pushes(by: Formulation) {
    // Force times height would tip the object; the table alone bears that.
    for (support, height_m) in
        [(SupportContact::Patch, 0.005), (SupportContact::Patch, 0.018), (three_feet(), 0.01)]
    {
        let mut last = (0.0, 0.0);
        push_at(by, block(support), 0.25, 0.4, [0.0, height_m], 1.0, |s| {
            last = (s.out.reading.pusher[0], s.out.reading.pusher[2]);
        });
        let expected = 0.25 * MASS_KG * G;
        assert!((last.0 - expected).abs() < 0.01 * expected, "{height_m} m: {last:?} N, {expected} N");
        assert!(last.1.abs() < 0.021 * expected, "{height_m} m: {last:?} N");
    }
}

fn what_would_tip_over_narrow_feet_is_held_by_friction_of_the_rod(by: Formulation) {
    // The feet bear 0.044 N m, the push has 0.066: 0.4 N at the pushed face are missing, friction of the rod bears 1.5 N.
    let feet = SupportContact::Points(
        heapless::Vec::from_slice(&[[0.003, 0.0], [-0.003, 0.02], [-0.003, -0.02]]).unwrap(),
    );
    for (mu_pusher, held) in [(0.4, true), (0.02, false)] {
        let mut tilt_rad: f64 = 0.0;
        push_at(by, block(feet.clone()), 0.25, mu_pusher, [0.0, 0.018], 1.0, |s| {
            tilt_rad = (s.world.rotation * Vec3::z()).z.acos();
        });
        assert!(if held { tilt_rad < 0.02 } else { tilt_rad > 0.1 }, "{mu_pusher}: {tilt_rad} rad");
    }
}

fn three_feet_bear_the_loads_of_statics(by: Formulation) {
    let mut loads = Vec::new();
    push(by, block(three_feet()), 0.25, 0.2, 0.0, 0.004, |s| {
        loads = s
            .out
            .contacts
            .iter()
            .zip(&s.out.force_n)
            .filter(|(c, _)| c.body.index() == 3)
            .map(|(_, f)| f[0])
            .collect();
    });
    // Before the push: sum W, moments zero; feet at x 0.03 and -0.02 twice.
    let weight = MASS_KG * G;
    for (load, share) in loads.iter().zip([0.4, 0.3, 0.3]) {
        assert!((load - share * weight).abs() < 0.01 * weight, "{loads:?}");
    }
}

fn an_eccentric_push_turns_the_object_by_the_limit_surface(by: Formulation) {
    // Quasi-static oracle: with frictionless pusher the force is along its normal, F x, at
    // the offset y; the object's twist is the one whose friction balances it. Friction of
    // the feet at twist (vx, vy, w): sum mu N_i v_i/|v_i|, solved by brute-force search.
    let offset = 0.02;
    let feet = [[0.03, 0.0], [-0.02, 0.025], [-0.02, -0.025]];
    let loads = [0.4, 0.3, 0.3].map(|s: f64| 0.25 * s * MASS_KG * G);
    let friction = |c: [f64; 2]| {
        // Unit rate about the centre c: force and moment about the centre of mass, for w = 1.
        let (mut f, mut m) = ([0.0; 2], 0.0);
        for (p, n) in feet.iter().zip(loads) {
            let v = [-(p[1] - c[1]), p[0] - c[0]];
            let size = v[0].hypot(v[1]).max(1e-12);
            let g = [-n * v[0] / size, -n * v[1] / size];
            f[0] += g[0];
            f[1] += g[1];
            m += p[0] * g[1] - p[1] * g[0];
        }
        (f, m)
    };
    // The pusher's moment about the centre of mass is -offset F: the object turns clockwise.
    let mut best = (f64::MAX, [0.0; 2], 0.0);
    for i in -400..400 {
        for j in -400..400 {
            let c = [f64::from(i) * 2.5e-4, f64::from(j) * 2.5e-4];
            let (f, m) = friction(c);
            // w = -1: friction turns its sign; the pusher gives F = -friction.
            let push = [f[0], f[1]];
            let error = push[1].abs() + (m + offset * push[0]).abs() / 0.03;
            if push[0] > 0.0 && error < best.0 {
                best = (error, c, push[0]);
            }
        }
    }
    let mut early = (0.0, 0.0, 0.0);
    push(by, block(three_feet()), 0.25, 0.0, offset, 0.04, |s| {
        let v = s.state.velocity;
        early = (s.out.reading.pusher[0], v[5], v[1]);
    });
    let (_, c, force) = best;
    assert!((early.0 - force).abs() < 0.03 * force, "force {} oracle {force}", early.0);
    // w: the contact point moves at 0.02 m/s along x: v_x = -w (y - c_y).
    let w = 0.02 / -(offset - c[1]);
    assert!((early.1 - w).abs() < 0.1 * w.abs(), "turning {} oracle {w}", early.1);
}
