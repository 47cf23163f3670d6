//! One time step's contact forces as a complementarity problem: the step of Stewart and Trinkle (1996)
//! with a friction pyramid at each contact point.
//!
//! The same points, masses and compliances as in the step with the exact cone ([`crate::cone`]), from
//! which it differs in the set of friction forces alone: a regular polygon instead of an ellipse.
//! With `u = J v + b` (normal, two tangents), stiffness `k` and adhesion `a`, unknown normal force
//! `n` and friction `f`,
//!
//! ```text
//! 0 <= n  complementary to  u_n + (n - a) / k_n >= 0
//! f in mu n P,  the slip u_t + f / k_t turned against the normal cone of mu n P at f
//! M (v - v_free) / dt = sum J' (n - a, f)
//! ```
//!
//! is a linear complementarity problem, for the polygon `P` has edges and not an arc. It is solved in the space of
//! the seven velocities by the path following of [`super::contact`] and with its law of one contact.
//! The compliances are those of the step, so nothing has to be regularised: one path leads to the answer.
//!
//! - **First edge.** A pyramid has its full friction at its corners only, and none across the slip while the slip
//!   stays in the normal cone of a corner. So the first corner of each point's polygon follows the direction in which
//!   friction acts at the velocity with which the iteration begins: that of the last step.
//! - **Anisotropy.** Tangents are multiplied by their coefficients of friction: the ellipse becomes the circle in which
//!   the polygon is inscribed. The ratio of the coefficients is at least 1/100.
//! - **Viscosity.** Its share of friction that is not bounded (see the cone) is a damper, which belongs to the masses.
//!   A point that opens in the step keeps it until the end of the step.
//! - **Warm start.** The velocity and what each point did in the step before (open, stuck, slid) are an exact solution for
//!   other constants, from which the path begins. It has no kink where all do the same again.
//!
//! The parts of a solve are not inlined: the step has several callers, and copies would fill the flash.
//!
//! Above 600 lines: every part of a solve works on the points' tracks in place, and they are one course from the guess to the forces.
//!
//! Certificate: at the velocity found, forces obey the law of the pyramid by construction, so
//! the only error is that of the momentum balance in newtons, as for the cone.

mod balance;
mod params;
mod point;
mod slide;

use super::contact::law::{Mode, add_scaled, dot};
use super::contact::path::{End, Equations, follow};
use super::contact::polygon::{Polygon, along};
use crate::linear::{Factors, Kept, Mat7, Vec7};
use crate::real::{Real, Vec3, abs, max, sqrt};
use crate::solve::{
    Answer, Bodies, ContactPoint, DOF, MAX_POINTS, Solution, SolveBudget, SolveStatus, Solved,
};
use balance::{Balance, Inertia};
use heapless::Vec;
pub use params::{FirstEdge, PyramidParams};
pub use point::{Past, Points};
use point::{Point, damping, expect, in_range};
use slide::{Slide, Track, unit};

/// Turns of a pyramid below this are not made, rad: a hundredth of a degree changes nothing that is measured.
const LEAST_TURN: f64 = 2e-4;

/// Work of a turn besides its polishing, in evaluations: a matrix and its factors, the rows turned, the misfit, and forces once
/// more (18,000 instructions where an evaluation takes 5,000 to 6,400).
const TURN_WORK: u32 = 3;

/// Factors serve for a step that is longer or shorter by such a share: sample times in single precision differ by less, and
/// what the factors are wrong by the balance shows.
const SAME_DT: f64 = 1e-3;

/// Working memory of a solve.
#[derive(Clone, Debug)]
pub struct Paths<R: Real, const NC: usize> {
    tracks: Vec<Track<R>, NC>,
    answers: Vec<Answer<R>, NC>,
}

/// A solve under way.
struct Problem<'a, R: Real, const NC: usize> {
    points: &'a mut [Point<R>],
    tracks: &'a mut Vec<Track<R>, NC>,
    answers: &'a mut Vec<Answer<R>, NC>,
    inertia: Inertia<R>,
    budget: SolveBudget<R>,
    params: &'a PyramidParams<R>,
}

/// Solves the step's contact problem with friction pyramids, starting from the velocity `guess` (the last
/// step's). Forces are there where it was solved. See [`Paths::solve`].
pub fn solve<R: Real, const NC: usize>(
    points: &Vec<ContactPoint<R>, NC>,
    bodies: &Bodies<R>,
    guess: &[R; DOF],
    budget: &SolveBudget<R>,
    params: &PyramidParams<R>,
) -> Solution<R, NC> {
    let mut given = Points::<R, NC>::new();
    for p in points {
        given.add(p, None);
    }
    let mut paths = Paths::new();
    let s = paths.solve(&mut given, bodies, guess, budget, params, &mut Kept::nothing());
    Solution::of(&s, paths.answers().iter().map(|a| a.force_n).collect())
}

/// Where an attempt begins.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Start {
    /// Every point does what it did in the step before.
    Before,
    /// Every point does what the guessed velocity says.
    Guess,
    /// Every point is open.
    Open,
}

impl<R: Real, const NC: usize> Default for Paths<R, NC> {
    fn default() -> Self {
        Self::new()
    }
}

impl<R: Real, const NC: usize> Paths<R, NC> {
    /// Empty.
    #[inline(always)]
    pub fn new() -> Self {
        Self { tracks: Vec::new(), answers: Vec::new() }
    }

    /// Every point's answer to the velocity found, in the order in which they were added; none where the
    /// problem was not solved.
    #[inline(always)]
    pub fn answers(&self) -> &[Answer<R>] {
        &self.answers
    }

    /// Forgets what the points answered.
    pub(crate) fn forget(&mut self) {
        self.answers.clear();
    }

    /// Solves for the velocity at the end of the step, from `guess` (the last step's); with the factors of that step, where
    /// `kept` has them and every point does what it did, and leaves its own there.
    ///
    /// A number out of its range is `BadInput`; what is not finite is never `Solved`. Never panics; `iterations` counts the
    /// paths' factorisations, `evaluations` balances and kinks, and three for each turn of the pyramids; both are bounded by
    /// `budget`.
    #[inline(never)]
    pub fn solve(
        &mut self,
        points: &mut Points<R, NC>,
        bodies: &Bodies<R>,
        guess: &[R; DOF],
        budget: &SolveBudget<R>,
        params: &PyramidParams<R>,
        kept: &mut Kept<R>,
    ) -> Solved<R> {
        self.answers.clear();
        let mut solved = Solved {
            velocity: *guess,
            status: SolveStatus::Numerical,
            residual_n: R::zero(),
            iterations: 0,
            evaluations: 0,
        };
        let Some(inertia) = Inertia::of(bodies).filter(|_| points.list.iter().all(|p| in_range(&p.given)))
        else {
            solved.status = SolveStatus::BadInput;
            return solved;
        };
        if !(points.lost || points.list.len() > MAX_POINTS) {
            let budget = budget.bounded_for(points.list.len());
            let Self { tracks, answers } = self;
            let problem = Problem { points: &mut points.list, tracks, answers, inertia, budget, params };
            problem.solve(bodies.dt_s, guess, kept, &mut solved);
        }
        solved
    }
}

impl<R: Real, const NC: usize> Problem<'_, R, NC> {
    #[inline(always)]
    fn solve(mut self, dt_s: R, guess: &[R; DOF], kept: &mut Kept<R>, solved: &mut Solved<R>) {
        let guess = self.inertia.scaled(guess);
        let polygon = Polygon::new(self.params.edges);
        self.load(&polygon, &guess);
        let damped = self.damped();
        let mut equations = Equations::new(&polygon, Some(&damped));
        let first = if self.points.iter().any(|p| p.past.is_some()) { Start::Before } else { Start::Guess };
        let mut begun = None;
        let arrived = 'arrived: {
            if first == Start::Before {
                let at = self.start(&polygon, &guess, first);
                solved.evaluations += 1;
                if self.rests(&at, solved) {
                    break 'arrived Some(guess);
                }
                let same_dt = abs(kept.dt_s - dt_s) <= dt_s * R::of(SAME_DT);
                if same_dt && kept.modes == self.modes() {
                    equations.borrow(&kept.factors);
                    if let Some(velocity) = self.repeat(&equations, &guess, &at, solved) {
                        break 'arrived Some(velocity);
                    }
                } else {
                    begun = Some(at);
                }
            }
            kept.dt_s = R::zero();
            for start in [first, Start::Guess, Start::Open] {
                let mut velocity = if start == Start::Open { self.inertia.free } else { guess };
                let mut at = match begun.take() {
                    Some(at) => at,
                    None => {
                        solved.evaluations += 1;
                        self.start(&polygon, &velocity, start)
                    }
                };
                // A repair that takes longer than a cold start is none.
                let most = if start == Start::Open { 20 } else { 2 } * self.points.len() as u32 + 10;
                for _ in 0..self.params.paths {
                    let left = self.left(solved);
                    if left == 0 {
                        solved.status = SolveStatus::IterationLimit;
                        return;
                    }
                    solved.iterations += 1;
                    let limit = most.min(left);
                    let (end, kinks) = follow(&mut equations, self.tracks, &mut velocity, &at.rest, limit);
                    solved.evaluations = solved.evaluations.saturating_add(kinks);
                    if end != End::Arrived {
                        break;
                    }
                    if self.polish(&mut equations, &mut velocity, solved) {
                        break 'arrived Some(velocity);
                    }
                    at = self.set_out(&velocity);
                }
            }
            None
        };
        if let Some(velocity) = arrived {
            self.finish(&mut equations, velocity, solved);
            // Where nothing was solved, those at hand are still what they were.
            if equations.has_factors() {
                *kept = Kept { factors: equations.factors(), modes: self.modes(), dt_s };
            }
        }
    }

    /// Evaluations that are left for a path, beside its factorisation.
    fn left(&self, solved: &Solved<R>) -> u32 {
        self.budget.evaluations_beside(solved.iterations + 1).saturating_sub(solved.evaluations)
    }

    /// Begins another path where the last one ended.
    fn set_out(&mut self, velocity: &Vec7<R>) -> Balance<R> {
        let at = self.balance(velocity);
        for track in self.tracks.iter_mut() {
            track.offset = [R::zero(); 3];
        }
        at
    }

    /// Whether the guess is the answer already: every point does what it did, and that balances as exactly as is asked.
    fn rests(&self, at: &Balance<R>, solved: &mut Solved<R>) -> bool {
        self.balanced(at, solved) && self.tracks.iter().all(|track| track.offset == [R::zero(); 3])
    }

    /// Whether it balances as exactly as is asked.
    fn balanced(&self, at: &Balance<R>, solved: &mut Solved<R>) -> bool {
        solved.residual_n = at.residual_n();
        solved.residual_n <= at.tolerance_n(&self.budget, self.params)
    }

    /// Steps with the equations at hand while every point does what they are for; whether that solves it.
    #[inline(never)]
    fn polish(
        &mut self,
        equations: &mut Equations<'_, R, DOF>,
        velocity: &mut Vec7<R>,
        solved: &mut Solved<R>,
    ) -> bool {
        for _ in 0..=self.params.polish_steps {
            let same = self.answer_to(equations.polygon, velocity);
            let at = self.balance(velocity);
            solved.evaluations += 1;
            if self.balanced(&at, solved) {
                return true;
            }
            if !same || solved.work() >= self.budget.max_work {
                return false;
            }
            add_scaled(velocity, -R::one(), &equations.solve(&at.rest));
        }
        false
    }

    /// Takes the solution at `velocity`, or the one with pyramids turned to the slip that it has.
    #[inline(never)]
    fn finish(
        &mut self,
        equations: &mut Equations<'_, R, DOF>,
        mut velocity: Vec7<R>,
        solved: &mut Solved<R>,
    ) {
        self.answer(equations.polygon);
        solved.status = SolveStatus::Solved;
        solved.velocity = self.inertia.unscaled(&velocity);
        let mut best_n = self.misfit_n();
        let mut residual_n = solved.residual_n;
        for _ in 0..self.params.turns {
            // With it one balance at the least.
            let ends = self.params.first_edge != FirstEdge::Slip
                || solved.work().saturating_add(TURN_WORK) >= self.budget.max_work;
            if ends || !self.turn(equations, &mut velocity) {
                break;
            }
            solved.evaluations = solved.evaluations.saturating_add(TURN_WORK);
            let mut good = self.polish(equations, &mut velocity, solved);
            let left = self.left(solved);
            if !good && left > 0 {
                let at = self.set_out(&velocity);
                solved.iterations += 1;
                let (end, kinks) = follow(equations, self.tracks, &mut velocity, &at.rest, left);
                solved.evaluations = solved.evaluations.saturating_add(kinks);
                good = end == End::Arrived && self.polish(equations, &mut velocity, solved);
            }
            if !good {
                break;
            }
            let misfit_n = self.misfit_n();
            if misfit_n < best_n {
                best_n = misfit_n;
                residual_n = solved.residual_n;
                self.answer(equations.polygon);
                solved.velocity = self.inertia.unscaled(&velocity);
            }
        }
        solved.residual_n = residual_n;
    }

    /// Friction that does not act against the slip: of every point that slides times the squared sine of the angle
    /// between them.
    fn misfit_n(&self) -> R {
        self.tracks.iter().filter(|t| matches!(t.mode, Mode::Corner(_) | Mode::Edge(_))).fold(
            R::zero(),
            |sum, t| {
                let friction_n = t.impulse[0] * t.friction;
                let share = Slide::of(t).map_or(R::one(), |slide| {
                    let square = slide.across_m_s * slide.across_m_s;
                    square / (square + slide.along_m_s * slide.along_m_s)
                });
                sum + friction_n * share
            },
        )
    }

    /// Turns the pyramids of the points that slide to their slip, and `velocity` to what it then is about; `false`
    /// where all point along it already.
    ///
    /// A corner whose normal cone holds the slip gives the same friction whatever the slip's direction
    /// in it. Friction that turns also turns the slip: one Newton step on "friction against the slip", which is
    /// the cone's law, finds for all points at once where the two agree.
    #[inline(never)]
    fn turn(&mut self, equations: &mut Equations<'_, R, DOF>, velocity: &mut Vec7<R>) -> bool {
        let slides = || self.tracks.iter().filter_map(|track| Some((track, Slide::of(track)?)));
        if !slides().any(|(_, slide)| abs(slide.across_m_s) > slide.along_m_s * R::of(LEAST_TURN)) {
            return false;
        }
        equations.build(self.tracks);
        let mut matrix = equations.matrix;
        let mut force = [R::zero(); DOF];
        for (track, slide) in slides() {
            let row = slide.row(track);
            let stiffness = slide.friction_n / slide.along_m_s;
            let elastic = match track.mode {
                // It becomes a corner, whose friction does not grow along the edge.
                Mode::Edge(k) => {
                    let share = along(equations.polygon.along(k), slide.across);
                    track.tangent_gain * share * share
                }
                _ => R::zero(),
            };
            for (to, x) in matrix.iter_mut().zip(&row) {
                add_scaled(to, *x * (stiffness - elastic), &row);
            }
            add_scaled(&mut force, stiffness * slide.across_m_s, &row);
        }
        let change = Factors::of(&matrix).solve(&force);
        add_scaled(velocity, R::one(), &change);
        for (p, track) in self.points.iter_mut().zip(self.tracks.iter_mut()) {
            let Some(slide) = Slide::of(track) else { continue };
            let across_m_s = slide.across_m_s - dot(&slide.row(track), &change);
            let [a1, a2] = slide.across;
            let (x, y) = (slide.along_m_s, across_m_s);
            let Some([c, s]) = unit([a2 * x + a1 * y, a2 * y - a1 * x]) else { continue };
            p.first = p.turned_back([c, s]);
            let [_, first, second] = &mut track.rows;
            for (x, y) in first.iter_mut().zip(second) {
                (*x, *y) = (c * *x + s * *y, c * *y - s * *x);
            }
            let [_, x, y] = &mut track.constant;
            (*x, *y) = (c * *x + s * *y, c * *y - s * *x);
        }
        true
    }

    /// Rows, constants and compliances of every point; its pyramid is turned as friction acts at `v`.
    #[inline(never)]
    fn load(&mut self, polygon: &Polygon<R>, v: &Vec7<R>) {
        let (params, scale) = (self.params, self.inertia.scale);
        let (zero, one) = (R::zero(), R::one());
        let (linear, angular) = (Vec3::new(v[0], v[1], v[2]), Vec3::new(v[3], v[4], v[5]));
        let wider = if params.circumscribed { one / polygon.apothem } else { one };
        self.tracks.clear();
        for p in self.points.iter_mut() {
            let g = &p.given;
            let [kn, k1, k2] = g.stiffness_n_s_m;
            let [b0, b1, b2] = g.bias_m_s;
            let larger = max(g.mu[0], g.mu[1]);
            let rubs = larger > zero;
            let least = larger * params.min_friction_ratio;
            p.factor = if rubs { g.mu.map(|mu| max(mu, least)) } else { [one; 2] };
            let arm = g.lever_m * scale;
            p.arm = arm;
            let at = linear + angular.cross(&arm);
            let [n, t1, t2] = &g.axes;
            let [m1, m2] = p.factor;
            // The unbounded friction there, in tangents that are scaled by the coefficients.
            let force = [-k1 * (t1.dot(&at) + b1) / m1, -k2 * (t2.dot(&at) + b2) / m2];
            p.first = match params.first_edge {
                FirstEdge::Fixed(direction) => direction,
                FirstEdge::Slip => {
                    let now = unit(force).unwrap_or([one, zero]);
                    p.held().filter(|held| held[0] * now[0] + held[1] * now[1] > zero).unwrap_or(now)
                }
            };
            let [c, s] = p.first;
            let along = [t1 * (m1 * c) + t2 * (m2 * s), t2 * (m2 * c) - t1 * (m1 * s)];
            let rest = one - p.viscous;
            let mut track = Track::nothing(());
            let row = |axis: &Vec3<R>, jaw: R| {
                let moment = arm.cross(axis);
                [axis.x, axis.y, axis.z, moment.x, moment.y, moment.z, jaw]
            };
            track.rows = [row(n, g.jaw), row(&along[0], zero), row(&along[1], zero)];
            track.constant = [b0 - g.adhesion_n / kn, m1 * c * b1 + m2 * s * b2, m2 * c * b2 - m1 * s * b1];
            track.friction = if rubs { rest * wider } else { zero };
            track.normal_gain = kn;
            track.tangent_gain = k1 / (m1 * m1) * rest;
            // The capacity is that of the points: nothing is refused.
            let _ = self.tracks.push(track);
        }
    }

    /// The masses, with what viscous friction does whatever the normal force.
    fn damped(&self) -> Mat7<R> {
        let mut mass = self.inertia.mass;
        for (p, track) in self.points.iter().zip(self.tracks.iter()) {
            let damping = damping(p, track);
            if !(damping > R::zero()) {
                continue;
            }
            for tangent in [&track.rows[1], &track.rows[2]] {
                for (to, x) in mass.iter_mut().zip(tangent) {
                    add_scaled(to, *x * damping, tangent);
                }
            }
        }
        mass
    }

    /// `M (v - v_free) / dt` less the forces of the points, which are `impulse` of their tracks with their speeds.
    fn balance(&self, v: &Vec7<R>) -> Balance<R> {
        let inertia = &self.inertia;
        let zero = R::zero();
        let mut change = *v;
        let mut rounding_n = zero;
        for (k, (change, free)) in change.iter_mut().zip(&inertia.free).enumerate() {
            if k < 3 {
                rounding_n = max(rounding_n, inertia.rate * (abs(*change) + abs(*free)));
            }
            *change -= *free;
        }
        // Blocks: the object's velocity, its angular velocity, the jaw.
        let row = |r: &[R; DOF]| r[3] * change[3] + r[4] * change[4] + r[5] * change[5];
        let mut rest = [
            inertia.mass[0][0] * change[0],
            inertia.mass[1][1] * change[1],
            inertia.mass[2][2] * change[2],
            row(&inertia.mass[3]),
            row(&inertia.mass[4]),
            row(&inertia.mass[5]),
            inertia.mass[6][6] * change[6],
        ];
        let mut scale_n = R::of(1e-6);
        for k in [0, 1, 2, 6] {
            scale_n = max(scale_n, abs(rest[k]));
        }
        for (p, track) in self.points.iter().zip(self.tracks.iter()) {
            let [normal, first, second] = track.impulse;
            let g = &p.given;
            // Opened, it keeps what viscosity damps and its adhesion pulls with.
            let mut force = [normal - g.adhesion_n, first, second];
            if p.viscous > zero {
                let damping = damping(p, track);
                force[1] -= damping * track.speed[1];
                force[2] -= damping * track.speed[2];
            }
            if force != [zero; 3] {
                p.take_off(track, force, &mut rest);
            }
            if track.mode == Mode::Open {
                continue;
            }
            scale_n = max(scale_n, normal);
            rounding_n = max(rounding_n, g.stiffness_n_s_m[0] * abs(g.bias_m_s[0]));
            if track.mode == Mode::Stick {
                let stiffness = max(g.stiffness_n_s_m[1], g.stiffness_n_s_m[2]);
                rounding_n = max(rounding_n, stiffness * (abs(g.bias_m_s[1]) + abs(g.bias_m_s[2])));
            }
        }
        Balance { rest, scale_n, rounding_n }
    }

    /// Modes, trial impulses and offsets with which the path begins at `v`.
    #[inline(never)]
    fn start(&mut self, polygon: &Polygon<R>, v: &Vec7<R>, start: Start) -> Balance<R> {
        let zero = R::zero();
        let golden = R::of(0.618_033_988_749_894_9);
        let (mut approach, mut share) = (zero, zero);
        for (p, track) in self.points.iter().zip(self.tracks.iter_mut()) {
            track.speed = p.speeds_at(track, v);
            approach = max(approach, -track.speed[0]);
        }
        for (p, track) in self.points.iter().zip(self.tracks.iter_mut()) {
            let natural = track.trial_at(&track.speed);
            track.trial = natural;
            match start {
                Start::Guess => {}
                Start::Before => expect(p, track, polygon),
                Start::Open => {
                    // Different for each, so that no two close together.
                    share =
                        if share + golden < R::one() { share + golden } else { share + golden - R::one() };
                    let opened = approach * (R::of(1.01) + R::of(0.1) * share);
                    track.trial[0] = -track.normal_gain * (track.speed[0] + opened);
                }
            }
            // The offset that turns the natural trial into the one begun with.
            for k in 0..3 {
                let gain = if k == 0 { track.normal_gain } else { track.tangent_gain };
                let changed = track.trial[k] != natural[k];
                track.offset[k] = if changed { (natural[k] - track.trial[k]) / gain } else { zero };
            }
            track.mode = track.classified(polygon);
            track.impulse = track.impulse_of(polygon, &track.trial);
        }
        self.balance(v)
    }

    /// Impulses and modes of the points at `v`; whether the modes are those on the path.
    #[inline(never)]
    fn answer_to(&mut self, polygon: &Polygon<R>, v: &Vec7<R>) -> bool {
        let mut same = true;
        for (p, track) in self.points.iter().zip(self.tracks.iter_mut()) {
            track.speed = p.speeds_at(track, v);
            track.trial = track.trial_at(&track.speed);
            let mode = track.classified(polygon);
            same &= mode == track.mode;
            track.mode = mode;
            track.impulse = track.impulse_of(polygon, &track.trial);
        }
        same
    }

    /// Number of the modes of all points, for [`Kept`].
    fn modes(&self) -> u32 {
        // No number of the cone's, which begins with that of the points.
        self.tracks.iter().fold(!(self.tracks.len() as u32), |code, track| {
            let mode = match track.mode {
                Mode::Open => 0,
                Mode::Stick => 1,
                Mode::Free => 2,
                Mode::Corner(k) => 32 + u32::from(k),
                Mode::Edge(k) => 64 + u32::from(k),
            };
            code.wrapping_mul(0x0100_0193) ^ mode
        })
    }

    /// From the start that balances but for `at`, to the velocity at which every point does what it did before, by the
    /// factors of that solve; `None` where a point does something else there, or the factors no longer serve.
    ///
    /// The trial impulses of a mode are a convex set: where all end in the modes in which they began, the path of
    /// [`follow`] has no kink, and this is its solution without a matrix.
    #[inline(never)]
    fn repeat(
        &mut self,
        equations: &Equations<'_, R, DOF>,
        guess: &Vec7<R>,
        at: &Balance<R>,
        solved: &mut Solved<R>,
    ) -> Option<Vec7<R>> {
        let zero = R::zero();
        let mut rest = at.rest;
        for (p, track) in self.points.iter().zip(self.tracks.iter()) {
            let [normal, first, second] = track.offset;
            if normal != zero || first != zero || second != zero {
                let gain = track.tangent_gain;
                let trial = [track.normal_gain * normal, gain * first, gain * second];
                p.take_off(track, track.impulse_of(equations.polygon, &trial), &mut rest);
            }
        }
        let mut velocity = *guess;
        let mut least_n = at.residual_n();
        for _ in 0..=self.params.polish_steps {
            add_scaled(&mut velocity, -R::one(), &equations.solve(&rest));
            solved.evaluations += 1;
            if !self.answer_to(equations.polygon, &velocity) {
                return None;
            }
            let at = self.balance(&velocity);
            if self.balanced(&at, solved) {
                return Some(velocity);
            }
            // Others' factors that do not bring it down by a power of ten a step cost more than own ones.
            if !(solved.residual_n < least_n * R::of(0.1)) {
                return None;
            }
            least_n = solved.residual_n;
            rest = at.rest;
        }
        None
    }

    /// Forces along the points' own axes.
    #[inline(never)]
    fn answer(&mut self, polygon: &Polygon<R>) {
        self.answers.clear();
        for (p, track) in self.points.iter().zip(self.tracks.iter()) {
            let (zero, g) = (R::zero(), &p.given);
            let [normal, first, second] = track.impulse;
            let slip = p.turned_back([track.speed[1], track.speed[2]]);
            let damping = damping(p, track);
            let friction = p.turned_back([first, second]);
            let total = [0, 1].map(|k| friction[k] - damping * slip[k]);
            let force = [0, 1].map(|k| if track.friction > zero { total[k] * p.factor[k] } else { zero });
            // The coefficients that the pyramid has in the direction of the force.
            let size = sqrt(total[0] * total[0] + total[1] * total[1]);
            let share = match track.mode {
                Mode::Corner(_) | Mode::Edge(_) => size / normal,
                Mode::Stick if size > normal * R::of(1e-6) => {
                    let bounded = sqrt(first * first + second * second);
                    polygon.radius([first, second], bounded) * track.friction / (R::one() - p.viscous)
                }
                _ => R::one(),
            };
            let _ = self.answers.push(Answer {
                force_n: [normal - g.adhesion_n, force[0], force[1]],
                biased_slip_m_s: [slip[0] / p.factor[0], slip[1] / p.factor[1]],
                stiffness_n_s_m: [g.stiffness_n_s_m[1], g.stiffness_n_s_m[2]],
                mu: g.mu.map(|mu| mu * share),
                adhesion_n: g.adhesion_n,
            });
        }
    }
}
