//! The certificate: how far `z` is from solving the problem, without units.
//!
//! With `Z = |z|_inf` and `s_i = |q_i| + sum_j |M_ij| Z` (the size of the numbers that make
//! `w_i`), the residual is the largest of three: the most negative unknown `-min(z) / Z`, the
//! most negative slack `-w_i / s_i`, and the sum of the products `(|z_i| / Z) (|w_i| / s_i)`.

use super::tolerance;
use crate::real::{Real, abs, max, sqrt};

/// The three parts of the residual, dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual<R> {
    /// `max(0, -min(z) / Z)`.
    pub unknown: R,
    /// `max(0, max_i(-w_i / s_i))`.
    pub slack: R,
    /// `sum_i (|z_i| / Z) (|w_i| / s_i)`.
    pub complementarity: R,
}

impl<R: Real> Residual<R> {
    /// Of `z = 0`, before rows are added.
    pub fn zero() -> Self {
        Self { unknown: R::zero(), slack: R::zero(), complementarity: R::zero() }
    }

    /// Adds a row: unknown `z`, slack `w`, row size `size` = `s_i`, largest unknown `largest` = `Z`.
    pub fn add_row(&mut self, z: R, w: R, size: R, largest: R) {
        if largest > R::zero() {
            self.unknown = max(self.unknown, -z / largest);
        }
        if size > R::zero() {
            let relative = w / size;
            self.slack = max(self.slack, -relative);
            if largest > R::zero() {
                self.complementarity += abs(z) / largest * abs(relative);
            }
        }
        // A row of size zero has w = 0 exactly. What is not a number solves nothing.
        if !(z.finite() && w.finite() && size.finite()) {
            self.complementarity = R::of(f64::INFINITY);
        }
    }

    /// [`Residual::add_row`] with one over the largest unknown, which is positive: a division less for
    /// each part. `size` is positive, or `w` zero with it.
    #[inline(always)]
    pub(super) fn add_scaled_row(&mut self, z: R, w: R, size: R, by_largest: R) {
        let share = z * by_largest;
        self.unknown = max(self.unknown, -share);
        if size > R::zero() {
            let relative = w / size;
            self.slack = max(self.slack, -relative);
            self.complementarity += abs(share) * abs(relative);
        }
        // Only finite numbers times zero add up to zero.
        if !((z + w + size) * R::zero() == R::zero()) {
            self.complementarity = R::of(f64::INFINITY);
        }
    }

    /// The largest part: the number that is compared with the tolerance.
    pub fn value(&self) -> R {
        max(max(self.unknown, self.slack), self.complementarity)
    }
}

/// The residual, or how far the worst slack is below zero in units of the largest constant
/// where that is more than the square root of the tolerance (1e-4 in `f64`). Huge unknowns make
/// any row large and its residual small: contacts that contradict each other, if only a little
/// beside what else moves, would be solved by impulses without bound.
pub(super) fn credible<R: Real>(residual: R, worst_slack: R, largest_constant: R) -> R {
    let violation = -worst_slack;
    if violation > largest_constant * sqrt(tolerance::<R>()) && largest_constant > R::zero() {
        max(violation / largest_constant, residual)
    } else {
        residual
    }
}

/// Largest magnitude in `z`.
pub fn largest<R: Real>(z: &[R]) -> R {
    z.iter().fold(R::zero(), |most_so_far, &x| max(abs(x), most_so_far))
}

/// Residual of `z` (n) for the dense problem `m` (n x n, row by row) and `q` (n).
///
/// Lengths that do not belong together give an infinite residual.
pub fn dense<R: Real>(m: &[R], q: &[R], z: &[R]) -> Residual<R> {
    let n = q.len();
    let mut sum = Residual::zero();
    if n == 0 || z.len() != n || m.len() / n != n || !m.len().is_multiple_of(n) {
        sum.slack = R::of(f64::INFINITY);
        return sum;
    }
    let biggest = largest(z);
    for ((row, &constant), &unknown) in m.chunks_exact(n).zip(q).zip(z) {
        let (mut w, mut size) = (constant, R::zero());
        for (&entry, &x) in row.iter().zip(z) {
            w += entry * x;
            size += abs(entry);
        }
        sum.add_row(unknown, w, abs(constant) + size * biggest, biggest);
    }
    sum
}
