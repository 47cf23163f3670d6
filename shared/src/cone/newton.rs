//! The iteration: semismooth Newton on the momentum balance, its line search, and the Tresca fixed
//! point where the descent stalls. See [`super`] for the method.

use super::params::ConeParams;
use super::patch::{Bound, Patch, add_jacobian, curvature, find_kinks, subtract_forces};
use super::point::{Local, modes};
use crate::linear::{Kept, Vec7};
use crate::real::{Real, abs, clamp, max};
use crate::solve::{DOF, MAX_POINTS, SolveBudget, SolveStatus};
use heapless::Vec;

/// The momentum residual `F(v)`, a scale of its terms (N), and optionally its Jacobian.
pub(super) struct Residual<R> {
    f: Vec7<R>,
    /// Largest force in it.
    scale_n: R,
    /// What rounding of velocities can do to the stiffest contact's force.
    rounding_n: R,
}

impl<R: Real> Residual<R> {
    fn tolerance_n(&self, options: &SolveBudget<R>) -> R {
        options.tolerance * self.scale_n + self.rounding_n
    }
}

/// A solve in progress. Angular velocities are multiplied by the radius of gyration, moments
/// divided by it: all components of a vector are then comparable.
pub(super) struct Problem<'a, R: Real> {
    pub(super) patches: &'a [Patch<R>],
    pub(super) points: &'a mut [Local<R>],
    /// `M / dt`.
    pub(super) momentum: [[R; 3]; 3],
    pub(super) mass_rate: R,
    pub(super) jaw_rate: R,
    pub(super) free: Vec7<R>,
    /// Evaluations of the residual made.
    pub(super) evaluations: u32,
    /// Whether to begin with what the points did before.
    pub(super) expected: bool,
    pub(super) dt_s: R,
    pub(super) kept: &'a mut Kept<R>,
    pub(super) params: &'a ConeParams<R>,
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

    /// The momentum residual at `v`; the points keep their answers for [`Self::factorise`].
    pub(super) fn residual(&mut self, v: &Vec7<R>, bound: Bound<'_, R>) -> Residual<R> {
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
        Residual { f, scale_n: scale, rounding_n: rounding * self.params.roundings * R::EPSILON }
    }

    /// Whether the work of the solve is used up, `used` Newton steps among it.
    fn spent(&self, used: u32, options: &SolveBudget<R>) -> bool {
        self.evaluations >= options.evaluations_beside(used)
    }

    /// Whether the factors at hand were made for what the points do now.
    fn fits(&self) -> bool {
        self.kept.dt_s == self.dt_s && self.kept.modes == modes(self.points)
    }

    /// Factors of the generalised Jacobian where the last balance was taken; `false` where it is singular.
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
        add_jacobian(self.patches, self.points, bound, h);
        let regular = self.kept.factors.factorise();
        // Those with friction bounds held are for no other solve.
        let lasting = regular && !matches!(bound, Bound::Frozen(_));
        self.kept.dt_s = if lasting { self.dt_s } else { R::zero() };
        self.kept.modes = modes(self.points);
        regular
    }
}

/// Largest entry (maximum norm), N.
fn largest<R: Real>(f: &Vec7<R>) -> R {
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

/// Where an iteration stands.
struct Progress<R> {
    velocity: Vec7<R>,
    best: Vec7<R>,
    best_n: R,
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
    pub(super) fn coupled(
        &mut self,
        start: Vec7<R>,
        options: &SolveBudget<R>,
    ) -> (Vec7<R>, R, SolveStatus, u32) {
        let mut p = Progress { velocity: start, best: start, best_n: R::of(1e30), used: 0 };
        let mut phase = self.newton(&mut p, options, self.params.first_steps);
        if phase == Phase::Stalled {
            let mut bounds = [R::zero(); MAX_POINTS];
            p.velocity = p.best;
            self.normal_bounds(&p.best, &mut bounds);
            let mut relaxation = R::one();
            let mut before = [R::zero(); MAX_POINTS];
            while !self.spent(p.used, options) {
                let relaxed = self.frozen(p.velocity, &bounds, &mut p.used, options);
                p.velocity = relaxed;
                phase = self.newton(&mut p, options, self.params.later_steps);
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
                    relaxation = max(relaxation * R::of(0.5), self.params.min_relaxation);
                }
                for (b, change) in bounds.iter_mut().zip(before.iter()) {
                    *b += relaxation * *change;
                }
            }
        }
        // What was evaluated last is the best there is where it is solved.
        let status = match phase {
            Phase::Solved => SolveStatus::Solved,
            Phase::Singular => SolveStatus::Numerical,
            Phase::Stalled | Phase::Limit => SolveStatus::IterationLimit,
        };
        (p.best, p.best_n, status, p.used)
    }

    /// At most `steps` Newton steps with a line search on the norm of the residual.
    fn newton(&mut self, p: &mut Progress<R>, options: &SolveBudget<R>, steps: u32) -> Phase {
        let mut taken = 0;
        let mut trusted = 0_u8;
        let mut fresh = true;
        let mut at = self.residual(&p.velocity, Bound::Coupled);
        loop {
            let norm = largest(&at.f);
            let solved = norm <= at.tolerance_n(options);
            if solved || norm < p.best_n {
                p.best = p.velocity;
                p.best_n = norm;
            }
            if solved {
                return Phase::Solved;
            }
            if self.spent(p.used, options) {
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
                if merit(&at.f) < before * self.params.good_share {
                    continue;
                }
            }
            taken += 1;
            if self.spent(p.used + 1, options) {
                return Phase::Limit;
            }
            p.used += 1;
            if !self.factorise(Bound::Coupled) {
                return Phase::Singular;
            }
            let Some(d) = self.kept.factors.solve_negative(&at.f) else {
                return Phase::Singular;
            };
            let before = merit(&at.f);
            let (trial, there) = if slope(&at.f, &d) < R::zero() {
                self.search(&p.velocity, &d, &at.f, Bound::Coupled, options.evaluations_beside(p.used))
            } else if trusted < self.params.trusted_steps {
                // Where friction couples strongly to the normal force, the step need not descend.
                trusted += 1;
                let full = advance(&p.velocity, &d, R::one());
                (full, self.residual(&full, Bound::Coupled))
            } else {
                return Phase::Stalled;
            };
            p.velocity = trial;
            at = there;
            if merit(&at.f) < before * self.params.good_share {
                at = self.polish(p, at, options);
            }
        }
    }

    /// First step where a point touches at the last velocity that was open before, or the reverse:
    /// to the velocity at which all do what they did before.
    fn as_before(&mut self, p: &mut Progress<R>, at: Residual<R>, options: &SolveBudget<R>) -> Residual<R> {
        let expected = self.residual(&p.velocity, Bound::Expected);
        let made = self.fits() || {
            p.used += 1;
            self.factorise(Bound::Expected)
        };
        let step = if made { self.kept.factors.solve_negative(&expected.f) } else { None };
        let Some(d) = step else {
            return self.residual(&p.velocity, Bound::Coupled);
        };
        let start = p.velocity;
        p.velocity = advance(&start, &d, R::one());
        let there = self.residual(&p.velocity, Bound::Coupled);
        if merit(&there.f) < merit(&at.f) * self.params.good_share {
            return self.polish(p, there, options);
        }
        if !(merit(&there.f) < merit(&at.f)) {
            // They do something else now.
            p.velocity = start;
            return self.residual(&start, Bound::Coupled);
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
        most_evaluations: u32,
    ) -> (Vec7<R>, Residual<R>) {
        let zero = R::zero();
        let along = |f: &Vec7<R>| slope(f, d);
        let enough = abs(along(f)) * self.params.search_share;
        let mut kinks: Vec<R, { 2 * MAX_POINTS }> = Vec::new();
        // Ends of the bracket, and the components there.
        let (mut low, mut high) = ((zero, along(f)), (zero, zero));
        let mut step = R::one();
        let mut trial = advance(v, d, step);
        let mut there = self.residual(&trial, bound);
        let mut turned = along(&there.f);
        if !(turned > enough) {
            return (trial, there);
        }
        // Where the component turns, it mostly does at the kink of one contact.
        find_kinks(self.patches, self.points, v, d, &mut kinks);
        for _ in 0..self.params.search_steps {
            if self.evaluations >= most_evaluations {
                break;
            }
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
            there = self.residual(&trial, bound);
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
    fn polish(&mut self, p: &mut Progress<R>, mut at: Residual<R>, options: &SolveBudget<R>) -> Residual<R> {
        for _ in 0..self.params.polish_steps {
            if largest(&at.f) <= at.tolerance_n(options) || self.spent(p.used, options) {
                break;
            }
            let Some(d) = self.kept.factors.solve_negative(&at.f) else { break };
            let trial = advance(&p.velocity, &d, R::one());
            let there = self.residual(&trial, Bound::Coupled);
            let (before, after) = (merit(&at.f), merit(&there.f));
            if !(after < before) {
                // The points answer for the velocity that is kept.
                return self.residual(&p.velocity, Bound::Coupled);
            }
            p.velocity = trial;
            at = there;
            if !(after < before * self.params.good_share) {
                break;
            }
        }
        at
    }

    /// Friction bound of each contact from its normal force at `v`.
    fn normal_bounds(&mut self, v: &Vec7<R>, bounds: &mut [R; MAX_POINTS]) {
        self.residual(v, Bound::Coupled);
        for (b, p) in bounds.iter_mut().zip(self.points.iter()) {
            *b = p.bound();
        }
    }

    /// Minimises the convex problem with the friction bounds held fixed.
    fn frozen(&mut self, start: Vec7<R>, bounds: &[R], used: &mut u32, options: &SolveBudget<R>) -> Vec7<R> {
        let mut v = start;
        let bound = Bound::Frozen(bounds);
        let mut at = self.residual(&v, bound);
        for _ in 0..self.params.frozen_steps {
            if largest(&at.f) <= at.tolerance_n(options) || self.spent(*used + 1, options) {
                break;
            }
            *used += 1;
            let regular = self.factorise(bound);
            let direction = if regular { self.kept.factors.solve_negative(&at.f) } else { None };
            let Some(d) = direction else {
                break;
            };
            (v, at) = self.search(&v, &d, &at.f, bound, options.evaluations_beside(*used));
        }
        v
    }
}
