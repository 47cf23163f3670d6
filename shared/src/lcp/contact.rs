//! The contact solver.

use super::factors::{Factors, Impulses};
use super::residual::Residual;
use super::small::Factorisation;
use super::{Outcome, Path, Report, Status, magnitude, tolerance};
use crate::real::{Real, most};

/// What a contact does: no force, no slip, or slip against `along`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Open,
    Stick,
    /// Signs of the friction along t1 and t2: one of them on a vertex, both on an edge.
    Slide(i8, i8),
}

/// A contact in units in which every degree of freedom has mass one.
#[derive(Clone, Copy, Debug)]
struct Prepared<R, const ND: usize> {
    rows: [[R; ND]; 3],
    constant: [R; 3],
    compliance: R,
    friction: R,
    /// Squared lengths of the rows: diagonal of `W`.
    size: [R; 3],
    normal_shift: R,
    normal_gain: R,
    tangent_gain: R,
}

#[inline(always)]
fn dot<R: Real, const ND: usize>(a: &[R; ND], b: &[R; ND]) -> R {
    let mut even = R::zero();
    let mut odd = R::zero();
    for k in 0..ND / 2 {
        even += a[2 * k] * b[2 * k];
        odd += a[2 * k + 1] * b[2 * k + 1];
    }
    if ND % 2 == 1 {
        even += a[ND - 1] * b[ND - 1];
    }
    even + odd
}

#[inline(always)]
fn add_scaled<R: Real, const ND: usize>(sum: &mut [R; ND], factor: R, row: &[R; ND]) {
    for k in 0..ND {
        sum[k] += factor * row[k];
    }
}

/// Working memory, warm start and answer.
pub struct ContactSolver<R, const NC: usize, const ND: usize> {
    prepared: [Prepared<R, ND>; NC],
    count: usize,
    modes: [Mode; NC],
    anchors: [[R; 3]; NC],
    impulses: [[R; 3]; NC],
    slip: [R; NC],
    speeds: [R; ND],
    answer: Impulses<R, NC, ND>,
    known: usize,
    offset: [[R; 3]; NC],
    trial: [[R; 3]; NC],
    rate: [[R; 3]; NC],
    sliding: [[R; 3]; NC],
    /// dev
    pub bad: usize,
    /// dev
    pub rate_t: f64,
    /// dev
    pub shift: f64,

}

impl<R: Real, const NC: usize, const ND: usize> Default for ContactSolver<R, NC, ND> {
    fn default() -> Self {
        Self::new()
    }
}

impl<R: Real, const NC: usize, const ND: usize> ContactSolver<R, NC, ND> {
    /// Empty working memory.
    pub fn new() -> Self {
        let nothing = Prepared {
            rows: [[R::zero(); ND]; 3],
            constant: [R::zero(); 3],
            compliance: R::zero(),
            friction: R::zero(),
            size: [R::zero(); 3],
            normal_shift: R::zero(),
            normal_gain: R::zero(),
            tangent_gain: R::zero(),
        };
        Self {
            prepared: [nothing; NC],
            count: 0,
            modes: [Mode::Open; NC],
            anchors: [[R::zero(); 3]; NC],
            impulses: [[R::zero(); 3]; NC],
            slip: [R::zero(); NC],
            speeds: [R::zero(); ND],
            answer: Impulses::none(),
            known: 0, bad: 0, rate_t: 0.1,
            offset: [[R::zero(); 3]; NC],
            trial: [[R::zero(); 3]; NC],
            rate: [[R::zero(); 3]; NC],
            sliding: [[R::zero(); 3]; NC],
            shift: 1e-7,
        }
    }

    /// Forgets the active set: the next solve starts from rest.
    pub fn forget(&mut self) {
        self.known = 0;
    }

    /// Solve.
    pub fn solve(&mut self, problem: &Factors<R, NC, ND>) -> Outcome<'_, Impulses<R, NC, ND>, R> {
        let report = match problem.defect() {
            Some(defect) => {
                self.answer = Impulses::none();
                self.known = 0;
                Report {
                    status: Status::BadInput(defect),
                    residual: R::of(f64::INFINITY),
                    pivots: 0,
                    path: Path::Trivial,
                }
            }
            None => self.search(problem),
        };
        Outcome::new(&self.answer, report)
    }

    fn prepare(&mut self, problem: &Factors<R, NC, ND>) -> [R; ND] {
        let mut roots = [R::zero(); ND];
        for (root, inverse) in roots.iter_mut().zip(problem.inverse_mass) {
            *root = inverse.root();
        }
        self.count = problem.contacts.len();
        let shift = R::of(self.shift);
        for (p, contact) in self.prepared.iter_mut().zip(&problem.contacts) {
            for k in 0..ND {
                p.rows[0][k] = contact.normal[k] * roots[k];
                p.rows[1][k] = contact.tangents[0][k] * roots[k];
                p.rows[2][k] = contact.tangents[1][k] * roots[k];
            }
            for k in 0..3 {
                p.size[k] = dot(&p.rows[k], &p.rows[k]);
            }
            p.constant = [contact.separation, contact.slip[0], contact.slip[1]];
            p.compliance = contact.compliance;
            p.friction = contact.friction;
            p.normal_shift = p.size[0] * shift;
            p.normal_gain = R::one() / (p.compliance + p.normal_shift);
            p.tangent_gain = R::one() / ((p.size[1] + p.size[2]) * shift * R::of(0.5));
        }
        roots
    }

    /// Impulses and modes at the given speeds by the proximal law; returns `G'p - y`.
    #[inline]
    fn respond(
        &mut self,
        y: &[R; ND],
        modes: &mut [Mode; NC],
    ) -> [R; ND] {
        let mut sum = [R::zero(); ND];
        for k in 0..ND {
            sum[k] = -y[k];
        }
        let zero = R::zero();
        for (((p, anchor), impulse), mode) in self
            .prepared
            .iter()
            .zip(&self.anchors)
            .zip(&mut self.impulses)
            .zip(modes.iter_mut())
            .take(self.count)
        {
            let separation = dot(&p.rows[0], y) + p.constant[0];
            let normal = p.normal_gain * (p.normal_shift * anchor[0] - separation);
            if !(normal > zero) {
                *mode = Mode::Open;
                *impulse = [zero; 3];
                continue;
            }
            let limit = p.friction * normal;
            let first = anchor[1] - p.tangent_gain * (dot(&p.rows[1], y) + p.constant[1]);
            let second = anchor[2] - p.tangent_gain * (dot(&p.rows[2], y) + p.constant[2]);
            let (a, b) = (magnitude(first), magnitude(second));
            let (sign_a, sign_b) = (if first < zero { -1 } else { 1 }, if second < zero { -1 } else { 1 });
            let signed = |sign: i8, x: R| if sign < 0 { -x } else { x };
            let (force, now) = if p.friction == zero {
                ([zero; 2], Mode::Slide(0, 0))
            } else if a + b <= limit {
                ([first, second], Mode::Stick)
            } else if a - b > limit {
                ([signed(sign_a, limit), zero], Mode::Slide(sign_a, 0))
            } else if b - a > limit {
                ([zero, signed(sign_b, limit)], Mode::Slide(0, sign_b))
            } else {
                let over = (a + b - limit) * R::of(0.5);
                ([signed(sign_a, a - over), signed(sign_b, b - over)], Mode::Slide(sign_a, sign_b))
            };
            *mode = now;
            *impulse = [normal, force[0], force[1]];
            add_scaled(&mut sum, normal, &p.rows[0]);
            add_scaled(&mut sum, force[0], &p.rows[1]);
            add_scaled(&mut sum, force[1], &p.rows[2]);
        }
        sum
    }

    /// As [`Self::respond`], each contact held in its mode.
    fn respond_held(&mut self, y: &[R; ND], modes: &[Mode; NC]) -> [R; ND] {
        let mut sum = [R::zero(); ND];
        for k in 0..ND {
            sum[k] = -y[k];
        }
        let zero = R::zero();
        let half = R::of(0.5);
        for ((p, anchor), mode) in
            self.prepared.iter().zip(&self.anchors).zip(modes).take(self.count)
        {
            if *mode == Mode::Open {
                continue;
            }
            let separation = dot(&p.rows[0], y) + p.constant[0];
            let normal = p.normal_gain * (p.normal_shift * anchor[0] - separation);
            let limit = p.friction * normal;
            let force = match *mode {
                Mode::Open => [zero; 2],
                Mode::Slide(s, 0) => [limit * R::of(s as f64), zero],
                Mode::Slide(0, s) => [zero, limit * R::of(s as f64)],
                _ => {
                    let first = anchor[1] - p.tangent_gain * (dot(&p.rows[1], y) + p.constant[1]);
                    let second = anchor[2] - p.tangent_gain * (dot(&p.rows[2], y) + p.constant[2]);
                    match *mode {
                        Mode::Slide(s, t) => {
                            let (s, t) = (R::of(s as f64), R::of(t as f64));
                            let across = (first * s - second * t) * half;
                            [s * (across + limit * half), t * (limit * half - across)]
                        }
                        _ => [first, second],
                    }
                }
            };
            add_scaled(&mut sum, normal, &p.rows[0]);
            add_scaled(&mut sum, force[0], &p.rows[1]);
            add_scaled(&mut sum, force[1], &p.rows[2]);
        }
        sum
    }

    /// `I + sum G_i' K_i G_i` for the modes, factored.
    fn factor(&self, modes: &[Mode; NC]) -> Factorisation<R, ND> {
        let mut matrix = [[R::zero(); ND]; ND];
        for k in 0..ND {
            matrix[k][k] = R::one();
        }
        let half = R::of(0.5);
        for (p, mode) in self.prepared.iter().zip(modes).take(self.count) {
            let [normal, first, second] = &p.rows;
            let mut force = *normal;
            match *mode {
                Mode::Open => continue,
                Mode::Stick => {
                    for r in 0..ND {
                        let (f, g) = (first[r] * p.tangent_gain, second[r] * p.tangent_gain);
                        for c in 0..ND {
                            matrix[r][c] += f * first[c] + g * second[c];
                        }
                    }
                }
                Mode::Slide(s, 0) => {
                    add_scaled(&mut force, p.friction * R::of(s as f64), first);
                }
                Mode::Slide(0, s) => {
                    add_scaled(&mut force, p.friction * R::of(s as f64), second);
                }
                Mode::Slide(s, t) => {
                    let (s, t) = (R::of(s as f64), R::of(t as f64));
                    add_scaled(&mut force, p.friction * s * half, first);
                    add_scaled(&mut force, p.friction * t * half, second);
                    let mut along = [R::zero(); ND];
                    for k in 0..ND {
                        along[k] = s * first[k] - t * second[k];
                    }
                    let gain = p.tangent_gain * half;
                    for r in 0..ND {
                        add_scaled(&mut matrix[r], along[r] * gain, &along);
                    }
                }
            }
            for r in 0..ND {
                add_scaled(&mut matrix[r], force[r] * p.normal_gain, normal);
            }
        }
        Factorisation::of(&matrix)
    }

    /// Upper bound of the residual of the impulses; `speeds` is `G'p`.
    fn certify(&mut self, speeds: &[R; ND]) -> R {
        let zero = R::zero();
        let mut largest = zero;
        for ((p, impulse), slip) in
            self.prepared.iter().zip(&self.impulses).zip(&mut self.slip).take(self.count)
        {
            let first = dot(&p.rows[1], speeds) + p.constant[1];
            let second = dot(&p.rows[2], speeds) + p.constant[2];
            *slip = most(magnitude(first), magnitude(second));
            let friction = most(magnitude(impulse[1]), magnitude(impulse[2]));
            largest = most(most(*slip, largest), most(impulse[0], friction));
        }
        let mut sum = Residual::zero();
        for (((p, impulse), &slip), sliding) in
            self.prepared.iter().zip(&self.impulses).zip(&self.slip).zip(&mut self.sliding).take(self.count)
        {
            let [normal, first, second] = *impulse;
            let un = dot(&p.rows[0], speeds) + p.constant[0];
            let w = un + p.compliance * normal;
            sliding[0] = un;
            let size = magnitude(p.constant[0]) + (p.size[0] + p.compliance) * largest;
            sum.add_row(normal, w, size, largest);
            let used = magnitude(first) + magnitude(second);
            sum.add_row(slip, p.friction * normal - used, (p.friction + R::of(4.0)) * largest, largest);
            for (k, force) in [(1, first), (2, second)] {
                let u = dot(&p.rows[k], speeds) + p.constant[k];
                sliding[k] = u;
                let size = magnitude(p.constant[k]) + (p.size[k] + p.size[k] + R::one()) * largest;
                let w = if force < zero { slip - u } else { slip + u };
                sum.add_row(magnitude(force), w, size, largest);
            }
        }
        sum.value()
    }

    fn gains(&mut self, level: f64) {
        let shift = R::of(level);
        for p in self.prepared.iter_mut().take(self.count) {
            p.normal_shift = p.size[0] * shift;
            p.normal_gain = R::one() / (p.compliance + p.normal_shift);
            p.tangent_gain = R::one() / ((p.size[1] + p.size[2]) * shift * R::of(0.5));
        }
    }

    /// Trial impulses and modes by the law at `y` (`self.constants` true), force sum returned.
    fn force_rate(p: &Prepared<R, ND>, mode: Mode, n: R, a: R, b: R) -> [R; 3] {
        let half = R::of(0.5);
        let zero = R::zero();
        let limit = p.friction * n;
        match mode {
            Mode::Open => [zero; 3],
            Mode::Stick => [n, a, b],
            Mode::Slide(s, 0) => [n, limit * R::of(s as f64), zero],
            Mode::Slide(0, s) => [n, zero, limit * R::of(s as f64)],
            Mode::Slide(s, t) => {
                let (s, t) = (R::of(s as f64), R::of(t as f64));
                let across = (a * s - b * t) * half;
                [n, s * (across + limit * half), t * (limit * half - across)]
            }
        }
    }

    fn update_rates(&mut self, dy: &[R; ND]) {
        for (((p, e), rate), _) in
            self.prepared.iter().zip(&self.offset).zip(&mut self.rate).zip(0..self.count)
        {
            let un = dot(&p.rows[0], dy) - e[0];
            let ua = dot(&p.rows[1], dy) - e[1];
            let ub = dot(&p.rows[2], dy) - e[2];
            *rate = [-p.normal_gain * un, -p.tangent_gain * ua, -p.tangent_gain * ub];
        }
    }

    /// Follows the solution from the offset constants to the true ones.
    fn follow(&mut self, limit: u32) -> (bool, u32) {
        let zero = R::zero();
        let one = R::one();
        let half = R::of(0.5);
        let mut inverse = [[zero; ND]; ND];
        let open = self.modes.iter().take(self.count).all(|m| *m == Mode::Open);
        if open {
            for k in 0..ND {
                inverse[k][k] = one;
            }
        } else {
            let f = self.factor(&self.modes);
            for k in 0..ND {
                let mut unit = [zero; ND];
                unit[k] = one;
                let column = f.solve(&unit);
                for r in 0..ND {
                    inverse[r][k] = column[r];
                }
            }
        }
        let mut g = [zero; ND];
        for ((p, e), mode) in
            self.prepared.iter().zip(&self.offset).zip(&self.modes).take(self.count)
        {
            let f = Self::force_rate(p, *mode, p.normal_gain * e[0], p.tangent_gain * e[1], p.tangent_gain * e[2]);
            for k in 0..3 {
                add_scaled(&mut g, f[k], &p.rows[k]);
            }
        }
        let mut dy = [zero; ND];
        for r in 0..ND {
            dy[r] = dot(&inverse[r], &g);
        }
        self.update_rates(&dy);
        let mut t = zero;
        let mut forward = true;
        for count in 0..limit {
            let sigma = if forward { one } else { -one };
            let mut least = if forward { one - t } else { R::of(1e30) };
            let mut hit: Option<(usize, Mode)> = None;
            for i in 0..self.count {
                let v = self.trial[i];
                let r = self.rate[i];
                let p = &self.prepared[i];
                let dn = r[0] * sigma;
                let mut check = |value: R, rate: R, target: Mode| {
                    // value >= 0 falls at `rate` < 0
                    if rate < zero {
                        let alpha = most(value, zero) / -rate;
                        if alpha < least {
                            least = alpha;
                            hit = Some((i, target));
                        }
                    }
                };
                let mode = self.modes[i];
                let (l, dl) = (p.friction * v[0], p.friction * dn);
                let (da, db) = (r[1] * sigma, r[2] * sigma);
                match mode {
                    Mode::Open => {
                        check(-v[0], -dn, Mode::Slide(0, 0));
                        continue;
                    }
                    Mode::Stick => {
                        for (s, t) in [(1i8, 1i8), (1, -1), (-1, 1), (-1, -1)] {
                            let (fs, ft) = (R::of(s as f64), R::of(t as f64));
                            check(l - fs * v[1] - ft * v[2], dl - fs * da - ft * db, Mode::Slide(s, t));
                        }
                    }
                    Mode::Slide(0, 0) => {}
                    Mode::Slide(s, 0) => {
                        let fs = R::of(s as f64);
                        for t in [1i8, -1] {
                            let ft = R::of(t as f64);
                            check(fs * v[1] - l - ft * v[2], fs * da - dl - ft * db, Mode::Slide(s, t));
                        }
                    }
                    Mode::Slide(0, t) => {
                        let ft = R::of(t as f64);
                        for s in [1i8, -1] {
                            let fs = R::of(s as f64);
                            check(ft * v[2] - l - fs * v[1], ft * db - dl - fs * da, Mode::Slide(s, t));
                        }
                    }
                    Mode::Slide(s, t) => {
                        let (fs, ft) = (R::of(s as f64), R::of(t as f64));
                        let (a, b, da, db) = (fs * v[1], ft * v[2], fs * da, ft * db);
                        check(a + b - l, da + db - dl, Mode::Stick);
                        check(l - a + b, dl - da + db, Mode::Slide(s, 0));
                        check(l + a - b, dl + da - db, Mode::Slide(0, t));
                    }
                }
                check(v[0], dn, Mode::Open);
            }
            let step = sigma * least;
            add_scaled(&mut self.speeds, step, &dy);
            for i in 0..self.count {
                for k in 0..3 {
                    self.trial[i][k] += step * self.rate[i][k];
                }
            }
            t += step;
            let Some((i, target)) = hit else {
                return (forward, count);
            };
            // switch contact i
            let p = &self.prepared[i];
            let v = self.trial[i];
            let r = self.rate[i];
            let from = self.modes[i];
            let target = if from == Mode::Open && p.friction > zero {
                if magnitude(v[1]) >= magnitude(v[2]) {
                    Mode::Slide(if v[1] < zero { -1 } else { 1 }, 0)
                } else {
                    Mode::Slide(0, if v[2] < zero { -1 } else { 1 })
                }
            } else {
                target
            };
            let rank = |m: Mode| match m {
                Mode::Open => 0,
                Mode::Slide(s, t) if s != 0 && t != 0 => 2,
                Mode::Slide(_, _) => 1,
                Mode::Stick => 3,
            };
            let finer = rank(target) > rank(from);
            let (low, high) = if finer { (from, target) } else { (target, from) };
            let sign = |s: i8| R::of(s as f64);
            let mut a = [zero; ND];
            let mut b = [zero; ND];
            let phi;
            match (low, high) {
                (Mode::Open, Mode::Slide(s, t)) => {
                    b = p.rows[0];
                    a = p.rows[0];
                    add_scaled(&mut a, p.friction * sign(s), &p.rows[1]);
                    add_scaled(&mut a, p.friction * sign(t), &p.rows[2]);
                    for k in 0..ND {
                        a[k] *= p.normal_gain;
                    }
                    phi = -r[0] / p.normal_gain;
                }
                (Mode::Open, _) => {
                    self.bad += 1;
                    return (false, count);
                }
                (Mode::Slide(_, lt), Mode::Slide(s, t)) => {
                    let flip = if lt == 0 { one } else { -one };
                    add_scaled(&mut a, half * sign(s) * flip, &p.rows[1]);
                    add_scaled(&mut a, -half * sign(t) * flip, &p.rows[2]);
                    add_scaled(&mut b, (p.tangent_gain) * (half + half) * R::of(2.0), &a);
                    add_scaled(&mut b, -p.friction * p.normal_gain, &p.rows[0]);
                    phi = -(flip * (sign(s) * r[1] - sign(t) * r[2]) - p.friction * r[0]);
                }
                (Mode::Slide(s, t), _) => {
                    add_scaled(&mut a, half * sign(s), &p.rows[1]);
                    add_scaled(&mut a, half * sign(t), &p.rows[2]);
                    add_scaled(&mut b, p.tangent_gain * R::of(2.0), &a);
                    add_scaled(&mut b, -p.friction * p.normal_gain, &p.rows[0]);
                    phi = -(sign(s) * r[1] + sign(t) * r[2] - p.friction * r[0]);
                }
                _ => return (false, count),
            }
            if !finer {
                for k in 0..ND {
                    a[k] = -a[k];
                }
            }
            let mut w = [zero; ND];
            let mut c = [zero; ND];
            for k in 0..ND {
                w[k] = dot(&inverse[k], &a);
                add_scaled(&mut c, b[k], &inverse[k]);
            }
            let det = one + dot(&b, &w);
            if !(magnitude(det) > R::of(1e-14)) {
                self.bad += 1;
                return (false, count);
            }
            let id = one / det;
            add_scaled(&mut dy, -phi * id, &w);
            for k in 0..ND {
                add_scaled(&mut inverse[k], -w[k] * id, &c);
            }
            if det < zero {
                forward = !forward;
            }
            self.modes[i] = target;
            self.update_rates(&dy);
        }
        (false, limit)
    }

    fn search(&mut self, problem: &Factors<R, NC, ND>) -> Report<R> {
        let _ = self.prepare(problem);
        let zero = R::zero();
        let warm = self.known == self.count && self.count > 0;
        let mut pivots = 0;
        self.gains(self.shift);
        let mut ok;
        if warm {
            let mut y = [zero; ND];
            self.anchors = self.impulses;
            for (p, impulse) in self.prepared.iter().zip(&self.impulses).take(self.count) {
                for k in 0..3 {
                    add_scaled(&mut y, impulse[k], &p.rows[k]);
                }
            }
            for i in 0..self.count {
                let p = &self.prepared[i];
                let (u, l) = (self.sliding[i], self.anchors[i]);
                self.trial[i] = [
                    p.normal_gain * (p.normal_shift * l[0] - u[0]),
                    l[1] - p.tangent_gain * u[1],
                    l[2] - p.tangent_gain * u[2],
                ];
                for k in 0..3 {
                    self.offset[i][k] = u[k] - dot(&p.rows[k], &y) - p.constant[k];
                }
            }
            self.speeds = y;
            let (done, steps) = self.follow(400);
            ok = done;
            pivots += 1 + steps;
        } else {
            self.anchors = [[zero; 3]; NC];
            self.speeds = [zero; ND];
            self.modes = [Mode::Open; NC];
            let mut worst = zero;
            for p in self.prepared.iter().take(self.count) {
                worst = most(-p.constant[0], worst);
            }
            let mut phase = 0.0f64;
            let mut tangent = zero;
            for p in self.prepared.iter().take(self.count) {
                tangent = most(tangent, most(magnitude(p.constant[1]), magnitude(p.constant[2])));
            }
            tangent = tangent * R::of(self.rate_t);
            for i in 0..self.count {
                phase += 0.618033988749895;
                if phase > 1.0 { phase -= 1.0; }
                let p = &self.prepared[i];
                let ph2 = phase * 7.0 - (phase * 7.0) as i32 as f64;
                self.offset[i] = [worst * R::of(1.01 + 0.1 * phase), tangent * R::of(phase - 0.5), tangent * R::of(ph2 - 0.5)];
                let e = self.offset[i];
                self.trial[i] = [
                    -p.normal_gain * (e[0] + p.constant[0]),
                    -p.tangent_gain * (e[1] + p.constant[1]),
                    -p.tangent_gain * (e[2] + p.constant[2]),
                ];
            }
            let (done, steps) = self.follow(400);
            ok = done;
            pivots += steps;
        }
        let aim = tolerance::<R>() * R::of(1e-3);
        let mut residual = R::of(f64::INFINITY);
        let mut modes = self.modes;
        if ok {
            let mut y = self.speeds;
            let mut first = true;
            let mut factors = Factorisation::identity();
            for round in 0..12 {
                let r = self.respond(&y, &mut modes);
                let mut speeds = y;
                add_scaled(&mut speeds, R::one(), &r);
                let now = self.certify(&speeds);
                if now < residual { residual = now; }
                if now <= aim || round == 11 { break; }
                self.anchors = self.impulses;
                let r = self.respond(&y, &mut modes);
                if first || !modes.iter().zip(&self.modes).take(self.count).all(|(a, b)| a == b) {
                    self.modes = modes;
                    factors = self.factor(&modes);
                    pivots += 1;
                    first = false;
                }
                let step = factors.solve(&r);
                add_scaled(&mut y, R::one(), &step);
            }
            self.modes = modes;
        }
        self.answer = Impulses::none();
        for (impulse, &slip) in self.impulses.iter().zip(&self.slip).take(self.count) {
            let _ = self.answer.normal.push(impulse[0]);
            let _ = self.answer.tangential.push([impulse[1], impulse[2]]);
            let _ = self.answer.slip.push(slip);
        }
        let good = residual <= tolerance();
        self.known = if good { self.count } else { 0 };
        Report {
            status: if good { Status::Solved } else { Status::Numerical },
            residual,
            pivots,
            path: if warm { Path::Warm } else { Path::Newton },
        }
    }
}
