//! A point of the step: what it is, what it did, and where the path begins with it.

use super::slide::{Track, unit};
use crate::lcp::contact::polygon::Polygon;
use crate::linear::Vec7;
use crate::real::{Real, Vec3, max, sqrt};
use crate::solve::{Before, ContactPoint};
use heapless::Vec;

/// What a point did in the step before.
#[derive(Clone, Copy, Debug)]
pub struct Past<R> {
    /// Open, stuck, slid.
    pub before: Before<R>,
    /// Its tangential spring, m: friction acts against it.
    pub spring_m: [R; 2],
}

/// A point, and what turns the pyramid's impulses into forces along its tangents.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point<R: Real> {
    pub given: ContactPoint<R>,
    /// From the centre of mass, over the radius of gyration.
    pub arm: Vec3<R>,
    pub past: Option<Past<R>>,
    /// Factors of the tangents: friction coefficients, or one where there is no friction.
    pub factor: [R; 2],
    /// Direction of the first corner, in tangents so scaled.
    pub first: [R; 2],
    /// Share of friction that goes on as if stuck, with a viscosity.
    pub viscous: R,
}

/// Points of a problem, added one by one.
#[derive(Clone, Debug)]
pub struct Points<R: Real, const NC: usize> {
    pub(super) list: Vec<Point<R>, NC>,
    /// One found no room.
    pub(super) lost: bool,
}

impl<R: Real, const NC: usize> Default for Points<R, NC> {
    fn default() -> Self {
        Self::new()
    }
}

impl<R: Real, const NC: usize> Points<R, NC> {
    /// None.
    #[inline(always)]
    pub fn new() -> Self {
        Self { list: Vec::new(), lost: false }
    }

    /// Forgets them.
    pub fn forget(&mut self) {
        self.list.clear();
        self.lost = false;
    }

    /// Adds a point; `past`: what it did in the step before, where that is known.
    pub fn add(&mut self, point: &ContactPoint<R>, past: Option<Past<R>>) {
        let (zero, one) = (R::zero(), R::one());
        let [k1, k2] = [point.stiffness_n_s_m[1], point.stiffness_n_s_m[2]];
        let c = point.viscous_n_s_m;
        let viscous = if c > zero { c / (max(k1, k2) + c) } else { zero };
        let point =
            Point { given: *point, arm: Vec3::zeros(), past, factor: [one; 2], first: [one, zero], viscous };
        self.lost |= self.list.push(point).is_err();
    }

    /// How many were added.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// As they were added, with what they did before.
    pub fn iter(&self) -> impl Iterator<Item = (&ContactPoint<R>, Option<Before<R>>)> {
        self.list.iter().map(|p| (&p.given, p.past.map(|past| past.before)))
    }
}

impl<R: Real> Point<R> {
    /// The direction of the friction of a point that slid, along the scaled tangents.
    pub fn held(&self) -> Option<[R; 2]> {
        let Past { before: Before::Slid { .. }, spring_m } = self.past? else { return None };
        unit([0, 1].map(|k| -spring_m[k] * self.factor[k]))
    }

    /// Separation and slip at `v`: as [`Track::speeds_at`], by the velocity at the point, which its three rows share.
    #[inline(always)]
    pub fn speeds_at(&self, track: &Track<R>, v: &Vec7<R>) -> [R; 3] {
        let at = Vec3::new(v[0], v[1], v[2]) + Vec3::new(v[3], v[4], v[5]).cross(&self.arm);
        let along = |k: usize| {
            let row = &track.rows[k];
            row[0] * at.x + row[1] * at.y + row[2] * at.z + track.constant[k]
        };
        [along(0) + track.rows[0][6] * v[6], along(1), along(2)]
    }

    /// Takes the force `[normal, first, second]` along the track's rows off a balance.
    #[inline(always)]
    pub fn take_off(&self, track: &Track<R>, force: [R; 3], rest: &mut Vec7<R>) {
        let along = |k: usize| {
            force[0] * track.rows[0][k] + force[1] * track.rows[1][k] + force[2] * track.rows[2][k]
        };
        let force_n = Vec3::new(along(0), along(1), along(2));
        let moment = self.arm.cross(&force_n);
        rest[0] -= force_n.x;
        rest[1] -= force_n.y;
        rest[2] -= force_n.z;
        rest[3] -= moment.x;
        rest[4] -= moment.y;
        rest[5] -= moment.z;
        rest[6] -= force[0] * track.rows[0][6];
    }

    /// A vector along the pyramid's axes, along the scaled tangents.
    pub fn turned_back(&self, [x, y]: [R; 2]) -> [R; 2] {
        let [c, s] = self.first;
        [c * x - s * y, s * x + c * y]
    }
}

/// Whether the numbers of the law may be; a NaN is none of these.
pub(super) fn in_range<R: Real>(p: &ContactPoint<R>) -> bool {
    let zero = R::zero();
    let [k0, k1, k2] = p.stiffness_n_s_m;
    let springs = k0 > zero && k1 > zero && k2 > zero;
    springs && p.mu[0] >= zero && p.mu[1] >= zero && p.adhesion_n >= zero && p.viscous_n_s_m >= zero
}

/// Damping of the share of viscous friction that nothing bounds, along the scaled tangents, N s/m.
#[inline(always)]
pub(super) fn damping<R: Real>(p: &Point<R>, track: &Track<R>) -> R {
    if p.viscous > R::zero() && track.friction > R::zero() {
        track.tangent_gain * p.viscous / (R::one() - p.viscous)
    } else {
        R::zero()
    }
}

/// Changes the trial so that the point does what it did before.
#[inline]
pub(super) fn expect<R: Real>(p: &Point<R>, track: &mut Track<R>, polygon: &Polygon<R>) {
    let zero = R::zero();
    let Some(Past { before, .. }) = p.past else { return };
    let touches = track.trial[0] > zero;
    let (load_n, slid) = match before {
        Before::Open => {
            if touches {
                track.trial[0] = zero;
            }
            return;
        }
        Before::Stuck { load_n } => (load_n, false),
        Before::Slid { load_n } => (load_n, true),
    };
    if !touches {
        track.trial[0] = load_n + p.given.adhesion_n;
    }
    let [normal, first, second] = track.trial;
    let limit = track.friction * normal;
    let square = first * first + second * second;
    let inner = limit * polygon.apothem * R::of(0.9);
    let outer = limit * R::of(1.02);
    let bound = if slid { outer } else { inner };
    let other = if slid { square < bound * bound } else { square > bound * bound };
    if other && square > zero {
        let share = bound / sqrt(square);
        track.trial = [normal, first * share, second * share];
    }
}
