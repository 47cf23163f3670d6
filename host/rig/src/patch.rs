//! A contact as many points, each a spring and damper along the normal and a bristle in
//! the tangent plane.
//!
//! Elastic-plastic (Prandtl) friction: a bristle stretches with the relative motion and is
//! cut back, as a vector, to the length at which it carries `mu` times the point's normal
//! force, so the limit is the exact circular cone and the force opposes the motion.
//! Damping acts while a point sticks and never lifts the force over the limit. There is no
//! complementarity problem anywhere, on purpose: the predictor is judged against this.
//!
//! Contact frame: axis `n` points into the object, `a` and `b` span the tangent plane
//! (right-handed `n, a, b`), origin in the contact surface.

use super::law::{FrictionLaw, Memory, Stiffness};

/// Points of one contact, structure of arrays, all of the same length.
#[derive(Clone, Debug, Default)]
pub struct Patch {
    /// Position along `a`, m.
    pub a: Vec<f64>,
    /// Position along `b`, m.
    pub b: Vec<f64>,
    /// Penetration, m; not positive where the point does not touch.
    pub depth: Vec<f64>,
    /// Share of the contact's stiffness; they sum to one.
    pub weight: Vec<f64>,
    stretch_a: Vec<f64>,
    stretch_b: Vec<f64>,
    slip_speed: Vec<f64>,
    /// What the patch as a whole remembers.
    pub memory: Memory,
}

/// Motion of the object relative to the contact frame, in contact axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct RelativeTwist {
    /// Velocity of the object's material point at the frame's origin, `n, a, b`, m/s.
    pub velocity: [f64; 3],
    /// Angular velocity, rad/s.
    pub spin: [f64; 3],
}

/// Sum of all point forces on the object, in contact axes about the frame's origin.
#[derive(Clone, Copy, Debug, Default)]
pub struct Resultant {
    /// N.
    pub force: [f64; 3],
    /// N m.
    pub torque: [f64; 3],
}

impl Patch {
    /// Points at `(a, b)` with equal weights.
    pub fn new(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let (a, b): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        let n = a.len();
        let zero = vec![0.0; n];
        Self {
            weight: vec![1.0 / n.max(1) as f64; n],
            depth: zero.clone(),
            stretch_a: zero.clone(),
            stretch_b: zero.clone(),
            slip_speed: zero,
            memory: Memory::default(),
            a,
            b,
        }
    }

    /// A disc: two rings of 6 and 18 points of equal area, each at its area's mean radius,
    /// so that force and torsional friction (2/3 mu N R) are those of the uniform disc.
    pub fn disc(radius_m: f64) -> Self {
        let ring = |radius: f64, count: usize| {
            (0..count).map(move |i| {
                let angle = std::f64::consts::TAU * (i as f64 + 0.5) / count as f64;
                (radius * angle.cos(), radius * angle.sin())
            })
        };
        Self::new(ring(radius_m / 3.0, 6).chain(ring(radius_m * 7.0 / 9.0, 18)))
    }

    /// A line along `a`, `count` points at the middle of equal parts.
    pub fn line(length_m: f64, count: usize) -> Self {
        let n = count as f64;
        Self::new((0..count).map(|i| (length_m * ((i as f64 + 0.5) / n - 0.5), 0.0)))
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.a.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.a.is_empty()
    }

    /// Shifts the centre of pressure by `(da, db)` metres by a linear change of the local
    /// stiffness over the patch.
    pub fn shift_pressure(&mut self, da: f64, db: f64) {
        let second = |x: &[f64], w: &[f64]| x.iter().zip(w).map(|(x, w)| w * x * x).sum::<f64>();
        let (aa, bb) = (second(&self.a, &self.weight), second(&self.b, &self.weight));
        let slope = |d: f64, m: f64| if m > 0.0 { d / m } else { 0.0 };
        let (ga, gb) = (slope(da, aa), slope(db, bb));
        for i in 0..self.len() {
            self.weight[i] *= (1.0 + ga * self.a[i] + gb * self.b[i]).max(0.0);
        }
        let total: f64 = self.weight.iter().sum();
        self.weight.iter_mut().for_each(|w| *w /= total);
    }

    /// Forces on the object now; moves the bristles on by `dt_s`.
    pub fn press(
        &mut self,
        twist: &RelativeTwist,
        stiffness: &Stiffness,
        law: &FrictionLaw,
        dt_s: f64,
    ) -> Resultant {
        match law.is_plain() {
            true => self.press_plain(twist, stiffness, law.mu, dt_s),
            false => self.press_with_effects(twist, stiffness, law, dt_s),
        }
    }

    fn press_plain(&mut self, twist: &RelativeTwist, k: &Stiffness, mu: f64, dt: f64) -> Resultant {
        let [vn, va, vb] = twist.velocity;
        let [wn, wa, wb] = twist.spin;
        let n = self.len();
        let (a, b, depth, weight) = (&self.a[..n], &self.b[..n], &self.depth[..n], &self.weight[..n]);
        let (sa, sb) = (&mut self.stretch_a[..n], &mut self.stretch_b[..n]);
        let mut sum = Resultant::default();
        for i in 0..n {
            if depth[i] <= 0.0 {
                sa[i] = 0.0;
                sb[i] = 0.0;
                continue;
            }
            let (a, b, w) = (a[i], b[i], weight[i]);
            let un = vn + wa * b - wb * a;
            let ua = va - wn * b;
            let ub = vb + wn * a;
            let normal = (w * (k.normal * depth[i] - k.normal_damping * un)).max(0.0);
            let limit = mu * normal;
            let kt = w * k.tangential;
            let (mut xa, mut xb) = (sa[i] + ua * dt, sb[i] + ub * dt);
            let pull = kt * (xa * xa + xb * xb).sqrt();
            let (mut fa, mut fb);
            if pull > limit {
                let cut = limit / pull;
                xa *= cut;
                xb *= cut;
                fa = kt * xa;
                fb = kt * xb;
            } else {
                let ct = w * k.tangential_damping;
                fa = kt * xa + ct * ua;
                fb = kt * xb + ct * ub;
                let size = (fa * fa + fb * fb).sqrt();
                if size > limit {
                    fa *= limit / size;
                    fb *= limit / size;
                }
            }
            sa[i] = xa;
            sb[i] = xb;
            sum.add(a, b, [normal, -fa, -fb]);
        }
        self.memory.normal_n = sum.force[0];
        sum
    }

    fn press_with_effects(
        &mut self,
        twist: &RelativeTwist,
        k: &Stiffness,
        law: &FrictionLaw,
        dt: f64,
    ) -> Resultant {
        let [vn, va, vb] = twist.velocity;
        let [wn, wa, wb] = twist.spin;
        let shared = law.patch_factor(&self.memory);
        let stretch = law.lay_stretch();
        let [ca, cb] = law.lay_axis;
        let mut sum = Resultant::default();
        let (mut slip, mut power) = (0.0, 0.0);
        for i in 0..self.len() {
            if self.depth[i] <= 0.0 {
                self.stretch_a[i] = 0.0;
                self.stretch_b[i] = 0.0;
                continue;
            }
            let (a, b, w) = (self.a[i], self.b[i], self.weight[i]);
            let un = vn + wa * b - wb * a;
            let ua = va - wn * b;
            let ub = vb + wn * a;
            let normal = (w * (k.normal * self.depth[i] - k.normal_damping * un)).max(0.0);
            let mu = law.mu * shared * law.point_factor(self.slip_speed[i], a, b);
            let limit = mu * (normal + w * law.adhesion_n);
            let kt = w * k.tangential;
            // In the axes of the surface's lay, stretched so that the elliptic limit is a circle.
            let (xa, xb) = (self.stretch_a[i] + ua * dt, self.stretch_b[i] + ub * dt);
            let (mut p, mut q) = (stretch[0] * (ca * xa + cb * xb), stretch[1] * (ca * xb - cb * xa));
            let (up, uq) = (stretch[0] * (ca * ua + cb * ub), stretch[1] * (ca * ub - cb * ua));
            let pull = kt * (p * p + q * q).sqrt();
            let (mut fp, mut fq);
            let sliding = pull > limit;
            if sliding {
                p *= limit / pull;
                q *= limit / pull;
                fp = kt * p;
                fq = kt * q;
            } else {
                let ct = w * k.tangential_damping;
                fp = kt * p + ct * up;
                fq = kt * q + ct * uq;
                let size = (fp * fp + fq * fq).sqrt();
                if size > limit {
                    fp *= limit / size;
                    fq *= limit / size;
                }
            }
            let (gp, gq) = (p / stretch[0], q / stretch[1]);
            self.stretch_a[i] = ca * gp - cb * gq;
            self.stretch_b[i] = cb * gp + ca * gq;
            let (hp, hq) = (fp * stretch[0], fq * stretch[1]);
            let (mut fa, mut fb) = (ca * hp - cb * hq, cb * hp + ca * hq);
            let speed = if sliding { (ua * ua + ub * ub).sqrt() } else { 0.0 };
            self.slip_speed[i] += (speed - self.slip_speed[i]) * (dt / law.speed_memory_s).min(1.0);
            slip += w * speed;
            power += (fa * ua + fb * ub).max(0.0);
            fa += w * law.viscous_n_s_m * ua;
            fb += w * law.viscous_n_s_m * ub;
            sum.add(a, b, [normal, -fa, -fb]);
        }
        self.memory.advance(sum.force[0], slip, power, law, dt);
        sum
    }
}

impl Resultant {
    #[inline]
    fn add(&mut self, a: f64, b: f64, f: [f64; 3]) {
        self.force[0] += f[0];
        self.force[1] += f[1];
        self.force[2] += f[2];
        self.torque[0] += a * f[2] - b * f[1];
        self.torque[1] += b * f[0];
        self.torque[2] -= a * f[0];
    }
}
