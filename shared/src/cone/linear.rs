//! Seven linear equations: elimination with row exchanges, kept for further right-hand sides.

use crate::real::{Real, abs};
use crate::solve::DOF;

pub(super) type Vec7<R> = [R; DOF];
pub(super) type Mat7<R> = [[R; DOF]; DOF];

/// Triangular factors of a matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors<R> {
    /// Multipliers below the diagonal, the upper triangle above it, inverses on it.
    rows: Mat7<R>,
    /// Row that was exchanged with row k at step k.
    exchanged: [u8; DOF],
}

impl<R: Real> Factors<R> {
    /// Of nothing yet.
    pub(super) fn none() -> Self {
        Self { rows: [[R::zero(); DOF]; DOF], exchanged: [0; DOF] }
    }

    /// Where the matrix is written before it is factorised.
    pub(super) fn matrix(&mut self) -> &mut Mat7<R> {
        &mut self.rows
    }

    /// Turns the matrix into its factors; `false` where it is singular or not a number.
    pub(super) fn factorise(&mut self) -> bool {
        let Self { rows, exchanged } = self;
        for k in 0..DOF {
            let (mut pivot, mut size) = (k, abs(rows[k][k]));
            for i in k + 1..DOF {
                let candidate = abs(rows[i][k]);
                if candidate > size {
                    (pivot, size) = (i, candidate);
                }
            }
            if !(size > R::zero()) {
                return false;
            }
            exchanged[k] = pivot as u8;
            // Fails where both are the same row.
            if let Ok([a, b]) = rows.get_disjoint_mut([k, pivot]) {
                core::mem::swap(a, b);
            }
            let inverse = R::one() / rows[k][k];
            rows[k][k] = inverse;
            let above = rows[k];
            for row in rows.iter_mut().skip(k + 1) {
                let factor = row[k] * inverse;
                row[k] = factor;
                if factor != R::zero() {
                    for j in k + 1..DOF {
                        row[j] -= factor * above[j];
                    }
                }
            }
        }
        true
    }

    /// Solves `A x = -b`; `None` where a component is not finite.
    pub(super) fn solve_negative(&self, b: &Vec7<R>) -> Option<Vec7<R>> {
        let mut x = [R::zero(); DOF];
        for (x, b) in x.iter_mut().zip(b) {
            *x = -*b;
        }
        for (k, other) in self.exchanged.iter().enumerate() {
            let other = usize::from(*other);
            if other != k && other < DOF {
                x.swap(k, other);
            }
        }
        for k in 0..DOF {
            let value = x[k];
            for i in k + 1..DOF {
                x[i] -= self.rows[i][k] * value;
            }
        }
        let mut probe = R::zero();
        for k in (0..DOF).rev() {
            x[k] *= self.rows[k][k];
            let value = x[k];
            probe += value * R::zero();
            for i in 0..k {
                x[i] -= self.rows[i][k] * value;
            }
        }
        // Only finite numbers times zero add up to zero.
        (probe == R::zero()).then_some(x)
    }
}
