//! Contact problems as candidates: of the generated families, changed number by number.

use std::cell::RefCell;

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use stickslip_shared::lcp::contact::ContactSolver;
use stickslip_shared::lcp::factors::{Contact, Factors as Problem, Impulses};
use stickslip_shared::lcp::{SolveStatus, tolerance};

use super::Target;
use super::search::Candidate;
use stickslip_lcp::files::Factors;
use stickslip_lcp::generate::{FAMILIES, contact_problem, to_problem};
use stickslip_lcp::solve::{Judged, Solver, Solvers};

/// Contacts of a candidate.
const CONTACTS: usize = 10;
/// Degrees of freedom of every candidate: those that a family does not use do not move.
const FREEDOMS: usize = 8;

impl Candidate for Factors {
    fn fresh(rng: &mut ChaCha8Rng) -> Self {
        let family = FAMILIES[rng.random_range(0..FAMILIES.len())];
        let mut problem = widened(contact_problem(family, CONTACTS, rng.random()));
        for _ in 0..rng.random_range(0..4) {
            change(&mut problem, rng);
        }
        problem
    }

    fn mutated(&self, rng: &mut ChaCha8Rng) -> Self {
        let mut problem = self.clone();
        for _ in 0..rng.random_range(1..5) {
            change(&mut problem, rng);
        }
        problem
    }

    fn mixed(&self, other: &Self, rng: &mut ChaCha8Rng) -> Self {
        let mut problem = self.clone();
        for i in 0..contacts(self).min(contacts(other)) {
            if rng.random_bool(0.5) {
                copy_contact(other, i, &mut problem, i);
            }
        }
        problem
    }
}

fn contacts(p: &Factors) -> usize {
    p.friction.len()
}

/// All candidates have eight degrees of freedom, so that they mix and share a file.
fn widened(p: Factors) -> Factors {
    let own = p.inverse_mass.len();
    let mut jacobian = Vec::new();
    for row in p.jacobian.chunks_exact(own) {
        jacobian.extend_from_slice(row);
        jacobian.resize(jacobian.len() + FREEDOMS - own, 0.0);
    }
    let mut inverse_mass = p.inverse_mass;
    inverse_mass.resize(FREEDOMS, 0.0);
    Factors { jacobian, inverse_mass, ..p }
}

/// Rows of a contact: its normal, and t1, t2, -t1, -t2.
fn rows(p: &Factors, contact: usize) -> [usize; 5] {
    let first = contacts(p) + 4 * contact;
    [contact, first, first + 1, first + 2, first + 3]
}

fn copy_contact(from: &Factors, i: usize, to: &mut Factors, j: usize) {
    for (a, b) in rows(from, i).into_iter().zip(rows(to, j)) {
        let source: Vec<f64> = from.jacobian[a * FREEDOMS..(a + 1) * FREEDOMS].to_vec();
        to.jacobian[b * FREEDOMS..(b + 1) * FREEDOMS].copy_from_slice(&source);
        to.constant[b] = from.constant[a];
    }
    to.friction[j] = from.friction[i];
    to.compliance[j] = from.compliance[i];
}

/// Makes the third and fourth tangent the opposites of the first two again.
fn mirror(p: &mut Factors) {
    for i in 0..contacts(p) {
        let [_, t1, t2, o1, o2] = rows(p, i);
        for (from, to) in [(t1, o1), (t2, o2)] {
            p.constant[to] = -p.constant[from];
            for k in 0..FREEDOMS {
                p.jacobian[to * FREEDOMS + k] = -p.jacobian[from * FREEDOMS + k];
            }
        }
    }
}

/// One change, from tiny to drastic, within what contacts of bodies can be.
fn change(p: &mut Factors, rng: &mut ChaCha8Rng) {
    let count = contacts(p);
    let (i, j) = (rng.random_range(0..count), rng.random_range(0..count));
    match rng.random_range(0..10) {
        0 => p.friction[i] = [0.0, 10.0, p.friction[j]][rng.random_range(0..3)],
        1 => p.friction[i] = 10f64.powf(rng.random_range(-3.0..1.0)),
        2 => {
            let source = p.clone();
            copy_contact(&source, i, p, j);
        }
        3 => p.compliance[i] = 0.0,
        4 => p.compliance[i] = 10f64.powf(rng.random_range(-4.0..1.5)),
        5 => {
            let k = rng.random_range(0..FREEDOMS);
            let scaled = p.inverse_mass[k] * 10f64.powf(rng.random_range(-1.5..1.5));
            p.inverse_mass[k] = if scaled == 0.0 { 0.0 } else { scaled.clamp(1e-6, 1e7) };
        }
        6 => p.constant[i] = p.constant[j],
        7 => p.constant[i] = rng.random_range(-0.2..0.1),
        8 => {
            // Ties: what is left has few digits.
            let grid = 10f64.powi(rng.random_range(-5..-1));
            let row = rows(p, i)[rng.random_range(0..3)];
            p.constant[row] = (p.constant[row] / grid).round() * grid;
            for x in &mut p.jacobian[row * FREEDOMS..(row + 1) * FREEDOMS] {
                *x = (*x / grid).round() * grid;
            }
        }
        _ => {
            let size = 10f64.powf(rng.random_range(-8.0..-0.3));
            for row in rows(p, i).into_iter().take(3) {
                p.constant[row] *= 1.0 + size * rng.random_range(-1.0..1.0);
                for x in &mut p.jacobian[row * FREEDOMS..(row + 1) * FREEDOMS] {
                    *x *= 1.0 + size * rng.random_range(-1.0..1.0);
                }
            }
        }
    }
    mirror(p);
}

/// What the solvers make of a candidate.
pub struct Verdict {
    /// Contact solver, cold, then the dense one where it failed.
    pub contact: Judged,
    /// Dense solver.
    pub dense: Judged,
}

thread_local! {
    static SOLVERS: RefCell<Solvers> = RefCell::default();
    static NARROW: RefCell<Box<ContactSolver<f32, 16, FREEDOMS>>> = RefCell::default();
}

/// Solves by both; `None` where the problem exceeds the solvers' capacity.
#[must_use]
pub fn verdict(p: &Factors) -> Option<Verdict> {
    SOLVERS.with_borrow_mut(|solvers| {
        let contact = solvers.judge_factors(p, Solver::Contact, 1).ok()?;
        let dense = solvers.judge_factors(p, Solver::Dense, 1).ok()?;
        Some(Verdict { contact, dense })
    })
}

/// Velocities that `z` gives each degree of freedom.
fn velocities(p: &Factors, z: &[f64]) -> Vec<f64> {
    let freedoms = p.inverse_mass.len();
    (0..freedoms)
        .map(|k| {
            let sum: f64 =
                p.jacobian.chunks_exact(freedoms).zip(z).map(|(row, impulse)| row[k] * impulse).sum();
            sum * p.inverse_mass[k]
        })
        .collect()
}

/// Largest difference of the velocities, of the largest velocity (at least 1 mm/s).
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().take(3).chain(b.iter().take(3)).map(|x| x.abs()).fold(1e-3, f64::max);
    let apart = a.iter().zip(b).take(3).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    apart / largest
}

/// The same problem in single precision.
#[must_use]
pub fn single(p: &Problem<f64, 16, FREEDOMS>) -> Problem<f32, 16, FREEDOMS> {
    let contacts = p.contacts.iter().map(|c| Contact {
        normal: c.normal.map(|x| x as f32),
        tangents: c.tangents.map(|t| t.map(|x| x as f32)),
        compliance: c.compliance as f32,
        tangential_compliance: c.tangential_compliance as f32,
        friction: c.friction as f32,
        separation: c.separation as f32,
        slip: c.slip.map(|x| x as f32),
    });
    Problem { inverse_mass: p.inverse_mass.map(|x| x as f32), contacts: contacts.collect() }
}

/// Answer in single precision and whether it is claimed.
#[must_use]
pub fn in_single(p: &Factors) -> Option<(Impulses<f32, 16, FREEDOMS>, SolveStatus)> {
    let problem = single(&to_problem::<16, FREEDOMS>(p)?);
    NARROW.with_borrow_mut(|solver| {
        solver.forget();
        let (answer, report) = solver.solve(&problem).best();
        Some((answer.clone(), report.status))
    })
}

/// How far single precision is from a solution in double precision; zero where one has none.
fn single_apart(p: &Factors, wide: &Judged) -> f64 {
    match in_single(p) {
        Some((answer, SolveStatus::Solved)) if wide.report.status == SolveStatus::Solved => {
            let narrow: Vec<f64> = answer.velocity_change.iter().map(|x| f64::from(*x)).collect();
            apart(&velocities(p, &wide.answer.z), &narrow)
        }
        _ => 0.0,
    }
}

/// How bad a candidate is; zero where the target does not apply to it.
#[must_use]
pub fn score(target: Target, p: &Factors) -> f64 {
    // The dense solver takes a hundred times longer: it is asked where it counts.
    if matches!(target, Target::Pivots | Target::DensePivots | Target::Single) {
        let solver = if target == Target::DensePivots { Solver::Dense } else { Solver::Contact };
        let one = SOLVERS.with_borrow_mut(|solvers| solvers.judge_factors(p, solver, 1));
        let Ok(one) = one else { return 0.0 };
        return match target {
            Target::Single => single_apart(p, &one),
            _ => f64::from(one.report.pivots),
        };
    }
    let Some(Verdict { contact, dense }) = verdict(p) else { return 0.0 };
    let solved = |j: &Judged| j.report.status == SolveStatus::Solved;
    match target {
        Target::Residual => {
            [&contact, &dense].into_iter().filter(|j| solved(j)).map(|j| j.residual).fold(0.0, f64::max)
        }
        Target::Disagreement if solved(&contact) && solved(&dense) => {
            apart(&velocities(p, &contact.answer.z), &velocities(p, &dense.answer.z))
        }
        _ => 0.0,
    }
}

/// Most pivots that the two solvers may take on `contacts` contacts: documented bounds.
#[must_use]
pub fn most_pivots(contacts: usize) -> u32 {
    let nc = contacts as u32;
    let (contact, dense) = (4 * (12 * (20 * nc + 41) + 1), 16 * (20 * 6 * nc + 50));
    contact + dense
}

/// Whether a claim is below the tolerance, judged apart from the solver.
#[must_use]
pub fn honest(j: &Judged) -> bool {
    j.report.status != SolveStatus::Solved || j.residual <= tolerance::<f64>()
}
