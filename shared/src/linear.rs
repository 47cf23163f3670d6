//! Linear equations of a handful of unknowns: elimination with row exchanges, kept for further
//! right-hand sides.

use crate::real::{Real, abs};
use crate::solve::DOF;

/// A generalised velocity, or a generalised impulse.
pub(crate) type Vec7<R> = [R; DOF];
/// A matrix between them.
pub(crate) type Mat7<R> = [[R; DOF]; DOF];

/// Triangular factors of a square matrix of `ND` rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factors<R, const ND: usize> {
    /// Multipliers below the diagonal, the upper triangle above it, inverses on it.
    rows: [[R; ND]; ND],
    /// Row that was exchanged with row k at step k.
    exchanged: [u8; ND],
}

/// Factors of an earlier solve: while the points do the same, they serve again.
#[derive(Clone, Copy, Debug)]
pub struct Kept<R> {
    pub(crate) factors: Factors<R, DOF>,
    /// Of what the points did when they were made, in which formulation.
    pub(crate) modes: u32,
    /// Zero: there are none.
    pub(crate) dt_s: R,
}

impl<R: Real> Kept<R> {
    /// None.
    pub fn nothing() -> Self {
        Self { factors: Factors::none(), modes: 0, dt_s: R::zero() }
    }
}

impl<R: Real, const ND: usize> Factors<R, ND> {
    /// Of nothing yet.
    pub(crate) fn none() -> Self {
        Self { rows: [[R::zero(); ND]; ND], exchanged: [0; ND] }
    }

    /// Of the identity.
    pub(crate) fn identity() -> Self {
        let mut out = Self::none();
        for (k, (row, exchanged)) in out.rows.iter_mut().zip(&mut out.exchanged).enumerate() {
            *exchanged = k as u8;
            row[k] = R::one();
        }
        out
    }

    /// Of `matrix`; a pivot of zero leaves its unknown at zero.
    pub(crate) fn of(matrix: &[[R; ND]; ND]) -> Self {
        let mut out = Self { rows: *matrix, exchanged: [0; ND] };
        out.factorise();
        out
    }

    /// Where the matrix is written before it is factorised.
    pub(crate) fn matrix(&mut self) -> &mut [[R; ND]; ND] {
        &mut self.rows
    }

    /// Turns the matrix into its factors; `false` where it is singular or not a number.
    pub(crate) fn factorise(&mut self) -> bool {
        let Self { rows, exchanged } = self;
        let mut regular = true;
        for k in 0..ND {
            let (mut pivot, mut size) = (k, abs(rows[k][k]));
            for i in k + 1..ND {
                let candidate = abs(rows[i][k]);
                if candidate > size {
                    (pivot, size) = (i, candidate);
                }
            }
            regular &= size > R::zero();
            exchanged[k] = pivot as u8;
            // Fails where both are the same row.
            if let Ok([a, b]) = rows.get_disjoint_mut([k, pivot]) {
                core::mem::swap(a, b);
            }
            let pivot = rows[k][k];
            let inverse = if pivot == R::zero() { R::zero() } else { R::one() / pivot };
            rows[k][k] = inverse;
            let above = rows[k];
            for row in rows.iter_mut().skip(k + 1) {
                let factor = row[k] * inverse;
                row[k] = factor;
                if factor != R::zero() {
                    for j in k + 1..ND {
                        row[j] -= factor * above[j];
                    }
                }
            }
        }
        regular
    }

    /// Solves `A x = b`.
    pub(crate) fn solve(&self, b: &[R; ND]) -> [R; ND] {
        let mut x = *b;
        for (k, other) in self.exchanged.iter().enumerate() {
            let other = usize::from(*other);
            if other != k && other < ND {
                x.swap(k, other);
            }
        }
        for k in 0..ND {
            let value = x[k];
            for i in k + 1..ND {
                x[i] -= self.rows[i][k] * value;
            }
        }
        for k in (0..ND).rev() {
            x[k] *= self.rows[k][k];
            let value = x[k];
            for i in 0..k {
                x[i] -= self.rows[i][k] * value;
            }
        }
        x
    }

    /// Solves `A x = -b`; `None` where a component is not finite.
    pub(crate) fn solve_negative(&self, b: &[R; ND]) -> Option<[R; ND]> {
        let x = self.solve(&b.map(|b| -b));
        // Only finite numbers times zero add up to zero.
        let probe = x.iter().fold(R::zero(), |sum, x| sum + *x * R::zero());
        (probe == R::zero()).then_some(x)
    }

    /// The inverse, row by row.
    pub(crate) fn inverse(&self) -> [[R; ND]; ND] {
        let mut inverse = [[R::zero(); ND]; ND];
        for k in 0..ND {
            let mut unit = [R::zero(); ND];
            unit[k] = R::one();
            let column = self.solve(&unit);
            for r in 0..ND {
                inverse[r][k] = column[r];
            }
        }
        inverse
    }
}
