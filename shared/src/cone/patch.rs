//! Contact points in groups that share their axes: the points of one fingertip, of one face.
//!
//! In the axes of its patch a point at `(d_n, d_1, d_2)` from the patch's centre sees the
//! patch's velocity `V` and angular velocity `W` as
//! `u = V + W x d`, so that its normal row of the Jacobian has three entries and each
//! tangential row three others. Forces, moments and the stiffness matrix are summed in these
//! axes and turned into the object's once a patch.
//!
//! Angular velocities are multiplied and lengths divided by the radius of gyration: all
//! numbers of the balance are then newtons and metres a second.

use super::point::{Friction, Local};
use crate::linear::{Mat7, Vec7};
use crate::real::{Real, Vec3, abs, max};
use crate::solve::ContactPoint;

/// How the friction bound enters an evaluation.
#[derive(Clone, Copy)]
pub(super) enum Bound<'a, R> {
    /// From the normal force at the same velocity (the real problem).
    Coupled,
    /// Given, one a contact (Tresca friction: the problem is then convex).
    Frozen(&'a [R]),
    /// Coupled, in the modes that the points are expected to be in.
    Expected,
}

/// Axes and centre of a patch, and how many points it has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch<R: Real> {
    /// Normal and tangents, right-handed.
    axes: [Vec3<R>; 3],
    /// Whether the axes were right-handed as they were given.
    side: bool,
    centre: Vec3<R>,
    jaw: R,
    pub(super) count: usize,
}

impl<R: Real> Patch<R> {
    /// The patch that begins with `first`, without points yet; lengths are multiplied by `scale`.
    pub(super) fn new(first: &ContactPoint<R>, scale: R) -> Self {
        let [n, t1, t2] = first.axes;
        let right_handed = n.cross(&t1).dot(&t2) > R::zero();
        let axes = [n, t1, if right_handed { t2 } else { -t2 }];
        Self { axes, side: right_handed, centre: first.lever_m * scale, jaw: first.jaw, count: 0 }
    }

    /// Whether `p` has the axes of the patch.
    #[inline(always)]
    pub(super) fn holds(&self, p: &ContactPoint<R>) -> bool {
        let t2 = if self.side { self.axes[2] } else { -self.axes[2] };
        self.axes[0] == p.axes[0] && self.axes[1] == p.axes[1] && t2 == p.axes[2] && self.jaw == p.jaw
    }

    /// Writes `p` in the axes of the patch; returns a number that is zero where all of its
    /// numbers are finite, else NaN.
    #[inline(always)]
    pub(super) fn place(&self, p: &ContactPoint<R>, scale: R, to: &mut Local<R>) -> R {
        let zero = R::zero();
        let side = if self.side { R::one() } else { -R::one() };
        let from = p.lever_m * scale - self.centre;
        let [kn, k1, k2] = p.stiffness_n_s_m;
        let [b0, b1, b2] = p.bias_m_s;
        let [mu1, mu2] = p.mu;
        to.at = [self.axes[0].dot(&from), self.axes[1].dot(&from), self.axes[2].dot(&from)];
        to.bias = [b0, b1, b2 * side];
        to.normal_stiffness = kn;
        to.stiffness = [k1, k2];
        to.mu = p.mu;
        to.adhesion = p.adhesion_n;
        to.viscous = zero;
        if p.viscous_n_s_m > zero {
            to.viscous = p.viscous_n_s_m / (max(k1, k2) + p.viscous_n_s_m);
        }
        to.side = side;
        to.bias_force = [kn * abs(b0), max(k1, k2) * (abs(b1) + abs(b2))];
        (to.gain, to.across, to.weight) = ([zero; 2], [zero; 2], zero);
        if mu1 > zero && mu2 > zero {
            let (by1, by2) = (R::one() / mu1, R::one() / mu2);
            to.gain = [k1 * by1, k2 * by2];
            to.across = [mu1 * by2, mu2 * by1];
            to.weight = to.gain[0] * by1;
        }
        let numbers = to.at[0] + to.at[1] + to.at[2] + to.bias_force[0] + to.bias_force[1];
        (numbers + mu1 + mu2 + p.adhesion_n + p.viscous_n_s_m + p.jaw) * zero
    }
}

/// Sum of the forces of a patch, about its centre and along its axes, and their sizes.
struct Sum<R> {
    force: [R; 3],
    moment: [R; 3],
}

/// Subtracts the contact forces at velocity `v` from `f`; raises `scale` to the largest of
/// them and `rounding` to the largest force of a bias.
pub(super) fn subtract_forces<R: Real>(
    patches: &[Patch<R>],
    points: &mut [Local<R>],
    v: &Vec7<R>,
    bound: Bound<'_, R>,
    f: &mut Vec7<R>,
    scale: &mut R,
    rounding: &mut R,
) {
    let zero = R::zero();
    let mut rest = points;
    let mut index = 0;
    for patch in patches {
        let (own, others) = rest.split_at_mut(patch.count.min(rest.len()));
        rest = others;
        let [n, t1, t2] = &patch.axes;
        let twist = patch.twist(v);
        let mut sum = Sum { force: [zero; 3], moment: [zero; 3] };
        for p in own {
            let [dn, d1, d2] = p.at;
            let u = p.moved(&twist);
            let u = [u[0] + p.bias[0], u[1] + p.bias[1], u[2] + p.bias[2]];
            match bound {
                Bound::Coupled => p.answer(u, None),
                Bound::Frozen(list) => p.answer(u, Some(list.get(index).copied().unwrap_or(zero))),
                Bound::Expected => p.as_expected(u),
            }
            index += 1;
            let [fn_, f1, f2] = p.force;
            if p.touching {
                *scale = max(*scale, fn_);
                *rounding = max(*rounding, p.bias_force[0]);
                if p.friction == Friction::Stick {
                    *rounding = max(*rounding, p.bias_force[1]);
                }
            } else if p.friction == Friction::None && p.adhesion == zero {
                continue;
            }
            sum.force[0] += fn_;
            sum.force[1] += f1;
            sum.force[2] += f2;
            sum.moment[0] += d1 * f2 - d2 * f1;
            sum.moment[1] += d2 * fn_ - dn * f2;
            sum.moment[2] += dn * f1 - d1 * fn_;
        }
        let force = n * sum.force[0] + t1 * sum.force[1] + t2 * sum.force[2];
        let own_moment = n * sum.moment[0] + t1 * sum.moment[1] + t2 * sum.moment[2];
        let moment = own_moment + patch.centre.cross(&force);
        for k in 0..3 {
            f[k] -= force[k];
            f[3 + k] -= moment[k];
        }
        f[6] -= patch.jaw * sum.force[0];
    }
}

/// Sum of `u' S u` with the velocities `u` that `d` gives to the points, in their present modes.
pub(super) fn curvature<R: Real>(
    patches: &[Patch<R>],
    points: &[Local<R>],
    d: &Vec7<R>,
    bound: Bound<'_, R>,
) -> R {
    let coupled = !matches!(bound, Bound::Frozen(_));
    let mut sum = R::zero();
    let mut rest = points;
    for patch in patches {
        let (own, others) = rest.split_at(patch.count.min(rest.len()));
        rest = others;
        let twist = patch.twist(d);
        for p in own {
            let [u0, u1, u2] = p.moved(&twist);
            if p.touching {
                sum += p.normal_stiffness * u0 * u0;
            }
            match p.friction {
                Friction::None => {}
                Friction::Stick => sum += p.stiffness[0] * u1 * u1 + p.stiffness[1] * u2 * u2,
                Friction::Slip => {
                    let [q1, q2] = p.q;
                    let across = q1 * p.across[1] * u2 - q2 * p.across[0] * u1;
                    sum += p.s * p.weight * across * across;
                    if p.viscous > R::zero() {
                        let [a, b] = p.stiffness.map(|k| k * p.viscous);
                        sum += a * u1 * u1 + b * u2 * u2;
                    }
                    if coupled && p.touching {
                        sum += p.normal_stiffness * u0 * (q1 * u1 + q2 * u2);
                    }
                }
            }
        }
    }
    sum
}

/// Velocity and angular velocity of a patch in its axes.
struct Twist<R> {
    linear: [R; 3],
    angular: [R; 3],
}

impl<R: Real> Patch<R> {
    #[inline(always)]
    fn twist(&self, v: &Vec7<R>) -> Twist<R> {
        let (linear, turning) = (Vec3::new(v[0], v[1], v[2]), Vec3::new(v[3], v[4], v[5]));
        let at = linear + turning.cross(&self.centre);
        let [n, t1, t2] = &self.axes;
        Twist {
            linear: [n.dot(&at) + self.jaw * v[6], t1.dot(&at), t2.dot(&at)],
            angular: [n.dot(&turning), t1.dot(&turning), t2.dot(&turning)],
        }
    }
}

impl<R: Real> Local<R> {
    /// Velocity of the point, without bias.
    #[inline(always)]
    fn moved(&self, twist: &Twist<R>) -> [R; 3] {
        let ([vn, v1, v2], [wn, w1, w2], [dn, d1, d2]) = (twist.linear, twist.angular, self.at);
        [vn + w1 * d2 - w2 * d1, v1 + w2 * dn - wn * d2, v2 + wn * d1 - w1 * dn]
    }
}

/// Steps in 0 to 1 along `d` from `v` at which a contact opens or closes, or its slip is least.
pub(super) fn find_kinks<R: Real, const N: usize>(
    patches: &[Patch<R>],
    points: &[Local<R>],
    v: &Vec7<R>,
    d: &Vec7<R>,
    out: &mut heapless::Vec<R, N>,
) {
    let zero = R::zero();
    let mut add = |over: R, under: R| {
        if under > zero && over > zero && over < under {
            // Two a point, and room for that.
            let _ = out.push(over / under);
        } else if under < zero && over < zero && over > under {
            let _ = out.push(over / under);
        }
    };
    let mut rest = points;
    for patch in patches {
        let (own, others) = rest.split_at(patch.count.min(rest.len()));
        rest = others;
        let (from, along) = (patch.twist(v), patch.twist(d));
        for p in own {
            let (u, du) = (p.moved(&from), p.moved(&along));
            let u = [u[0] + p.bias[0], u[1] + p.bias[1], u[2] + p.bias[2]];
            add(p.adhesion / p.normal_stiffness - u[0], du[0]);
            if p.gain[0] > zero {
                let square = du[1] * du[1] + du[2] * du[2];
                add(-(u[1] * du[1] + u[2] * du[2]), square);
            }
        }
    }
}

/// Row by column, patch axes: force (or moment) per velocity (or angular velocity).
type Block<R> = [[R; 3]; 3];

/// Adds `J' S J` of the contacts in their present modes to `h`.
pub(super) fn add_jacobian<R: Real>(
    patches: &[Patch<R>],
    points: &[Local<R>],
    bound: Bound<'_, R>,
    h: &mut Mat7<R>,
) {
    let coupled = !matches!(bound, Bound::Frozen(_));
    let mut rest = points;
    for patch in patches {
        let (own, others) = rest.split_at(patch.count.min(rest.len()));
        rest = others;
        if own.iter().any(|p| p.touching || p.friction != Friction::None) {
            let sums = Slopes::of(own, coupled);
            patch.add(&sums, h);
        }
    }
}

/// Stiffness of a patch. Rows and columns of the tangential part: along t1 and t2, about n,
/// t1, t2; of the normal part: along n, about t1 and t2.
struct Slopes<R> {
    normal: [[R; 3]; 3],
    /// Lower triangle.
    tangential: [[R; 5]; 5],
    coupling: [[R; 3]; 5],
}

impl<R: Real> Slopes<R> {
    /// Adds a point at `at` that resists motion along both tangents with the given stiffness.
    #[inline(always)]
    fn hold(&mut self, [a, b]: [R; 2], [dn, d1, d2]: [R; 3]) {
        let t = &mut self.tangential;
        let (a2, an, b1, bn) = (a * d2, a * dn, b * d1, b * dn);
        t[0][0] += a;
        t[1][1] += b;
        t[2][0] -= a2;
        t[2][1] += b1;
        t[2][2] += a2 * d2 + b1 * d1;
        t[3][1] -= bn;
        t[3][2] -= bn * d1;
        t[3][3] += bn * dn;
        t[4][0] += an;
        t[4][2] -= an * d2;
        t[4][4] += an * dn;
    }

    #[inline(always)]
    fn of(points: &[Local<R>], coupled: bool) -> Self {
        let zero = R::zero();
        let mut s = Self { normal: [[zero; 3]; 3], tangential: [[zero; 5]; 5], coupling: [[zero; 3]; 5] };
        for p in points {
            let [dn, d1, d2] = p.at;
            if p.touching {
                let k = p.normal_stiffness;
                let (k1, k2) = (k * d2, -k * d1);
                s.normal[0][0] += k;
                s.normal[1][0] += k1;
                s.normal[2][0] += k2;
                s.normal[1][1] += k1 * d2;
                s.normal[2][1] += k2 * d2;
                s.normal[2][2] -= k2 * d1;
            }
            match p.friction {
                Friction::None => {}
                Friction::Stick => s.hold(p.stiffness, p.at),
                Friction::Slip => {
                    if p.viscous > zero {
                        s.hold(p.stiffness.map(|k| k * p.viscous), p.at);
                    }
                    let [q1, q2] = p.q;
                    // Across the slip: its derivative has rank one.
                    let (p1, p2) = (-q2 * p.across[0], q1 * p.across[1]);
                    let weight = p.s * p.weight;
                    let along = [p1, p2, d1 * p2 - d2 * p1, -dn * p2, dn * p1];
                    for i in 0..5 {
                        let a = weight * along[i];
                        for j in 0..=i {
                            s.tangential[i][j] += a * along[j];
                        }
                    }
                    if coupled && p.touching {
                        let k = p.normal_stiffness;
                        let row = [k, k * d2, -k * d1];
                        let slide = [q1, q2, d1 * q2 - d2 * q1, -dn * q2, dn * q1];
                        for i in 0..5 {
                            for j in 0..3 {
                                s.coupling[i][j] += slide[i] * row[j];
                            }
                        }
                    }
                }
            }
        }
        s
    }
}

impl<R: Real> Patch<R> {
    /// Turns the stiffness into the object's axes, about the centre of mass, and adds it.
    #[inline(always)]
    fn add(&self, s: &Slopes<R>, h: &mut Mat7<R>) {
        let (n, t, c) = (&s.normal, &s.tangential, &s.coupling);
        // Force and moment (rows n, 1, 2) per velocity and angular velocity (columns n, 1, 2).
        let force_v =
            [[n[0][0], R::zero(), R::zero()], [c[0][0], t[0][0], t[1][0]], [c[1][0], t[1][0], t[1][1]]];
        let force_w = [
            [R::zero(), n[1][0], n[2][0]],
            [t[2][0], c[0][1] + t[3][0], c[0][2] + t[4][0]],
            [t[2][1], c[1][1] + t[3][1], c[1][2] + t[4][1]],
        ];
        let moment_v = [
            [c[2][0], t[2][0], t[2][1]],
            [n[1][0] + c[3][0], t[3][0], t[3][1]],
            [n[2][0] + c[4][0], t[4][0], t[4][1]],
        ];
        let moment_w = [
            [t[2][2], c[2][1] + t[3][2], c[2][2] + t[4][2]],
            [t[3][2], n[1][1] + c[3][1] + t[3][3], n[2][1] + c[3][2] + t[4][3]],
            [t[4][2], n[2][1] + c[4][1] + t[4][3], n[2][2] + c[4][2] + t[4][4]],
        ];
        let vv = self.turned(&force_v);
        let mut vw = self.turned(&force_w);
        let mut wv = self.turned(&moment_v);
        let mut ww = self.turned(&moment_w);
        // Velocity at the centre is v + w x c, the moment about the centre of mass c x F more.
        let c = &self.centre;
        add_across_rows(&mut ww, &wv, c);
        add_across_rows(&mut vw, &vv, c);
        add_across_columns(&mut wv, &vv, c);
        add_across_columns(&mut ww, &vw, c);
        for i in 0..3 {
            for j in 0..3 {
                h[i][j] += vv[i][j];
                h[i][3 + j] += vw[i][j];
                h[3 + i][j] += wv[i][j];
                h[3 + i][3 + j] += ww[i][j];
            }
        }
        if self.jaw != R::zero() {
            self.add_jaw(s, h);
        }
    }

    /// The jaw opens along the normal.
    fn add_jaw(&self, s: &Slopes<R>, h: &mut Mat7<R>) {
        let (axes, c, jaw) = (&self.axes, &s.coupling, self.jaw);
        let force = axes[0] * s.normal[0][0] + axes[1] * c[0][0] + axes[2] * c[1][0];
        let own =
            axes[0] * c[2][0] + axes[1] * (s.normal[1][0] + c[3][0]) + axes[2] * (s.normal[2][0] + c[4][0]);
        let moment = own + self.centre.cross(&force);
        // The normal force alone, per velocity and angular velocity.
        let row_v = axes[0] * s.normal[0][0];
        let row_w = axes[1] * s.normal[1][0] + axes[2] * s.normal[2][0] + self.centre.cross(&row_v);
        for k in 0..3 {
            h[k][6] += jaw * force[k];
            h[3 + k][6] += jaw * moment[k];
            h[6][k] += jaw * row_v[k];
            h[6][3 + k] += jaw * row_w[k];
        }
        h[6][6] += jaw * jaw * s.normal[0][0];
    }

    /// `A K A'` with the axes as the columns of `A`.
    #[inline(always)]
    fn turned(&self, k: &Block<R>) -> Block<R> {
        let [n, a, b] = &self.axes;
        let mut half = [[R::zero(); 3]; 3];
        for (to, from) in half.iter_mut().zip(k) {
            for j in 0..3 {
                to[j] = from[0] * n[j] + from[1] * a[j] + from[2] * b[j];
            }
        }
        let mut whole = [[R::zero(); 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                whole[i][j] = n[i] * half[0][j] + a[i] * half[1][j] + b[i] * half[2][j];
            }
        }
        whole
    }
}

/// `to += K (w -> w x c)`, row by row.
#[inline(always)]
fn add_across_rows<R: Real>(to: &mut Block<R>, k: &Block<R>, c: &Vec3<R>) {
    for (to, k) in to.iter_mut().zip(k) {
        // k . (w x c) = (c x k) . w
        to[0] += c.y * k[2] - c.z * k[1];
        to[1] += c.z * k[0] - c.x * k[2];
        to[2] += c.x * k[1] - c.y * k[0];
    }
}

/// `to += (F -> c x F) K`, column by column.
#[inline(always)]
fn add_across_columns<R: Real>(to: &mut Block<R>, k: &Block<R>, c: &Vec3<R>) {
    for j in 0..3 {
        to[0][j] += c.y * k[2][j] - c.z * k[1][j];
        to[1][j] += c.z * k[0][j] - c.x * k[2][j];
        to[2][j] += c.x * k[1][j] - c.y * k[0][j];
    }
}
