//! The step with friction pyramids: against Lemke's method on the same problem, against the exact cone,
//! and small cases by hand.

use crate::common::grasps::*;
use stickslip_shared::cone::{self, Kept};
use stickslip_shared::lcp::dense::Dense;
use stickslip_shared::lcp::factors::{Contact, Factors, Impulses};
use stickslip_shared::lcp::step::{self, FirstEdge, Past, Paths, PyramidParams};
use stickslip_shared::real::{Real, Vec3};
use stickslip_shared::solve::*;

/// The problem that Lemke's method knows: four edges, the first along the first tangent.
fn as_factors(points: &Points<f64>, bodies: &Bodies<f64>) -> Factors<f64, CAPACITY, 7> {
    let i = &bodies.inertia_kg_m2;
    let inverse_mass = [
        1.0 / bodies.mass_kg,
        1.0 / bodies.mass_kg,
        1.0 / bodies.mass_kg,
        1.0 / i[0][0],
        1.0 / i[1][1],
        1.0 / i[2][2],
        1.0 / bodies.jaw_mass_kg,
    ];
    let contact = |p: &ContactPoint<f64>| {
        let row = |k: usize| {
            let (a, m) = (p.axes[k], p.lever_m.cross(&p.axes[k]));
            [a.x, a.y, a.z, m.x, m.y, m.z, if k == 0 { p.jaw } else { 0.0 }]
        };
        let at = |k: usize| (0..7).map(|i| row(k)[i] * bodies.free[i]).sum::<f64>() + p.bias_m_s[k];
        Contact {
            normal: row(0),
            tangents: [row(1), row(2)],
            compliance: 1.0 / (p.stiffness_n_s_m[0] * bodies.dt_s),
            tangential_compliance: 1.0 / (p.stiffness_n_s_m[1] * bodies.dt_s),
            friction: p.mu[0],
            separation: at(0),
            slip: [at(1), at(2)],
        }
    };
    Factors { inverse_mass, contacts: points.iter().map(contact).collect() }
}

fn draw_grasp(draw: &mut Draw, case: usize, mu: f64, spring_n_m: f64) -> (Points<f64>, Bodies<f64>) {
    random_grasp(draw, if case.is_multiple_of(2) { Push::Plane } else { Push::Edge }, mu, spring_n_m)
}

/// Lemke's answer to a problem.
fn lemke(dense: &mut Dense<f64, 98>, problem: &Factors<f64, CAPACITY, 7>) -> Impulses<f64, CAPACITY, 7> {
    let n = problem.unknowns();
    let (mut m, mut q) = (vec![0.0; n * n], vec![0.0; n]);
    assert!(problem.write_dense(&mut m, &mut q));
    let mut impulses = Impulses::none();
    impulses.read_unknowns(dense.solve(&m, &q).solved().expect("Lemke's method solves it"), problem);
    impulses
}

#[test]
fn four_fixed_edges_give_the_velocity_of_lemkes_method_on_the_same_problem() {
    let mut draw = Draw(2718);
    let params =
        PyramidParams { edges: 4, first_edge: FirstEdge::Fixed([1.0, 0.0]), ..PyramidParams::default() };
    let mut dense = Box::new(Dense::<f64, 98>::new());
    for case in 0..40 {
        let (points, bodies) = draw_grasp(&mut draw, case, 0.6, 2e6);
        let problem = as_factors(&points, &bodies);
        let impulses = lemke(&mut dense, &problem);
        let ours = step::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default(), &params);
        assert_eq!(ours.status, SolveStatus::Solved, "case {case}");
        for k in 0..7 {
            let theirs = bodies.free[k] + impulses.velocity_change[k];
            let size = if (3..6).contains(&k) { 1e-5 } else { 1e-6 };
            assert!(
                (ours.velocity[k] - theirs).abs() < size,
                "case {case} {k}: {} {theirs}",
                ours.velocity[k]
            );
        }
    }
}

#[test]
fn the_contact_solver_solves_problems_with_tangential_compliance_as_lemkes_method_does() {
    let mut draw = Draw(161_803);
    let mut dense = Box::new(Dense::<f64, 98>::new());
    for case in 0..40 {
        let (points, bodies) = draw_grasp(&mut draw, case, 0.6, 2e6);
        let problem = as_factors(&points, &bodies);
        let theirs = lemke(&mut dense, &problem);
        let mut solver = Box::new(stickslip_shared::lcp::contact::ContactSolver::<f64, CAPACITY, 7>::new());
        let ours = solver.solve(&problem).solved().expect("the contact solver solves it");
        let mut z = vec![0.0; problem.unknowns()];
        ours.write_unknowns(&mut z);
        assert!(problem.residual(&z).value() < 1e-8, "case {case}");
        for (a, b) in ours.velocity_change.iter().zip(&theirs.velocity_change) {
            assert!((a - b).abs() < 1e-5, "case {case}: {a} {b}");
        }
    }
}

/// Slip of a point at the velocity found, with its bias.
fn slip_at(p: &ContactPoint<f64>, v: &[f64; 7]) -> [f64; 2] {
    let at = Vec3::new(v[0], v[1], v[2]) + Vec3::new(v[3], v[4], v[5]).cross(&p.lever_m);
    [1, 2].map(|k| p.axes[k].dot(&at) + p.bias_m_s[k])
}

#[test]
fn friction_lies_between_pyramid_and_cone_and_never_drives() {
    for edges in [4, 8, 16] {
        let mut draw = Draw(4242);
        let params = PyramidParams { edges, ..PyramidParams::default() };
        let bound_share = (std::f64::consts::PI / f64::from(edges)).cos();
        let mut slid = 0;
        for case in 0..100 {
            let (points, bodies) = draw_grasp(&mut draw, case, 0.6, 1e7);
            let s = step::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default(), &params);
            assert_eq!(s.status, SolveStatus::Solved, "{edges} edges, case {case}");
            for (p, f) in points.iter().zip(&s.force_n) {
                assert!(f[0] >= 0.0, "a contact that pulls: {f:?}");
                let (bound, size) = (p.mu[0] * f[0], f[1].hypot(f[2]));
                assert!(size <= bound * (1.0 + 1e-9) + 1e-12, "outside the cone: {f:?}");
                let u = slip_at(p, &s.velocity);
                // What the compliance takes of the relative velocity is no slip.
                let slip = [0, 1].map(|k| u[k] + f[k + 1] / p.stiffness_n_s_m[k + 1]);
                let (power, speed) = (f[1] * slip[0] + f[2] * slip[1], slip[0].hypot(slip[1]));
                assert!(power <= 1e-7, "friction that drives: {power}");
                if f[0] > 1e-3 && speed > 1e-5 {
                    slid += 1;
                    assert!(size >= bound * bound_share * (1.0 - 1e-6), "{edges} edges: {size} of {bound}");
                    // The greatest dissipation of the pyramid.
                    assert!(-power >= bound * bound_share * speed * (1.0 - 1e-4), "{power} {bound} {speed}");
                }
            }
        }
        assert!(slid > 300, "only {slid} points slide");
    }
}

#[test]
fn with_more_edges_body_forces_come_nearer_to_the_cones() {
    // Pyramids that do not turn: what is left is the set of forces.
    let worst = |edges: u8| {
        let mut draw = Draw(31);
        let params = PyramidParams { edges, turns: 0, ..PyramidParams::default() };
        let mut errors = Vec::new();
        for case in 0..60 {
            let (points, bodies) = draw_grasp(&mut draw, case, 0.5, 1e6);
            let exact = cone::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default());
            let ours = step::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default(), &params);
            assert_eq!((exact.status, ours.status), (SolveStatus::Solved, SolveStatus::Solved));
            let sum = |s: &Solution<f64, CAPACITY>| {
                points.iter().zip(&s.force_n).fold(Vec3::zeros(), |sum, (p, f)| {
                    sum + p.axes[0] * f[0] + p.axes[1] * f[1] + p.axes[2] * f[2]
                })
            };
            let scale = exact.force_n.iter().map(|f| f[0]).sum::<f64>();
            errors.push((sum(&exact) - sum(&ours)).norm() / scale);
        }
        errors.sort_by(f64::total_cmp);
        errors[errors.len() * 9 / 10]
    };
    let [four, eight, sixteen] = [4, 8, 16].map(worst);
    assert!(eight < four && sixteen < eight, "{four} {eight} {sixteen}");
    // Resultants over the sum of normal forces: below what the pyramid may lack of friction 0.5.
    let lacks = |edges: f64| 0.5 * (1.0 - (std::f64::consts::PI / edges).cos());
    assert!(sixteen < 2.0 * lacks(16.0), "{sixteen}");
}

#[test]
fn a_step_without_drive_gains_no_energy() {
    let mut draw = Draw(77);
    for case in 0..100 {
        let (mut points, mut bodies) = draw_grasp(&mut draw, case, 2.0, 1e7);
        points.iter_mut().for_each(|p| p.bias_m_s = [0.0; 3]);
        bodies.free = core::array::from_fn(|_| draw.within(-0.2, 0.2));
        let energy = |v: &[f64; 7]| {
            let linear: f64 = v[..3].iter().map(|v| v * v).sum::<f64>() * bodies.mass_kg;
            let turning: f64 = (0..3).map(|k| bodies.inertia_kg_m2[k][k] * v[3 + k] * v[3 + k]).sum();
            0.5 * (linear + turning + bodies.jaw_mass_kg * v[6] * v[6])
        };
        let s = step::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default(), &PyramidParams::default());
        assert_eq!(s.status, SolveStatus::Solved, "case {case}");
        assert!(energy(&s.velocity) <= energy(&bodies.free) * (1.0 + 1e-9), "case {case}");
    }
}

#[test]
fn high_friction_is_solved_always() {
    // Coefficients up to 3, where the cone leaves some unsolved: the path ends where Newton's method cycles.
    let mut draw = Draw(31_337);
    for case in 0..400 {
        let (points, bodies) = draw_grasp(&mut draw, case, 3.0, 1e7);
        let s = step::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default(), &PyramidParams::default());
        assert_eq!(s.status, SolveStatus::Solved, "case {case}");
    }
}

/// A body of 1 kg on one point below its centre, which can only move; nothing turns.
fn block(free: [f64; 3]) -> (ContactPoint<f64>, Bodies<f64>) {
    let k = 1e7 * 0.004;
    let point = ContactPoint {
        lever_m: Vec3::zeros(),
        axes: [Vec3::z(), Vec3::x(), Vec3::y()],
        jaw: 0.0,
        bias_m_s: [0.0; 3],
        stiffness_n_s_m: [k; 3],
        mu: [0.5; 2],
        adhesion_n: 0.0,
        viscous_n_s_m: 0.0,
    };
    let inertia_kg_m2 = [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]];
    let free = [free[0], free[1], free[2], 0.0, 0.0, 0.0, 0.0];
    (point, Bodies { mass_kg: 1.0, inertia_kg_m2, jaw_mass_kg: 1.0, dt_s: 0.004, free })
}

fn solve_one(point: ContactPoint<f64>, bodies: &Bodies<f64>) -> ([f64; 7], [f64; 3]) {
    let points: Points<f64> = [point].into_iter().collect();
    let s = step::solve(&points, bodies, &[0.0; 7], &SolveBudget::default(), &PyramidParams::default());
    assert_eq!(s.status, SolveStatus::Solved);
    (s.velocity, s.force_n[0])
}

fn near(a: f64, b: f64, within: f64) {
    assert!((a - b).abs() <= within, "{a} {b}");
}

#[test]
fn one_point_opens_sticks_and_slips_as_by_hand() {
    // 1 kg and 4 ms: 0.04 m/s of approach are 10 N.
    let (point, bodies) = block([0.1, 0.0, 0.02]);
    let (v, f) = solve_one(point, &bodies);
    assert_eq!(f, [0.0; 3], "it flies");
    near(v[0], 0.1, 1e-12);

    let (point, bodies) = block([0.01, 0.005, -0.04]);
    let (v, f) = solve_one(point, &bodies);
    near(f[0], 10.0, 0.1);
    near(f[1], -2.5, 0.05);
    near(f[2], -1.25, 0.05);
    near(v[0].hypot(v[1]), 0.0, 1e-3);

    // 5 N of friction take 0.02 m/s against the slip, whatever its direction.
    for angle in [0.0, 0.3, 1.0, 2.5, -1.7] {
        let (s, c) = f64::sin_cos(angle);
        let (point, bodies) = block([0.1 * c, 0.1 * s, -0.04]);
        let (v, f) = solve_one(point, &bodies);
        near(f[1], -0.5 * f[0] * c, 1e-6);
        near(f[2], -0.5 * f[0] * s, 1e-6);
        near(v[0].hypot(v[1]), 0.1 - 0.5 * f[0] * 0.004, 1e-6);
    }
}

#[test]
fn one_point_adheres_and_has_no_friction_and_is_anisotropic_as_by_hand() {
    let (point, bodies) = block([0.0, 0.0, 0.01]);
    let (v, f) = solve_one(ContactPoint { adhesion_n: 5.0, ..point }, &bodies);
    near(f[0], -2.5, 0.05);
    near(v[2], 0.0, 1e-3);
    let (_, f) = solve_one(ContactPoint { adhesion_n: 1.0, ..point }, &bodies);
    near(f[0], -1.0, 1e-9);

    let (point, bodies) = block([0.1, 0.0, -0.04]);
    let (v, f) = solve_one(ContactPoint { mu: [0.0; 2], ..point }, &bodies);
    assert_eq!(f[1..], [0.0, 0.0]);
    near(v[0], 0.1, 1e-12);

    // Half the friction along the second tangent: stiffness in proportion to mu^2, as the step has it.
    let (point, bodies) = block([0.06, 0.08, -0.04]);
    let k = point.stiffness_n_s_m[1];
    let odd = ContactPoint { mu: [0.5, 0.25], stiffness_n_s_m: [k, k, 0.25 * k], ..point };
    let (_, f) = solve_one(odd, &bodies);
    let used = (f[1] / (0.5 * f[0])).hypot(f[2] / (0.25 * f[0]));
    near(used, 1.0, 1e-6);
    let points: Points<f64> = [odd].into_iter().collect();
    let exact = cone::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default());
    near(f[1], exact.force_n[0][1], 1e-3);
    near(f[2], exact.force_n[0][2], 1e-3);
}

#[test]
fn viscous_friction_is_that_of_the_cone() {
    let (point, bodies) = block([0.1, 0.03, -0.04]);
    let viscous = ContactPoint { viscous_n_s_m: 20.0, ..point };
    let (_, f) = solve_one(viscous, &bodies);
    let points: Points<f64> = [viscous].into_iter().collect();
    let exact = cone::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default());
    for (a, b) in f.iter().zip(&exact.force_n[0]) {
        near(*a, *b, 1e-3);
    }
    assert!(f[1].abs() > 0.5 * f[0] * 0.95, "viscosity adds to Coulomb's friction: {f:?}");
}

#[test]
fn a_step_like_the_last_takes_no_factorisation_and_one_that_hardly_differs_those_at_hand() {
    let mut draw = Draw(5);
    let (points, bodies) = draw_grasp(&mut draw, 0, 0.5, 1e7);
    let first = step::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default(), &PyramidParams::default());
    let (mut given, mut paths) = (step::Points::<f64, CAPACITY>::new(), Paths::<f64, CAPACITY>::new());
    for (p, f) in points.iter().zip(&first.force_n) {
        let load_n = f[0];
        let slides = f[1].hypot(f[2]) > 0.999 * p.mu[0] * f[0];
        let before = match (load_n > 0.0, slides) {
            (false, _) => Before::Open,
            (true, true) => Before::Slid { load_n },
            (true, false) => Before::Stuck { load_n },
        };
        let spring_m = [1, 2].map(|k| -f[k] * bodies.dt_s / p.stiffness_n_s_m[k]);
        given.add(p, Some(Past { before, spring_m }));
    }
    let (budget, params) = (SolveBudget::present(), PyramidParams::default());
    let mut kept = Kept::nothing();
    let forces = |paths: &Paths<f64, CAPACITY>| paths.answers().iter().map(|a| a.force_n).collect::<Vec<_>>();
    let near_all = |one: &[[f64; 3]], other: &[[f64; 3]], within: f64| {
        assert_eq!(one.len(), other.len());
        one.iter().flatten().zip(other.iter().flatten()).for_each(|(a, b)| near(*a, *b, within));
    };
    // The same once more: the answer is there already.
    let again = paths.solve(&mut given, &bodies, &first.velocity, &budget, &params, &mut kept);
    assert_eq!((again.status, again.iterations, again.evaluations), (SolveStatus::Solved, 0, 1));
    near_all(&forces(&paths), &first.force_n, 1e-6);

    // A push that is a thousandth harder: solved once, then with the factors of that, in a step a little longer too.
    let harder = |by: f64| Bodies { free: bodies.free.map(|v| v * by), ..bodies };
    let moved = paths.solve(&mut given, &harder(1.001), &first.velocity, &budget, &params, &mut kept);
    assert_eq!((moved.status, moved.iterations), (SolveStatus::Solved, 1));
    let once =
        paths.solve(&mut given, &harder(1.002), &moved.velocity, &budget, &params, &mut Kept::nothing());
    let expected = forces(&paths);
    let repeated = paths.solve(&mut given, &harder(1.002), &moved.velocity, &budget, &params, &mut kept);
    assert_eq!((once.iterations, repeated.status, repeated.iterations), (1, SolveStatus::Solved, 0));
    near_all(&forces(&paths), &expected, 1e-6);
    let longer = Bodies { dt_s: bodies.dt_s * 1.0001, ..harder(1.003) };
    let repeated = paths.solve(&mut given, &longer, &repeated.velocity, &budget, &params, &mut kept);
    assert_eq!((repeated.status, repeated.iterations), (SolveStatus::Solved, 0));
}

#[test]
fn pyramids_that_turn_are_paid_for_and_are_not_turned_without_work_that_is_left() {
    let mut draw = Draw(31);
    let turned = PyramidParams::default();
    let still = PyramidParams { turns: 0, ..turned };
    let mut count = 0;
    for case in 0..40 {
        let (points, bodies) = draw_grasp(&mut draw, case, 0.3, 1e7);
        let solve = |budget: &SolveBudget<f64>, params| {
            let s = step::solve(&points, &bodies, &[0.0; 7], budget, params);
            assert_eq!(s.status, SolveStatus::Solved, "case {case}");
            // A factorisation is four.
            (s.velocity, 4 * s.iterations + s.evaluations)
        };
        let unbounded = SolveBudget::default();
        let (before, alone) = solve(&unbounded, &still);
        let (after, work) = solve(&unbounded, &turned);
        if after == before {
            continue;
        }
        count += 1;
        // A matrix, its factors and the rows, and the balance that tells whether it serves.
        assert!(work >= alone + 4, "case {case}: {work}, without turns {alone}");
        let within = SolveBudget { max_work: alone + 3, usual_points: MAX_POINTS as u32, ..unbounded };
        assert_eq!(solve(&within, &turned), (before, alone), "case {case}");
    }
    assert!(count > 10, "{count} of 40 turned");
}

#[test]
fn single_precision_mostly_finds_the_same_velocity() {
    let mut draw = Draw(2024);
    let (mut solved, mut near) = (0, 0);
    for case in 0..100 {
        let (points, bodies) = draw_grasp(&mut draw, case, 0.5, 1e7);
        let wide =
            step::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default(), &PyramidParams::default());
        let (narrow_points, narrow_bodies) = narrow(&points, &bodies);
        let small = step::solve(
            &narrow_points,
            &narrow_bodies,
            &[0.0; 7],
            &SolveBudget::default(),
            &PyramidParams::default(),
        );
        if small.status != SolveStatus::Solved {
            continue;
        }
        solved += 1;
        let change = wide.velocity.iter().zip(&small.velocity).map(|(a, b)| (a - b.to_f64()).abs());
        near += usize::from(change.fold(0.0, f64::max) < 2e-3);
    }
    // The rest turn their pyramids otherwise, within the bound.
    assert!(solved >= 98 && near >= 90, "{solved} of 100 solved, {near} near");
}

#[test]
fn what_is_not_a_number_is_never_called_solved() {
    let mut draw = Draw(5);
    let (points, bodies) = draw_grasp(&mut draw, 0, 0.5, 1e7);
    let solved = |points: &Points<f64>, bodies: &Bodies<f64>| {
        let s = step::solve(points, bodies, &[0.0; 7], &SolveBudget::default(), &PyramidParams::default());
        s.status == SolveStatus::Solved
    };
    let mut bad = points.clone();
    bad[3].mu = [f64::NAN; 2];
    assert!(!solved(&bad, &bodies));
    let mut bad = points.clone();
    bad[3].bias_m_s[1] = f64::INFINITY;
    assert!(!solved(&bad, &bodies));
    let mut bad = points.clone();
    bad[0].stiffness_n_s_m[0] = 0.0;
    assert!(!solved(&bad, &bodies));
    assert!(!solved(&points, &Bodies { mass_kg: -1.0, ..bodies }));
    assert!(!solved(&points, &Bodies { dt_s: f64::NAN, ..bodies }));
}
