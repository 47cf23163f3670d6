//! Problems that no rig has, solved by every solver, and hashed: numbers that are none, zero
//! and negative masses, singular inertias, no contacts, contacts all in one point, friction
//! beyond its bounds, objects crushed between advancing walls, magnitudes at the ends of the
//! range. Whatever the answers are, they must be the same bits everywhere.

use crate::Draw;
use heapless::Vec;
use stickslip_shared::cone::{self, Bodies, ContactPoint, SolveBudget, SolveStatus};
use stickslip_shared::lcp::contact::ContactSolver;
use stickslip_shared::lcp::dense::Dense;
use stickslip_shared::lcp::factors::{Contact, Factors, Impulses};
use stickslip_shared::lcp::step::{self, PyramidParams};
use stickslip_shared::lcp::{Path, Report};
use stickslip_shared::predictor::HASH_START;
use stickslip_shared::real::{Real, Vec3, sqrt};

/// Most contacts of a problem.
const CONTACTS: usize = 8;
/// Degrees of freedom of a problem.
const FREEDOMS: usize = 6;
/// Contacts whose dense form is solved as well.
const DENSE_CONTACTS: usize = 2;
/// Its unknowns.
const UNKNOWNS: usize = 6 * DENSE_CONTACTS;

/// What the solvers made of the problems.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answers {
    /// Of every number of every answer.
    pub hash: u32,
    /// Solved, by their own word.
    pub solved: u32,
    /// Refused as bad input.
    pub refused: u32,
    /// Everything else: marked as not solved.
    pub marked: u32,
}

impl Answers {
    fn take(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.hash = (self.hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    }

    fn number<R: Real>(&mut self, x: R) {
        let bits = x.canonical_bits();
        self.take(bits as u32);
        self.take((bits >> 32) as u32);
    }

    fn report<R: Real>(&mut self, report: Report<R>) {
        let status = match report.status {
            SolveStatus::Solved => 0,
            SolveStatus::Contradiction => 1,
            SolveStatus::IterationLimit => 2,
            SolveStatus::Numerical => 3,
            SolveStatus::BadInput => 4 + report.defect.map_or(0, |defect| defect as u32),
        };
        let path = match report.path {
            Path::Trivial => 0,
            Path::Warm => 1,
            Path::Repaired => 2,
            Path::Velocities => 3,
            Path::Lemke => 4,
            Path::Restarted(k) => 5 + u32::from(k),
        };
        self.count(report.status == SolveStatus::Solved, report.status == SolveStatus::BadInput);
        self.take(status);
        self.take(path);
        self.take(report.pivots);
        self.number(report.residual);
    }

    fn count(&mut self, solved: bool, refused: bool) {
        match (solved, refused) {
            (true, _) => self.solved += 1,
            (false, true) => self.refused += 1,
            (false, false) => self.marked += 1,
        }
    }

    fn impulses<R: Real>(&mut self, answer: &Impulses<R, CONTACTS, FREEDOMS>) {
        let tangential = answer.tangential.iter().flatten();
        for x in answer.normal.iter().chain(tangential).chain(&answer.slip).chain(&answer.velocity_change) {
            self.number(*x);
        }
    }
}

/// A number that spoils what it replaces.
fn wild(draw: &mut Draw) -> f32 {
    const WILD: [f32; 12] =
        [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, -1.0, 1e-38, 1e-45, 1e30, -1e30, 1e6, 1e-6];
    WILD.get(draw.below(WILD.len() as u32) as usize).copied().unwrap_or(0.0)
}

type Points = Vec<ContactPoint<f32>, CONTACTS>;

fn axes(draw: &mut Draw) -> [Vec3<f32>; 3] {
    let mut v = || Vec3::new(draw.within(-1.0, 1.0), draw.within(-1.0, 1.0), draw.within(-1.0, 1.0));
    let (a, b) = (v(), v());
    let n = a / stickslip_shared::real::max(sqrt(a.dot(&a)), 1e-3);
    let t = b - n * n.dot(&b);
    let t = t / stickslip_shared::real::max(sqrt(t.dot(&t)), 1e-3);
    [n, t, n.cross(&t)]
}

/// A contact problem of the time step: ordinary, then spoilt.
fn step_problem(draw: &mut Draw) -> (Points, Bodies<f32>) {
    let mut bodies = Bodies {
        mass_kg: 0.2,
        inertia_kg_m2: [[2e-5, 0.0, 0.0], [0.0, 1.8e-4, 0.0], [0.0, 0.0, 1.8e-4]],
        jaw_mass_kg: 0.3,
        dt_s: 0.004,
        free: [0.0; 7].map(|_: f32| draw.within(-0.1, 0.1)),
    };
    let mut points = Points::new();
    let crushed = draw.below(4) == 0;
    let coincident = draw.below(4) == 0;
    let (first_axes, first_at) = (axes(draw), [draw.within(-0.03, 0.03), draw.within(-0.03, 0.03)]);
    for k in 0..draw.below(CONTACTS as u32 + 1) {
        let mut axes = if coincident || crushed { first_axes } else { axes(draw) };
        if crushed && k % 2 == 1 {
            axes = [-axes[0], axes[1], -axes[2]];
        }
        let at = if coincident { first_at } else { [draw.within(-0.03, 0.03), draw.within(-0.03, 0.03)] };
        let approach = if crushed { draw.within(0.01, 100.0) } else { draw.within(-0.05, 0.1) };
        let stiffness = if draw.below(8) == 0 { draw.within(1.0, 1e9) } else { 4e4 };
        let mu = if draw.below(8) == 0 { draw.within(0.0, 10.0) } else { 0.4 };
        let point = ContactPoint {
            lever_m: axes[1] * at[0] + axes[2] * at[1] - axes[0] * 0.0125,
            axes,
            jaw: draw.below(2) as f32,
            bias_m_s: [-approach, draw.within(-0.02, 0.02), draw.within(-0.02, 0.02)],
            stiffness_n_s_m: [stiffness; 3],
            mu: [mu, if draw.below(8) == 0 { mu * 0.1 } else { mu }],
            adhesion_n: if draw.below(8) == 0 { draw.within(0.0, 5.0) } else { 0.0 },
            viscous_n_s_m: 0.0,
        };
        // As many as fit are asked for.
        let _ = points.push(point);
    }
    spoil_step(draw, &mut points, &mut bodies);
    (points, bodies)
}

fn spoil_step(draw: &mut Draw, points: &mut Points, bodies: &mut Bodies<f32>) {
    let x = wild(draw);
    let index = draw.below(CONTACTS as u32) as usize;
    let axis = draw.below(3) as usize;
    match draw.below(14) {
        0 => bodies.mass_kg = x,
        1 => bodies.dt_s = x,
        2 => bodies.jaw_mass_kg = x,
        3 => bodies.inertia_kg_m2[axis][axis] = x,
        4 => bodies.inertia_kg_m2[1][2] = x,
        5 => bodies.free[axis] = x,
        6 => bodies.mass_kg *= 1e-6,
        7 => {
            if let Some(p) = points.get_mut(index) {
                match draw.below(7) {
                    0 => p.lever_m[axis] = x,
                    1 => p.axes[axis].x = x,
                    2 => p.bias_m_s[axis] = x,
                    3 => p.stiffness_n_s_m[axis] = x,
                    4 => p.mu = [x; 2],
                    5 => p.adhesion_n = x,
                    _ => p.jaw = x,
                }
            }
        }
        // The rest is left as it is: hostile enough, or ordinary.
        _ => {}
    }
}

fn widened(points: &Points, bodies: &Bodies<f32>) -> (Vec<ContactPoint<f64>, CONTACTS>, Bodies<f64>) {
    let v = |v: &Vec3<f32>| Vec3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z));
    let points = points.iter().map(|p| ContactPoint {
        lever_m: v(&p.lever_m),
        axes: [v(&p.axes[0]), v(&p.axes[1]), v(&p.axes[2])],
        jaw: f64::from(p.jaw),
        bias_m_s: p.bias_m_s.map(f64::from),
        stiffness_n_s_m: p.stiffness_n_s_m.map(f64::from),
        mu: p.mu.map(f64::from),
        adhesion_n: f64::from(p.adhesion_n),
        viscous_n_s_m: 0.0,
    });
    let bodies = Bodies {
        mass_kg: f64::from(bodies.mass_kg),
        inertia_kg_m2: bodies.inertia_kg_m2.map(|row| row.map(f64::from)),
        jaw_mass_kg: f64::from(bodies.jaw_mass_kg),
        dt_s: f64::from(bodies.dt_s),
        free: bodies.free.map(f64::from),
    };
    (points.collect(), bodies)
}

fn solve_step<R: Real>(points: &Vec<ContactPoint<R>, CONTACTS>, bodies: &Bodies<R>, out: &mut Answers) {
    for options in [SolveBudget::present(), SolveBudget::look_ahead()] {
        let guess = [R::zero(); cone::DOF];
        let pyramids = step::solve(points, bodies, &guess, &options, &PyramidParams::default());
        for s in [cone::solve(points, bodies, &guess, &options), pyramids] {
            out.count(s.status == SolveStatus::Solved, s.status == SolveStatus::BadInput);
            out.take(s.status as u32);
            out.take(s.iterations);
            out.take(s.evaluations);
            for x in s.velocity.iter().chain(s.force_n.iter().flatten()).chain([&s.residual_n]) {
                out.number(*x);
            }
        }
    }
}

/// A complementarity problem of contacts: ordinary, then spoilt.
fn factors(draw: &mut Draw) -> Factors<f32, CONTACTS, FREEDOMS> {
    let mut problem = Factors { inverse_mass: [5.0, 5.0, 5.0, 4.8e4, 5.6e3, 5.6e3], contacts: Vec::new() };
    let crushed = draw.below(4) == 0;
    let coincident = draw.below(4) == 0;
    let first = axes(draw);
    for k in 0..draw.below(CONTACTS as u32 + 1) {
        let mut axes = if coincident || crushed { first } else { axes(draw) };
        if crushed && k % 2 == 1 {
            axes = [-axes[0], axes[1], -axes[2]];
        }
        let side = if coincident { 0.0 } else { draw.within(-0.01, 0.01) };
        let at = axes[1] * side - axes[0] * 0.0125;
        let row = |direction: &Vec3<f32>| {
            let turn = at.cross(direction);
            [direction.x, direction.y, direction.z, turn.x, turn.y, turn.z]
        };
        let contact = Contact {
            normal: row(&axes[0]),
            tangents: [row(&axes[1]), row(&axes[2])],
            compliance: if crushed || draw.below(2) == 0 { 0.0 } else { draw.within(1e-3, 1.0) },
            tangential_compliance: if draw.below(2) == 0 { 0.0 } else { draw.within(1e-3, 1.0) },
            friction: draw.within(0.0, 1.0),
            separation: if crushed { -0.1 } else { draw.within(-0.1, 0.05) },
            slip: [draw.within(-0.1, 0.1), draw.within(-0.1, 0.1)],
        };
        // As many as fit are asked for.
        let _ = problem.contacts.push(contact);
    }
    let x = wild(draw);
    let (index, freedom) = (draw.below(CONTACTS as u32) as usize, draw.below(FREEDOMS as u32) as usize);
    match (draw.below(12), problem.contacts.get_mut(index)) {
        (0, _) => problem.inverse_mass[freedom] = x,
        (1, _) => problem.inverse_mass = [0.0; FREEDOMS],
        (2, _) => problem.inverse_mass[freedom] *= 1e6,
        (3, Some(c)) => c.normal[freedom] = x,
        (4, Some(c)) => c.tangents[0][freedom] = x,
        (5, Some(c)) => c.compliance = x,
        (6, Some(c)) => c.friction = x,
        (7, Some(c)) => c.separation = x,
        (8, Some(c)) => c.slip[1] = x,
        _ => {}
    }
    problem
}

fn widened_factors(p: &Factors<f32, CONTACTS, FREEDOMS>) -> Factors<f64, CONTACTS, FREEDOMS> {
    let contacts = p.contacts.iter().map(|c| Contact {
        normal: c.normal.map(f64::from),
        tangents: c.tangents.map(|t| t.map(f64::from)),
        compliance: f64::from(c.compliance),
        tangential_compliance: f64::from(c.tangential_compliance),
        friction: f64::from(c.friction),
        separation: f64::from(c.separation),
        slip: c.slip.map(f64::from),
    });
    Factors { inverse_mass: p.inverse_mass.map(f64::from), contacts: contacts.collect() }
}

/// Solvers of one precision.
struct Solvers<R> {
    contact: ContactSolver<R, CONTACTS, FREEDOMS>,
    dense: Dense<R, { UNKNOWNS + 2 }>,
}

impl<R: Real> Solvers<R> {
    fn new() -> Self {
        Self { contact: ContactSolver::new(), dense: Dense::new() }
    }

    /// Cold, once more warm, and by the dense solver where it is small enough.
    fn solve(&mut self, problem: &Factors<R, CONTACTS, FREEDOMS>, out: &mut Answers) {
        self.contact.forget();
        for _ in 0..2 {
            let (answer, report) = self.contact.solve(problem).best();
            out.report(report);
            out.impulses(answer);
        }
        let mut small = problem.clone();
        small.contacts.truncate(DENSE_CONTACTS);
        let n = small.unknowns();
        let (mut m, mut q) = ([R::zero(); UNKNOWNS * UNKNOWNS], [R::zero(); UNKNOWNS]);
        let (Some(m), Some(q)) = (m.get_mut(..n * n), q.get_mut(..n)) else { return };
        // Without contacts there is nothing to write, and the dense solver refuses it.
        small.write_dense(m, q);
        let (z, report) = self.dense.solve(m, q).best();
        out.report(report);
        for x in z {
            out.number(*x);
        }
    }
}

/// Solves `rounds` problems of the time step and as many complementarity problems, in single
/// and in double precision.
pub fn run(seed: u32, rounds: u32) -> Answers {
    let mut draw = Draw(seed);
    let mut out = Answers { hash: HASH_START, solved: 0, refused: 0, marked: 0 };
    let (mut narrow, mut wide) = (Solvers::<f32>::new(), Solvers::<f64>::new());
    for _ in 0..rounds {
        let (points, bodies) = step_problem(&mut draw);
        solve_step(&points, &bodies, &mut out);
        let (points, bodies) = widened(&points, &bodies);
        solve_step(&points, &bodies, &mut out);
        let problem = factors(&mut draw);
        narrow.solve(&problem, &mut out);
        wide.solve(&widened_factors(&problem), &mut out);
    }
    out
}
