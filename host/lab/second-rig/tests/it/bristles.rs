//! Oracles for bristles, foundations and patches, each alone.

use nalgebra::{Matrix3, Vector3};
use stickslip_second_rig::physics::foundation::Foundation;
use stickslip_second_rig::physics::friction::{Bristle, Kind, Law};
use stickslip_second_rig::physics::layout::{Element, Profile, disc, plate, rectangle, shift_pressure};
use stickslip_second_rig::physics::patch::{Load, Patch, Shear};
use stickslip_second_rig::physics::surface::{Geometry, Relative, Surface};
use stickslip_second_rig::random::{log_uniform, normal, stream, uniform};

const KINDS: [Kind; 3] = [Kind::Dahl, Kind::LuGre, Kind::ElastoPlastic];
const PROFILES: [Profile; 3] = [Profile::Uniform, Profile::Hertz, Profile::Gaussian];
const RADIUS: f64 = 0.01;
const STIFFNESS: f64 = 2e5;
const DT: f64 = 2e-5;

fn law(kind: Kind, mu: f64) -> Law {
    Law { kind, ..Law::coulomb(mu) }
}

fn patch(law: Law, profile: Profile, shear: Shear) -> Patch {
    let foundation =
        Foundation { stiffness: 4e5, damping: 0.0, relaxing: 0.0, relaxation_s: 1.0, tension_n: 0.0 };
    let geometry = Geometry::ToolOnFace { axis: 1, sign: 1.0 };
    Patch::new(disc(RADIUS, profile, 0.3), law, foundation, shear, 0.0, geometry)
}

/// Finger 1 pressed `depth` into the face of a block that moves with the given velocity.
fn press(patch: &mut Patch, depth: f64, velocity: Vector3<f64>, spin: Vector3<f64>) -> Load {
    let half = Vector3::new(0.05, 0.0125, 0.0125);
    let surface = Surface { half, round: false, taper: 0.0, wave: [0.0, 1.0, 0.0] };
    let relative = Relative { rotation: Matrix3::identity(), position: Vector3::zeros(), velocity, spin };
    let shift = Vector3::y() * (half.y - depth);
    patch.step(&surface, &relative, &shift, &Vector3::zeros(), 1.0, DT)
}

#[test]
fn bristles_of_every_law_never_create_energy_whatever_motion_and_load() {
    let rng = &mut stream(7, "energy");
    for kind in KINDS {
        for case in 0..40 {
            let mut law = law(kind, 1.0);
            law.anisotropy = if case % 2 == 0 { 1.0 } else { log_uniform(rng, 0.5, 2.0) };
            law.viscous_s_m = uniform(rng, 0.0, 2.0);
            law.creep_1_s = if case % 3 == 0 { uniform(rng, 0.0, 10.0) } else { 0.0 };
            let stiffness = log_uniform(rng, 1e3, 1e6);
            let damping = stiffness * log_uniform(rng, 1e-6, 1e-3);
            let mut z = Vector3::zeros();
            let mut v = Vector3::zeros();
            let (mut work, mut load, mut stored) = (0.0, 5.0_f64, 0.0);
            let mut supplied = 1e-12;
            for _ in 0..5000 {
                v += (Vector3::new(normal(rng), 0.0, normal(rng)) * 0.01 - v) * 0.02;
                load = (load + 0.2 * normal(rng)).clamp(0.0, 10.0);
                let bristle = Bristle { stiffness, damping, limit_n: load, grain: Vector3::x() };
                let pull = bristle.step(&law, &mut z, &v, DT);
                work += pull.force.dot(&v) * DT;
                supplied += pull.force.dot(&v).abs() * DT;
                stored = 0.5 * stiffness * z.norm_squared();
                assert!(work >= stored - 1e-9 * supplied, "{kind:?}: {work} J in, {stored} J stored");
            }
            assert!(work > stored, "sliding dissipates");
        }
    }
}

#[test]
fn a_sliding_patch_carries_mu_times_n_for_every_pressure_and_law() {
    for profile in PROFILES {
        for kind in KINDS {
            for direction in [Vector3::x(), Vector3::new(0.6, 0.0, 0.8)] {
                let mut p = patch(law(kind, 0.4), profile, Shear::Fixed(STIFFNESS));
                let mut load = Load::default();
                for _ in 0..5000 {
                    load = press(&mut p, 5e-5, direction * 0.01, Vector3::zeros());
                }
                assert!((load.normal_n - 20.0).abs() < 1e-9);
                let friction = load.force - Vector3::y() * load.force.y;
                assert!((friction + direction * 8.0).norm() < 1e-3, "{profile:?} {kind:?} {friction}");
                assert!(load.sliding > 0.999);
            }
        }
    }
}

#[test]
fn torque_of_a_disc_in_pure_spin_is_two_thirds_mu_n_r_under_uniform_pressure() {
    let mut p = patch(law(Kind::Dahl, 0.4), Profile::Uniform, Shear::Fixed(STIFFNESS));
    let mut load = Load::default();
    for _ in 0..40_000 {
        load = press(&mut p, 5e-5, Vector3::zeros(), Vector3::y() * 0.5);
    }
    let expected = 2.0 / 3.0 * 0.4 * 20.0 * RADIUS;
    assert!((load.torque.y + expected).abs() < 2e-3 * expected, "{} against {expected}", load.torque.y);
}

#[test]
fn torque_in_pure_spin_falls_as_the_pressure_gathers_in_the_middle() {
    let torque = |profile| {
        let mut p = patch(law(Kind::Dahl, 0.4), profile, Shear::Fixed(STIFFNESS));
        let mut load = Load::default();
        for _ in 0..40_000 {
            load = press(&mut p, 5e-5, Vector3::zeros(), Vector3::y() * 0.5);
        }
        -load.torque.y / (0.4 * 20.0 * RADIUS)
    };
    // Half ellipsoid: 3 pi / 16; three rings integrate its edge to 1 %.
    let hertz = torque(Profile::Hertz);
    assert!((hertz - 3.0 * std::f64::consts::PI / 16.0).abs() < 0.01, "{hertz}");
    assert!(torque(Profile::Gaussian) < hertz);
}

#[test]
fn loading_before_sliding_has_the_stated_stiffness() {
    for shear in [Shear::Fixed(STIFFNESS), Shear::PerLoad(STIFFNESS / 20.0)] {
        for kind in [Kind::Dahl, Kind::ElastoPlastic] {
            let mut p = patch(law(kind, 1.0), Profile::Uniform, shear);
            press(&mut p, 5e-5, Vector3::zeros(), Vector3::zeros());
            // 2 um, a fiftieth of what lets go.
            let mut load = Load::default();
            for _ in 0..100 {
                load = press(&mut p, 5e-5, Vector3::x() * 1e-3, Vector3::zeros());
            }
            let stiffness = -load.force.x / (100.0 * 1e-3 * DT);
            // Dahl's curve starts to bend at once: half of the load's share of the limit.
            let bend = if kind == Kind::Dahl { 0.015 } else { 1e-9 };
            assert!((stiffness / STIFFNESS - 1.0).abs() <= bend, "{kind:?} {shear:?}: {stiffness}");
        }
    }
}

#[test]
fn the_rim_slides_before_the_middle_under_hertz_pressure() {
    let mut p = patch(law(Kind::ElastoPlastic, 0.5), Profile::Hertz, Shear::Fixed(STIFFNESS));
    let mut seen = Vec::new();
    for _ in 0..20_000 {
        let load = press(&mut p, 5e-5, Vector3::x() * 1e-3, Vector3::zeros());
        seen.push((-load.force.x / 10.0, load.sliding));
    }
    let partial = seen.iter().filter(|(_, s)| *s > 0.02 && *s < 0.97).count();
    assert!(partial > 100, "partial slip in {partial} steps");
    let first = seen.iter().find(|(_, s)| *s > 0.02).map(|x| x.0);
    assert!(first.is_some_and(|share| share < 0.9), "first bristles slide at {first:?} of the limit");
    assert!(seen.last().is_some_and(|x| x.1 > 0.999));
}

#[test]
fn steady_friction_does_not_depend_on_the_time_step() {
    let force = |dt: f64| {
        let law = Law { static_ratio: 1.3, viscous_s_m: 3.0, ..law(Kind::LuGre, 1.0) };
        let bristle = Bristle { stiffness: 1e5, damping: 5.0, limit_n: 6.0, grain: Vector3::x() };
        let mut z = Vector3::zeros();
        let mut f = 0.0;
        for _ in 0..(0.05 / dt) as usize {
            f = bristle.step(&law, &mut z, &(Vector3::x() * 0.02), dt).force.x;
        }
        (f, 6.0 * law.speed_factor(0.02))
    };
    for dt in [1e-5, 5e-5, 2e-4] {
        let (f, expected) = force(dt);
        assert!((f - expected).abs() < 1e-6 * expected, "{dt}: {f} against {expected}");
    }
}

#[test]
fn friction_of_an_anisotropic_bristle_lies_on_its_ellipse_where_it_dissipates_most() {
    let law = Law { anisotropy: 1.6, ..law(Kind::Dahl, 1.0) };
    let bristle = Bristle { stiffness: 1e5, damping: 0.0, limit_n: 5.0, grain: Vector3::x() };
    for degrees in [0.0_f64, 30.0, 60.0, 90.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let mut z = Vector3::zeros();
        let mut f = Vector3::zeros();
        // Twenty-five times the time in which the slower axis settles.
        for _ in 0..10_000 {
            f = bristle.step(&law, &mut z, &(Vector3::new(c, 0.0, s) * 0.01), DT).force;
        }
        let ellipse = f.x * f.x / (25.0 * 1.6) + f.z * f.z / (25.0 / 1.6);
        assert!((ellipse - 1.0).abs() < 1e-6, "{degrees}: {ellipse}");
        // The motion is normal to the ellipse.
        let [x, z] = [f.x / 1.6, f.z * 1.6];
        assert!((x * s - z * c).abs() < 1e-6 * x.hypot(z), "{degrees}: {x} {z}");
    }
}

#[test]
fn a_relaxing_foundation_starts_at_both_springs_and_ends_at_one() {
    let f = Foundation { stiffness: 1e5, damping: 0.0, relaxing: 5e4, relaxation_s: 0.1, tension_n: 0.0 };
    let mut memory = 0.0;
    let mut force = 0.0;
    for i in 1..=100 {
        force = f.step(&mut memory, 1e-6 * f64::from(i), 1e-6 / 1e-6, 1.0, 1e-6);
    }
    assert!((force - 15.0).abs() < 0.02, "{force}");
    for _ in 0..100_000 {
        force = f.step(&mut memory, 1e-4, 0.0, 1.0, 1e-5);
    }
    assert!((force - 10.0).abs() < 0.01, "{force}");
}

#[test]
fn the_centre_of_pressure_moves_by_what_is_asked() {
    let moved = shift_pressure(disc(RADIUS, Profile::Uniform, 0.0), [0.001, -0.0005]);
    let at: Vector3<f64> = moved.iter().map(|e| e.position * e.load).sum();
    assert!((at - Vector3::new(0.001, 0.0, -0.0005)).norm() < 1e-9, "{at}");
}

#[test]
fn an_even_rectangle_has_the_area_radius_of_gyration_and_spin_torque_of_the_integral() {
    let sizes = [[0.0465, 0.0195], [0.02, 0.02], [0.012, 0.05]];
    for ([x, y], of) in sizes.into_iter().flat_map(|size| [(size, rectangle as fn(_, _) -> _), (size, plate)])
    {
        let elements: Vec<Element> = of(Vector3::zeros(), [Vector3::x() * x, Vector3::y() * y]);
        let sum = |of: &dyn Fn(&Vector3<f64>) -> f64| {
            elements.iter().map(|e| e.load * of(&e.position)).sum::<f64>()
        };
        assert!((sum(&|p| p.x * p.x) / (x * x / 3.0) - 1.0).abs() < 1e-9);
        assert!((sum(&|p| p.y * p.y) / (y * y / 3.0) - 1.0).abs() < 1e-9);
        let n = 400;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
        let mean: f64 = (0..n).flat_map(|i| (0..n).map(move |j| (x * at(i)).hypot(y * at(j)))).sum();
        let mean = mean / f64::from(n * n);
        let torque = sum(&|p| p.norm()) / mean;
        assert!((torque - 1.0).abs() < 0.02, "{x} {y}: {torque}");
    }
}
