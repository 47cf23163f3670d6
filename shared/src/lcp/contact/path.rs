//! Follows the solution while the constants of the contacts move to their true values.
//!
//! With `y` the velocities that the impulses cause (masses scaled to one), the equations are
//! `y = G'p(G y + q + (1 - t) offset)`; in general, with a mass matrix and a balance that is not met at
//! the start, `M y = G'p(..) + h + (1 - t) r`. In each combination of modes they are linear, `t` runs
//! until a contact reaches a kink of its law, its mode changes, and the inverse of the
//! equations is updated by a matrix of rank one. Where the determinant changes sign the path
//! turns back in `t`, as Lemke's does. From all contacts open this is Lemke's method in
//! `ND` instead of `6 nc` unknowns; from the modes of the last problem it repairs them.

use super::law::{Mode, Track, add_scaled, dot};
use super::polygon::Polygon;
use crate::linear::Factors as Lu;
use crate::real::{Real, max};

/// How a path ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::lcp) enum End {
    /// At the true constants.
    Arrived,
    /// It runs away from them for ever.
    Ray,
    /// The bound on kinks was reached.
    Limit,
    /// A kink could not be crossed under rounding.
    Stuck,
}

/// What is followed: polygon, masses and the equations in the present modes.
pub(in crate::lcp) struct Equations<'a, R, const ND: usize> {
    pub polygon: &'a Polygon<R>,
    /// `M`; `None`: one for every degree of freedom.
    pub mass: Option<&'a [[R; ND]; ND]>,
    /// `M + G'K G`, where `built`.
    pub matrix: [[R; ND]; ND],
    built: bool,
    /// There are factors, own or borrowed.
    ready: bool,
    /// Its inverse as factors, and, after a kink, as it is.
    factors: Lu<R, ND>,
    inverse: Option<[[R; ND]; ND]>,
}

impl<'a, R: Real, const ND: usize> Equations<'a, R, ND> {
    pub(in crate::lcp) fn new(polygon: &'a Polygon<R>, mass: Option<&'a [[R; ND]; ND]>) -> Self {
        let matrix = [[R::zero(); ND]; ND];
        Self { polygon, mass, matrix, built: false, ready: false, factors: Lu::none(), inverse: None }
    }

    /// Takes factors of an earlier problem for those of this one.
    pub(in crate::lcp) fn borrow(&mut self, factors: &Lu<R, ND>) {
        self.factors = *factors;
        self.inverse = None;
        self.built = false;
        self.ready = true;
    }

    /// Sees to it that the matrix is that of the modes of `tracks`, where factors were borrowed.
    pub(in crate::lcp) fn build<X>(&mut self, tracks: &[Track<R, ND, X>]) {
        if !self.built {
            self.begin(tracks);
        }
    }

    /// Whether there are factors, own or borrowed.
    pub(in crate::lcp) fn has_factors(&self) -> bool {
        self.ready
    }

    /// Factors in the present modes.
    pub(in crate::lcp) fn factors(&self) -> Lu<R, ND> {
        // After a kink they are those of before it.
        if self.inverse.is_some() { Lu::of(&self.matrix) } else { self.factors }
    }

    /// Takes them up in the modes of `tracks`.
    fn begin<X>(&mut self, tracks: &[Track<R, ND, X>]) {
        self.inverse = None;
        self.built = true;
        self.ready = true;
        if let Some(mass) = self.mass {
            // Number by number: as a whole it would be moved, by a routine that is as long as it is slow.
            for (to, from) in self.matrix.iter_mut().flatten().zip(mass.iter().flatten()) {
                *to = *from;
            }
        } else {
            self.matrix = [[R::zero(); ND]; ND];
            for k in 0..ND {
                self.matrix[k][k] = R::one();
            }
            if tracks.iter().all(|track| track.mode == Mode::Open) {
                self.factors = Lu::identity();
                return;
            }
        }
        for track in tracks {
            track.add_to(self.polygon, &mut self.matrix);
        }
        self.factors = Lu::of(&self.matrix);
    }

    /// Solves them.
    pub(in crate::lcp) fn solve(&self, b: &[R; ND]) -> [R; ND] {
        match &self.inverse {
            Some(inverse) => {
                let mut x = [R::zero(); ND];
                for (x, row) in x.iter_mut().zip(inverse) {
                    *x = dot(row, b);
                }
                x
            }
            None => self.factors.solve(b),
        }
    }
}

#[inline]
fn update_rates<R: Real, const ND: usize, X>(tracks: &mut [Track<R, ND, X>], dy: &[R; ND]) {
    for track in tracks {
        let [normal, first, second] = track.offset;
        track.rate = [
            track.normal_gain * (normal - dot(&track.rows[0], dy)),
            track.tangent_gain * (first - dot(&track.rows[1], dy)),
            track.tangent_gain * (second - dot(&track.rows[2], dy)),
        ];
    }
}

/// From trial impulses that are consistent with the modes, velocities `y`, offsets and the `unbalanced`
/// rest `M y - G'p - h`, to offsets and a rest of zero. Returns the number of kinks crossed.
#[inline(never)]
pub(in crate::lcp) fn follow<R: Real, const ND: usize, X>(
    equations: &mut Equations<'_, R, ND>,
    tracks: &mut [Track<R, ND, X>],
    y: &mut [R; ND],
    unbalanced: &[R; ND],
    limit: u32,
) -> (End, u32) {
    let (zero, one) = (R::zero(), R::one());
    let polygon = equations.polygon;
    let mut force = unbalanced.map(|r| -r);
    for track in tracks.iter() {
        let [normal, first, second] = track.offset;
        let trial = [track.normal_gain * normal, track.tangent_gain * first, track.tangent_gain * second];
        let impulse = track.impulse_of(polygon, &trial);
        for k in 0..3 {
            add_scaled(&mut force, impulse[k], &track.rows[k]);
        }
    }
    equations.begin(tracks);
    let mut dy = equations.factors.solve(&force);
    update_rates(tracks, &dy);
    let mut t = zero;
    let mut direction = one;
    for count in 0..limit {
        let forward = direction > zero;
        let mut step = if forward { one - t } else { R::of(f32::MAX as f64) };
        let mut hit: Option<(usize, Mode)> = None;
        for (i, track) in tracks.iter().enumerate() {
            track.kinks(polygon, direction, step, |value, rate, mode| {
                if rate < zero {
                    let value = max(value, zero);
                    // Without a division: value / -rate < step.
                    if value < -rate * step {
                        step = value / -rate;
                        hit = Some((i, mode));
                    }
                }
            });
        }
        let signed = direction * step;
        if hit.is_none() && !forward {
            return (End::Ray, count);
        }
        add_scaled(y, signed, &dy);
        for track in tracks.iter_mut() {
            for k in 0..3 {
                track.trial[k] += signed * track.rate[k];
            }
        }
        t += signed;
        let Some((i, mode)) = hit else { return (End::Arrived, count) };
        let Some(kink) = tracks.get_mut(i).and_then(|track| track.change(polygon, mode)) else {
            return (End::Stuck, count);
        };
        let factors = &equations.factors;
        let inverse = equations.inverse.get_or_insert_with(|| factors.inverse());
        let (mut w, mut c) = ([zero; ND], [zero; ND]);
        for k in 0..ND {
            w[k] = dot(&inverse[k], &kink.a);
            add_scaled(&mut c, kink.b[k], &inverse[k]);
        }
        // Ratio of the determinants of the equations after and before.
        let ratio = one + dot(&kink.b, &w);
        let reciprocal = one / ratio;
        if !reciprocal.finite() {
            return (End::Stuck, count);
        }
        add_scaled(&mut dy, -kink.phi * reciprocal, &w);
        for k in 0..ND {
            add_scaled(&mut inverse[k], -w[k] * reciprocal, &c);
            add_scaled(&mut equations.matrix[k], kink.a[k], &kink.b);
        }
        if ratio < zero {
            direction = -direction;
        }
        update_rates(tracks, &dy);
    }
    (End::Limit, limit)
}
