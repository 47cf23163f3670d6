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
//! linear in the number of contacts and factorised in constant time. Where the friction
//! bound's dependence on the normal force spoils the descent, the bound is frozen, the then
//! convex problem is minimised, and the bound is updated (the Tresca fixed point).
//!
//! Certificate: forces obey the contact law by construction, so the only error is that of
//! the momentum balance; it is returned in newtons with every solution.

use crate::real::{Real, Vec3, most};
use heapless::Vec;

/// Most contact points of one solve.
pub const MAX_POINTS: usize = 64;
/// Unknowns: linear velocity (3), angular velocity (3), opening speed of the jaw.
pub const DOF: usize = 7;

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
    /// Newton steps taken.
    pub iterations: u32,
}

/// Limits of the iteration.
#[derive(Clone, Copy, Debug)]
pub struct ConeOptions<R: Real> {
    /// Most Newton steps, all phases together.
    pub max_iterations: u32,
    /// Residual called solved, as a share of the largest force in the balance.
    pub tolerance: R,
}

impl<R: Real> Default for ConeOptions<R> {
    fn default() -> Self {
        Self {
            max_iterations: 60,
            // f32: what summing some twenty forces leaves; f64: far below any use.
            tolerance: most(R::of(100.0) * R::EPSILON, R::of(1e-10)),
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
}

type Vec7<R> = [R; DOF];
type Mat7<R> = [[R; DOF]; DOF];

/// Force of one contact and its negative derivative with respect to `u`.
struct Response<R> {
    force: [R; 3],
    /// `-d f_i / d u_j`; the normal row has only its diagonal.
    slope: [[R; 3]; 3],
}

fn respond<R: Real>(point: &ConePoint<R>, u: [R; 3], frozen: Option<R>) -> Response<R> {
    let zero = R::zero();
    let [kn, k1, k2] = point.stiffness_n_s_m;
    let pressed = -kn * u[0];
    let touching = pressed > -point.adhesion_n;
    let normal = if touching { pressed } else { -point.adhesion_n };
    let mut slope = [[zero; 3]; 3];
    if touching {
        slope[0][0] = kn;
    }
    let bound = match frozen {
        Some(given) => given,
        None => normal + point.adhesion_n,
    };
    let [mu1, mu2] = point.mu;
    if !(bound > zero && mu1 > zero && mu2 > zero) {
        return Response { force: [normal, zero, zero], slope };
    }
    // In tangents scaled by mu the cone is a disc of radius `bound`.
    let y1 = -k1 * u[1] / mu1;
    let y2 = -k2 * u[2] / mu2;
    let square = y1 * y1 + y2 * y2;
    if square <= bound * bound {
        slope[1][1] = k1;
        slope[2][2] = k2;
        return Response { force: [normal, mu1 * y1, mu2 * y2], slope };
    }
    let inverse = R::one() / square.root();
    let (e1, e2) = (y1 * inverse, y2 * inverse);
    let (q1, q2) = (mu1 * e1, mu2 * e2);
    let s = bound * inverse;
    slope[1][1] = s * (R::one() - e1 * e1) * k1;
    slope[1][2] = -s * mu1 * e1 * e2 * k2 / mu2;
    slope[2][1] = -s * mu2 * e2 * e1 * k1 / mu1;
    slope[2][2] = s * (R::one() - e2 * e2) * k2;
    if touching && frozen.is_none() {
        slope[1][0] = q1 * kn;
        slope[2][0] = q2 * kn;
    }
    Response { force: [normal, bound * q1, bound * q2], slope }
}

fn relative_velocity<R: Real>(p: &ConePoint<R>, v: &Vec7<R>) -> [R; 3] {
    let w = Vec3::new(v[3], v[4], v[5]);
    let at = Vec3::new(v[0], v[1], v[2]) + w.cross(&p.lever_m);
    [
        p.axes[0].dot(&at) + p.jaw * v[6] + p.bias_m_s[0],
        p.axes[1].dot(&at) + p.bias_m_s[1],
        p.axes[2].dot(&at) + p.bias_m_s[2],
    ]
}

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

/// A solve in progress: the problem and its scaling.
struct Problem<'a, R: Real> {
    points: &'a [ConePoint<R>],
    /// `M / dt`.
    momentum: [[R; 3]; 3],
    mass_rate: R,
    jaw_rate: R,
    free: Vec7<R>,
    /// Radius of gyration, m: weighs torques against forces.
    radius_m: R,
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

    fn balance(&self, v: &Vec7<R>, bound: Bound<'_, R>, mut jacobian: Option<&mut Mat7<R>>) -> Balance<R> {
        let zero = R::zero();
        let mut f = self.inertial(v);
        let mut scale = f.iter().take(3).fold(R::of(1e-6), |s, x| most(s, x.abs()));
        scale = most(scale, f[6].abs());
        let mut rounding = zero;
        for (v, free) in v.iter().zip(self.free.iter()).take(3) {
            rounding = most(rounding, self.mass_rate * (v.abs() + free.abs()));
        }
        if let Some(h) = jacobian.as_deref_mut() {
            *h = [[zero; DOF]; DOF];
            for i in 0..3 {
                h[i][i] = self.mass_rate;
                for j in 0..3 {
                    h[3 + i][3 + j] = self.momentum[i][j];
                }
            }
            h[6][6] = self.jaw_rate;
        }
        for (i, p) in self.points.iter().enumerate() {
            let u = relative_velocity(p, v);
            let frozen = match bound {
                Bound::Coupled => None,
                Bound::Frozen(b) => Some(b.get(i).copied().unwrap_or(zero)),
            };
            let r = respond(p, u, frozen);
            if r.force[0] == zero && r.slope[0][0] == zero && r.force[1] == zero && r.force[2] == zero {
                continue;
            }
            let force = p.axes[0] * r.force[0] + p.axes[1] * r.force[1] + p.axes[2] * r.force[2];
            let torque = p.lever_m.cross(&force);
            for k in 0..3 {
                f[k] -= force[k];
                f[3 + k] -= torque[k];
            }
            f[6] -= p.jaw * r.force[0];
            scale = most(scale, r.force[0].abs());
            rounding = most(rounding, p.stiffness_n_s_m[0] * (u[0].abs() + p.bias_m_s[0].abs()));
            let across = u[1].abs() + p.bias_m_s[1].abs() + u[2].abs() + p.bias_m_s[2].abs();
            rounding = most(rounding, r.slope[1][1] * across);
            if let Some(h) = jacobian.as_deref_mut() {
                add_slope(h, p, &r.slope);
            }
        }
        Balance { f, scale_n: scale, rounding_n: rounding * R::of(32.0) * R::EPSILON }
    }

    /// Largest entry in newtons.
    fn size(&self, f: &Vec7<R>) -> R {
        let mut s = R::zero();
        for (i, x) in f.iter().enumerate() {
            let n = if (3..6).contains(&i) { x.abs() / self.radius_m } else { x.abs() };
            // A NaN must win: it is the worst residual there is.
            if !(n <= s) {
                s = n;
            }
        }
        s
    }

    /// Sum of squares in newtons, the merit of a line search.
    fn merit(&self, f: &Vec7<R>) -> R {
        let mut s = R::zero();
        for (i, x) in f.iter().enumerate() {
            let n = if (3..6).contains(&i) { *x / self.radius_m } else { *x };
            s += n * n;
        }
        s
    }
}

/// Adds `J' S J` of one contact.
fn add_slope<R: Real>(h: &mut Mat7<R>, p: &ConePoint<R>, s: &[[R; 3]; 3]) {
    let [n, t1, t2] = &p.axes;
    // Columns of S contracted with the axes: force change per unit relative velocity.
    let gn = n * s[0][0] + t1 * s[1][0] + t2 * s[2][0];
    let g1 = t1 * s[1][1] + t2 * s[2][1];
    let g2 = t1 * s[1][2] + t2 * s[2][2];
    let r = &p.lever_m;
    // d(relative velocity)/d(angular velocity) along each axis.
    let (an, a1, a2) = (r.cross(n), r.cross(t1), r.cross(t2));
    // d(torque)/d(relative velocity) along each axis.
    let (mn, m1, m2) = (r.cross(&gn), r.cross(&g1), r.cross(&g2));
    for i in 0..3 {
        for j in 0..3 {
            h[i][j] += gn[i] * n[j] + g1[i] * t1[j] + g2[i] * t2[j];
            h[i][3 + j] += gn[i] * an[j] + g1[i] * a1[j] + g2[i] * a2[j];
            h[3 + i][j] += mn[i] * n[j] + m1[i] * t1[j] + m2[i] * t2[j];
            h[3 + i][3 + j] += mn[i] * an[j] + m1[i] * a1[j] + m2[i] * a2[j];
        }
        if p.jaw != R::zero() {
            h[i][6] += gn[i] * p.jaw;
            h[3 + i][6] += mn[i] * p.jaw;
            h[6][i] += p.jaw * s[0][0] * n[i];
            h[6][3 + i] += p.jaw * s[0][0] * an[i];
        }
    }
    h[6][6] += p.jaw * p.jaw * s[0][0];
}

/// Solves `A x = b` in place by elimination with row pivoting; `None` where A is singular.
fn eliminate<R: Real>(a: &mut Mat7<R>, b: &mut Vec7<R>) -> Option<()> {
    for k in 0..DOF {
        let mut pivot = k;
        for i in k + 1..DOF {
            if a[i][k].abs() > a[pivot][k].abs() {
                pivot = i;
            }
        }
        if !(a[pivot][k].abs() > R::zero()) {
            return None;
        }
        a.swap(k, pivot);
        b.swap(k, pivot);
        let inverse = R::one() / a[k][k];
        let row = a[k];
        let right = b[k];
        for i in k + 1..DOF {
            let m = a[i][k] * inverse;
            if m != R::zero() {
                for j in k + 1..DOF {
                    a[i][j] -= m * row[j];
                }
                b[i] -= m * right;
            }
        }
    }
    for k in (0..DOF).rev() {
        let mut s = b[k];
        for j in k + 1..DOF {
            s -= a[k][j] * b[j];
        }
        b[k] = s / a[k][k];
    }
    b.iter().all(|x| x.finite()).then_some(())
}

fn newton_direction<R: Real>(h: &Mat7<R>, f: &Vec7<R>, radius: R) -> Option<Vec7<R>> {
    // Angles are measured as arc length at the radius of gyration: rows and columns of
    // one magnitude, so that pivoting compares like with like.
    let mut a = *h;
    let mut b = *f;
    let scale = R::one() / radius;
    for i in 0..DOF {
        for j in 0..DOF {
            if (3..6).contains(&i) {
                a[i][j] *= scale;
            }
            if (3..6).contains(&j) {
                a[i][j] *= scale;
            }
        }
        b[i] = if (3..6).contains(&i) { -b[i] * scale } else { -b[i] };
    }
    eliminate(&mut a, &mut b)?;
    for x in b.iter_mut().take(6).skip(3) {
        *x *= scale;
    }
    Some(b)
}

fn advance<R: Real>(v: &Vec7<R>, d: &Vec7<R>, step: R) -> Vec7<R> {
    let mut w = *v;
    for (w, d) in w.iter_mut().zip(d.iter()) {
        *w += step * *d;
    }
    w
}

fn valid<R: Real>(points: &[ConePoint<R>], bodies: &Bodies<R>) -> bool {
    let positive = |x: R| x.finite() && x > R::zero();
    let i = &bodies.inertia_kg_m2;
    positive(bodies.mass_kg)
        && positive(bodies.jaw_mass_kg)
        && positive(bodies.dt_s)
        && bodies.free.iter().all(|x| x.finite())
        && i.iter().flatten().all(|x| x.finite())
        && (0..3).all(|k| positive(i[k][k]))
        && points.iter().all(|p| {
            p.lever_m.iter().all(|x| x.finite())
                && p.axes.iter().all(|a| a.iter().all(|x| x.finite()))
                && p.bias_m_s.iter().all(|x| x.finite())
                && p.stiffness_n_s_m.iter().all(|k| positive(*k))
                && p.mu.iter().all(|m| m.finite() && *m >= R::zero())
                && p.adhesion_n.finite()
                && p.adhesion_n >= R::zero()
                && p.jaw.finite()
        })
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
    if points.len() > MAX_POINTS || !valid(points, bodies) {
        return ConeSolution {
            velocity: *guess,
            force_n: Vec::new(),
            status: ConeStatus::BadInput,
            residual_n: R::zero(),
            iterations: 0,
        };
    }
    let rate = R::one() / bodies.dt_s;
    let mut momentum = bodies.inertia_kg_m2;
    let trace = momentum[0][0] + momentum[1][1] + momentum[2][2];
    momentum.iter_mut().flatten().for_each(|x| *x *= rate);
    let problem = Problem {
        points,
        momentum,
        mass_rate: bodies.mass_kg * rate,
        jaw_rate: bodies.jaw_mass_kg * rate,
        free: bodies.free,
        radius_m: (trace / (R::of(3.0) * bodies.mass_kg)).root(),
    };
    let start = if guess.iter().all(|x| x.finite()) { *guess } else { bodies.free };
    let (velocity, residual_n, status, iterations) = problem.coupled(start, options);
    let mut force_n = Vec::new();
    for p in points {
        let u = relative_velocity(p, &velocity);
        // Capacity is that of `points`, so this cannot fail.
        let _ = force_n.push(respond(p, u, None).force);
    }
    ConeSolution { velocity, force_n, status, residual_n, iterations }
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
    fn coupled(&self, start: Vec7<R>, options: &ConeOptions<R>) -> (Vec7<R>, R, ConeStatus, u32) {
        let mut p = Progress { velocity: start, best: start, best_size_n: R::of(1e30), used: 0 };
        let mut phase = self.newton(&mut p, options, options.max_iterations);
        if phase == Phase::Stalled {
            let mut bounds = [R::zero(); MAX_POINTS];
            p.velocity = p.best;
            self.normal_bounds(&p.best, &mut bounds);
            let mut relaxation = R::one();
            let mut before = [R::zero(); MAX_POINTS];
            while p.used < options.max_iterations {
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
                    relaxation = most(relaxation * R::of(0.5), R::of(0.2));
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
    fn newton(&self, p: &mut Progress<R>, options: &ConeOptions<R>, steps: u32) -> Phase {
        let mut jacobian = [[R::zero(); DOF]; DOF];
        let mut taken = 0;
        let mut trusted = 0u8;
        let mut at = self.balance(&p.velocity, Bound::Coupled, Some(&mut jacobian));
        // Matrix and balance of the full step: mostly the next iterate's.
        let mut ahead = jacobian;
        loop {
            let size = self.size(&at.f);
            let solved = size <= at.tolerance_n(options);
            if solved || size < p.best_size_n {
                p.best = p.velocity;
                p.best_size_n = size;
            }
            if solved {
                return Phase::Solved;
            }
            if p.used >= options.max_iterations {
                return Phase::Limit;
            }
            if taken >= steps {
                return Phase::Stalled;
            }
            taken += 1;
            p.used += 1;
            let Some(d) = newton_direction(&jacobian, &at.f, self.radius_m) else {
                return Phase::Singular;
            };
            let merit = self.merit(&at.f);
            let enough = |m: R, step: R| m < merit * (R::one() - R::of(0.1) * step);
            let full = advance(&p.velocity, &d, R::one());
            let there = self.balance(&full, Bound::Coupled, Some(&mut ahead));
            let mut shorter = None;
            let accepted = enough(self.merit(&there.f), R::one());
            if !accepted {
                let mut step = R::one();
                for _ in 0..3 {
                    step *= R::of(0.4);
                    let trial = advance(&p.velocity, &d, step);
                    if enough(self.merit(&self.balance(&trial, Bound::Coupled, None).f), step) {
                        shorter = Some(trial);
                        break;
                    }
                }
            }
            match shorter {
                Some(trial) => {
                    p.velocity = trial;
                    at = self.balance(&trial, Bound::Coupled, Some(&mut jacobian));
                }
                // Kinks of the law make the size rise before it falls: a few full steps are
                // taken on trust.
                None if accepted || trusted < 3 => {
                    trusted += u8::from(!accepted);
                    p.velocity = full;
                    at = there;
                    jacobian = ahead;
                }
                None => return Phase::Stalled,
            }
        }
    }

    /// Friction bound of each contact from its normal force at `v`.
    fn normal_bounds(&self, v: &Vec7<R>, bounds: &mut [R; MAX_POINTS]) {
        for (b, p) in bounds.iter_mut().zip(self.points.iter()) {
            let r = respond(p, relative_velocity(p, v), None);
            *b = most(r.force[0] + p.adhesion_n, R::zero());
        }
    }

    /// Minimises the convex problem with the friction bounds held fixed.
    fn frozen(&self, start: Vec7<R>, bounds: &[R], used: &mut u32, options: &ConeOptions<R>) -> Vec7<R> {
        let mut v = start;
        let bound = Bound::Frozen(bounds);
        let mut jacobian = [[R::zero(); DOF]; DOF];
        for _ in 0..20 {
            let at = self.balance(&v, bound, Some(&mut jacobian));
            if self.size(&at.f) <= at.tolerance_n(options) || *used >= options.max_iterations {
                break;
            }
            *used += 1;
            let Some(d) = newton_direction(&jacobian, &at.f, self.radius_m) else {
                break;
            };
            // F is the gradient of a convex function: along a descent direction its
            // component changes sign once, at the minimum.
            let along = |f: &Vec7<R>| f.iter().zip(d.iter()).fold(R::zero(), |s, (f, d)| s + *f * *d);
            let slope = along(&at.f);
            let mut step = R::one();
            for _ in 0..12 {
                let s = along(&self.balance(&advance(&v, &d, step), bound, None).f);
                if s <= R::of(-0.5) * slope {
                    break;
                }
                // Secant estimate of the sign change, kept inside the bracket.
                step *= most(R::of(0.1), slope / (slope - s));
            }
            v = advance(&v, &d, step);
        }
        v
    }
}
