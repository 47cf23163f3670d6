//! Linear equations of a handful of unknowns: elimination with row exchanges.

use crate::real::{Real, abs};

/// Factors of a square matrix of `ND` rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factorisation<R, const ND: usize> {
    /// Unit lower and upper triangle; the diagonal of the upper one is inverted.
    rows: [[R; ND]; ND],
    /// Row that was exchanged with row k at step k.
    exchanged: [usize; ND],
}

impl<R: Real, const ND: usize> Factorisation<R, ND> {
    pub(super) fn identity() -> Self {
        let mut rows = [[R::zero(); ND]; ND];
        let mut exchanged = [0; ND];
        for k in 0..ND {
            rows[k][k] = R::one();
            exchanged[k] = k;
        }
        Self { rows, exchanged }
    }

    /// Factors `matrix`; a pivot of zero leaves its unknown at zero.
    #[inline]
    pub(super) fn of(matrix: &[[R; ND]; ND]) -> Self {
        let mut rows = *matrix;
        let mut exchanged = [0; ND];
        for k in 0..ND {
            let mut best = k;
            let mut size = abs(rows[k][k]);
            for i in k + 1..ND {
                let candidate = abs(rows[i][k]);
                if candidate > size {
                    size = candidate;
                    best = i;
                }
            }
            exchanged[k] = best;
            if best != k && best < ND {
                rows.swap(k, best);
            }
            let pivot = rows[k][k];
            let inverse = if pivot == R::zero() { R::zero() } else { R::one() / pivot };
            rows[k][k] = inverse;
            let above = rows[k];
            for i in k + 1..ND {
                let factor = rows[i][k] * inverse;
                rows[i][k] = factor;
                for j in k + 1..ND {
                    rows[i][j] -= factor * above[j];
                }
            }
        }
        Self { rows, exchanged }
    }

    /// The inverse, row by row.
    pub(super) fn inverse(&self) -> [[R; ND]; ND] {
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

    /// Solves for the right-hand side `b`.
    #[inline]
    pub(super) fn solve(&self, b: &[R; ND]) -> [R; ND] {
        let mut x = *b;
        for k in 0..ND {
            let other = self.exchanged[k];
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
}
