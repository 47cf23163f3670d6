//! Generalised least squares on whitened group means, by Gram matrices.
//!
//! Each group of repetitions has a mean residual with covariance `D + U U^T`: independent
//! noise and floor on the diagonal, run-to-run friction and common directions in `U`.
//! [`Whitener`] turns that into the identity. All further statistics (fits, held-out errors,
//! tests, resampling of conditions) are sums over groups of small Gram matrices of
//! `[parameters | constants of the rig | residual]`, so that none of them simulates again.

use nalgebra::{DMatrix, DVector};

use crate::fit::features::Features;

/// Turns features of one group into uncorrelated ones of unit variance.
#[derive(Clone, Debug)]
pub struct Whitener {
    /// Features in use.
    pub active: Vec<usize>,
    scale: Vec<f64>,
    basis: DMatrix<f64>,
    /// `basis` transposed, as a copy: nalgebra multiplies copies in blocks, views dot by dot.
    transposed: DMatrix<f64>,
    shrink: Vec<f64>,
}

impl Whitener {
    /// For features `active` with variances `variance` and common directions `common` (all
    /// given for every feature).
    pub fn new(active: Vec<usize>, variance: &[f64], common: &[Features]) -> Self {
        let scale: Vec<f64> = active.iter().map(|f| 1.0 / variance[*f].sqrt()).collect();
        let d = active.len();
        let u = DMatrix::from_fn(d, common.len(), |i, k| {
            let x = common[k][active[i]];
            if x.is_finite() { x * scale[i] } else { 0.0 }
        });
        // (I + U U^T)^(-1/2) = I - Q (1 - 1 / sqrt(1 + s^2)) Q^T with U = Q S V^T, from U^T U.
        let eigen = nalgebra::SymmetricEigen::new(u.transpose() * &u);
        let kept: Vec<usize> = (0..common.len()).filter(|k| eigen.eigenvalues[*k] > 1e-9).collect();
        let basis = DMatrix::from_fn(d, kept.len(), |i, k| {
            let k = kept[k];
            let x: f64 = (0..common.len()).map(|j| u[(i, j)] * eigen.eigenvectors[(j, k)]).sum();
            x / eigen.eigenvalues[k].sqrt()
        });
        let shrink = kept.iter().map(|k| 1.0 - 1.0 / (1.0 + eigen.eigenvalues[*k]).sqrt()).collect();
        Self { active, scale, transposed: basis.transpose(), basis, shrink }
    }

    /// Whitened features; what is not finite counts as zero.
    pub fn apply(&self, features: &[f64]) -> DVector<f64> {
        self.apply_all(&[features]).column(0).into_owned()
    }

    /// [`Self::apply`] of several, a column for each.
    pub fn apply_all(&self, columns: &[&[f64]]) -> DMatrix<f64> {
        let mut x = DMatrix::from_fn(self.active.len(), columns.len(), |i, k| {
            let v = columns[k][self.active[i]] * self.scale[i];
            if v.is_finite() { v } else { 0.0 }
        });
        let mut along = &self.transposed * &x;
        for (mut row, g) in along.row_iter_mut().zip(&self.shrink) {
            row *= *g;
        }
        x.gemm(-1.0, &self.basis, &along, 1.0);
        x
    }

    /// The same for a group that counts `weight` times.
    #[must_use]
    pub fn weighed(mut self, weight: f64) -> Self {
        self.scale.iter_mut().for_each(|s| *s *= weight.sqrt());
        self
    }

    /// Logarithm of the determinant: what whitening does to a volume.
    pub fn log_determinant(&self) -> f64 {
        let scales: f64 = self.scale.iter().map(|s| s.ln()).sum();
        scales + self.shrink.iter().map(|g| (1.0 - g).ln()).sum::<f64>()
    }

    /// Sum of squares of the whitened features.
    pub fn square(&self, features: &[f64]) -> f64 {
        self.apply(features).norm_squared()
    }
}

/// Precision of a parameter that stays where it is.
pub const FIXED: f64 = 1e15;

/// What is known of the coefficients before the data: each has mean zero.
#[derive(Clone, Debug)]
pub struct Prior {
    /// Precision of each; 0: nothing is known.
    pub precision: Vec<f64>,
    /// Largest absolute value of each.
    pub bound: Vec<f64>,
}

impl Prior {
    /// Nothing is known of `n` coefficients.
    pub fn none(n: usize) -> Self {
        Self { precision: vec![0.0; n], bound: vec![f64::INFINITY; n] }
    }

    /// Number of coefficients.
    pub fn len(&self) -> usize {
        self.precision.len()
    }

    /// Whether there are no coefficients.
    pub fn is_empty(&self) -> bool {
        self.precision.is_empty()
    }
}

/// Gram matrix of `[parameters | constants of the rig | residual]` of one group; of the constants, [`super::constants`].
#[derive(Clone, Debug)]
pub struct Gram {
    /// Index of the condition.
    pub condition: usize,
    /// Square, symmetric.
    pub matrix: DMatrix<f64>,
    /// Number of features.
    pub features: usize,
}

impl Gram {
    /// Of the columns at `places` only, in their order; the last of them stands for the residual.
    fn of(&self, places: &[usize]) -> Self {
        let n = places.len();
        let matrix = DMatrix::from_fn(n, n, |i, j| self.matrix[(places[i], places[j])]);
        Self { matrix, ..*self }
    }
}

/// Gram matrices of columns that a model has (the first `known` parameters) and of others that may stand beside them: all
/// are whitened and multiplied once.
#[derive(Clone, Debug)]
pub struct Beside {
    grams: Vec<Gram>,
    known: usize,
    others: usize,
}

impl Beside {
    /// Of Gram matrices of `known` and `others`, offsets and residual.
    pub fn new(grams: Vec<Gram>, known: usize, others: usize) -> Self {
        Self { grams, known, others }
    }

    /// With `others`, and one column in the place of the residual, which is the last of them.
    fn of(&self, others: &[usize], instead: Option<usize>) -> Vec<Gram> {
        let offsets = self.known + self.others;
        let of_group = |g: &Gram| {
            let residual = g.matrix.ncols() - 1;
            let places = (0..self.known).chain(others.iter().map(|k| self.known + k));
            let last = instead.unwrap_or(residual);
            g.of(&places.chain(offsets..residual).chain([last]).collect::<Vec<usize>>())
        };
        self.grams.iter().map(of_group).collect()
    }

    /// With some of the others.
    pub fn with(&self, others: &[usize]) -> Vec<Gram> {
        self.of(others, None)
    }

    /// With one of the others in the place of the residual.
    pub fn towards(&self, other: usize) -> Vec<Gram> {
        self.of(&[], Some(self.known + other))
    }
}

/// Columns that stand beside any others, and their products with each other: these are needed again and again.
#[derive(Clone, Debug)]
pub struct Columns {
    columns: DMatrix<f64>,
    products: DMatrix<f64>,
}

impl Columns {
    /// Of whitened columns.
    pub fn new(columns: DMatrix<f64>) -> Self {
        Self { products: columns.tr_mul(&columns), columns }
    }
}

/// Gram matrix of whitened columns of parameters (the residual is the last of them) and of the offsets beside them.
pub fn gram(condition: usize, seen: &DMatrix<f64>, offsets: &Columns) -> Gram {
    let Columns { columns, products } = offsets;
    let (n, beside) = (seen.ncols() - 1, columns.ncols());
    let (of_seen, across) = (seen.tr_mul(seen), seen.tr_mul(columns));
    let last = n + beside;
    let mut matrix = DMatrix::zeros(last + 1, last + 1);
    matrix.view_mut((0, 0), (n, n)).copy_from(&of_seen.view((0, 0), (n, n)));
    matrix.view_mut((0, n), (n, beside)).copy_from(&across.rows(0, n));
    matrix.view_mut((n, n), (beside, beside)).copy_from(products);
    matrix.view_mut((0, last), (n, 1)).copy_from(&of_seen.view((0, n), (n, 1)));
    matrix.view_mut((n, last), (beside, 1)).copy_from(&across.row(n).transpose());
    matrix[(last, last)] = of_seen[(n, n)];
    // Blocks of a product are summed in their own order: two halves may differ in the last bit.
    matrix.fill_lower_triangle_with_upper_triangle();
    Gram { condition, matrix, features: seen.nrows() }
}

/// Coefficients of `[parameters | offsets]` that minimise the summed loss.
pub fn solve<'a>(grams: impl Iterator<Item = (f64, &'a Gram)>, prior: &Prior) -> Option<DVector<f64>> {
    solve_towards(grams, prior, &[])
}

/// As [`solve`], with a prior mean `towards` of the first coefficients.
pub fn solve_towards<'a>(
    grams: impl Iterator<Item = (f64, &'a Gram)>,
    prior: &Prior,
    towards: &[f64],
) -> Option<DVector<f64>> {
    let n = prior.len();
    let mut a = DMatrix::zeros(n, n);
    let mut b = DVector::from_fn(n, |i, _| prior.precision[i] * towards.get(i).copied().unwrap_or(0.0));
    for (weight, g) in grams {
        a += g.matrix.view((0, 0), (n, n)) * weight;
        b += g.matrix.view((0, n), (n, 1)) * weight;
    }
    solve_normal(a, b, prior)
}

/// Changes of the set of bounds that hold tried at most.
const MOST_SETS: usize = 100;

/// Minimises `x' (A + diag(precision)) x / 2 - b' x` within the bounds: those that hold are found by
/// putting in what is violated and taking out what pulls inwards. What the data do not see stays at zero.
pub fn solve_normal(mut a: DMatrix<f64>, b: DVector<f64>, prior: &Prior) -> Option<DVector<f64>> {
    let n = prior.len();
    for i in 0..n {
        a[(i, i)] += prior.precision[i];
    }
    let mut held: Vec<Option<f64>> = vec![None; n];
    let mut x = DVector::zeros(n);
    for _ in 0..MOST_SETS {
        x = solve_with_held(&a, &b, &held)?;
        let mut changed = false;
        for i in 0..n {
            if held[i].is_none() && x[i].abs() > prior.bound[i] {
                held[i] = Some(prior.bound[i].copysign(x[i]));
                changed = true;
            }
        }
        if changed {
            continue;
        }
        // The gradient at a bound that holds points inwards.
        let slope = &a * &x - &b;
        let inwards = |i: &usize| held[*i].map_or(0.0, |v| slope[*i] * v.signum());
        match (0..n).max_by(|i, j| inwards(i).total_cmp(&inwards(j))) {
            Some(i) if inwards(&i) > 1e-9 * (1.0 + b[i].abs()) => held[i] = None,
            _ => return Some(x),
        }
    }
    for i in 0..n {
        x[i] = x[i].clamp(-prior.bound[i], prior.bound[i]);
    }
    Some(x)
}

/// Solves `A x = b` with some of `x` held at values, scaled.
fn solve_with_held(a: &DMatrix<f64>, b: &DVector<f64>, held: &[Option<f64>]) -> Option<DVector<f64>> {
    let n = held.len();
    let scale: Vec<f64> = (0..n)
        .map(|i| if a[(i, i)] > 0.0 && held[i].is_none() { 1.0 / a[(i, i)].sqrt() } else { 0.0 })
        .collect();
    let mut right = b.clone();
    for (j, v) in held.iter().enumerate().filter_map(|(j, v)| Some((j, (*v)?))) {
        right.axpy(-v, &a.column(j), 1.0);
    }
    let matrix = DMatrix::from_fn(n, n, |i, j| match i == j {
        true if scale[i] == 0.0 => 1.0,
        true => a[(i, i)] * scale[i] * scale[i] + 1e-9,
        false => a[(i, j)] * scale[i] * scale[j],
    });
    let right = DVector::from_fn(n, |i, _| right[i] * scale[i]);
    let x = matrix.cholesky()?.solve(&right);
    Some(DVector::from_fn(n, |i, _| held[i].unwrap_or(x[i] * scale[i])))
}

/// Loss of a group at coefficients `x`: squared whitened residual that remains.
pub fn loss(g: &Gram, x: &DVector<f64>) -> f64 {
    let n = x.len();
    let a = g.matrix.view((0, 0), (n, n));
    let b = g.matrix.view((0, n), (n, 1));
    let quadratic = (x.transpose() * a * x)[(0, 0)];
    let cross = (x.transpose() * b)[(0, 0)];
    (g.matrix[(n, n)] - 2.0 * cross + quadratic).max(0.0)
}

/// Least loss over the coefficients, what their prior costs included, and where it is.
pub fn least(grams: &[Gram], prior: &Prior) -> (f64, Vec<f64>) {
    let Some(x) = solve(grams.iter().map(|g| (1.0, g)), prior) else {
        return (f64::INFINITY, vec![0.0; prior.len()]);
    };
    let cost: f64 = x.iter().zip(&prior.precision).map(|(x, p)| p * x * x).sum();
    (grams.iter().map(|g| loss(g, &x)).sum::<f64>() + cost, x.iter().copied().collect())
}

/// Which of `folds` parts a condition belongs to; neighbouring conditions fall into different parts.
pub fn fold(condition: usize, folds: usize) -> usize {
    (condition * 7 + condition / folds) % folds
}

/// Coefficients fitted without each of `folds` parts of the conditions in turn.
pub fn fold_solutions(grams: &[Gram], prior: &Prior, folds: usize) -> Vec<DVector<f64>> {
    (0..folds)
        .map(|k| {
            let others = grams.iter().filter(|g| fold(g.condition, folds) != k).map(|g| (1.0, g));
            solve(others, prior).unwrap_or_else(|| DVector::zeros(prior.len()))
        })
        .collect()
}

/// Loss of every group when it is predicted from the other conditions.
pub fn held_out(grams: &[Gram], solutions: &[DVector<f64>]) -> Vec<f64> {
    grams.iter().map(|g| loss(g, &solutions[fold(g.condition, solutions.len())])).collect()
}
