//! The law of one contact, regularised around known impulses, and where it has kinks.
//!
//! With the constants of the row `u = G y + q` (separation and slip in m/s), known impulses
//! `p0` and small compliances `e`, the trial impulses are
//!
//! `n = (e_n n0 - u_n) / (c + e_n)`, `f = f0 - u_t / e_t`
//!
//! and the impulses are the projection of the trial: nothing where `n <= 0`, else `n` and the
//! nearest point to `f` in the diamond `|f1| + |f2| <= mu n`. At `p = p0` this is exactly the
//! complementarity problem; elsewhere it is the problem with `e` added to its diagonal
//! (proximal point method, Rockafellar 1976). The law is linear in each mode, and two modes
//! that meet differ by a multiple of the function that vanishes where they meet: a change of
//! mode changes the equations of motion by a matrix of rank one.

use crate::lcp::factors::Contact;
use crate::real::{Real, abs, max, min};

/// What a contact does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// No impulse.
    Open,
    /// An impulse and no slip.
    Stick,
    /// Slip; friction with these signs along t1 and t2: one on a vertex of the diamond, both
    /// on an edge, none without friction.
    Slide(i8, i8),
}

/// What the compliance of a normal is relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Normal {
    /// Its diagonal of `W`: the best conditioned.
    Whole,
    /// What couples it to other contacts. Light fingers make the diagonal far larger than what
    /// the object adds to it, and the rounds would converge slowly.
    Coupled,
}

/// A contact during a solve, in units in which every degree of freedom has mass one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Track<R, const ND: usize> {
    /// Normal, t1, t2.
    pub rows: [[R; ND]; 3],
    /// `q` of the three rows.
    pub constant: [R; 3],
    pub compliance: R,
    pub friction: R,
    /// Squared lengths of the rows: the diagonal of `W`.
    pub size: [R; 3],
    /// `e_n`, `1 / (c + e_n)`, `1 / e_t`.
    pub shift: R,
    pub normal_gain: R,
    pub tangent_gain: R,
    pub mode: Mode,
    /// The mode that belongs to `impulse`.
    pub settled: Mode,
    /// `p0`.
    pub anchor: [R; 3],
    /// Trial impulses, and how they change along the path that is followed.
    pub trial: [R; 3],
    pub rate: [R; 3],
    /// Offset of the constants at the start of that path.
    pub offset: [R; 3],
    /// Impulses, and separation and slip, of the answer.
    pub impulse: [R; 3],
    pub speed: [R; 3],
    /// Slip speed bound.
    pub slip: R,
}

/// A change of mode: `a b'` is added to the equations; `phi` is the rate of the function that
/// vanishes where the modes meet.
pub(super) struct Kink<R, const ND: usize> {
    pub a: [R; ND],
    pub b: [R; ND],
    pub phi: R,
}

/// Inner product; two sums, so that two lanes can work.
#[inline(always)]
pub(super) fn dot<R: Real, const ND: usize>(a: &[R; ND], b: &[R; ND]) -> R {
    let (mut even, mut odd) = (R::zero(), R::zero());
    for k in 0..ND / 2 {
        even += a[2 * k] * b[2 * k];
        odd += a[2 * k + 1] * b[2 * k + 1];
    }
    if ND % 2 == 1 {
        even += a[ND - 1] * b[ND - 1];
    }
    even + odd
}

/// `sum += factor * row`.
#[inline(always)]
pub(super) fn add_scaled<R: Real, const ND: usize>(sum: &mut [R; ND], factor: R, row: &[R; ND]) {
    for k in 0..ND {
        sum[k] += factor * row[k];
    }
}

#[inline(always)]
fn sign<R: Real>(s: i8) -> R {
    match s {
        0 => R::zero(),
        s if s < 0 => -R::one(),
        _ => R::one(),
    }
}

#[inline(always)]
fn sign_of<R: Real>(x: R) -> i8 {
    if x < R::zero() { -1 } else { 1 }
}

impl Mode {
    /// How many directions of motion the contact resists.
    fn rank(self) -> u8 {
        match self {
            Mode::Open => 0,
            Mode::Slide(s, t) if s != 0 && t != 0 => 2,
            Mode::Slide(_, _) => 1,
            Mode::Stick => 3,
        }
    }
}

impl<R: Real, const ND: usize> Track<R, ND> {
    pub(super) fn nothing() -> Self {
        let zero = [R::zero(); 3];
        Self {
            rows: [[R::zero(); ND]; 3],
            constant: zero,
            compliance: R::zero(),
            friction: R::zero(),
            size: zero,
            shift: R::zero(),
            normal_gain: R::one(),
            tangent_gain: R::one(),
            mode: Mode::Open,
            settled: Mode::Open,
            anchor: zero,
            trial: zero,
            rate: zero,
            offset: zero,
            impulse: zero,
            speed: zero,
            slip: R::zero(),
        }
    }

    /// Takes the numbers of a contact; `roots` are the square roots of the inverse masses.
    #[inline]
    pub(super) fn load(&mut self, contact: &Contact<R, ND>, roots: &[R; ND]) {
        for k in 0..ND {
            self.rows[0][k] = contact.normal[k] * roots[k];
            self.rows[1][k] = contact.tangents[0][k] * roots[k];
            self.rows[2][k] = contact.tangents[1][k] * roots[k];
        }
        for k in 0..3 {
            self.size[k] = dot(&self.rows[k], &self.rows[k]);
        }
        self.constant = [contact.separation, contact.slip[0], contact.slip[1]];
        self.compliance = contact.compliance;
        self.friction = contact.friction;
    }

    /// Sets the small compliances to `relative` of the diagonal.
    #[inline]
    pub(super) fn regularise(&mut self, relative: R, scale: Normal) {
        let tangent = (self.size[1] + self.size[2]) * R::of(0.5);
        let coupled = min(self.size[0], tangent * R::of(300.0));
        let normal = if scale == Normal::Coupled && coupled > R::zero() { coupled } else { self.size[0] };
        self.shift = normal * relative;
        let total = self.compliance + self.shift;
        self.normal_gain = if total > R::zero() { R::one() / total } else { R::one() };
        let total = tangent * relative;
        self.tangent_gain = if total > R::zero() { R::one() / total } else { R::one() };
    }

    /// Separation and slip at `y`, without compliance.
    #[inline(always)]
    pub(super) fn speeds_at(&self, y: &[R; ND]) -> [R; 3] {
        [
            dot(&self.rows[0], y) + self.constant[0],
            dot(&self.rows[1], y) + self.constant[1],
            dot(&self.rows[2], y) + self.constant[2],
        ]
    }

    /// Trial impulses at separation and slip `u`.
    #[inline(always)]
    pub(super) fn trial_at(&self, u: &[R; 3]) -> [R; 3] {
        [
            self.normal_gain * (self.shift * self.anchor[0] - u[0]),
            self.anchor[1] - self.tangent_gain * u[1],
            self.anchor[2] - self.tangent_gain * u[2],
        ]
    }

    /// Separation and slip near `u` at which the mode holds with the impulses `p0` exactly.
    #[inline]
    pub(super) fn consistent(&self, u: &[R; 3]) -> [R; 3] {
        let zero = R::zero();
        let [normal, first, second] = *u;
        if self.mode == Mode::Open {
            return [max(normal, zero), first, second];
        }
        let normal = -self.compliance * self.anchor[0];
        match self.mode {
            Mode::Slide(0, 0) => [normal, first, second],
            Mode::Slide(s, 0) => {
                let first = sign::<R>(s) * min(sign::<R>(s) * first, zero);
                let bound = abs(first);
                [normal, first, min(max(second, -bound), bound)]
            }
            Mode::Slide(0, t) => {
                let second = sign::<R>(t) * min(sign::<R>(t) * second, zero);
                let bound = abs(second);
                [normal, min(max(first, -bound), bound), second]
            }
            Mode::Slide(s, t) => {
                let mean = (sign::<R>(s) * first + sign::<R>(t) * second) * R::of(0.5);
                let mean = min(mean, zero);
                [normal, sign::<R>(s) * mean, sign::<R>(t) * mean]
            }
            _ => [normal, zero, zero],
        }
    }

    /// Impulses for the trial in the present mode: a linear map.
    #[inline(always)]
    pub(super) fn impulse_of(&self, trial: &[R; 3]) -> [R; 3] {
        let [normal, first, second] = *trial;
        let (zero, half) = (R::zero(), R::of(0.5));
        let limit = self.friction * normal;
        match self.mode {
            Mode::Open => [zero; 3],
            Mode::Stick => [normal, first, second],
            Mode::Slide(s, 0) => [normal, limit * sign(s), zero],
            Mode::Slide(0, t) => [normal, zero, limit * sign(t)],
            Mode::Slide(s, t) => {
                let (s, t) = (sign::<R>(s), sign::<R>(t));
                let across = (first * s - second * t) * half;
                [normal, s * (across + limit * half), t * (limit * half - across)]
            }
        }
    }

    /// Adds the contact's part of the equations `I + G'K G`.
    #[inline]
    pub(super) fn add_to(&self, matrix: &mut [[R; ND]; ND]) {
        let [normal, first, second] = &self.rows;
        let half = R::of(0.5);
        let mut force = *normal;
        match self.mode {
            Mode::Open => return,
            Mode::Stick => {
                for r in 0..ND {
                    let (f, g) = (first[r] * self.tangent_gain, second[r] * self.tangent_gain);
                    let h = normal[r] * self.normal_gain;
                    for c in 0..ND {
                        matrix[r][c] += f * first[c] + g * second[c] + h * normal[c];
                    }
                }
                return;
            }
            Mode::Slide(s, 0) => add_scaled(&mut force, self.friction * sign(s), first),
            Mode::Slide(0, t) => add_scaled(&mut force, self.friction * sign(t), second),
            Mode::Slide(s, t) => {
                let (s, t) = (sign::<R>(s), sign::<R>(t));
                add_scaled(&mut force, self.friction * s * half, first);
                add_scaled(&mut force, self.friction * t * half, second);
                let mut along = [R::zero(); ND];
                for k in 0..ND {
                    along[k] = s * first[k] - t * second[k];
                }
                let gain = self.tangent_gain * half;
                for r in 0..ND {
                    add_scaled(&mut matrix[r], along[r] * gain, &along);
                }
            }
        }
        for r in 0..ND {
            add_scaled(&mut matrix[r], force[r] * self.normal_gain, normal);
        }
    }

    /// Offers every kink ahead to `offer(value, rate, mode)`: `value >= 0` holds in this mode,
    /// and the mode changes where it reaches zero. `direction` is the sense along the path.
    #[inline(always)]
    pub(super) fn kinks(&self, direction: R, mut offer: impl FnMut(R, R, Mode)) {
        let [n, a, b] = self.trial;
        let (dn, da, db) = (self.rate[0] * direction, self.rate[1] * direction, self.rate[2] * direction);
        let (limit, dlimit) = (self.friction * n, self.friction * dn);
        match self.mode {
            Mode::Open => {
                offer(-n, -dn, Mode::Slide(0, 0));
                return;
            }
            Mode::Stick => {
                offer(limit - a - b, dlimit - da - db, Mode::Slide(1, 1));
                offer(limit - a + b, dlimit - da + db, Mode::Slide(1, -1));
                offer(limit + a - b, dlimit + da - db, Mode::Slide(-1, 1));
                offer(limit + a + b, dlimit + da + db, Mode::Slide(-1, -1));
            }
            Mode::Slide(0, 0) => {}
            Mode::Slide(s, 0) => {
                let (over, dover) = (sign::<R>(s) * a - limit, sign::<R>(s) * da - dlimit);
                offer(over - b, dover - db, Mode::Slide(s, 1));
                offer(over + b, dover + db, Mode::Slide(s, -1));
            }
            Mode::Slide(0, t) => {
                let (over, dover) = (sign::<R>(t) * b - limit, sign::<R>(t) * db - dlimit);
                offer(over - a, dover - da, Mode::Slide(1, t));
                offer(over + a, dover + da, Mode::Slide(-1, t));
            }
            Mode::Slide(s, t) => {
                let (a, b) = (sign::<R>(s) * a, sign::<R>(t) * b);
                let (da, db) = (sign::<R>(s) * da, sign::<R>(t) * db);
                offer(a + b - limit, da + db - dlimit, Mode::Stick);
                offer(limit - a + b, dlimit - da + db, Mode::Slide(s, 0));
                offer(limit + a - b, dlimit + da - db, Mode::Slide(0, t));
            }
        }
        offer(n, dn, Mode::Open);
    }

    /// Which mode a contact enters that closes: it slips along the larger trial.
    #[inline]
    fn closing(&self) -> Mode {
        let [_, first, second] = self.trial;
        if !(self.friction > R::zero()) {
            Mode::Slide(0, 0)
        } else if abs(first) >= abs(second) {
            Mode::Slide(sign_of(first), 0)
        } else {
            Mode::Slide(0, sign_of(second))
        }
    }

    /// Changes the mode; `None` where the two modes do not meet along a face.
    #[inline]
    pub(super) fn change(&mut self, target: Mode) -> Option<Kink<R, ND>> {
        let target = if self.mode == Mode::Open { self.closing() } else { target };
        let finer = target.rank() > self.mode.rank();
        let (low, high) = if finer { (self.mode, target) } else { (target, self.mode) };
        let (one, half, two) = (R::one(), R::of(0.5), R::of(2.0));
        let (mut a, mut b) = ([R::zero(); ND], [R::zero(); ND]);
        let rate = &self.rate;
        let phi = match (low, high) {
            (Mode::Open, Mode::Slide(s, t)) if s == 0 || t == 0 => {
                b = self.rows[0];
                a = self.rows[0];
                add_scaled(&mut a, self.friction * sign(s), &self.rows[1]);
                add_scaled(&mut a, self.friction * sign(t), &self.rows[2]);
                for k in 0..ND {
                    a[k] *= self.normal_gain;
                }
                -rate[0] / self.normal_gain
            }
            (Mode::Slide(_, other), Mode::Slide(s, t)) => {
                let side = if other == 0 { one } else { -one };
                add_scaled(&mut a, half * sign::<R>(s) * side, &self.rows[1]);
                add_scaled(&mut a, -half * sign::<R>(t) * side, &self.rows[2]);
                add_scaled(&mut b, self.tangent_gain * two, &a);
                add_scaled(&mut b, -self.friction * self.normal_gain, &self.rows[0]);
                let across = sign::<R>(s) * rate[1] - sign::<R>(t) * rate[2];
                self.friction * rate[0] - side * across
            }
            (Mode::Slide(s, t), Mode::Stick) => {
                add_scaled(&mut a, half * sign::<R>(s), &self.rows[1]);
                add_scaled(&mut a, half * sign::<R>(t), &self.rows[2]);
                add_scaled(&mut b, self.tangent_gain * two, &a);
                add_scaled(&mut b, -self.friction * self.normal_gain, &self.rows[0]);
                self.friction * rate[0] - sign::<R>(s) * rate[1] - sign::<R>(t) * rate[2]
            }
            _ => return None,
        };
        if !finer {
            for k in 0..ND {
                a[k] = -a[k];
            }
        }
        self.mode = target;
        Some(Kink { a, b, phi })
    }
}
