//! The law of one contact, regularised around known impulses, and where it has kinks.
//!
//! With the constants of the row `u = G y + q` (separation and slip in m/s), known impulses
//! `p0` and small compliances `e`, the trial impulses are
//!
//! `n = (e_n n0 - u_n) / (c_n + e_n)`, `f = (e_t f0 - u_t) / (c_t + e_t)`
//!
//! with the compliances `c` of the contact itself, and the impulses are the projection of the trial: nothing
//! where `n <= 0`, else `n` and the nearest point to `f` in the polygon whose corners are at `mu n`
//! (four edges: the diamond `|f1| + |f2| <= mu n`). At `p = p0` this is exactly the
//! complementarity problem; elsewhere it is the problem with `e` added to its diagonal
//! (proximal point method, Rockafellar 1976). The law is linear in each mode, and two modes
//! that meet differ by a multiple of the function that vanishes where they meet: a change of
//! mode changes the equations of motion by a matrix of rank one.

use super::polygon::{Polygon, along};
use crate::lcp::factors::Contact;
use crate::real::{Real, max, min};

/// What a contact does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::lcp) enum Mode {
    /// No impulse.
    Open,
    /// An impulse and no slip.
    Stick,
    /// Contact without friction.
    Free,
    /// Slip; friction is at this corner of the polygon.
    Corner(u8),
    /// Slip; friction is on this edge of the polygon.
    Edge(u8),
}

/// What the compliance of a normal is relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::lcp) enum Normal {
    /// Its diagonal of `W`: the best conditioned.
    Whole,
    /// What couples it to other contacts. Light fingers make the diagonal far larger than what
    /// the object adds to it, and the rounds would converge slowly.
    Coupled,
}

/// A contact during a solve, in units in which every degree of freedom has mass one; `X`: what regularises it.
#[derive(Clone, Copy, Debug)]
pub(in crate::lcp) struct Track<R, const ND: usize, X = Regular<R>> {
    /// Normal, t1, t2.
    pub rows: [[R; ND]; 3],
    /// `q` of the three rows.
    pub constant: [R; 3],
    pub friction: R,
    /// `1 / (c_n + e_n)`, `1 / (c_t + e_t)`.
    pub normal_gain: R,
    pub tangent_gain: R,
    pub mode: Mode,
    /// Trial impulses, and how they change along the path that is followed.
    pub trial: [R; 3],
    pub rate: [R; 3],
    /// Offset of the constants at the start of that path.
    pub offset: [R; 3],
    /// Impulses, and separation and slip (without what the compliance takes of it), of the answer.
    pub impulse: [R; 3],
    pub speed: [R; 3],
    pub regular: X,
}

/// What the law of a contact has besides where it is regularised around known impulses. A time step's is not: its contacts
/// have compliances of their own.
#[derive(Clone, Copy, Debug)]
pub(in crate::lcp) struct Regular<R> {
    pub compliance: R,
    /// The same along the tangents.
    pub tangential_compliance: R,
    /// Squared lengths of the rows: the diagonal of `W`.
    pub size: [R; 3],
    /// `e_n`, `e_t / (c_t + e_t)`.
    pub shift: R,
    pub tangent_hold: R,
    /// The mode that belongs to the impulses.
    pub settled: Mode,
    /// `p0`.
    pub anchor: [R; 3],
    /// Slip speed bound.
    pub slip: R,
}

impl<R: Real> Regular<R> {
    pub(in crate::lcp) fn nothing() -> Self {
        let zero = R::zero();
        Self {
            compliance: zero,
            tangential_compliance: zero,
            size: [zero; 3],
            shift: zero,
            tangent_hold: R::one(),
            settled: Mode::Open,
            anchor: [zero; 3],
            slip: zero,
        }
    }
}

/// A change of mode: `a b'` is added to the equations; `phi` is the rate of the function that
/// vanishes where the modes meet.
pub(in crate::lcp) struct Kink<R, const ND: usize> {
    pub a: [R; ND],
    pub b: [R; ND],
    pub phi: R,
}

/// Inner product; two sums, so that two lanes can work.
#[inline(always)]
pub(in crate::lcp) fn dot<R: Real, const ND: usize>(a: &[R; ND], b: &[R; ND]) -> R {
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
pub(in crate::lcp) fn add_scaled<R: Real, const ND: usize>(sum: &mut [R; ND], factor: R, row: &[R; ND]) {
    for k in 0..ND {
        sum[k] += factor * row[k];
    }
}

impl Mode {
    /// How many directions of motion the contact resists.
    fn rank(self) -> u8 {
        match self {
            Mode::Open => 0,
            Mode::Free | Mode::Corner(_) => 1,
            Mode::Edge(_) => 2,
            Mode::Stick => 3,
        }
    }
}

impl<R: Real, const ND: usize> Track<R, ND> {
    /// Takes the numbers of a contact; `roots` are the square roots of the inverse masses.
    #[inline]
    pub(in crate::lcp) fn load(&mut self, contact: &Contact<R, ND>, roots: &[R; ND]) {
        for k in 0..ND {
            self.rows[0][k] = contact.normal[k] * roots[k];
            self.rows[1][k] = contact.tangents[0][k] * roots[k];
            self.rows[2][k] = contact.tangents[1][k] * roots[k];
        }
        for k in 0..3 {
            self.regular.size[k] = dot(&self.rows[k], &self.rows[k]);
        }
        self.constant = [contact.separation, contact.slip[0], contact.slip[1]];
        self.regular.compliance = contact.compliance;
        self.regular.tangential_compliance = contact.tangential_compliance;
        self.friction = contact.friction;
    }

    /// Sets the small compliances to `relative` of the diagonal.
    #[inline]
    pub(in crate::lcp) fn regularise(&mut self, relative: R, scale: Normal) {
        let tangent = (self.regular.size[1] + self.regular.size[2]) * R::of(0.5);
        let coupled = min(self.regular.size[0], tangent * R::of(300.0));
        let normal =
            if scale == Normal::Coupled && coupled > R::zero() { coupled } else { self.regular.size[0] };
        self.regular.shift = normal * relative;
        let total = self.regular.compliance + self.regular.shift;
        self.normal_gain = if total > R::zero() { R::one() / total } else { R::one() };
        let shift = tangent * relative;
        let total = self.regular.tangential_compliance + shift;
        self.tangent_gain = if total > R::zero() { R::one() / total } else { R::one() };
        let soft = self.regular.tangential_compliance > R::zero();
        self.regular.tangent_hold = if soft { shift * self.tangent_gain } else { R::one() };
    }

    /// Separation and slip at `y`, without compliance.
    #[inline(always)]
    pub(in crate::lcp) fn speeds_at(&self, y: &[R; ND]) -> [R; 3] {
        [
            dot(&self.rows[0], y) + self.constant[0],
            dot(&self.rows[1], y) + self.constant[1],
            dot(&self.rows[2], y) + self.constant[2],
        ]
    }

    /// Trial impulses at separation and slip `u`.
    #[inline(always)]
    pub(in crate::lcp) fn trial_at(&self, u: &[R; 3]) -> [R; 3] {
        [
            self.normal_gain * (self.regular.shift * self.regular.anchor[0] - u[0]),
            self.regular.tangent_hold * self.regular.anchor[1] - self.tangent_gain * u[1],
            self.regular.tangent_hold * self.regular.anchor[2] - self.tangent_gain * u[2],
        ]
    }

    /// Separation and relative velocity at which the mode holds with the impulses `p0` exactly, near the
    /// separation and slip (without what the compliance takes of it) `u`.
    #[inline]
    pub(in crate::lcp) fn consistent(&self, polygon: &Polygon<R>, u: &[R; 3]) -> [R; 3] {
        let zero = R::zero();
        let [normal, ..] = *u;
        if self.mode == Mode::Open {
            return [max(normal, zero), u[1], u[2]];
        }
        let yielded = [1, 2].map(|k| self.regular.tangential_compliance * self.regular.anchor[k]);
        let against = [-u[1], -u[2]];
        let slip = match self.mode {
            Mode::Corner(k) => {
                let d = polygon.corner(k);
                let most = max(along(d, against), zero);
                let bound = most * polygon.tangent;
                let across = min(max(along([-d[1], d[0]], against), -bound), bound);
                [d[0] * most - d[1] * across, d[1] * most + d[0] * across]
            }
            Mode::Edge(k) => {
                let e = polygon.normal(k);
                let most = max(along(e, against), zero);
                [e[0] * most, e[1] * most]
            }
            Mode::Free => against,
            _ => [zero; 2],
        };
        [-self.regular.compliance * self.regular.anchor[0], -slip[0] - yielded[0], -slip[1] - yielded[1]]
    }
}

impl<R: Real, const ND: usize> Track<R, ND, ()> {
    /// Trial impulses at separation and slip `u`.
    #[inline(always)]
    pub(in crate::lcp) fn trial_at(&self, u: &[R; 3]) -> [R; 3] {
        let zero = R::zero();
        let along = |slip: R| zero - self.tangent_gain * slip;
        [self.normal_gain * (zero - u[0]), along(u[1]), along(u[2])]
    }
}

impl<R: Real, const ND: usize, X> Track<R, ND, X> {
    pub(in crate::lcp) fn nothing(regular: X) -> Self {
        let zero = [R::zero(); 3];
        Self {
            rows: [[R::zero(); ND]; 3],
            constant: zero,
            friction: R::zero(),
            normal_gain: R::one(),
            tangent_gain: R::one(),
            mode: Mode::Open,
            trial: zero,
            rate: zero,
            offset: zero,
            impulse: zero,
            speed: zero,
            regular,
        }
    }

    /// The mode that belongs to the trial impulses.
    pub(in crate::lcp) fn classified(&self, polygon: &Polygon<R>) -> Mode {
        let [normal, first, second] = self.trial;
        if !(normal > R::zero()) {
            return Mode::Open;
        }
        if !(self.friction > R::zero()) {
            return Mode::Free;
        }
        let f = [first, second];
        let limit = self.friction * normal;
        let inner = limit * polygon.apothem;
        if along(f, f) <= inner * inner {
            return Mode::Stick;
        }
        // Mostly the first edge has followed the slip.
        let bound = limit * polygon.half;
        let beside = |k: u8| {
            let ahead = along(polygon.along(k), f) + bound;
            let behind = bound - along(polygon.along(polygon.before(k)), f);
            (ahead, behind)
        };
        let (ahead, behind) = beside(0);
        if first > R::zero() && ahead <= R::zero() && behind <= R::zero() {
            return Mode::Corner(0);
        }
        let k = polygon.nearest(f);
        let before = polygon.before(k);
        if along(polygon.normal(k), f) <= inner && along(polygon.normal(before), f) <= inner {
            return Mode::Stick;
        }
        let (ahead, behind) = beside(k);
        if ahead > R::zero() {
            Mode::Edge(k)
        } else if behind > R::zero() {
            Mode::Edge(before)
        } else {
            Mode::Corner(k)
        }
    }

    /// Impulses for the trial in the present mode: a linear map.
    #[inline(always)]
    pub(in crate::lcp) fn impulse_of(&self, polygon: &Polygon<R>, trial: &[R; 3]) -> [R; 3] {
        let [normal, first, second] = *trial;
        let zero = R::zero();
        let limit = self.friction * normal;
        match self.mode {
            Mode::Open => [zero; 3],
            Mode::Stick => [normal, first, second],
            Mode::Free => [normal, zero, zero],
            Mode::Corner(k) => {
                let d = polygon.corner(k);
                [normal, limit * d[0], limit * d[1]]
            }
            Mode::Edge(k) => {
                let (e, t) = (polygon.normal(k), polygon.along(k));
                let (reach, across) = (limit * polygon.apothem, along(t, [first, second]));
                [normal, e[0] * reach + t[0] * across, e[1] * reach + t[1] * across]
            }
        }
    }

    /// The tangents' rows along a direction between them.
    #[inline(always)]
    fn row_along(&self, direction: [R; 2], factor: R) -> [R; ND] {
        let (a, b) = (direction[0] * factor, direction[1] * factor);
        let mut row = [R::zero(); ND];
        for k in 0..ND {
            row[k] = a * self.rows[1][k] + b * self.rows[2][k];
        }
        row
    }

    /// Adds the contact's part of the equations `I + G'K G`.
    #[inline]
    pub(in crate::lcp) fn add_to(&self, polygon: &Polygon<R>, matrix: &mut [[R; ND]; ND]) {
        let [normal, first, second] = &self.rows;
        let mut force = *normal;
        match self.mode {
            Mode::Open => return,
            Mode::Free => {}
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
            Mode::Corner(k) => {
                let d = polygon.corner(k);
                add_scaled(&mut force, self.friction * d[0], first);
                add_scaled(&mut force, self.friction * d[1], second);
            }
            Mode::Edge(k) => {
                let (e, reach) = (polygon.normal(k), self.friction * polygon.apothem);
                add_scaled(&mut force, reach * e[0], first);
                add_scaled(&mut force, reach * e[1], second);
                let across = self.row_along(polygon.along(k), R::one());
                for r in 0..ND {
                    add_scaled(&mut matrix[r], across[r] * self.tangent_gain, &across);
                }
            }
        }
        for r in 0..ND {
            add_scaled(&mut matrix[r], force[r] * self.normal_gain, normal);
        }
    }

    /// Offers every kink ahead to `offer(value, rate, mode)`: `value >= 0` holds in this mode,
    /// and the mode changes where it reaches zero. `direction` is the sense along the path, `within` a
    /// length of it beyond which no kink matters.
    #[inline(always)]
    pub(in crate::lcp) fn kinks(
        &self,
        polygon: &Polygon<R>,
        direction: R,
        within: R,
        mut offer: impl FnMut(R, R, Mode),
    ) {
        let [n, a, b] = self.trial;
        let (dn, da, db) = (self.rate[0] * direction, self.rate[1] * direction, self.rate[2] * direction);
        let (f, df) = ([a, b], [da, db]);
        let (limit, dlimit) = (self.friction * n, self.friction * dn);
        match self.mode {
            // Which one it enters is chosen where it closes.
            Mode::Open => {
                offer(-n, -dn, Mode::Free);
                return;
            }
            Mode::Free => {}
            Mode::Stick => {
                let (inner, dinner) = (limit * polygon.apothem, dlimit * polygon.apothem);
                // The cone over the polygon is convex: from within it to within the round cone in it, no
                // kink is met.
                let end = [f[0] + within * df[0], f[1] + within * df[1]];
                let reach = inner + within * dinner;
                if reach > R::zero() && along(end, end) <= reach * reach {
                    return;
                }
                for k in 0..polygon.edges() {
                    let e = polygon.normal(k);
                    offer(inner - along(e, f), dinner - along(e, df), Mode::Edge(k));
                }
            }
            Mode::Corner(k) => {
                let (bound, dbound) = (limit * polygon.half, dlimit * polygon.half);
                let before = polygon.before(k);
                let (ahead, behind) = (polygon.along(k), polygon.along(before));
                offer(-along(ahead, f) - bound, -along(ahead, df) - dbound, Mode::Edge(k));
                offer(along(behind, f) - bound, along(behind, df) - dbound, Mode::Edge(before));
            }
            Mode::Edge(k) => {
                let (e, t) = (polygon.normal(k), polygon.along(k));
                let (bound, dbound) = (limit * polygon.half, dlimit * polygon.half);
                let (across, dacross) = (along(t, f), along(t, df));
                let over = along(e, f) - limit * polygon.apothem;
                offer(over, along(e, df) - dlimit * polygon.apothem, Mode::Stick);
                offer(bound + across, dbound + dacross, Mode::Corner(k));
                offer(bound - across, dbound - dacross, Mode::Corner(polygon.after(k)));
            }
        }
        offer(n, dn, Mode::Open);
    }

    /// Which mode a contact enters that closes: it slips against the trial.
    #[inline]
    fn closing(&self, polygon: &Polygon<R>) -> Mode {
        let [_, first, second] = self.trial;
        if self.friction > R::zero() { Mode::Corner(polygon.nearest([first, second])) } else { Mode::Free }
    }

    /// Changes the mode; `None` where the two modes do not meet along a face.
    #[inline]
    pub(in crate::lcp) fn change(&mut self, polygon: &Polygon<R>, target: Mode) -> Option<Kink<R, ND>> {
        let target = if self.mode == Mode::Open { self.closing(polygon) } else { target };
        let finer = target.rank() > self.mode.rank();
        let (low, high) = if finer { (self.mode, target) } else { (target, self.mode) };
        let one = R::one();
        let rate = &self.rate;
        let slip_rate = [rate[1], rate[2]];
        let bound = self.friction * self.normal_gain;
        // The impulses differ by `a` times a function that vanishes where the modes meet, `b` is minus its
        // gradient.
        let (mut a, b, phi) = match (low, high) {
            (Mode::Open, Mode::Free | Mode::Corner(_)) => {
                let mut a = self.rows[0];
                if let Mode::Corner(k) = high {
                    let d = polygon.corner(k);
                    add_scaled(&mut a, self.friction * d[0], &self.rows[1]);
                    add_scaled(&mut a, self.friction * d[1], &self.rows[2]);
                }
                for x in &mut a {
                    *x *= self.normal_gain;
                }
                (a, self.rows[0], -rate[0] / self.normal_gain)
            }
            (Mode::Corner(c), Mode::Edge(k)) => {
                let side = if c == k { one } else { -one };
                let t = polygon.along(k);
                let mut b = self.row_along(t, self.tangent_gain);
                add_scaled(&mut b, side * polygon.half * bound, &self.rows[0]);
                let phi = -along(t, slip_rate) - side * polygon.half * self.friction * rate[0];
                (self.row_along(t, one), b, phi)
            }
            (Mode::Edge(k), Mode::Stick) => {
                let e = polygon.normal(k);
                let mut b = self.row_along(e, self.tangent_gain);
                add_scaled(&mut b, -polygon.apothem * bound, &self.rows[0]);
                let phi = polygon.apothem * self.friction * rate[0] - along(e, slip_rate);
                (self.row_along(e, one), b, phi)
            }
            _ => return None,
        };
        if !finer {
            for x in &mut a {
                *x = -*x;
            }
        }
        self.mode = target;
        Some(Kink { a, b, phi })
    }
}
