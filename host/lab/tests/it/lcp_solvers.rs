//! The complementarity solvers against enumeration, known examples, each other and bad input.

use proptest::prelude::*;
use rand::Rng;
use stickslip_lab::hunt::problem::single;
use stickslip_lcp::files::Factors;
use stickslip_lcp::generate::{
    DenseFamily, FAMILIES, Family, IMPOSSIBLE, contact_problem, dense_problem, neighbour, rng, to_problem,
};
use stickslip_shared::lcp::contact::ContactSolver;
use stickslip_shared::lcp::dense::Dense;
use stickslip_shared::lcp::fallback::Fallback;
use stickslip_shared::lcp::{Defect, Path, SolveStatus, residual, tolerance};

fn dense() -> Box<Dense<f64, 64>> {
    Box::new(Dense::new())
}

fn contact() -> Box<ContactSolver<f64, 16, 8>> {
    Box::new(ContactSolver::new())
}

/// Residual of `z` by the dense rows of the factors.
fn exact(factors: &Factors, z: &[f64]) -> f64 {
    let (m, q) = factors.dense();
    residual::dense(&m, &q, z).value()
}

/// Every choice of basis: the solutions, where the equations of a basis are regular.
fn enumerate(m: &[f64], q: &[f64]) -> Vec<Vec<f64>> {
    let n = q.len();
    let mut found = Vec::new();
    for mask in 0..1_u32 << n {
        let basis: Vec<usize> = (0..n).filter(|i| mask >> i & 1 == 1).collect();
        if basis.is_empty() {
            if residual::dense(m, q, &vec![0.0; n]).value() <= 1e-9 {
                found.push(vec![0.0; n]);
            }
            continue;
        }
        let a = nalgebra::DMatrix::from_fn(basis.len(), basis.len(), |r, c| m[basis[r] * n + basis[c]]);
        let b = nalgebra::DVector::from_fn(basis.len(), |r, _| -q[basis[r]]);
        let Some(x) = a.lu().solve(&b) else { continue };
        let mut z = vec![0.0; n];
        for (&i, &value) in basis.iter().zip(x.iter()) {
            z[i] = value;
        }
        if residual::dense(m, q, &z).value() <= 1e-9 {
            found.push(z);
        }
    }
    found
}

#[test]
fn dense_agrees_with_enumeration_on_whether_a_small_random_problem_has_a_solution() {
    let rng = &mut rng(7);
    let mut solver = dense();
    let (mut with, mut refused) = (0, 0);
    for _ in 0..400 {
        let n = rng.random_range(1..=5);
        // Small integers: singular bases, ties and problems without solution are common.
        let m: Vec<f64> = (0..n * n).map(|_| f64::from(rng.random_range(-2..=3_i32))).collect();
        let q: Vec<f64> = (0..n).map(|_| f64::from(rng.random_range(-3..=2_i32))).collect();
        let solutions = enumerate(&m, &q);
        let outcome = solver.solve(&m, &q);
        match outcome.solved() {
            Some(z) => {
                assert!(residual::dense(&m, &q, z).value() <= 1e-8);
                with += 1;
            }
            // For a general matrix a ray does not prove that there is no solution.
            None => {
                assert_ne!(outcome.report().status, SolveStatus::Solved);
                refused += usize::from(solutions.is_empty());
            }
        }
    }
    assert!(with > 150 && refused > 20, "{with} solved, {refused} without solution refused");
}

#[test]
fn dense_finds_the_one_solution_of_every_p_matrix_problem() {
    let mut solver = dense();
    for seed in 0..40 {
        for family in [DenseFamily::Spd, DenseFamily::Pmat] {
            let (m, q) = dense_problem(family, 6, seed);
            let only = enumerate(&m, &q);
            let z = solver.solve(&m, &q).solved().expect("a P-matrix has a solution").to_vec();
            let near = only.iter().any(|x| x.iter().zip(&z).all(|(a, b)| (a - b).abs() < 1e-6));
            assert!(near, "{family:?} {seed}: {z:?} is none of {only:?}");
        }
    }
}

#[test]
fn dense_solves_copositive_problems_of_every_size() {
    let mut solver = dense();
    for seed in 0..20 {
        for n in [1, 2, 8, 32, 60] {
            let (m, q) = dense_problem(DenseFamily::Copos, n, seed);
            assert!(solver.solve(&m, &q).solved().is_some(), "n {n} seed {seed}");
        }
    }
}

#[test]
fn murtys_example_is_solved_though_it_can_take_exponentially_many_pivots() {
    // Murty 1978: lower triangular, ones on the diagonal, twos below; q = -1.
    let mut solver = dense();
    for n in [3, 8, 16, 24] {
        let m: Vec<f64> = (0..n * n)
            .map(|k| match (k / n).cmp(&(k % n)) {
                std::cmp::Ordering::Equal => 1.0,
                std::cmp::Ordering::Greater => 2.0,
                std::cmp::Ordering::Less => 0.0,
            })
            .collect();
        let outcome = solver.solve(&m, &vec![-1.0; n]);
        let report = outcome.report();
        // z = (1, 0, ..., 0).
        let z = outcome.solved().expect("a P-matrix has a solution");
        assert!((z[0] - 1.0).abs() < 1e-9 && z[1..].iter().all(|x| x.abs() < 1e-9));
        assert!(report.pivots <= 16 * (20 * n as u32 + 50));
    }
}

#[test]
fn degenerate_example_that_cycles_without_lexicography_is_solved() {
    // Kostreva 1979 (Cottle, Pang and Stone 1992, 4.4): cycles under least-index-free ties.
    let m = [1.0, 2.0, 0.0, 0.0, 1.0, 2.0, 2.0, 0.0, 1.0];
    let z = dense().solve(&m, &[-1.0; 3]).solved().expect("a P-matrix has a solution").to_vec();
    assert!(z.iter().all(|x| (x - 1.0 / 3.0).abs() < 1e-9), "{z:?}");
}

#[test]
fn problem_without_a_solution_is_reported_as_a_ray() {
    // w1 = -z2 - 1 is negative for every z >= 0.
    let report = dense().solve(&[0.0, -1.0, 1.0, 0.0], &[-1.0, 0.0]).report();
    assert_eq!(report.status, SolveStatus::Contradiction);
}

/// Two rigid walls that approach each other with the object in between.
fn crushed() -> Factors {
    let mut problem = contact_problem(Family::Opposite, 4, 3);
    let freedoms = problem.inverse_mass.len();
    for k in 6..freedoms {
        problem.inverse_mass[k] = 0.0;
    }
    problem.compliance.fill(0.0);
    for q in &mut problem.constant[..4] {
        *q = -0.1;
    }
    problem
}

#[test]
fn object_between_two_advancing_walls_is_not_solved_and_said_to_be_a_ray() {
    let problem = to_problem::<16, 8>(&crushed()).expect("fits");
    let cold = contact().solve(&problem).report();
    assert_ne!(cold.status, SolveStatus::Solved);
    let mut both = Box::new(Fallback::<f64, 16, 8, 98, 9216>::new());
    let report = both.solve(&problem).report();
    assert_eq!(report.status, SolveStatus::Contradiction, "{report:?}");
}

#[test]
fn problems_made_without_a_solution_are_never_claimed_and_said_to_have_none() {
    let mut both = Box::new(Fallback::<f64, 16, 8, 98, 9216>::new());
    let mut rays = 0;
    for family in IMPOSSIBLE {
        for seed in 0..100 {
            let factors = contact_problem(family, [2, 6, 9, 10][(seed % 4) as usize], seed);
            // Rows that cancel: the sum of these speeds is that of the constants.
            let group = if family == Family::Wedged { 3 } else { 0 };
            if group > 0 {
                assert!(factors.constant[..group].iter().sum::<f64>() < 0.0);
            }
            let problem = to_problem::<16, 8>(&factors).expect("fits");
            both.contact.forget();
            let report = both.solve(&problem).report();
            assert_ne!(report.status, SolveStatus::Solved, "{family:?} {seed}");
            rays += usize::from(report.status == SolveStatus::Contradiction);
            let (m, q) = factors.dense();
            let report = dense().solve(&m, &q).report();
            assert_eq!(report.status, SolveStatus::Contradiction, "{family:?} {seed}");
            // By a proof after the first run, not by the failure of every other one.
            assert!(report.pivots as usize <= 10 * q.len() + 70, "{family:?} {seed}: {report:?}");
        }
    }
    assert!(rays >= 198, "{rays} of 200 said to have no solution");
}

#[test]
fn contact_solver_solves_every_family_to_the_tolerance_by_the_dense_rows() {
    let mut solver = contact();
    for family in FAMILIES {
        for seed in 0..60 {
            let contacts = [2, 6, 9, 10][(seed % 4) as usize];
            let factors = contact_problem(family, contacts, seed);
            let problem = to_problem::<16, 8>(&factors).expect("fits");
            solver.forget();
            let outcome = solver.solve(&problem);
            let report = outcome.report();
            let impulses = outcome.solved().unwrap_or_else(|| panic!("{family:?} {seed} {report:?}"));
            let mut z = vec![0.0; problem.unknowns()];
            impulses.write_unknowns(&mut z);
            let residual = exact(&factors, &z);
            assert!(residual <= 1e-8, "{family:?} {seed}: {residual:e}");
            // The certificate bounds the residual from above.
            assert!(residual <= report.residual * (1.0 + 1e-6) + 1e-15, "{family:?} {seed}");
        }
    }
}

#[test]
fn dense_solver_solves_the_same_contact_problems() {
    let mut solver = dense();
    for family in FAMILIES {
        for seed in 0..12 {
            let factors = contact_problem(family, [2, 6, 9, 10][(seed % 4) as usize], seed);
            let (m, q) = factors.dense();
            let outcome = solver.solve(&m, &q);
            assert!(outcome.solved().is_some(), "{family:?} {seed} {:?}", outcome.report());
        }
    }
}

#[test]
fn contact_solver_agrees_with_enumeration_for_one_and_two_contacts() {
    let mut solver = contact();
    for seed in 0..10 {
        let mut factors = contact_problem(Family::Approach, 2, seed);
        factors.compliance.fill(1.0);
        let (m, q) = factors.dense();
        let solutions = enumerate(&m, &q);
        assert!(!solutions.is_empty());
        let problem = to_problem::<16, 8>(&factors).expect("fits");
        solver.forget();
        let impulses = solver.solve(&problem).solved().expect("solved").clone();
        let near = solutions.iter().any(|z| (0..2).all(|i| (z[i] - impulses.normal[i]).abs() < 1e-6));
        assert!(near, "{seed}: {:?} is none of {solutions:?}", impulses.normal);
    }
}

#[test]
fn unchanged_problem_is_verified_by_one_factorisation_and_a_changed_one_is_repaired() {
    let mut solver = contact();
    let (mut kept, mut solved) = (0, 0);
    for seed in 0..40 {
        let factors = contact_problem(Family::Approach, 10, seed);
        let problem = to_problem::<16, 8>(&factors).expect("fits");
        solver.forget();
        let _ = solver.solve(&problem);
        let again = solver.solve(&problem).report();
        assert_eq!(again.status, SolveStatus::Solved);
        kept += usize::from(again.path == Path::Warm && again.pivots <= 2);
        let next = to_problem::<16, 8>(&neighbour(&factors, 1e-2, seed)).expect("fits");
        solved += usize::from(solver.solve(&next).report().status == SolveStatus::Solved);
    }
    assert!(kept >= 36, "{kept} of 40 verified");
    assert_eq!(solved, 40);
}

#[test]
fn a_solve_after_forgetting_gives_the_same_bits() {
    let (mut first, mut second) = (contact(), contact());
    for seed in 0..20 {
        let factors = contact_problem(Family::Force, 10, seed);
        let problem = to_problem::<16, 8>(&factors).expect("fits");
        first.forget();
        second.forget();
        let one = first.solve(&problem).best().0.clone();
        let two = second.solve(&problem).best().0.clone();
        assert!(one.normal.iter().zip(&two.normal).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}

#[test]
fn single_precision_solves_grasps_to_its_tolerance() {
    let mut solver = Box::new(ContactSolver::<f32, 16, 8>::new());
    let mut solved = 0;
    for seed in 0..100 {
        let factors = contact_problem(Family::Approach, 10, seed);
        let problem = single(&to_problem::<16, 8>(&factors).expect("fits"));
        solver.forget();
        let outcome = solver.solve(&problem);
        if let Some(impulses) = outcome.solved() {
            let mut z = vec![0.0; problem.unknowns()];
            impulses.write_unknowns(&mut z);
            assert!(problem.residual(&z).value() <= 2.0 * tolerance::<f32>());
            solved += 1;
        }
    }
    assert!(solved >= 95, "{solved} of 100");
}

#[test]
fn bad_numbers_are_refused_with_their_kind() {
    let good = to_problem::<16, 8>(&contact_problem(Family::Force, 6, 1)).expect("fits");
    let mut solver = contact();
    let mut check = |change: &dyn Fn(&mut stickslip_shared::lcp::factors::Factors<f64, 16, 8>),
                     defect: Defect| {
        let mut bad = good.clone();
        change(&mut bad);
        let report = solver.solve(&bad).report();
        assert_eq!((report.status, report.defect), (SolveStatus::BadInput, Some(defect)));
        assert!(solver.solve(&bad).solved().is_none());
    };
    check(&|p| p.contacts.clear(), Defect::Empty);
    check(&|p| p.inverse_mass[1] = -1.0, Defect::Mass);
    check(&|p| p.inverse_mass[1] = f64::INFINITY, Defect::NotFinite);
    check(&|p| p.contacts[2].friction = -0.1, Defect::Friction);
    check(&|p| p.contacts[2].friction = 10.5, Defect::Friction);
    check(&|p| p.contacts[0].compliance = -1e-9, Defect::Compliance);
    check(&|p| p.contacts[5].separation = f64::NAN, Defect::NotFinite);
    check(&|p| p.contacts[5].normal[2] = f64::INFINITY, Defect::NotFinite);
    check(
        &|p| {
            p.contacts[0].normal = [0.0; 8];
            p.contacts[0].tangents = [[0.0; 8]; 2];
        },
        Defect::Direction,
    );
    assert_eq!(dense().solve(&[], &[]).report().defect, Some(Defect::Empty));
    assert_eq!(dense().solve(&[1.0], &[1.0; 2]).report().defect, Some(Defect::Size));
    let wide = dense().solve(&[f64::NAN], &[1.0]).report().defect;
    assert_eq!(wide, Some(Defect::NotFinite));
}

fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -1.0..1.0_f64,
        2 => Just(0.0),
        1 => Just(1e-300),
        1 => Just(-1e300),
        1 => -1e9..1e9_f64,
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_numbers_give_a_status_and_never_a_false_claim(
        m in prop::collection::vec(wild(), 36),
        q in prop::collection::vec(wild(), 6),
    ) {
        let mut solver = dense();
        if let Some(z) = solver.solve(&m, &q).solved() {
            prop_assert!(residual::dense(&m, &q, z).value() <= 1e-8);
        }
    }

    #[test]
    fn any_contact_numbers_give_a_status_and_never_a_false_claim(
        seed in 0..1000_u64,
        changes in prop::collection::vec((0..200_usize, wild()), 0..4),
    ) {
        let mut factors = contact_problem(Family::Scattered, 6, seed);
        for (place, value) in changes {
            let list = [place % 5, place / 5];
            match list {
                [0, k] => { let n = factors.inverse_mass.len(); factors.inverse_mass[k % n] = value; }
                [1, k] => factors.compliance[k % 6] = value,
                [2, k] => factors.friction[k % 6] = value,
                [3, k] => factors.constant[k % 6] = value,
                [_, k] => factors.jacobian[k % 36] = value,
            }
        }
        if let Some(problem) = to_problem::<16, 8>(&factors) {
            let mut solver = contact();
            for _ in 0..2 {
                if let Some(impulses) = solver.solve(&problem).solved() {
                    let mut z = vec![0.0; problem.unknowns()];
                    impulses.write_unknowns(&mut z);
                    let value = exact(&factors, &z);
                    prop_assert!(value <= 1e-8, "{}", value);
                }
            }
        }
    }
}
