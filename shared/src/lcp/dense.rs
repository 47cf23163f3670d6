//! Any matrix: Lemke's method with lexicographic ties, and what makes it hold under rounding.
//!
//! The covering vector `d > 0` makes `w = M z + q + d z0` feasible for a large `z0`; complementary
//! pivots then drive `z0` to zero (Lemke 1965; Cottle, Pang and Stone 1992, algorithm 4.4.5).
//! Three things go wrong in floating point on contact problems, where `M` has a rank of six
//! to eight under rounding noise:
//!
//! - the scales of rows differ by a million: rows and columns are scaled by powers of two,
//!   which is exact;
//! - a pivot on noise: a small multiple of the diagonal is added, far below the tolerance of
//!   the residual and far above the noise, so that the pivots are made of something. The
//!   answer is then corrected on its own basis with the matrix as given;
//! - the sequence of pivots fails all the same: it starts again with another covering vector
//!   and a larger multiple (`ATTEMPTS`). The best answer by the residual is kept.
//!
//! The pivots work on a dictionary (basic variables as functions of the nonbasic ones), which
//! holds the inverse of the basis in its slack columns: ties are broken by these, exactly.
//!
//! Above 600 lines: pivots, proof and correction work in place on one dictionary.

use super::{Defect, Outcome, Path, Report, SolveStatus, residual, tolerance};
use crate::real::{Real, abs, max, min, sqrt};

/// One run of Lemke's method.
#[derive(Clone, Copy, Debug)]
struct Attempt {
    /// Multiple of the diagonal that is added, in units of the scaled matrix.
    shift: f64,
    /// Spread of the covering vector: 0 is all ones.
    spread: f64,
    /// Smallest pivot relative to the largest in its column.
    pivot: f64,
}

/// The order in which runs are tried. The first finds nearly every answer.
const ATTEMPTS: [Attempt; 16] = [
    Attempt { shift: 1e-9, spread: 0.0, pivot: 1e-9 },
    Attempt { shift: 1e-9, spread: 0.5, pivot: 1e-12 },
    Attempt { shift: 1e-10, spread: 0.9, pivot: 1e-13 },
    Attempt { shift: 0.0, spread: 0.0, pivot: 1e-11 },
    Attempt { shift: 1e-8, spread: 0.3, pivot: 1e-12 },
    Attempt { shift: 1e-12, spread: 0.9, pivot: 1e-10 },
    Attempt { shift: 0.0, spread: 0.9, pivot: 1e-9 },
    Attempt { shift: 1e-9, spread: 0.8, pivot: 1e-9 },
    Attempt { shift: 1e-7, spread: 0.6, pivot: 1e-12 },
    Attempt { shift: 1e-10, spread: 0.95, pivot: 1e-7 },
    Attempt { shift: 1e-13, spread: 0.2, pivot: 1e-11 },
    Attempt { shift: 1e-8, spread: 0.99, pivot: 1e-10 },
    Attempt { shift: 1e-6, spread: 0.1, pivot: 1e-12 },
    Attempt { shift: 1e-5, spread: 0.7, pivot: 1e-12 },
    Attempt { shift: 1e-9, spread: 0.97, pivot: 1e-14 },
    Attempt { shift: 0.0, spread: 0.5, pivot: 1e-12 },
];

/// Runs that are given up early: one that arrives takes `3 n` pivots at most, with few exceptions.
const SHORT_RUNS: usize = 12;
/// Coefficients below this many roundings count as zero where a ray is proved.
const FLAT: f64 = 1e4;

/// How a run of pivots ended.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Basis,
    Ray,
    Limit,
}

/// Working memory and answer of the dense solver; holds problems of up to `N - 2` unknowns.
pub struct Dense<R, const N: usize> {
    /// Dictionary: row i holds basic variable i; columns are the constant, z0, then n more.
    table: [[R; N]; N],
    /// Variable of each row: slack i is `i`, unknown i is `n + i`, z0 is `2 n`.
    basic: [usize; N],
    /// Variable of each column (the first is the constant and is not used).
    nonbasic: [usize; N],
    row_scale: [R; N],
    column_scale: [R; N],
    /// Of `q`, so that its largest entry is near one; the answer is divided by it.
    constant_scale: R,
    z: [R; N],
    best: [R; N],
    step: [R; N],
}

impl<R: Real, const N: usize> Default for Dense<R, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<R: Real, const N: usize> Dense<R, N> {
    /// Largest number of unknowns.
    pub const CAPACITY: usize = N.saturating_sub(2);

    /// Working memory, about `N * N` scalars.
    pub fn new() -> Self {
        Self {
            table: [[R::zero(); N]; N],
            basic: [0; N],
            nonbasic: [0; N],
            row_scale: [R::one(); N],
            column_scale: [R::one(); N],
            constant_scale: R::one(),
            z: [R::zero(); N],
            best: [R::zero(); N],
            step: [R::zero(); N],
        }
    }

    /// Solves `w = m z + q` with `m` n x n, row by row, and `q` n, at the default tolerance.
    ///
    /// Runs at most 16 attempts, 12 of `6 n + 50` and 4 of `20 n + 50` pivots, and the proof that
    /// there is no solution (`4 n + 20`). Nothing here panics; numbers
    /// that are not finite and sizes that do not fit are [`SolveStatus::BadInput`].
    pub fn solve(&mut self, m: &[R], q: &[R]) -> Outcome<'_, [R], R> {
        let n = q.len();
        let refuse = |defect| Outcome::new(&[] as &[R], Report::refused(defect));
        if n == 0 {
            return refuse(Defect::Empty);
        }
        if n > Self::CAPACITY || m.len() != n * n {
            return refuse(Defect::Size);
        }
        if !m.iter().chain(q).all(|x| x.finite()) {
            return refuse(Defect::NotFinite);
        }
        let report = self.search(m, q, n);
        Outcome::new(self.best.get(..n).unwrap_or(&[]), report)
    }

    fn search(&mut self, m: &[R], q: &[R], n: usize) -> Report<R> {
        self.best = [R::zero(); N];
        let mut report = Report { status: SolveStatus::Solved, residual: R::zero(), ..Report::nothing() };
        if q.iter().all(|&x| x >= R::zero()) {
            return report;
        }
        report.residual = R::of(f64::INFINITY);
        self.scale(m, q, n);
        // Rays and runs without a shift: with one, a copositive problem always has a solution.
        let (mut rays, mut unshifted, mut limits) = (0, 0, 0);
        for (index, attempt) in ATTEMPTS.iter().enumerate() {
            self.fill(m, q, n, attempt);
            let limit = if index < SHORT_RUNS { 6 * n + 50 } else { 20 * n + 50 };
            let (end, pivots) = self.pivot_to_end(n, R::of(attempt.pivot), limit as u32);
            report.pivots = report.pivots.saturating_add(pivots);
            if attempt.shift == 0.0 {
                unshifted += 1;
                rays += u32::from(end == End::Ray);
            }
            limits += u32::from(end == End::Limit);
            self.read(n);
            let mut found = self.judge(m, q, n);
            if !(found <= tolerance::<R>() * R::of(1e-2)) && end == End::Basis {
                found = self.correct(m, q, n, found);
            }
            if found < report.residual {
                report.residual = found;
                report.path = if index == 0 { Path::Lemke } else { Path::Restarted(index as u8) };
                self.best = self.z;
            }
            if report.residual <= tolerance() {
                return report;
            }
            // Before the long way: is there anything to be found?
            if index == 0 {
                let (none, pivots) = self.infeasible(m, q, n);
                report.pivots = report.pivots.saturating_add(pivots);
                if none {
                    report.status = SolveStatus::Contradiction;
                    return report;
                }
            }
        }
        report.status = if rays == unshifted {
            SolveStatus::Contradiction
        } else if limits > 0 {
            SolveStatus::IterationLimit
        } else {
            SolveStatus::Numerical
        };
        report
    }

    /// Powers of two that bring the largest entries of rows and columns near one.
    fn scale(&mut self, m: &[R], q: &[R], n: usize) {
        self.row_scale = [R::one(); N];
        self.column_scale = [R::one(); N];
        for _ in 0..3 {
            let mut columns = [R::zero(); N];
            for (row, scale) in m.chunks_exact(n).zip(&mut self.row_scale) {
                let mut largest = R::zero();
                for ((&entry, &column), peak) in row.iter().zip(&self.column_scale).zip(&mut columns) {
                    let size = abs(entry) * column * *scale;
                    largest = max(size, largest);
                    *peak = max(size, *peak);
                }
                *scale *= inverse_root_power_of_two(largest);
            }
            for (scale, peak) in self.column_scale.iter_mut().zip(columns).take(n) {
                *scale *= inverse_root_power_of_two(peak);
            }
        }
        let mut largest = R::zero();
        for (&constant, &scale) in q.iter().zip(&self.row_scale) {
            largest = max(abs(constant) * scale, largest);
        }
        let root = inverse_root_power_of_two(largest);
        self.constant_scale = root * root;
    }

    /// Writes the first dictionary: `w = q + d z0 + M z` in scaled units.
    fn fill(&mut self, m: &[R], q: &[R], n: usize, attempt: &Attempt) {
        let shift = R::of(attempt.shift) * R::of(if R::EPSILON.to_f64() < 1e-12 { 1.0 } else { 1e5 });
        // A low-discrepancy sequence: the covering vector differs from row to row, always the same.
        let mut phase = 0.0_f64;
        for (i, ((line, row), &constant)) in self.table.iter_mut().zip(m.chunks_exact(n)).zip(q).enumerate() {
            let scale = self.row_scale.get(i).copied().unwrap_or(R::one());
            phase += 0.618_033_988_749_894_9;
            if phase >= 1.0 {
                phase -= 1.0;
            }
            for (k, value) in line.iter_mut().take(n + 2).enumerate() {
                *value = match k {
                    0 => constant * scale * self.constant_scale,
                    1 => R::of(1.0 - attempt.spread * phase),
                    _ => {
                        let j = k - 2;
                        let entry = row.get(j).copied().unwrap_or(R::zero());
                        let column = self.column_scale.get(j).copied().unwrap_or(R::one());
                        let mut scaled = entry * scale * column;
                        if i == j {
                            scaled += shift;
                        }
                        scaled
                    }
                };
            }
        }
        for (i, variable) in self.basic.iter_mut().enumerate() {
            *variable = i;
        }
        for (k, variable) in self.nonbasic.iter_mut().enumerate() {
            *variable = if k == 1 { 2 * n } else { (n + k).saturating_sub(2) };
        }
    }

    /// Complementary pivots until z0 leaves, a ray appears, or the bound is reached.
    fn pivot_to_end(&mut self, n: usize, smallest: R, limit: u32) -> (End, u32) {
        let artificial = 2 * n;
        // z0 enters.
        let Some(row) = self.neediest(n) else { return (End::Limit, 0) };
        let mut leaving = self.exchange(row, 1, n);
        for count in 1..limit {
            let entering = if leaving < n { leaving + n } else { leaving.saturating_sub(n) };
            let column = self.nonbasic.iter().take(n + 2).skip(1).position(|&x| x == entering);
            let Some(column) = column.map(|k| k + 1) else { return (End::Limit, count) };
            let Some(row) = self.blocking_row(column, n, smallest) else {
                return (End::Ray, count);
            };
            leaving = self.exchange(row, column, n);
            if leaving == artificial {
                return (End::Basis, count + 1);
            }
        }
        (End::Limit, limit)
    }

    /// Whether it is proved that no `z >= 0` makes every slack non-negative, and the pivots made.
    ///
    /// The simplex method on the same dictionary makes z0 as small as it gets. Where that is
    /// above zero, the coefficients of the slacks in its row are weights `y >= 0` with
    /// `M'y <= 0` and `q'y < 0` (Farkas 1902): `y'w = (M'y)'z + q'y` is below zero whatever z is.
    /// The weights are judged with the matrix as given, so rounding in the pivots proves nothing.
    fn infeasible(&mut self, m: &[R], q: &[R], n: usize) -> (bool, u32) {
        let artificial = 2 * n;
        self.fill(m, q, n, &Attempt { shift: 0.0, spread: 0.0, pivot: 0.0 });
        let Some(row) = self.neediest(n) else { return (false, 0) };
        self.exchange(row, 1, n);
        let limit = (4 * n + 20) as u32;
        let flat = R::of(FLAT) * R::EPSILON;
        for count in 1..limit {
            let Some(at) = self.basic.iter().take(n).position(|&x| x == artificial) else {
                return (false, count);
            };
            let Some(line) = self.table.get(at) else { return (false, count) };
            let (mut steepest, mut column) = (-flat, None);
            for (k, &slope) in line.iter().enumerate().take(n + 2).skip(1) {
                if slope < steepest {
                    (steepest, column) = (slope, Some(k));
                }
            }
            let Some(column) = column else {
                self.read_weights(at, n);
                return (self.proves(m, q, n), count);
            };
            let Some(row) = self.blocking_row(column, n, flat) else {
                return (false, count);
            };
            self.exchange(row, column, n);
        }
        (false, limit)
    }

    /// Weights of the slacks in the row `at` of z0, in the units of the problem; left in `step`.
    fn read_weights(&mut self, at: usize, n: usize) {
        self.step = [R::zero(); N];
        let Some(line) = self.table.get(at) else { return };
        let weights = self.nonbasic.iter().zip(line).take(n + 2).skip(1).filter(|w| *w.0 < n);
        let peak = weights.clone().fold(R::zero(), |peak, (_, &weight)| max(weight, peak));
        for (&variable, &weight) in weights {
            // Any weights may prove it, so those that are rounding alone are left out.
            if weight > peak * R::of(FLAT) * R::EPSILON
                && let (Some(y), Some(&scale)) = (self.step.get_mut(variable), self.row_scale.get(variable))
            {
                *y = weight * scale;
            }
        }
    }

    /// Whether the weights in `step` prove that nothing solves the problem: `M'y` is zero or less
    /// to the rounding of its own sums, and `q'y` so far below zero that slacks which a claim is
    /// allowed cannot make up for it.
    fn proves(&self, m: &[R], q: &[R], n: usize) -> bool {
        let (mut sums, mut sizes) = ([R::zero(); N], [R::zero(); N]);
        let (mut constant, mut total) = (R::zero(), R::zero());
        for ((row, &q), &y) in m.chunks_exact(n).zip(q).zip(&self.step) {
            constant += y * q;
            total += y;
            for ((&entry, sum), size) in row.iter().zip(&mut sums).zip(&mut sizes) {
                *sum += entry * y;
                *size += abs(entry) * y;
            }
        }
        let rounding = R::EPSILON * R::of(32.0 * n as f64);
        let consistent = sums.iter().zip(&sizes).take(n).all(|(&sum, &size)| sum <= size * rounding);
        consistent && constant < -(total * residual::largest(q) * sqrt(tolerance::<R>()))
    }

    /// The row that needs z0 most; ties go to the last row, which is the lexicographic order
    /// of the perturbation (e, e^2, ...).
    fn neediest(&self, n: usize) -> Option<usize> {
        let mut first: Option<(usize, R)> = None;
        for (i, line) in self.table.iter().enumerate().take(n) {
            let (Some(&constant), Some(&cover)) = (line.first(), line.get(1)) else { continue };
            let ratio = constant / cover;
            if first.is_none_or(|(_, least)| ratio <= least) {
                first = Some((i, ratio));
            }
        }
        first.map(|(row, _)| row)
    }

    /// Lexicographic ratio test: the row that first reaches zero as `column` grows.
    fn blocking_row(&self, column: usize, n: usize, smallest: R) -> Option<usize> {
        let mut peak = R::zero();
        for line in self.table.iter().take(n) {
            peak = max(abs(line.get(column).copied().unwrap_or(R::zero())), peak);
        }
        let threshold = peak * smallest;
        let mut least: Option<R> = None;
        for line in self.table.iter().take(n) {
            let (Some(&constant), Some(&rate)) = (line.first(), line.get(column)) else { continue };
            if -rate > threshold {
                let ratio = max(constant, R::zero()) / -rate;
                if least.is_none_or(|x| ratio < x) {
                    least = Some(ratio);
                }
            }
        }
        let least = least?;
        // What differs by rounding only is a tie.
        let tie = least * R::of(1.0 + 1e4 * R::EPSILON.to_f64()) + R::EPSILON * R::of(1e-2);
        let mut chosen: Option<usize> = None;
        for (i, line) in self.table.iter().enumerate().take(n) {
            let (Some(&constant), Some(&rate)) = (line.first(), line.get(column)) else { continue };
            if !(-rate > threshold && max(constant, R::zero()) / -rate <= tie) {
                continue;
            }
            if self.basic.get(i) == Some(&(2 * n)) {
                return Some(i);
            }
            chosen = match chosen {
                None => Some(i),
                Some(j) if self.precedes(i, j, column, n) => Some(i),
                kept => kept,
            };
        }
        chosen
    }

    /// Whether row i comes before row j in the lexicographic order of the perturbed ratios.
    fn precedes(&self, i: usize, j: usize, column: usize, n: usize) -> bool {
        let (Some(line_i), Some(line_j)) = (self.table.get(i), self.table.get(j)) else {
            return false;
        };
        let (Some(&rate_i), Some(&rate_j)) = (line_i.get(column), line_j.get(column)) else {
            return false;
        };
        let (basic_i, basic_j) = (self.basic.get(i), self.basic.get(j));
        for slack in 0..n {
            // Coefficient of the perturbation of q at `slack` in each row.
            let coefficients = if basic_i == Some(&slack) {
                (R::one(), R::zero())
            } else if basic_j == Some(&slack) {
                (R::zero(), R::one())
            } else {
                let place = self.nonbasic.iter().take(n + 2).skip(1).position(|&x| x == slack);
                let Some(k) = place.map(|k| k + 1) else { continue };
                match (line_i.get(k), line_j.get(k)) {
                    (Some(&a), Some(&b)) => (-a, -b),
                    _ => continue,
                }
            };
            let difference = coefficients.0 / -rate_i - coefficients.1 / -rate_j;
            let size = abs(coefficients.0 / rate_i) + abs(coefficients.1 / rate_j);
            if abs(difference) > size * R::of(1e3) * R::EPSILON {
                return difference < R::zero();
            }
        }
        false
    }

    /// Exchanges the variable of `row` with that of `column`; returns the one that left.
    fn exchange(&mut self, row: usize, column: usize, n: usize) -> usize {
        let width = (n + 2).min(N);
        let mut line = [R::zero(); N];
        if let Some(source) = self.table.get(row) {
            line = *source;
        }
        let inverse = R::one() / line.get(column).copied().unwrap_or(R::one());
        for value in line.iter_mut().take(width) {
            *value = -*value * inverse;
        }
        if let Some(value) = line.get_mut(column) {
            *value = inverse;
        }
        let Some(pivot_line) = line.get(..width) else { return usize::MAX };
        for (i, target) in self.table.iter_mut().enumerate().take(n) {
            let Some(target) = target.get_mut(..width) else { continue };
            if i == row {
                target.copy_from_slice(pivot_line);
                continue;
            }
            let Some(entry) = target.get_mut(column) else { continue };
            let factor = *entry;
            *entry = R::zero();
            if factor != R::zero() {
                for (value, &pivot) in target.iter_mut().zip(pivot_line) {
                    *value += factor * pivot;
                }
            }
        }
        match (self.basic.get_mut(row), self.nonbasic.get_mut(column)) {
            (Some(a), Some(b)) => {
                core::mem::swap(a, b);
                *b
            }
            _ => usize::MAX,
        }
    }

    /// Unknowns of the present basis, in the units of the problem.
    fn read(&mut self, n: usize) {
        self.z = [R::zero(); N];
        for (&variable, line) in self.basic.iter().zip(&self.table).take(n) {
            let Some(i) = variable.checked_sub(n).filter(|&i| i < n) else { continue };
            if let (Some(z), Some(&value), Some(&scale)) =
                (self.z.get_mut(i), line.first(), self.column_scale.get(i))
            {
                *z = max(value, R::zero()) * scale / self.constant_scale;
            }
        }
    }

    fn judge(&self, m: &[R], q: &[R], n: usize) -> R {
        let Some(z) = self.z.get(..n) else { return R::of(f64::INFINITY) };
        let mut worst = R::zero();
        for (row, &constant) in m.chunks_exact(n).zip(q) {
            let mut w = constant;
            for (&entry, &x) in row.iter().zip(z) {
                w += entry * x;
            }
            worst = min(w, worst);
        }
        residual::credible(residual::dense(m, q, z).value(), worst, residual::largest(q))
    }

    /// Corrects the answer on its own basis with the matrix as given: `M_BB dz = -(q + M z)_B`,
    /// elimination with complete pivoting that stops at the rank. Returns the residual kept.
    fn correct(&mut self, m: &[R], q: &[R], n: usize, before: R) -> R {
        let mut found = before;
        for _ in 0..3 {
            let mut members = 0;
            let kept = self.z;
            // The members of the basis, in order, are left in `nonbasic`; the dictionary is
            // no longer needed and holds the equations.
            for i in 0..n {
                if self.basic.iter().take(n).any(|&x| x == n + i) {
                    if let Some(slot) = self.nonbasic.get_mut(members) {
                        *slot = i;
                    }
                    members += 1;
                }
            }
            for (r, line) in self.table.iter_mut().enumerate().take(members) {
                let i = self.nonbasic.get(r).copied().unwrap_or(0);
                let row = m.get(i * n..(i + 1) * n).unwrap_or(&[]);
                let scale = self.row_scale.get(i).copied().unwrap_or(R::one());
                let mut slack = q.get(i).copied().unwrap_or(R::zero());
                for (&entry, &z) in row.iter().zip(&kept) {
                    slack += entry * z;
                }
                for (c, value) in line.iter_mut().enumerate().take(members) {
                    let j = self.nonbasic.get(c).copied().unwrap_or(0);
                    *value = row.get(j).copied().unwrap_or(R::zero())
                        * scale
                        * self.column_scale.get(j).copied().unwrap_or(R::one());
                }
                if let Some(value) = line.get_mut(members) {
                    *value = -slack * scale;
                }
            }
            self.eliminate(members);
            for (r, &j) in self.nonbasic.iter().enumerate().take(members) {
                if let (Some(z), Some(&step), Some(&scale)) =
                    (self.z.get_mut(j), self.step.get(r), self.column_scale.get(j))
                {
                    *z = max(*z + step * scale, R::zero());
                }
            }
            let after = self.judge(m, q, n);
            if after < found {
                found = after;
            } else {
                self.z = kept;
                break;
            }
        }
        found
    }

    /// Solves the first `size` rows of the table for `step`; what the rank leaves free stays 0.
    fn eliminate(&mut self, size: usize) {
        let mut order = [0_usize; N];
        for (k, place) in order.iter_mut().enumerate() {
            *place = k;
        }
        let mut rank = 0;
        let mut first = R::zero();
        for k in 0..size.min(N) {
            let mut best = (R::zero(), k, k);
            for (i, line) in self.table.iter().enumerate().take(size).skip(k) {
                for (j, &value) in line.iter().enumerate().take(size).skip(k) {
                    if abs(value) > best.0 {
                        best = (abs(value), i, j);
                    }
                }
            }
            first = max(best.0, first);
            if !(best.0 > first * R::EPSILON * R::of(100.0)) {
                break;
            }
            self.table.swap(k, best.1);
            order.swap(k, best.2);
            for line in self.table.iter_mut().take(size) {
                line.swap(k, best.2);
            }
            let Some((upper, lower)) = self.table.split_at_mut_checked(k + 1) else { break };
            let Some(pivot_line) = upper.last() else { break };
            let Some(&pivot) = pivot_line.get(k) else { break };
            for line in lower.iter_mut().take(size.saturating_sub(k + 1)) {
                let factor = line.get(k).copied().unwrap_or(R::zero()) / pivot;
                if factor != R::zero() {
                    for (value, &above) in line.iter_mut().zip(pivot_line).take(size + 1).skip(k) {
                        *value -= factor * above;
                    }
                }
            }
            rank = k + 1;
        }
        let mut solution = [R::zero(); N];
        for k in (0..rank).rev() {
            let Some(line) = self.table.get(k) else { continue };
            let mut value = line.get(size).copied().unwrap_or(R::zero());
            for (&entry, &x) in line.iter().zip(&solution).take(rank).skip(k + 1) {
                value -= entry * x;
            }
            if let (Some(x), Some(&pivot)) = (solution.get_mut(k), line.get(k)) {
                *x = value / pivot;
            }
        }
        self.step = [R::zero(); N];
        for (&place, &x) in order.iter().zip(&solution).take(rank) {
            if let Some(step) = self.step.get_mut(place) {
                *step = x;
            }
        }
    }
}

/// The power of two nearest to `1 / sqrt(x)`, one for zero.
fn inverse_root_power_of_two<R: Real>(x: R) -> R {
    let (two, half) = (R::of(2.0), R::of(0.5));
    let mut scale = R::one();
    if !(x > R::zero() && x.finite()) {
        return scale;
    }
    // At most the 2,100 binary orders of f64, halved.
    for _ in 0..1100 {
        let value = x * scale * scale;
        if value > two {
            scale *= half;
        } else if value < half {
            scale *= two;
        } else {
            break;
        }
    }
    scale
}
