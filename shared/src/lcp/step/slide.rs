//! How a point slides: its friction, and its slip along and across it.

use crate::lcp::contact::law::{self, Mode, add_scaled};
use crate::lcp::contact::polygon::along;
use crate::real::{Real, sqrt};
use crate::solve::DOF;

/// A point on the path.
pub(super) type Track<R> = law::Track<R, DOF, ()>;

/// A point that slides, in the axes of its pyramid.
pub(super) struct Slide<R> {
    pub friction_n: R,
    /// Direction across its friction.
    pub across: [R; 2],
    /// Its slip, turned round, along the friction and across it.
    pub along_m_s: R,
    pub across_m_s: R,
}

impl<R: Real> Slide<R> {
    /// `None` for a point that does not slide, or not against its friction.
    pub fn of(track: &Track<R>) -> Option<Self> {
        if !matches!(track.mode, Mode::Corner(_) | Mode::Edge(_)) {
            return None;
        }
        let [_, f1, f2] = track.impulse;
        let friction_n = sqrt(f1 * f1 + f2 * f2);
        let [h1, h2] = unit([f1, f2])?;
        let slip = [-track.speed[1], -track.speed[2]];
        let along_m_s = along([h1, h2], slip);
        let across = [-h2, h1];
        (along_m_s > R::zero()).then(|| Self {
            friction_n,
            across,
            along_m_s,
            across_m_s: along(across, slip),
        })
    }

    /// Velocity along `across`, as a row.
    pub fn row(&self, track: &Track<R>) -> [R; DOF] {
        let mut row = [R::zero(); DOF];
        add_scaled(&mut row, self.across[0], &track.rows[1]);
        add_scaled(&mut row, self.across[1], &track.rows[2]);
        row
    }
}

/// The direction of `v`; `None` where it has none.
#[inline(always)]
pub(super) fn unit<R: Real>(v: [R; 2]) -> Option<[R; 2]> {
    let size = sqrt(v[0] * v[0] + v[1] * v[1]);
    (size > R::of(1e-18)).then(|| v.map(|x| x / size))
}
