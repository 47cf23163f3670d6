//! One time step's contact forces with the exact (circular or elliptic) friction cone.
//!
//! Unknown is the velocity `v` at the end of the step, seven numbers: the object's linear
//! and angular velocity and the opening speed of the jaw. Each contact point answers a
//! relative velocity `u = J v + b` (normal, two tangents) with a force `f(u)`:
//!
//! ```text
//! f_n = max(-a, -k_n u_n)                                    non-penetration, adhesion a
//! f_t = projection of -k_t u_t on { |f_i / mu_i| <= f_n + a }  Coulomb, maximum dissipation
//!       (with a viscosity c: 1 - b of it, and b of -k_t u_t itself, b = c / (k_t + c))
//! ```
//!
//! and the velocity is the root of the momentum balance
//! `F(v) = M (v - v_free) / dt - sum J' f(J v + b) = 0`.
//! This is the Stewart-Trinkle step (Stewart and Trinkle 1996) with the pyramid replaced by
//! the cone itself and with a stiffness `k` (newtons per metre a second: spring times step
//! plus damper) in place of infinity. For rigid contact `k` is made so large that its
//! deflection is far below what is measured; what it then does is choose one of the many
//! force distributions that a rigid grasp admits: the one of least elastic energy.
//! There are no facets, hence nothing that could depend on how facets are turned.
//!
//! Method: semismooth Newton in seven dimensions. The generalised Jacobian is assembled in a time that is
//! linear in the number of contacts and factorised in constant time. Factors of an earlier step serve again
//! while the points do what they did when these were made. A rigid contact turns a wrong guess of
//! a micrometre into newtons: where a point touches at the last velocity that was open in the
//! step before, or the reverse, the first Newton step is made as if every point did the same
//! again. Where they only rub otherwise it is not: which of several solutions is found would
//! change. Where the friction
//! bound's dependence on the normal force spoils the descent, the bound is frozen, the then
//! convex problem is minimised, and the bound is updated (the Tresca fixed point).
//!
//! Certificate: forces obey the contact law by construction, so the only error is that of
//! the momentum balance; it is returned in newtons with every solution.

mod newton;
mod params;
mod patch;
mod point;

pub use crate::linear::Kept;
use crate::linear::Vec7;
use crate::real::{Real, sqrt};
pub use crate::solve::{
    Answer, Before, Bodies, ContactPoint, DOF, Follows, MAX_POINTS, Solution, SolveBudget, SolveStatus,
    Solved,
};
use heapless::Vec;
use newton::Problem;
pub use params::ConeParams;
use patch::{Bound, Patch};
use point::Local;

/// Working memory of a solve: points are added one by one, then solved for.
#[derive(Clone, Debug)]
pub struct Workspace<R: Real, const NC: usize> {
    patches: Vec<Patch<R>, NC>,
    /// The first `count` belong to the problem.
    locals: Vec<Local<R>, NC>,
    count: usize,
    /// One over the radius of gyration.
    scale: R,
    /// Zero while every number was finite.
    probe: R,
    good: bool,
    /// Some point is expected to touch.
    expected: bool,
}

impl<R: Real, const NC: usize> Default for Workspace<R, NC> {
    fn default() -> Self {
        Self::new()
    }
}

/// Solves the step's contact problem, starting from the velocity `guess` (the last step's).
///
/// Points beyond [`MAX_POINTS`] make it `BadInput`.
///
/// Never panics; the work is bounded by `options.max_work` times the contacts.
pub fn solve<R: Real, const NC: usize>(
    points: &Vec<ContactPoint<R>, NC>,
    bodies: &Bodies<R>,
    guess: &[R; DOF],
    options: &SolveBudget<R>,
) -> Solution<R, NC> {
    let mut work = Workspace::<R, NC>::new();
    work.begin(bodies);
    for p in points {
        work.add(p);
    }
    let s = work.solve(bodies, guess, options, &ConeParams::default(), &mut Kept::nothing());
    let refused = s.status == SolveStatus::BadInput;
    Solution::of(&s, if refused { Vec::new() } else { work.answers().map(|a| a.force_n).collect() })
}

impl<R: Real, const NC: usize> Workspace<R, NC> {
    /// Empty.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            patches: Vec::new(),
            locals: Vec::new(),
            count: 0,
            scale: R::one(),
            probe: R::zero(),
            good: false,
            expected: false,
        }
    }

    /// Begins a problem of `bodies`, without points.
    pub fn begin(&mut self, bodies: &Bodies<R>) {
        let zero = R::zero();
        let i = &bodies.inertia_kg_m2;
        self.forget();
        self.expected = false;
        self.probe = (bodies.mass_kg + bodies.jaw_mass_kg + bodies.dt_s) * zero;
        for row in i {
            self.probe += (row[0] + row[1] + row[2]) * zero;
        }
        let minor = i[0][0] * i[1][1] - i[0][1] * i[1][0];
        let determinant = i[2][2] * minor - i[1][2] * (i[0][0] * i[2][1] - i[0][1] * i[2][0])
            + i[0][2] * (i[1][0] * i[2][1] - i[1][1] * i[2][0]);
        self.good = bodies.mass_kg > zero
            && bodies.jaw_mass_kg > zero
            && bodies.dt_s > zero
            && i[0][0] > zero
            && minor > zero
            && determinant > zero
            && finite(&bodies.free);
        let trace = i[0][0] + i[1][1] + i[2][2];
        self.scale = R::one() / sqrt(trace / (R::of(3.0) * bodies.mass_kg));
    }

    /// Adds a point. Neighbours with the same axes are handled together, so they come one
    /// after the other.
    #[inline(always)]
    pub fn add(&mut self, p: &ContactPoint<R>) {
        let zero = R::zero();
        let [k0, k1, k2] = p.stiffness_n_s_m;
        self.good &= k0 > zero && k1 > zero && k2 > zero;
        self.good &= p.mu[0] >= zero && p.mu[1] >= zero && p.adhesion_n >= zero && p.viscous_n_s_m >= zero;
        if !self.patches.last().is_some_and(|patch| patch.holds(p)) {
            self.good &= self.patches.push(Patch::new(p, self.scale)).is_ok();
        }
        if self.count == self.locals.len() {
            let _ = self.locals.push(Local::nothing());
        }
        match (self.patches.last_mut(), self.locals.get_mut(self.count)) {
            (Some(patch), Some(to)) => {
                self.probe += patch.place(p, self.scale, to);
                patch.count += 1;
                self.count += 1;
            }
            _ => self.good = false,
        }
    }

    /// The point that was added last did this in the step before.
    #[inline(always)]
    pub fn expect(&mut self, before: Before<R>) {
        if let Some(point) = self.count.checked_sub(1).and_then(|last| self.locals.get_mut(last)) {
            point.expect(before);
            self.expected |= before != Before::Open;
        }
    }

    /// Every point's answer to the velocity found, in the order in which they were added.
    #[inline(always)]
    pub fn answers(&self) -> impl Iterator<Item = Answer<R>> {
        self.locals.iter().take(self.count).map(Local::given)
    }

    /// How many points were added.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The answer of the point that was added as number `k`, from 0.
    #[inline(always)]
    pub(crate) fn answer(&self, k: usize) -> Option<Answer<R>> {
        self.locals.get(k).filter(|_| k < self.count).map(Local::given)
    }

    /// Forgets the points, and what they answered.
    pub fn forget(&mut self) {
        self.patches.clear();
        self.count = 0;
    }

    /// Solves for the velocity at the end of the step, from `guess`: see [`solve`]; with the factors of the last one, where
    /// `kept` has them and every point does what it did, and leaves its own there.
    pub fn solve(
        &mut self,
        bodies: &Bodies<R>,
        guess: &[R; DOF],
        options: &SolveBudget<R>,
        params: &ConeParams<R>,
        kept: &mut Kept<R>,
    ) -> Solved<R> {
        let points = self.locals.get_mut(..self.count).unwrap_or_default();
        if !(self.good && self.probe == R::zero() && points.len() <= MAX_POINTS) {
            self.forget();
            return Solved {
                velocity: *guess,
                status: SolveStatus::BadInput,
                residual_n: R::zero(),
                iterations: 0,
                evaluations: 0,
            };
        }
        let rate = R::one() / bodies.dt_s;
        let scale = self.scale;
        let radius = R::one() / scale;
        let scaled = |v: &Vec7<R>, by: R| {
            let mut v = *v;
            for x in v.iter_mut().take(6).skip(3) {
                *x *= by;
            }
            v
        };
        let square = rate * scale * scale;
        let mut problem = Problem {
            patches: &self.patches,
            points,
            momentum: bodies.inertia_kg_m2.map(|row| row.map(|x| x * square)),
            mass_rate: bodies.mass_kg * rate,
            jaw_rate: bodies.jaw_mass_kg * rate,
            free: scaled(&bodies.free, radius),
            evaluations: 0,
            expected: self.expected,
            dt_s: bodies.dt_s,
            kept,
            params,
        };
        let start = if finite(guess) { guess } else { &bodies.free };
        let start = scaled(start, radius);
        let options = &options.bounded_for(problem.points.len());
        let (velocity, residual_n, status, iterations) = problem.coupled(start, options);
        if status != SolveStatus::Solved {
            // What was evaluated last need not be the best.
            problem.residual(&velocity, Bound::Coupled);
        }
        let evaluations = problem.evaluations;
        Solved { velocity: scaled(&velocity, scale), status, residual_n, iterations, evaluations }
    }
}

/// Only finite numbers times zero add up to zero: one test for many.
fn finite<'a, R: Real>(numbers: impl IntoIterator<Item = &'a R>) -> bool {
    let mut probe = R::zero();
    for x in numbers {
        probe += *x * R::zero();
    }
    probe == R::zero()
}
