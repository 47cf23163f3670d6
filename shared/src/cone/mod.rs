//! One time step's contact forces with the exact (circular or elliptic) friction cone.
//!
//! Unknown is the velocity `v` at the end of the step, seven numbers: the object's linear
//! and angular velocity and the opening speed of the jaw. Each contact point answers a
//! relative velocity `u = J v + b` (normal, two tangents) with a force `f(u)`:
//!
//! ```text
//! f_n = max(-a, -k_n u_n)                                    non-penetration, adhesion a
//! f_t = projection of -k_t u_t on { |f_i / mu_i| <= f_n + a }  Coulomb, maximum dissipation
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
//! Method: semismooth Newton in seven dimensions. The matrix is assembled in a time that is
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

mod linear;
mod patch;

use crate::real::{Real, Vec3, abs, clamp, max, sqrt};
use heapless::Vec;
use linear::Factors;
use patch::{Local, Patch, add_slopes, curvature, find_kinks, modes, subtract_forces};

/// Most contact points of one solve.
pub const MAX_POINTS: usize = 64;
/// Unknowns: linear velocity (3), angular velocity (3), opening speed of the jaw.
pub const DOF: usize = 7;

/// A step that left less than this share of the merit (sum of squares) was a good one.
const GOOD: f64 = 0.04;
/// Most steps that reuse the factors of the last one.
const POLISH_STEPS: u8 = 3;

/// Bounds of [`ConeOptions::present`].
const PRESENT_ITERATIONS: u32 = 18;
const PRESENT_EVALUATIONS: u32 = 76;
/// Bounds and relative tolerance of [`ConeOptions::look_ahead`].
const LOOK_AHEAD_ITERATIONS: u32 = 8;
const LOOK_AHEAD_EVALUATIONS: u32 = 40;
const LOOK_AHEAD_TOLERANCE: f64 = 1e-3;

/// Contact points of the board's usual scene.
pub(crate) const USUAL_POINTS: u32 = 16;
/// What an evaluation costs besides its points, in points.
pub(crate) const FIXED_POINTS: u32 = 12;

/// Work of a Newton step besides its evaluations: matrix and factors cost four of them.
pub(crate) const FACTORS_WORK: u32 = 4;
/// No solve is bounded below so much work.
const LEAST_WORK: u32 = 16;

/// Most evaluations of a line search after the first.
const SEARCH_STEPS: u8 = 8;
/// Newton steps before friction bounds are held.
const FIRST_STEPS: u32 = 12;

/// What became of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ConeStatus {
    /// The momentum balance holds to the tolerance.
    Solved,
    /// The iteration bound was hit; the best velocity found is returned with its residual.
    IterationLimit,
    /// A number was not finite or a mass or stiffness not positive; nothing was solved.
    #[default]
    BadInput,
    /// The linear system broke down; the best velocity found is returned.
    Numerical,
    /// The contacts contradict each other (an object crushed between advancing walls): forces
    /// that no rig has. Said by the time step, which then has not moved anything.
    Contradiction,
}

/// One contact point as the solver sees it.
#[derive(Clone, Copy, Debug)]
pub struct ConePoint<R: Real> {
    /// From the centre of mass, m.
    pub lever_m: Vec3<R>,
    /// Normal into the object and two tangents, orthonormal.
    pub axes: [Vec3<R>; 3],
    /// Normal speed per unit of jaw opening speed: 1 on a fingertip, otherwise 0.
    pub jaw: R,
    /// Added to the relative velocity along `axes`, m/s (other body's motion, gap, spring memory).
    pub bias_m_s: [R; 3],
    /// Force per relative velocity along `axes`, N s/m; positive.
    pub stiffness_n_s_m: [R; 3],
    /// Friction coefficient along the two tangents; not negative.
    pub mu: [R; 2],
    /// Greatest pull that the contact bears, N; adds to the friction bound.
    pub adhesion_n: R,
}

/// Inertial side of the step.
#[derive(Clone, Copy, Debug)]
pub struct Bodies<R: Real> {
    /// Mass of the object.
    pub mass_kg: R,
    /// Inertia about the centre of mass, in the axes of the contacts.
    pub inertia_kg_m2: [[R; 3]; 3],
    /// Inertia of the jaw's opening motion.
    pub jaw_mass_kg: R,
    /// Step.
    pub dt_s: R,
    /// Velocity that the step would end with if no contact acted, m/s, rad/s, m/s.
    pub free: [R; DOF],
}

/// Result of [`solve`]. `velocity` and `force_n` are worth their `status` and `residual_n`.
#[derive(Clone, Debug)]
pub struct ConeSolution<R: Real, const NC: usize> {
    /// m/s, rad/s, m/s at the end of the step.
    pub velocity: [R; DOF],
    /// Force on the object at each point along its axes (normal, tangents).
    pub force_n: Vec<[R; 3], NC>,
    /// How far `velocity` can be trusted.
    pub status: ConeStatus,
    /// Largest error of the momentum balance, N (torques divided by the radius of gyration).
    pub residual_n: R,
    /// Newton steps taken, each with one factorisation.
    pub iterations: u32,
    /// Evaluations of the momentum balance.
    pub evaluations: u32,
}

/// Limits of the iteration.
#[derive(Clone, Copy, Debug)]
pub struct ConeOptions<R: Real> {
    /// Most Newton steps, all phases together.
    pub max_iterations: u32,
    /// Most evaluations of the balance; a line search that has begun may add eight.
    pub max_evaluations: u32,
    /// Residual called solved, as a share of the largest force in the balance.
    pub tolerance: R,
    /// Points for which the two bounds are meant: with more, which cost more, they are lowered.
    pub usual_points: u32,
}

impl<R: Real> Default for ConeOptions<R> {
    fn default() -> Self {
        Self {
            max_iterations: 60,
            max_evaluations: 400,
            // f32: what summing some twenty forces leaves; f64: far below any use.
            tolerance: max(R::of(100.0) * R::EPSILON, R::of(1e-10)),
            usual_points: MAX_POINTS as u32,
        }
    }
}

impl<R: Real> ConeOptions<R> {
    /// For the step to the present sample within a tick: bounded in time.
    pub fn present() -> Self {
        Self {
            max_iterations: PRESENT_ITERATIONS,
            max_evaluations: PRESENT_EVALUATIONS,
            usual_points: USUAL_POINTS,
            ..Self::default()
        }
    }

    /// For steps into the future, which is known far less exactly than a solve: the balance
    /// to a thousandth of the largest force, few iterations.
    pub fn look_ahead() -> Self {
        Self {
            max_iterations: LOOK_AHEAD_ITERATIONS,
            max_evaluations: LOOK_AHEAD_EVALUATIONS,
            tolerance: R::of(LOOK_AHEAD_TOLERANCE),
            usual_points: USUAL_POINTS,
        }
    }

    /// Work of a solve that uses up its bounds, in evaluations.
    pub(crate) fn work(&self) -> u32 {
        self.max_iterations.saturating_mul(FACTORS_WORK).saturating_add(self.max_evaluations)
    }

    /// The same with bounds for `work` evaluations, where that is less, but for some.
    pub(crate) fn within(&self, work: u32) -> Self {
        let whole = self.work();
        if work >= whole {
            return *self;
        }
        let work = work.max(LEAST_WORK).min(whole);
        let share = |bound: u32| bound.saturating_mul(work).checked_div(whole).map_or(1, |b| b.max(1));
        Self {
            max_iterations: share(self.max_iterations),
            max_evaluations: share(self.max_evaluations),
            ..*self
        }
    }

    /// The same where a step within a tick does `work` evaluations' worth besides the solve.
    pub(crate) fn beside(&self, work: u32) -> Self {
        if self.usual_points >= MAX_POINTS as u32 {
            return *self;
        }
        let whole = self.work();
        self.within(whole.saturating_sub(work).max(whole / 2))
    }

    /// The same with the bounds for `points` points.
    fn bounded_for(&self, points: usize) -> Self {
        let usual = self.usual_points.saturating_add(FIXED_POINTS);
        let points = (points as u32).saturating_add(FIXED_POINTS);
        let lowered =
            |bound: u32| if points > usual { (bound.saturating_mul(usual) / points).max(1) } else { bound };
        Self {
            max_iterations: lowered(self.max_iterations),
            max_evaluations: lowered(self.max_evaluations),
            ..*self
        }
    }
}

/// How the friction bound enters an evaluation.
#[derive(Clone, Copy)]
enum Bound<'a, R> {
    /// From the normal force at the same velocity (the real problem).
    Coupled,
    /// Given, one a contact (Tresca friction: the problem is then convex).
    Frozen(&'a [R]),
    /// Coupled, in the modes that the points are expected to be in.
    Expected,
}

type Vec7<R> = [R; DOF];
type Mat7<R> = [[R; DOF]; DOF];

/// The balance `F(v)`, a scale of its terms (N), and optionally its Jacobian.
struct Balance<R> {
    f: Vec7<R>,
    /// Largest force in the balance.
    scale_n: R,
    /// What rounding of velocities can do to the stiffest contact's force.
    rounding_n: R,
}

impl<R: Real> Balance<R> {
    fn tolerance_n(&self, options: &ConeOptions<R>) -> R {
        options.tolerance * self.scale_n + self.rounding_n
    }
}

/// Factors of an earlier solve: while the points do the same, they serve again.
#[derive(Clone, Copy, Debug)]
pub struct Kept<R> {
    factors: Factors<R>,
    /// Of what the points did when they were made.
    modes: u32,
    /// Zero: there are none.
    dt_s: R,
}

impl<R: Real> Kept<R> {
    /// None.
    pub fn nothing() -> Self {
        Self { factors: Factors::none(), modes: 0, dt_s: R::zero() }
    }
}

/// A solve in progress. Angular velocities are multiplied by the radius of gyration, moments
/// divided by it: all components of a vector are then comparable.
struct Problem<'a, R: Real> {
    patches: &'a [Patch<R>],
    points: &'a mut [Local<R>],
    /// `M / dt`.
    momentum: [[R; 3]; 3],
    mass_rate: R,
    jaw_rate: R,
    free: Vec7<R>,
    /// Evaluations of the balance made.
    evaluations: u32,
    /// Whether to begin with what the points did before.
    expected: bool,
    dt_s: R,
    kept: &'a mut Kept<R>,
}

impl<R: Real> Problem<'_, R> {
    fn inertial(&self, v: &Vec7<R>) -> Vec7<R> {
        let mut d = [R::zero(); DOF];
        for (d, (a, b)) in d.iter_mut().zip(v.iter().zip(self.free.iter())) {
            *d = *a - *b;
        }
        let row = |r: &[R; 3]| r[0] * d[3] + r[1] * d[4] + r[2] * d[5];
        [
            self.mass_rate * d[0],
            self.mass_rate * d[1],
            self.mass_rate * d[2],
            row(&self.momentum[0]),
            row(&self.momentum[1]),
            row(&self.momentum[2]),
            self.jaw_rate * d[6],
        ]
    }

    /// The balance at `v`; the points keep their answers for [`Self::slopes`].
    fn balance(&mut self, v: &Vec7<R>, bound: Bound<'_, R>) -> Balance<R> {
        self.evaluations += 1;
        let mut f = self.inertial(v);
        let mut scale = R::of(1e-6);
        for k in [0, 1, 2, 6] {
            scale = max(scale, abs(f[k]));
        }
        let mut rounding = R::zero();
        for (v, free) in v.iter().zip(self.free.iter()).take(3) {
            rounding = max(rounding, self.mass_rate * (abs(*v) + abs(*free)));
        }
        subtract_forces(self.patches, self.points, v, bound, &mut f, &mut scale, &mut rounding);
        Balance { f, scale_n: scale, rounding_n: rounding * R::of(32.0) * R::EPSILON }
    }

    /// Whether the factors at hand were made for what the points do now.
    fn fits(&self) -> bool {
        self.kept.dt_s == self.dt_s && self.kept.modes == modes(self.points)
    }

    /// Factors of the Jacobian where the last balance was taken; `false` where it is singular.
    fn factorise(&mut self, bound: Bound<'_, R>) -> bool {
        let h = self.kept.factors.matrix();
        *h = [[R::zero(); DOF]; DOF];
        for i in 0..3 {
            h[i][i] = self.mass_rate;
            for j in 0..3 {
                h[3 + i][3 + j] = self.momentum[i][j];
            }
        }
        h[6][6] = self.jaw_rate;
        add_slopes(self.patches, self.points, bound, h);
        let regular = self.kept.factors.factorise();
        // Those with friction bounds held are for no other solve.
        let lasting = regular && !matches!(bound, Bound::Frozen(_));
        self.kept.dt_s = if lasting { self.dt_s } else { R::zero() };
        self.kept.modes = modes(self.points);
        regular
    }
}

/// Largest entry, N.
fn size<R: Real>(f: &Vec7<R>) -> R {
    let mut s = R::zero();
    for x in f {
        let n = abs(*x);
        // A NaN must win: it is the worst residual there is.
        if !(n <= s) {
            s = n;
        }
    }
    s
}

/// Component of `f` along `d`.
fn slope<R: Real>(f: &Vec7<R>, d: &Vec7<R>) -> R {
    f.iter().zip(d).fold(R::zero(), |s, (f, d)| s + *f * *d)
}

/// Sum of squares, the merit of a line search.
fn merit<R: Real>(f: &Vec7<R>) -> R {
    let mut s = R::zero();
    for x in f {
        s += *x * *x;
    }
    s
}

fn advance<R: Real>(v: &Vec7<R>, d: &Vec7<R>, step: R) -> Vec7<R> {
    let mut w = *v;
    for (w, d) in w.iter_mut().zip(d.iter()) {
        *w += step * *d;
    }
    w
}

/// What a point did in the step before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Before<R> {
    /// No force.
    Open,
    /// Touched without slip.
    Stuck {
        /// Normal force.
        load_n: R,
    },
    /// Slipped.
    Slid {
        /// Normal force.
        load_n: R,
    },
}

/// A point's answer to the velocity found.
#[derive(Clone, Copy, Debug)]
pub struct Answer<R> {
    /// Force on the object along the point's axes (normal, tangents).
    pub force_n: [R; 3],
    /// Relative velocity along the tangents, the point's bias included.
    pub biased_slip_m_s: [R; 2],
    /// As given, along the tangents.
    pub stiffness_n_s_m: [R; 2],
    /// As given.
    pub mu: [R; 2],
    /// As given.
    pub adhesion_n: R,
}

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
    /// Factors of the last solve, for the next.
    pub kept: Kept<R>,
}

impl<R: Real, const NC: usize> Default for Workspace<R, NC> {
    fn default() -> Self {
        Self::new()
    }
}

/// What a solve says besides the forces; `velocity` is worth its `status` and `residual_n`.
#[derive(Clone, Copy, Debug)]
pub struct Solved<R> {
    /// m/s, rad/s, m/s at the end of the step.
    pub velocity: [R; DOF],
    /// How far `velocity` can be trusted.
    pub status: ConeStatus,
    /// Largest error of the momentum balance, N (torques divided by the radius of gyration).
    pub residual_n: R,
    /// Newton steps taken, each with one factorisation.
    pub iterations: u32,
    /// Evaluations of the momentum balance.
    pub evaluations: u32,
}

/// Solves the step's contact problem, starting from the velocity `guess` (the last step's).
///
/// Points beyond [`MAX_POINTS`] make it `BadInput`.
///
/// Never panics; the work is bounded by `options.max_iterations` times the contacts.
pub fn solve<R: Real, const NC: usize>(
    points: &Vec<ConePoint<R>, NC>,
    bodies: &Bodies<R>,
    guess: &[R; DOF],
    options: &ConeOptions<R>,
) -> ConeSolution<R, NC> {
    let mut work = Workspace::<R, NC>::new();
    work.begin(bodies);
    for p in points {
        work.add(p);
    }
    let s = work.solve(bodies, guess, options);
    let refused = s.status == ConeStatus::BadInput;
    ConeSolution {
        velocity: s.velocity,
        force_n: if refused { Vec::new() } else { work.answers().map(|a| a.force_n).collect() },
        status: s.status,
        residual_n: s.residual_n,
        iterations: s.iterations,
        evaluations: s.evaluations,
    }
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
            kept: Kept::nothing(),
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
    pub fn add(&mut self, p: &ConePoint<R>) {
        let zero = R::zero();
        let [k0, k1, k2] = p.stiffness_n_s_m;
        self.good &= k0 > zero && k1 > zero && k2 > zero;
        self.good &= p.mu[0] >= zero && p.mu[1] >= zero && p.adhesion_n >= zero;
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

    /// Forgets the points, and what they answered.
    pub fn forget(&mut self) {
        self.patches.clear();
        self.count = 0;
    }

    /// Solves for the velocity at the end of the step, from `guess`: see [`solve`].
    pub fn solve(&mut self, bodies: &Bodies<R>, guess: &[R; DOF], options: &ConeOptions<R>) -> Solved<R> {
        let points = self.locals.get_mut(..self.count).unwrap_or_default();
        if !(self.good && self.probe == R::zero() && points.len() <= MAX_POINTS) {
            self.forget();
            return Solved {
                velocity: *guess,
                status: ConeStatus::BadInput,
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
            kept: &mut self.kept,
        };
        let start = if finite(guess) { guess } else { &bodies.free };
        let start = scaled(start, radius);
        let options = &options.bounded_for(problem.points.len());
        let (velocity, residual_n, status, iterations) = problem.coupled(start, options);
        if status != ConeStatus::Solved {
            // What was evaluated last need not be the best.
            problem.balance(&velocity, Bound::Coupled);
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

/// Where an iteration stands.
struct Progress<R> {
    velocity: Vec7<R>,
    best: Vec7<R>,
    best_size_n: R,
    used: u32,
}

/// How a phase of the iteration ended.
#[derive(PartialEq)]
enum Phase {
    Solved,
    Stalled,
    Limit,
    Singular,
}

impl<R: Real> Problem<'_, R> {
    /// Newton on the real problem; where its descent stalls, the Tresca fixed point (bounds
    /// frozen, convex problem minimised, bounds updated with a relaxation that halves when
    /// the update turns back), with a few Newton steps on the real problem after each.
    fn coupled(&mut self, start: Vec7<R>, options: &ConeOptions<R>) -> (Vec7<R>, R, ConeStatus, u32) {
        let mut p = Progress { velocity: start, best: start, best_size_n: R::of(1e30), used: 0 };
        let mut phase = self.newton(&mut p, options, FIRST_STEPS);
        if phase == Phase::Stalled {
            let mut bounds = [R::zero(); MAX_POINTS];
            p.velocity = p.best;
            self.normal_bounds(&p.best, &mut bounds);
            let mut relaxation = R::one();
            let mut before = [R::zero(); MAX_POINTS];
            while p.used < options.max_iterations && self.evaluations < options.max_evaluations {
                let relaxed = self.frozen(p.velocity, &bounds, &mut p.used, options);
                p.velocity = relaxed;
                phase = self.newton(&mut p, options, 6);
                if phase != Phase::Stalled {
                    break;
                }
                p.velocity = relaxed;
                let mut next = bounds;
                self.normal_bounds(&relaxed, &mut next);
                let mut turned = R::zero();
                for ((b, n), r) in bounds.iter().zip(next.iter_mut()).zip(before.iter_mut()) {
                    let change = *n - *b;
                    turned += change * *r;
                    *r = change;
                }
                if turned < R::zero() {
                    relaxation = max(relaxation * R::of(0.5), R::of(0.2));
                }
                for (b, change) in bounds.iter_mut().zip(before.iter()) {
                    *b += relaxation * *change;
                }
            }
        }
        // What was evaluated last is the best there is where it is solved.
        let status = match phase {
            Phase::Solved => ConeStatus::Solved,
            Phase::Singular => ConeStatus::Numerical,
            Phase::Stalled | Phase::Limit => ConeStatus::IterationLimit,
        };
        (p.best, p.best_size_n, status, p.used)
    }

    /// At most `steps` Newton steps with a line search on the size of the balance.
    fn newton(&mut self, p: &mut Progress<R>, options: &ConeOptions<R>, steps: u32) -> Phase {
        let mut taken = 0;
        let mut trusted = 0_u8;
        let mut fresh = true;
        let mut at = self.balance(&p.velocity, Bound::Coupled);
        loop {
            let size = size(&at.f);
            let solved = size <= at.tolerance_n(options);
            if solved || size < p.best_size_n {
                p.best = p.velocity;
                p.best_size_n = size;
            }
            if solved {
                return Phase::Solved;
            }
            if p.used >= options.max_iterations || self.evaluations >= options.max_evaluations {
                return Phase::Limit;
            }
            if taken >= steps {
                return Phase::Stalled;
            }
            if core::mem::take(&mut self.expected) && !self.points.iter().all(Local::touches_as_before) {
                at = self.as_before(p, at, options);
                continue;
            }
            let before = merit(&at.f);
            if core::mem::replace(&mut fresh, false) && self.fits() {
                at = self.polish(p, at, options);
                if merit(&at.f) < before * R::of(GOOD) {
                    continue;
                }
            }
            taken += 1;
            p.used += 1;
            if !self.factorise(Bound::Coupled) {
                return Phase::Singular;
            }
            let Some(d) = self.kept.factors.solve_negative(&at.f) else {
                return Phase::Singular;
            };
            let before = merit(&at.f);
            let (trial, there) = if slope(&at.f, &d) < R::zero() {
                self.search(&p.velocity, &d, &at.f, Bound::Coupled)
            } else if trusted < 2 {
                // Where friction couples strongly to the normal force, the step need not descend.
                trusted += 1;
                let full = advance(&p.velocity, &d, R::one());
                (full, self.balance(&full, Bound::Coupled))
            } else {
                return Phase::Stalled;
            };
            p.velocity = trial;
            at = there;
            if merit(&at.f) < before * R::of(GOOD) {
                at = self.polish(p, at, options);
            }
        }
    }

    /// First step where a point touches at the last velocity that was open before, or the reverse:
    /// to the velocity at which all do what they did before.
    fn as_before(&mut self, p: &mut Progress<R>, at: Balance<R>, options: &ConeOptions<R>) -> Balance<R> {
        let expected = self.balance(&p.velocity, Bound::Expected);
        let made = self.fits() || {
            p.used += 1;
            self.factorise(Bound::Expected)
        };
        let step = if made { self.kept.factors.solve_negative(&expected.f) } else { None };
        let Some(d) = step else {
            return self.balance(&p.velocity, Bound::Coupled);
        };
        let start = p.velocity;
        p.velocity = advance(&start, &d, R::one());
        let there = self.balance(&p.velocity, Bound::Coupled);
        if merit(&there.f) < merit(&at.f) * R::of(GOOD) {
            return self.polish(p, there, options);
        }
        if !(merit(&there.f) < merit(&at.f)) {
            // They do something else now.
            p.velocity = start;
            return self.balance(&start, Bound::Coupled);
        }
        there
    }

    /// Along a direction of descent `d` from `v`, where the balance is `f`: the full step, or
    /// one that ends before the balance has turned against it. With friction bounds held, the
    /// balance is the gradient of a convex function: its component along `d` changes sign
    /// once, at the minimum. A contact that closes turns it by orders of magnitude.
    fn search(
        &mut self,
        v: &Vec7<R>,
        d: &Vec7<R>,
        f: &Vec7<R>,
        bound: Bound<'_, R>,
    ) -> (Vec7<R>, Balance<R>) {
        let zero = R::zero();
        let along = |f: &Vec7<R>| slope(f, d);
        let enough = abs(along(f)) * R::of(0.5);
        let mut kinks: Vec<R, { 2 * MAX_POINTS }> = Vec::new();
        // Ends of the bracket, and the components there.
        let (mut low, mut high) = ((zero, along(f)), (zero, zero));
        let mut step = R::one();
        let mut trial = advance(v, d, step);
        let mut there = self.balance(&trial, bound);
        let mut turned = along(&there.f);
        if !(turned > enough) {
            return (trial, there);
        }
        // Where the component turns, it mostly does at the kink of one contact.
        find_kinks(self.patches, self.points, v, d, &mut kinks);
        for _ in 0..SEARCH_STEPS {
            // Newton's method on the component, which has kinks, kept inside the bracket.
            if turned > zero {
                high = (step, turned);
            } else {
                low = (step, turned);
            }
            let width = high.0 - low.0;
            let newton = step - turned / self.curvature(d, bound);
            let margin = width * R::of(0.01);
            let estimate = if newton > low.0 + margin && newton < high.0 - margin {
                newton
            } else {
                let share = low.1 / (low.1 - high.1);
                low.0 + width * clamp(share, R::of(0.1), R::of(0.9))
            };
            let mut nearest = None;
            let mut distance = width;
            for kink in &kinks {
                let away = abs(*kink - estimate);
                if *kink > low.0 && *kink < high.0 && away < distance {
                    (nearest, distance) = (Some(*kink), away);
                }
            }
            step = nearest.unwrap_or(estimate);
            trial = advance(v, d, step);
            there = self.balance(&trial, bound);
            turned = along(&there.f);
            if abs(turned) <= enough {
                break;
            }
        }
        (trial, there)
    }

    /// `d' J d` where the last balance was taken.
    fn curvature(&self, d: &Vec7<R>, bound: Bound<'_, R>) -> R {
        let mut still = self.free;
        for (s, d) in still.iter_mut().zip(d) {
            *s += *d;
        }
        let inertia = self.inertial(&still).iter().zip(d).fold(R::zero(), |s, (f, d)| s + *f * *d);
        inertia + curvature(self.patches, self.points, d, bound)
    }

    /// Further steps with the same factors while they are worth their cost: a step without a
    /// new matrix costs a fifth of one with it.
    fn polish(&mut self, p: &mut Progress<R>, mut at: Balance<R>, options: &ConeOptions<R>) -> Balance<R> {
        for _ in 0..POLISH_STEPS {
            if size(&at.f) <= at.tolerance_n(options) {
                break;
            }
            let Some(d) = self.kept.factors.solve_negative(&at.f) else { break };
            let trial = advance(&p.velocity, &d, R::one());
            let there = self.balance(&trial, Bound::Coupled);
            let (before, after) = (merit(&at.f), merit(&there.f));
            if !(after < before) {
                // The points answer for the velocity that is kept.
                return self.balance(&p.velocity, Bound::Coupled);
            }
            p.velocity = trial;
            at = there;
            if !(after < before * R::of(GOOD)) {
                break;
            }
        }
        at
    }

    /// Friction bound of each contact from its normal force at `v`.
    fn normal_bounds(&mut self, v: &Vec7<R>, bounds: &mut [R; MAX_POINTS]) {
        self.balance(v, Bound::Coupled);
        for (b, p) in bounds.iter_mut().zip(self.points.iter()) {
            *b = p.bound();
        }
    }

    /// Minimises the convex problem with the friction bounds held fixed.
    fn frozen(&mut self, start: Vec7<R>, bounds: &[R], used: &mut u32, options: &ConeOptions<R>) -> Vec7<R> {
        let mut v = start;
        let bound = Bound::Frozen(bounds);
        let mut at = self.balance(&v, bound);
        for _ in 0..20 {
            let spent = *used >= options.max_iterations || self.evaluations >= options.max_evaluations;
            if size(&at.f) <= at.tolerance_n(options) || spent {
                break;
            }
            *used += 1;
            let regular = self.factorise(bound);
            let direction = if regular { self.kept.factors.solve_negative(&at.f) } else { None };
            let Some(d) = direction else {
                break;
            };
            (v, at) = self.search(&v, &d, &at.f, bound);
        }
        v
    }
}
